"""A scene checked against the descriptions of its units: everything named exists and fits.

Every value becomes a number in the unit that its variable declares, SI for the shipped units; connections get the factor
between two units of the same dimension. Nothing of the FMUs is run.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple

import msgspec

from towage.errors import SceneError, suggest
from towage.fmus.declare.quantities import QuantityError, base_expression, dimension, parse_quantity, unit_definition
from towage.registry import SCHEMES
from towage.scene.scene import Scene
from towage.units.description import Description, Value, Variable

Definition = tuple[tuple[int, ...], float, float]
"""Exponents of the base units, factor and offset of a unit."""


class Connection(NamedTuple):
    """Target value = factor * source value."""

    source_unit: str
    source: str
    target_unit: str
    target: str
    factor: float

    def __str__(self) -> str:
        return f"{self.source_unit}.{self.source} -> {self.target_unit}.{self.target}"


class ResolvedUnit(msgspec.Struct, frozen=True):
    """A unit that exists: its FMU, and the values set on it before the run, in the units its variables declare.
    ``flavour``: python, native, or for a foreign FMU the tool that made it."""

    name: str
    path: Path
    description: Description
    parameters: dict[str, Value]
    flavour: str = ""


class ResolvedScene(msgspec.Struct, frozen=True):
    """A scene in which everything named exists and fits. ``record`` is (unit, variable); ``loops`` the algebraic ones,
    as "a.y -> b.u -> b.y -> a.u -> a.y": solved by the implicit scheme, or only presumed, for want of declarations."""

    scene: Scene
    units: dict[str, ResolvedUnit]
    connections: tuple[Connection, ...]
    record: tuple[tuple[str, str], ...]
    loops: tuple[str, ...]


class Resolver:
    """Checks one scene against the descriptions of its units."""

    def __init__(self, scene: Scene, descriptions: dict[str, Description]) -> None:
        self.scene = scene
        self.descriptions = descriptions
        self.variables = {name: description.by_name() for name, description in descriptions.items()}
        self.values: dict[tuple[str, str], Value] = {}

    def resolved(self) -> ResolvedScene:
        connections = tuple(map(self.connect, range(len(self.scene.connections))))
        self.check_single_sources(connections)
        units = {}
        for name, entry in self.scene.units.items():
            parameters = {parameter: self.value(name, parameter, ()) for parameter in entry.parameters}
            units[name] = ResolvedUnit(name, self.descriptions[name].path, self.descriptions[name], parameters)
        record = self.record()
        self.check_checks()
        self.check_instances()
        loops = _loops(connections, self.descriptions)
        if loops:
            self.check_loops(loops)
        return ResolvedScene(self.scene, units, connections, record, tuple(map(" -> ".join, loops)))

    def check_loops(self, loops: list[tuple[str, ...]]) -> None:
        """Refuse algebraic loops that the scheme cannot solve. FMI counts an output whose unit declares no dependencies
        as direct, and units that cannot restore their state have no implicit scheme: to name a scheme that never goes
        back says that such a loop is only presumed."""
        name, presumed = self.scene.coupling.scheme, not all(map(self.declares, loops))
        if name != "auto":
            scheme = SCHEMES.get(name)
            if scheme.solves_loops or (presumed and not scheme.goes_back):
                return
        note = " (outputs without declared dependencies count as direct)" if presumed else ""
        hint = "; if one of them has a state all the same, say so by scheme 'extrapolate'" if presumed else ""
        raise self.fault(
            f"algebraic loop {'; '.join(map(' -> '.join, loops))}{note}, which scheme {name!r} cannot solve: "
            f"use scheme 'implicit', or break the loop with a unit that has a state{hint}",
            "connections",
        )

    def fault(self, message: str, key: str) -> SceneError:
        return self.scene.error(message, key)

    def find(self, end: str, key: str) -> tuple[str, Variable]:
        """The variable that "unit.variable" names."""
        unit, _, name = end.strip().partition(".")
        if unit not in self.variables:
            raise self.fault(f"{end!r}: there is no unit {unit!r}{suggest(unit, self.variables)}", key)
        if name not in self.variables[unit]:
            raise self.fault(f"{end!r}: {unit} has no variable {name!r}{suggest(name, self.variables[unit])}", key)
        return unit, self.variables[unit][name]

    def connect(self, index: int) -> Connection:
        key, text = f"connections[{index}]", self.scene.connections[index]
        (source_unit, source), (target_unit, target) = (self.find(end, key) for end in text.split(" -> ", 1))
        if source.causality != "output":
            raise self.fault(f"{source_unit}.{source.name} is {_a(source.causality)}: expected an output", key)
        if target.causality != "input":
            raise self.fault(f"{target_unit}.{target.name} is {_a(target.causality)}: expected an input", key)
        if source.type != target.type:
            raise self.fault(f"{text!r} joins {source.type} to {target.type}: the types must agree", key)
        if source.type != "Real":
            raise self.fault(f"{text!r} carries {source.type}: only Real signals are coupled", key)
        return Connection(
            source_unit,
            source.name,
            target_unit,
            target.name,
            self.factor(text, source_unit, source, target_unit, target, key),
        )

    def factor(self, text: str, unit: str, source: Variable, to: str, target: Variable, key: str) -> float:
        """By what a value of ``source`` is multiplied for ``target``. An undeclared unit fits every other."""
        if source.unit is None or target.unit is None or source.type != "Real":
            return 1.0
        ours, theirs = self.definition(unit, source.unit), self.definition(to, target.unit)
        if ours == theirs and (ours is not None or source.unit == target.unit):
            return 1.0
        if ours is None or theirs is None:
            which = source.unit if ours is None else target.unit
            raise self.fault(f"{text!r}: unit {which!r} is defined nowhere, so it cannot be converted", key)
        if ours[0] != theirs[0] or ours[2] != theirs[2]:
            first, second = (f"{v.unit} [{base_expression(d[0])}]" for v, d in ((source, ours), (target, theirs)))
            raise self.fault(f"{text!r} joins {first} to {second}: the units do not measure the same thing", key)
        return ours[1] / theirs[1]

    def definition(self, unit: str, name: str) -> Definition | None:
        """(exponents, factor, offset) of a unit: as its FMU defines it, else as towage does, else None."""
        if own := self.descriptions[unit].units.get(name):
            return own.exponents, own.factor, own.offset
        return _known(name)

    def check_single_sources(self, connections: tuple[Connection, ...]) -> None:
        fed: dict[tuple[str, str], Connection] = {}
        for index, connection in enumerate(connections):
            first = fed.setdefault((connection.target_unit, connection.target), connection)
            if first is not connection:
                target = f"{connection.target_unit}.{connection.target}"
                message = f"{target} has two sources: {first.source_unit}.{first.source} and "
                raise self.fault(f"{message}{connection.source_unit}.{connection.source}", f"connections[{index}]")

    def value(self, unit: str, name: str, path: tuple[tuple[str, str], ...]) -> Value:
        """The value given to a parameter or input, in its declared unit; ``path`` are the references that led here."""
        key = f"units.{unit}.parameters.{name}"
        if (unit, name) in path:
            cycle = " -> ".join(f"{u}.{n}" for u, n in (*path[path.index((unit, name)) :], (unit, name)))
            raise self.fault(f"circular reference {cycle}", key)
        if (unit, name) not in self.values:
            _, variable = self.find(f"{unit}.{name}", key)
            if variable.causality not in ("parameter", "input") or variable.variability == "constant":
                raise self.fault(f"{name!r} is {_a(variable.causality)}: only parameters and inputs can be set", key)
            given = self.scene.units[unit].parameters[name]
            if isinstance(given, str) and given.lstrip().startswith("="):
                given = self.referenced(unit, variable, given.lstrip()[1:].strip(), (*path, (unit, name)), key)
            self.values[unit, name] = self.checked(unit, variable, given, key)
        return self.values[unit, name]

    def referenced(self, unit: str, variable: Variable, end: str, path: tuple[tuple[str, str], ...], key: str) -> Value:
        """The value of another parameter: as the scene sets it, else its start value."""
        other, source = self.find(end, key)
        if source.causality not in ("parameter", "input"):
            raise self.fault(f"'= {end}' is {_a(source.causality)}: its value is known only during a run", key)
        if (source.type == "String") != (variable.type == "String"):
            raise self.fault(f"'= {end}' is {source.type}, expected {variable.type}", key)
        if source.name in self.scene.units[other].parameters:
            value: Value | None = self.value(other, source.name, path)
        else:
            value = source.start
        if value is None:
            raise self.fault(f"'= {end}' has no start value: give it one", key)
        factor = self.factor(f"= {end}", other, source, unit, variable, key)
        return value if isinstance(value, (bool, str)) or factor == 1.0 else value * factor

    def checked(self, unit: str, variable: Variable, given: Value, key: str) -> Value:
        """``given`` as a value of the variable's type, inside its bounds."""
        value: Value = given
        if variable.type == "Real" and isinstance(given, str):
            value = self.quantity(unit, variable, given, key)
        elif variable.type == "Real" and isinstance(given, int) and not isinstance(given, bool):
            value = float(given) if abs(given) < 2**1000 else math.inf
        expected = {"Real": float, "Boolean": bool, "String": str}.get(variable.type, int)
        if type(value) is not expected:
            raise self.fault(f"{given!r} is no {variable.type}, as {variable.name} is", key)
        if isinstance(value, (bool, str)):
            return value
        if not math.isfinite(value):
            raise self.fault(f"{given!r} is not finite", key)
        low = -math.inf if variable.min is None else variable.min
        high = math.inf if variable.max is None else variable.max
        if variable.type != "Real":
            low, high = max(low, -(2**31)), min(high, 2**31 - 1)
        if not low <= value <= high:
            suffix = f" {variable.unit}" if variable.unit not in (None, "1") else ""
            written = f" ({given})" if isinstance(given, str) else ""
            raise self.fault(
                f"{value!r}{suffix}{written} is out of range: expected {low:.9g} to {high:.9g}{suffix}", key
            )
        return value

    def quantity(self, unit: str, variable: Variable, text: str, key: str) -> float:
        """A text with a unit, in the unit that the variable declares."""
        if variable.unit is None:
            raise self.fault(f"{text!r}: {variable.name} declares no unit, write a plain number", key)
        declared, known = self.definition(unit, variable.unit), _known(variable.unit)
        if declared is None:
            raise self.fault(f"unit {variable.unit!r} of {variable.name} is defined nowhere, write a plain number", key)
        try:
            if declared == known:
                return parse_quantity(text, variable.unit)
            exponents, factor, offset = declared
            return (parse_quantity(text, base_expression(exponents)) - offset) / factor
        except QuantityError as error:
            raise self.fault(f"{error} (the unit of {variable.name} is {variable.unit})", key) from None

    def record(self) -> tuple[tuple[str, str], ...]:
        names = self.scene.record.variables
        if names is None:
            every = ((unit, v) for unit, variables in self.variables.items() for v in variables.values())
            return tuple((unit, v.name) for unit, v in every if v.causality == "output" and v.type == "Real")
        found = [self.find(name, f"record.variables[{index}]") for index, name in enumerate(names)]
        for index, (unit, variable) in enumerate(found):
            if variable.type != "Real":
                raise self.fault(
                    f"{unit}.{variable.name} is {variable.type}: only Real variables are recorded",
                    f"record.variables[{index}]",
                )
        return tuple(dict.fromkeys((unit, variable.name) for unit, variable in found))

    def check_checks(self) -> None:
        checks = self.scene.checks
        for index, name in enumerate(checks.report_only):
            key = f"checks.report_only[{index}]"
            _, variable = self.find(name, key)
            if not variable.name.startswith("margin_"):
                raise self.fault(f"{name!r} is no margin: expected 'unit.margin_...'", key)
        if checks.simpler:
            margin = checks.simpler.margin
            names = {f"motions[{k}]": name for k, name in enumerate(checks.simpler.motions)}
            recorded = self.record()
            for place, name in (names | ({"margin": margin} if margin else {})).items():
                key = f"checks.simpler.{place}"
                unit, variable = self.find(name, key)
                if (unit, variable.name) not in recorded:
                    raise self.fault(f"{name!r} is not recorded: add it to record.variables", key)
            Resolver(self.scene.simpler(), self.descriptions).resolved()
        if checks.sdof is None:
            return
        for index, cut in enumerate(checks.sdof.cut):
            if cut not in self.scene.connections:
                hint = suggest(cut, self.scene.connections)
                raise self.fault(f"there is no connection {cut!r}{hint}", f"checks.sdof.cut[{index}]")
        for field in ("driver", "motion", "tension"):
            unit, variable = self.find(getattr(checks.sdof, field), f"checks.sdof.{field}")
            if variable.type != "Real":
                raise self.fault(f"{unit}.{variable.name} is {variable.type}, expected Real", f"checks.sdof.{field}")

    def check_instances(self) -> None:
        """A unit that a process may hold once: not twice in the scene, and no second run beside the first."""
        scene, seen = self.scene, set()
        for name, description in self.descriptions.items():
            if not description.once_per_process:
                continue
            if description.path in seen:
                raise self.fault(f"{description.path.name} can be instantiated only once in a process", f"units.{name}.fmu")
            if scene.coupling.error_estimate or scene.checks.sdof or scene.checks.simpler:
                raise self.fault(
                    f"{description.path.name} can be instantiated only once in a process, so that there is no second run to "
                    "compare with: set coupling.error_estimate = false and leave out checks.sdof and checks.simpler",
                    f"units.{name}.fmu",
                )
            seen.add(description.path)

    def declares(self, loop: tuple[str, ...]) -> bool:
        """Whether every output on the loop declares its dependencies."""
        ends = (node.partition(".") for node in loop)
        return all(self.descriptions[unit].dependencies.get(name, ()) is not None for unit, _, name in ends)


def _known(unit: str) -> Definition | None:
    """A unit as towage defines it."""
    try:
        return dimension(unit), unit_definition(unit)[1], 0.0
    except QuantityError:
        return None


def _a(causality: str) -> str:
    return ("an " if causality[0] in "io" else "a ") + re.sub("(?<=[a-z])(?=[A-Z])", " ", causality).lower()


def _loops(connections: tuple[Connection, ...], descriptions: dict[str, Description]) -> list[tuple[str, ...]]:
    """A shortest cycle through each output that can reach itself by connections and direct dependencies, each once."""
    after: dict[str, list[str]] = {}
    for c in connections:
        after.setdefault(f"{c.source_unit}.{c.source}", []).append(f"{c.target_unit}.{c.target}")
        for output, inputs in descriptions[c.target_unit].dependencies.items():
            if inputs is None or c.target in inputs:
                after.setdefault(f"{c.target_unit}.{c.target}", []).append(f"{c.target_unit}.{output}")
    loops: list[tuple[str, ...]] = []
    for start in dict.fromkeys(f"{c.source_unit}.{c.source}" for c in connections):
        if any(start in loop for loop in loops):
            continue
        before: dict[str, str] = {}
        queue = [start]
        while queue and start not in before:
            node = queue.pop(0)
            for following in after.get(node, ()):
                if following not in before:
                    before[following] = node
                    queue.append(following)
        if start in before:
            loop = [start, before[start]]
            while loop[-1] != start:
                loop.append(before[loop[-1]])
            loops.append(tuple(reversed(loop)))
    return loops
