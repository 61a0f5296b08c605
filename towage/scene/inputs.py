"""Inputs of a scene's units that nothing is connected to: set to a constant, needed, meant to be open, or forgotten; and
parameters that their unit needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from towage.scene.values import Names
from towage.units.description import Variable

Sources = Mapping[tuple[str, str], str]
"""For each connected input, (unit, name), the output "unit.name" that feeds it."""
MOST = 4
"""Outputs that a message offers."""


def check_constants(names: Names, sources: Sources) -> None:
    """Refuses a constant for an input that is connected. Raises `SceneError`."""
    for unit, entry in names.scene.units.items():
        for name in entry.values:
            if source := sources.get((unit, name)):
                raise names.fault(
                    f"{unit}.{name} is connected to {source}, so that it has no value of its own: take out the constant or "
                    "the connection",
                    f"units.{unit}.{entry.table(name)}.{name}",
                )


def check_needed(names: Names) -> None:
    """Refuses a scene that leaves a parameter to its start value although the unit needs it. Raises `SceneError`."""
    for unit, variables in names.variables.items():
        for v in variables.values():
            if v.needed and v.causality == "parameter" and v.name not in names.scene.units[unit].values:
                key = f"units.{unit}.parameters.{v.name}"
                raise names.fault(f"{unit}.{v.name} is not set, and {unit} needs it: {v.description}", key)


def check_aliases(names: Names, sources: Sources) -> None:
    """Refuses two names of one variable that are both set or connected: the second would take the place of the first. Raises
    `SceneError`."""
    for unit, entry in names.scene.units.items():
        first: dict[tuple[int, str], str] = {}
        for name in dict.fromkeys([*entry.values, *(target for of, target in sources if of == unit)]):
            v = names.variables[unit].get(name)
            other = first.setdefault((v.value_reference, v.kind), name) if v and v.array == 1 else name
            if v and other != name:
                raise names.fault(
                    f"{unit}.{other} and {unit}.{name} are two names of one variable (value reference {v.value_reference}): set "
                    "or connect one of them",
                    f"units.{unit}",
                )


def unset_inputs(names: Names, sources: Sources, open_ends: bool) -> dict[str, str]:
    """The inputs that may have been forgotten, "unit.input" to what to do: neither connected nor set, and their unit
    does not say what their start value means. Raises `SceneError` for one that its unit needs, unless ``open_ends``."""
    forgotten = {}
    for unit, variables in names.variables.items():
        given = names.scene.units[unit].values
        for v in variables.values():
            if v.causality != "input" or v.name in given or (unit, v.name) in sources or v.unset:
                continue
            if v.needed and not open_ends:
                raise names.fault(
                    f"{unit}.{v.name} is neither connected nor set, and {unit} needs it: {_remedy(names, sources, unit, v)}",
                    f"units.{unit}.inputs.{v.name}",
                )
            forgotten[f"{unit}.{v.name}"] = _remedy(names, sources, unit, v)
    return forgotten


def unset_text(forgotten: Sequence[str]) -> str:
    """What to say of inputs that may have been forgotten."""
    every = ", ".join(forgotten)
    one = forgotten[0].partition(".")
    verb = "is" if len(forgotten) == 1 else "are"
    return (
        f"{every} {verb} neither connected nor set and keep{'s' if verb == 'is' else ''} the start value: connect, or say so by "
        f"a constant, [units.{one[0]}.inputs] {one[2]} = ..."
    )


def _remedy(names: Names, sources: Sources, unit: str, target: Variable) -> str:
    """The outputs that would fit, and how to set a constant. First come those of the input's own name, then those of units
    that do not feed this one yet, then the most similar names."""
    from difflib import SequenceMatcher  # for a fault alone

    feeding = {source.partition(".")[0] for (fed, _), source in sources.items() if fed == unit}
    fitting = [
        f"{other}.{v.name}"
        for other, variables in names.variables.items() if other != unit
        for v in variables.values() if v.causality == "output" and _fits(names, other, v, unit, target)
    ]  # fmt: skip

    def rank(end: str) -> tuple[bool, bool, float]:
        other, _, name = end.partition(".")
        return name != target.name, other in feeding, -SequenceMatcher(None, name, target.name).ratio()

    fitting.sort(key=rank)
    constant = f"set a constant, [units.{unit}.inputs] {target.name} = ..."
    if not fitting:
        return f"no output of another unit measures the same ({target.unit or 'no unit'}); {constant}"
    more = f" (also {', '.join(fitting[1:MOST])})" if len(fitting) > 1 else ""
    return f'connect "{fitting[0]} -> {unit}.{target.name}"{more}, or {constant}'


def _fits(names: Names, source_unit: str, source: Variable, target_unit: str, target: Variable) -> bool:
    """Whether both are Real and declare units of measure of the same dimension."""
    if source.type != "Real" or target.type != "Real" or source.unit is None or target.unit is None:
        return False
    one, other = names.definition(source_unit, source.unit), names.definition(target_unit, target.unit)
    return one is not None and other is not None and one[0] == other[0]
