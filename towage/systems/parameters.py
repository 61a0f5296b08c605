"""Parameter sets (SSV) and parameter mappings (SSM) of SSP 1.0, what 2.0 has alike, and the transformations of both and of
connections."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

from towage.fmus.declare.quantities import BASES
from towage.systems.network import Change, Given, Network
from towage.systems.source import local
from towage.units.conventions import Definition
from towage.units.description import Value

REALS = ("Real", "Float64", "Float32")
INTEGERS = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
TYPES = (*REALS, *INTEGERS, "Boolean", "String", "Enumeration", "Binary")
STEPS = {"FixedStepAlgorithm": "baseStepSize", "FixedStepMaster": "stepSize"}
"""Elements of annotations that say a step: of the Open Simulation Platform, of OMSimulator."""
SILENT = (
    "ElementGeometry", "ConnectorGeometry", "ConnectionGeometry", "SystemGeometry", "GraphicalElements", "MetaData", "Signature",
)  # fmt: skip
"""Elements that say nothing of numbers."""


class Entry(NamedTuple):
    """An entry of a mapping: the parameter ``source`` is applied as ``target``."""

    source: str
    target: str
    raw: bool
    change: Change


class Document:
    """A description in the file ``name``; its units of measure are its own."""

    def __init__(self, network: Network, name: str, root: Element) -> None:
        self.network, self.name, self.root = network, name, root
        version = root.get("version", "")
        if version not in ("1.0", "2.0"):
            network.say("warning", f"{name}: version {version!r} is read as 1.0")
        self.units = dict(self._units())

    def _units(self) -> Iterator[tuple[str, Definition]]:
        for element in self.root:
            for unit in element if local(element) == "Units" else ():
                base = next((child for child in unit if local(child) == "BaseUnit"), None)
                if base is None:
                    continue
                place = f"{self.name}: Unit {unit.get('name')!r}"
                exponents = tuple(int(self.number(base, key, 0.0, place)) for key in BASES)
                factor, offset = self.number(base, "factor", 1.0, place), self.number(base, "offset", 0.0, place)
                if factor == 0.0:
                    raise self.network.fault("a unit of measure has a factor other than 0", place)
                yield unit.get("name", ""), (exponents, factor, offset)

    def number(self, element: Element, key: str, default: float, place: str) -> float:
        """An attribute as a finite number. Raises `SceneError`."""
        written = element.get(key)
        if written is None:
            return default
        try:
            value = float(written)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.network.fault(f"{key}={written!r} is no finite number", place)
        return value

    def truth(self, element: Element, key: str, place: str) -> bool:
        """An attribute as a truth value, false where it is missing. Raises `SceneError`."""
        written = element.get(key, "false").strip()
        if written not in ("true", "false", "1", "0"):
            raise self.network.fault(f"{key}={written!r} is no truth value", place)
        return written in ("true", "1")

    def children(self, element: Element, known: tuple[str, ...], place: str) -> Iterator[tuple[str, Element]]:
        """The children of an element that are known, by their tags; others are noted."""
        for child in element:
            tag = local(child)
            if tag == "Annotations":
                self.annotations(child, place)
            elif tag in known:
                yield tag, child
            elif tag not in (*SILENT, "Enumerations", "Units"):
                self.network.say("warning", f"{place}: <{tag}> is not understood, and ignored")

    def annotations(self, element: Element, place: str) -> None:
        """Of which the steps of the Open Simulation Platform and of OMSimulator are read, and all others are named."""
        for annotation in element:
            algorithm = next((e for e in annotation.iter() if local(e) in STEPS), None)
            if algorithm is not None:
                tag = local(algorithm)
                step = self.number(algorithm, STEPS[tag], 0.0, f"{place}: {tag}") or None
                if step and self.network.step not in (None, step):
                    self.network.say("warning", f"{place}: {tag} says another step, {step:g} s, which is ignored")
                else:
                    self.network.step = step or self.network.step
            else:
                hints = [f"{local(e)} {e.get('value')}" for e in annotation if e.get("value")]
                kind = f"{annotation.get('type')!r}" + (f" ({', '.join(hints)})" if hints else "")
                self.network.say("info", f"{self.name}: the annotation of type {kind} is ignored")

    def unit(self, element: Element) -> Definition | None:
        """The unit of measure that the type of a connector or a parameter names."""
        name = element.get("unit", "")
        if name and name not in self.units:
            self.network.say("warning", f"{self.name}: the unit of measure {name!r} is not defined there, and ignored")
        return self.units.get(name)

    def change(self, element: Element, place: str) -> Change:
        """The transformation in a connection or a mapping. Raises `SceneError`."""
        done = Change()
        for child in element:
            tag = local(child)
            if tag == "LinearTransformation":
                done = Change(self.number(child, "factor", 1.0, place), self.number(child, "offset", 0.0, place))
            elif tag in _TABLES:
                done = Change(table=dict(self._rows(child, _TABLES[tag], place)))
        return done

    def _rows(self, element: Element, read: Callable[[str], Value], place: str) -> Iterator[tuple[str, Value]]:
        seen = set()
        for row in element:
            if local(row) != "MapEntry":
                continue
            try:
                source, target = read(row.get("source", "")), read(row.get("target", ""))
            except (ValueError, KeyError):
                message = f"cannot map {row.get('source')!r} to {row.get('target')!r} in {local(element)}"
                raise self.network.fault(message, place) from None
            key = str(source).lower() if isinstance(source, bool) else str(source)
            if key in seen:
                raise self.network.fault(f"{local(element)} maps {key!r} twice", place)
            seen.add(key)
            yield key, target

    def parameters(self, element: Element, place: str) -> Iterator[tuple[str, Given]]:
        """(name, value) of a parameter set; an array once for each element, as name[1]. Raises `SceneError`."""
        known = ("Parameters",)
        for _, parameters in self.children(element, known, place):
            for _, parameter in self.children(parameters, ("Parameter",), place):
                name = parameter.get("name", "")
                here = f"{place}: {name!r}"
                for tag, typed in self.children(parameter, (*TYPES, "Dimension"), here):
                    if tag == "Dimension":
                        continue
                    values = _values(typed, tag)
                    for k, written in enumerate(values, 1):
                        value = self._value(written, tag, here)
                        given = Given(value, self.unit(typed), False, Change(), here)
                        yield (name if len(values) == 1 else f"{name}[{k}]"), given

    def _value(self, written: str, tag: str, place: str) -> Value:
        value = value_of(tag, written)
        if value is None:
            raise self.network.fault(f"{written!r} is no {tag}", place)
        return value

    def mapping(self, element: Element, place: str) -> list[Entry]:
        """The entries of a mapping. Raises `SceneError`, also for two parameters that become one."""
        entries = []
        for _, entry in self.children(element, ("MappingEntry",), place):
            source, target = entry.get("source", ""), entry.get("target", "")
            here = f"{place}: {source!r}"
            entries.append(
                Entry(source, target, self.truth(entry, "suppressUnitConversion", here), self.change(entry, here))
            )
        targets = [entry.target for entry in entries]
        if twice := next((target for target in targets if targets.count(target) > 1), None):
            raise self.network.fault(f"two parameters are mapped to {twice!r}", place)
        return entries


def value_of(tag: str, written: str) -> Value | None:
    """The value of a type of SSP or OSP as it is written; None where it is none."""
    try:
        return _READ.get(tag, str)(written)
    except (ValueError, KeyError):
        return None


def _truth(written: str) -> bool:
    return {"true": True, "1": True, "false": False, "0": False}[written.strip()]


def _finite(written: str) -> float:
    value = float(written)
    if not math.isfinite(value):
        raise ValueError
    return value


def _values(element: Element, tag: str) -> list[str]:
    """The values of a parameter as they are written: one, or those of an array."""
    inside = [child.get("value", "") for child in element if local(child) == "Value"]
    if inside:
        return inside
    written = element.get("value", "")
    return [written] if tag in ("String", "Enumeration", "Binary") else written.split() or [written]


_READ: dict[str, Callable[[str], Value]] = {
    **dict.fromkeys(REALS, _finite), **dict.fromkeys(INTEGERS, int), "Boolean": _truth
}  # fmt: skip
_TABLES: dict[str, Callable[[str], Value]] = {
    "BooleanMappingTransformation": _truth, "IntegerMappingTransformation": int, "EnumerationMappingTransformation": str,
}  # fmt: skip
