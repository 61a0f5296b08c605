"""What a connection does to the value that it carries: the conversion between two units of measure, and beyond it what the
scene writes under ``[transformations]``."""

from __future__ import annotations

from towage.scene.values import Names
from towage.units.description import Value, Variable

DISCRETE = ("Integer", "Enumeration", "Boolean")
_TRUTH = {"true": True, "false": False}
End = tuple[str, Variable]
"""A unit by name, and a variable of it."""
Carried = tuple[float, float, tuple[tuple[float, float], ...]]
"""(factor, offset, pairs): target = factor * source + offset, or what a pair has for it."""


def carried(names: Names, text: str, source: End, target: End, key: str) -> Carried:
    """What the connection ``text`` of the scene does, ``key`` its place. Raises `SceneError` where it does not fit."""
    change = names.scene.transformations.get(text)
    one, other = source[1].type, target[1].type
    if one != other and {one, other} != {"Integer", "Enumeration"}:
        raise names.fault(f"{text!r} joins {one} to {other}: the types must agree", key)
    if one != other and not (change and change.values):
        names.warnings.append(f"{text!r} joins {one} to {other}: the number passes unchanged")
    if change is None:
        return (*names.conversion(text, *source, *target, key), ())
    place = f"transformations.{text}"
    if (change.factor, change.offset) != (1.0, 0.0) and one != "Real":
        raise names.fault(f"factor and offset are for Real, and {source[0]}.{source[1].name} is {one}", place)
    if change.values and one not in DISCRETE:
        raise names.fault(f"values are for {', '.join(DISCRETE)}, and {source[0]}.{source[1].name} is {one}", place)
    pairs = tuple(_pair(names, source[1], target[1], item, place) for item in change.values.items())
    factor, offset = names.conversion(text, *source, *target, key) if change.convert else (1.0, 0.0)
    return change.factor * factor, change.factor * offset + change.offset, pairs


def _pair(names: Names, source: Variable, target: Variable, item: tuple[str, Value], place: str) -> tuple[float, float]:
    """An entry of ``values`` as numbers."""
    known = _TRUTH if source.type == "Boolean" else source.items
    try:
        first = float(known[item[0]] if item[0] in known else int(item[0]))
    except ValueError:
        expected = ", ".join(known) or "whole numbers"
        raise names.fault(f"{item[0]!r} is no {source.type} of {source.name}: expected {expected}", place) from None
    value = target.items.get(item[1], item[1]) if isinstance(item[1], str) else item[1]
    if type(value) is not (bool if target.type == "Boolean" else int):
        raise names.fault(f"{item[1]!r} is no {target.type}, as {target.name} is", place)
    return first, float(value)
