"""The internal form of a system: components, and a net of connectors through which values travel.

A node is a connector of an element, (path of the element, name). Those of components are variables of FMUs; those of systems,
of signal dictionaries and of functions pass on what they get. An edge carries a value from node to node: it converts it to the
unit of measure of the node it leads to, and then transforms it. `Network.connections` follows the edges from every input of a
component back to the output that feeds it, which flattens the system; `Network.give` takes a value along them to the variables.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Literal, NamedTuple

from towage.errors import SceneError
from towage.fmus.declare.quantities import base_expression
from towage.systems.source import Files
from towage.units.conventions import Definition, definition
from towage.units.description import Description, Value, Variable

Path = tuple[str, ...]
Node = tuple[Path, str]
MAX_COMPONENTS = 10_000
MAX_NOTES = 100
SOURCES, TARGETS = ("output", "calculatedParameter", "local", "constant"), ("input", "parameter", "structuralParameter")


class Change(NamedTuple):
    """A transformation: factor * value + offset, or what ``table`` has for the text of a discrete value."""

    factor: float = 1.0
    offset: float = 0.0
    table: Mapping[str, Value] = {}

    def then(self, other: Change) -> Change:
        """Both, one after the other."""
        table = {key: other.table.get(text(value), value) for key, value in self.table.items()}
        table = {**other.table, **table}
        return Change(other.factor * self.factor, other.factor * self.offset + other.offset, table)


class Edge(NamedTuple):
    """What leads from ``source`` to ``target``; ``raw``: without conversion of units of measure. ``place`` in the file."""

    source: Node
    target: Node
    raw: bool
    change: Change
    place: str


class Component(NamedTuple):
    """An FMU in the system: its path, its file's name in ``files``."""

    path: Path
    files: Files
    fmu: str
    description: Description


class Given(NamedTuple):
    """A value as it is written, its unit of measure, and what its mapping does to it; ``raw``: without conversion."""

    value: Value
    unit: Definition | None
    raw: bool
    change: Change
    place: str


class Carried(NamedTuple):
    """What was done to a value on its way: ``unit`` is the one that it is in now, None: not known."""

    change: Change
    unit: Definition | None


class Link(NamedTuple):
    """A connection of the flattened system: ``change`` None where it does no more than convert the FMUs' units."""

    source: Node
    target: Node
    change: Change | None


class Note(NamedTuple):
    """What a reader of the system has to know; ``key``: of the scene, that makes it void when it is set, "" for none."""

    level: Literal["info", "warning"]
    text: str
    key: str = ""


@dataclass
class Network:
    """A system that is being read from ``file``. ``units``: of measure, which connectors declare; times in s."""

    files: Files
    file: FilePath
    title: str = ""
    text: str = ""
    start: float | None = None
    stop: float | None = None
    step: float | None = None
    components: dict[Path, Component] = field(default_factory=dict)
    units: dict[Node, Definition] = field(default_factory=dict)
    into: dict[Node, Edge] = field(default_factory=dict)
    out: dict[Node, list[Edge]] = field(default_factory=dict)
    values: dict[Node, Value] = field(default_factory=dict)
    notes: dict[Note, None] = field(default_factory=dict)

    def say(self, level: Literal["info", "warning"], text: str, key: str = "") -> None:
        """Note something, once; of very many notes the first."""
        if len(self.notes) < MAX_NOTES:
            self.notes.setdefault(Note(level, text, key))
        else:
            self.notes.setdefault(Note("warning", f"more than {MAX_NOTES} remarks: the rest is left out"))

    def fault(self, message: str, place: str) -> SceneError:
        """What is wrong with the system, and where."""
        return SceneError(message, file=self.files.root, key=place)

    def add(self, component: Component, place: str) -> None:
        """Add a component. Raises `SceneError` where its name is taken, or for too many."""
        if component.path in self.components:
            raise self.fault(f"the name {component.path[-1]!r} is taken by another element", place)
        if len(self.components) >= MAX_COMPONENTS:
            raise self.fault(f"more than {MAX_COMPONENTS} components: refused", place)
        self.components[component.path] = component

    def variable(self, node: Node) -> Variable | None:
        """The variable of an FMU that a node is; None for nodes that pass on."""
        component = self.components.get(node[0])
        return component.description.by_name().get(node[1]) if component else None

    def connect(self, edge: Edge) -> None:
        """Add an edge. Raises `SceneError` for a second one into the same node."""
        if edge.target in self.into:
            first = self.into[edge.target].source
            raise self.fault(f"{show(edge.target)} has two sources: {show(first)} and {show(edge.source)}", edge.place)
        self.into[edge.target] = edge
        self.out.setdefault(edge.source, []).append(edge)

    def unit(self, node: Node) -> Definition | None:
        """The unit of measure that a connector declares, else that of the FMU's variable."""
        if node in self.units:
            return self.units[node]
        variable = self.variable(node)
        return definition(self.components[node[0]].description, variable.unit) if variable else None

    def carry(self, carried: Carried, edge: Edge) -> Carried:
        """A value taken along an edge. Raises `SceneError` where two units do not measure the same."""
        return self.arrive(carried, edge.target, edge.raw, edge.change, edge.place)

    def arrive(self, carried: Carried, node: Node, raw: bool, change: Change, place: str) -> Carried:
        """A value that comes to a node, converted to its unit unless ``raw``, and transformed."""
        here = self.unit(node)
        done = carried.change
        if here and carried.unit and not raw and here != carried.unit:
            done = done.then(_converted(carried.unit, here) or self._refuse(carried.unit, here, node, place))
        unknown = carried.unit if not raw else None
        return Carried(done.then(change), here or unknown)

    def _refuse(self, one: Definition, other: Definition, node: Node, place: str) -> Change:
        first, second = base_expression(one[0]), base_expression(other[0])
        raise self.fault(
            f"{show(node)} gets [{first}] and measures [{second}]: the units do not measure the same thing; "
            "suppressUnitConversion passes the number unchanged",
            place,
        )

    # ---- the flattened system ----------------------------------------------------------------------------------------

    def connections(self) -> Iterator[Link]:
        """Every input of a component that is fed by an output of another. Raises `SceneError`."""
        for node, last in self.into.items():
            if node[0] not in self.components:
                continue
            edges = [last]
            while edges[-1].source[0] not in self.components and (before := self.into.get(edges[-1].source)):
                if before in edges:
                    raise self.fault(f"what feeds {show(node)} goes round in a circle", last.place)
                edges.append(before)
            first = edges[-1].source
            if first[0] not in self.components:
                if node not in self.values:
                    text = f"{show(node)} is connected to {show(first)}, which nothing feeds: it keeps its start value"
                    self.say("warning", text)
                continue
            carried = Carried(Change(), self.unit(first))
            for edge in reversed(edges):
                carried = self.carry(carried, edge)
            yield Link(first, node, self._beyond(first, node, carried.change, all(edge.raw for edge in edges)))

    def _beyond(self, source: Node, target: Node, change: Change, raw: bool) -> Change | None:
        """What a connection does, None where that is what the units of both FMUs ask for."""
        one, other = self.variable(source), self.variable(target)
        usual: Change | None = Change()
        if one and other and one.type == "Real" and one.unit and other.unit:
            first = definition(self.components[source[0]].description, one.unit)
            second = definition(self.components[target[0]].description, other.unit)
            if first and second and first != second:
                usual = _converted(first, second)
        return None if change == usual and not (raw and usual is None) else change

    def give(self, node: Node, given: Given) -> bool:
        """Set what a node leads to; whether it leads anywhere. Raises `SceneError`."""
        start = self.arrive(Carried(Change(), given.unit), node, given.raw, given.change, given.place)
        left, seen, found = [(node, start)], {node}, False
        while left:
            here, carried = left.pop()
            if variable := self.variable(here):
                found = True
                self.values[here] = typed(given.value, carried.change, variable)
            elif here[0] not in self.components:
                for edge in self.out.get(here, ()):
                    if edge.target not in seen:
                        seen.add(edge.target)
                        left.append((edge.target, self.carry(carried, edge)))
        return found


def _converted(one: Definition, other: Definition) -> Change | None:
    """From one unit of measure to another, as `towage.scene.values.Names.conversion` does; None for another dimension."""
    if one[0] != other[0]:
        return None
    return Change(one[1] / other[1], (one[2] - other[2]) / other[1])


def typed(value: Value, change: Change, variable: Variable) -> Value:
    """A value, transformed, as the type of a variable where nothing is lost; else as it is, for the scene to refuse."""
    value = change.table.get(text(value), value)
    if isinstance(value, (bool, str)):
        return value
    if (change.factor, change.offset) != (1.0, 0.0):
        value = value * change.factor + change.offset
    if variable.type == "Real":
        return float(value)
    return int(value) if float(value).is_integer() else value


def text(value: Value) -> str:
    """A discrete value as the key of a table."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def show(node: Node) -> str:
    """A node as it is read."""
    return ".".join((*node[0], node[1]))
