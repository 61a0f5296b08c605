"""Names and values of a scene against the descriptions of its units: everything named exists, every value is a number in
the unit that its variable declares (SI for the shipped units)."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from towage.errors import SceneError, suggest
from towage.fmus.declare.quantities import base_expression, parse_quantity
from towage.scene.scene import Scene
from towage.units.conventions import Definition, definition, known
from towage.units.description import Description, Value, Variable

References = tuple[tuple[str, str], ...]
"""Parameters, as (unit, name), that refer to one another."""
LARGEST_INTEGER = 2**31 - 1
"""FMI's Integer has 32 bits."""


class Names:
    """The variables of a scene's units by name; every fault is a `SceneError` with the key of the scene."""

    def __init__(self, scene: Scene, descriptions: Mapping[str, Description]) -> None:
        self.scene = scene
        self.descriptions = descriptions
        self.variables = {name: description.by_name() for name, description in descriptions.items()}
        self.warnings: list[str] = []

    def fault(self, message: str, key: str) -> SceneError:
        """A fault of the scene."""
        return self.scene.error(message, key)

    def find(self, end: str, key: str) -> tuple[str, Variable]:
        """(unit, variable) that "unit.variable" names. Raises `SceneError`."""
        unit, _, name = end.strip().partition(".")
        if unit not in self.variables:
            raise self.fault(f"{end!r}: there is no unit {unit!r}{suggest(unit, self.variables)}", key)
        if name not in self.variables[unit]:
            raise self.fault(f"{end!r}: {unit} has no variable {name!r}{suggest(name, self.variables[unit])}", key)
        return unit, self.variables[unit][name]

    def exists(self, end: str) -> bool:
        """Whether "unit.variable" names one."""
        unit, _, name = end.strip().partition(".")
        return name in self.variables.get(unit, ())

    def record(self) -> tuple[tuple[str, str], ...]:
        """(unit, variable) of everything that is recorded. Raises `SceneError`."""
        names = self.scene.record.variables
        if names is None:
            every = ((unit, v) for unit, variables in self.variables.items() for v in variables.values())
            return tuple((unit, v.name) for unit, v in every if v.causality == "output")
        named = [self.find(name, f"record.variables[{index}]") for index, name in enumerate(names)]
        return tuple(dict.fromkeys((unit, variable.name) for unit, variable in named))

    def recorded(self, end: str, key: str) -> tuple[str, Variable]:
        """`find` of a variable that the run records. Raises `SceneError`."""
        unit, variable = self.find(end, key)
        if (unit, variable.name) not in self.record():
            raise self.fault(f"{end!r} is not recorded: add it to record.variables", key)
        return unit, variable

    def conversion(
        self, text: str, unit: str, source: Variable, to: str, target: Variable, key: str
    ) -> tuple[float, float]:
        """(factor, offset): target = factor * source + offset. An undeclared unit of measure fits every other; one that is
        defined nowhere too, with a warning."""
        if source.unit is None or target.unit is None or source.type != "Real":
            return 1.0, 0.0
        ours, theirs = self.definition(unit, source.unit), self.definition(to, target.unit)
        if ours == theirs and (ours is not None or source.unit == target.unit):
            return 1.0, 0.0
        if ours is None or theirs is None:
            which, other = (source.unit, target.unit) if ours is None else (target.unit, source.unit)
            self.warnings.append(
                f"{text!r}: {which!r} is defined nowhere, so values pass unchanged, as if it were {other!r}"
            )
            return 1.0, 0.0
        if ours[0] != theirs[0]:
            first, second = (f"{v.unit} [{base_expression(d[0])}]" for v, d in ((source, ours), (target, theirs)))
            raise self.fault(f"{text!r} joins {first} to {second}: the units do not measure the same thing", key)
        return ours[1] / theirs[1], (ours[2] - theirs[2]) / theirs[1]

    def definition(self, unit: str, name: str) -> Definition | None:
        """A unit of measure as the FMU of ``unit`` defines it, else as towage does, else None."""
        return definition(self.descriptions[unit], name)


class Values:
    """The values that a scene gives to parameters and inputs."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self._known: dict[tuple[str, str], Value] = {}

    def of(self, unit: str) -> dict[str, Value]:
        """All values given to a unit, in the units of measure that its variables declare. Raises `SceneError`."""
        return {name: self._value(unit, name, ()) for name in self._names.scene.units[unit].values}

    def _value(self, unit: str, name: str, path: References) -> Value:
        """The value given to a parameter or input; ``path`` are the references that led here."""
        entry = self._names.scene.units[unit]
        key = f"units.{unit}.{entry.table(name)}.{name}"
        if (unit, name) in path:
            cycle = " -> ".join(f"{u}.{n}" for u, n in (*path[path.index((unit, name)) :], (unit, name)))
            raise self._names.fault(f"circular reference {cycle}", key)
        if (unit, name) not in self._known:
            _, variable = self._names.find(f"{unit}.{name}", key)
            if not settable(variable):
                kind = with_article(variable.causality)
                message = "only parameters and inputs can be set, and what has a start value of its own"
                raise self._names.fault(f"{name!r} is {kind}: {message}", key)
            if name in entry.inputs and variable.causality != "input":
                raise self._names.fault(f"{name!r} is a parameter: set it in [units.{unit}.parameters]", key)
            given = entry.values[name]
            if isinstance(given, str) and given.lstrip().startswith("="):
                given = self._referenced(unit, variable, given.lstrip()[1:].strip(), (*path, (unit, name)), key)
            self._known[unit, name] = self._checked(unit, variable, given, key)
        return self._known[unit, name]

    def _referenced(self, unit: str, variable: Variable, end: str, path: References, key: str) -> Value:
        """The value of another parameter: as the scene sets it, else its start value."""
        other, source = self._names.find(end, key)
        if source.causality not in ("parameter", "input"):
            kind = with_article(source.causality)
            raise self._names.fault(f"'= {end}' is {kind}: its value is known only during a run", key)
        if (source.type == "String") != (variable.type == "String"):
            raise self._names.fault(f"'= {end}' is {source.type}, expected {variable.type}", key)
        if source.name in self._names.scene.units[other].values:
            value: Value | None = self._value(other, source.name, path)
        else:
            value = source.start
        if value is None:
            raise self._names.fault(f"'= {end}' has no start value: give it one", key)
        factor, offset = self._names.conversion(f"= {end}", other, source, unit, variable, key)
        return value if isinstance(value, (bool, str)) or (factor, offset) == (1.0, 0.0) else value * factor + offset

    def _checked(self, unit: str, variable: Variable, given: Value, key: str) -> Value:
        """``given`` as a value of the variable's type, inside its bounds."""
        value: Value = variable.items.get(given, given) if isinstance(given, str) else given
        if variable.type == "Real" and isinstance(given, str):
            value = self._quantity(unit, variable, given, key)
        elif variable.type == "Real" and isinstance(given, int) and not isinstance(given, bool):
            value = float(given) if abs(given) < 2**1000 else math.inf
        expected = {"Real": float, "Boolean": bool, "String": str, "Binary": str}.get(variable.type, int)
        if variable.type == "Binary" and not re.fullmatch(r"([0-9a-fA-F]{2}|\s)*", str(value)):
            raise self._names.fault(f"{given!r} is no Binary: write hexadecimal digits, two a byte", key)
        if type(value) is not expected:
            items = ", ".join(variable.items)
            hint = f"{suggest(str(given), variable.items)}; expected one of: {items}" if items else ""
            raise self._names.fault(f"{given!r} is no {variable.type}, as {variable.name} is{hint}", key)
        if isinstance(value, (bool, str)):
            return value
        if not math.isfinite(value):
            raise self._names.fault(f"{given!r} is not finite", key)
        low = -math.inf if variable.min is None else variable.min
        high = math.inf if variable.max is None else variable.max
        if variable.type != "Real":
            low, high = max(low, -LARGEST_INTEGER - 1), min(high, LARGEST_INTEGER)
        if not low <= value <= high:
            suffix = f" {variable.unit}" if variable.unit not in (None, "1") else ""
            written = f" ({given})" if isinstance(given, str) else ""
            raise self._names.fault(
                f"{value!r}{suffix}{written} is out of range: expected {low:.9g} to {high:.9g}{suffix}", key
            )
        return value

    def _quantity(self, unit: str, variable: Variable, text: str, key: str) -> float:
        """A text with a unit of measure, in the one that the variable declares."""
        if variable.unit is None:
            raise self._names.fault(f"{text!r}: {variable.name} declares no unit, write a plain number", key)
        declared, ours = self._names.definition(unit, variable.unit), known(variable.unit)
        if declared is None:
            message = f"unit {variable.unit!r} of {variable.name} is defined nowhere, write a plain number"
            raise self._names.fault(message, key)
        try:
            exponents, factor, offset = declared
            number, _, name = text.strip().partition(" ")
            own = self._names.descriptions[unit].units.get(name.strip())  # a unit that the FMU defines, as degC
            if own and own.exponents == exponents and known(name.strip()) is None:
                return (float(number) * own.factor + own.offset - offset) / factor
            if declared == ours:
                return parse_quantity(text, variable.unit)
            return (parse_quantity(text, base_expression(exponents)) - offset) / factor
        except ValueError as error:
            raise self._names.fault(f"{error} (the unit of {variable.name} is {variable.unit})", key) from None


def settable(variable: Variable) -> bool:
    """Whether a variable may be given a value before a run: a parameter, an input, or one whose start value is not calculated."""
    if variable.variability == "constant":
        return False
    return variable.causality in ("parameter", "input") or variable.initial in ("exact", "approx")


def with_article(causality: str) -> str:
    """A causality of FMI in words, "a calculated parameter"."""
    return ("an " if causality[0] in "io" else "a ") + re.sub("(?<=[a-z])(?=[A-Z])", " ", causality).lower()
