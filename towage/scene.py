"""Scenes: what is coupled to what, with which values; read from TOML, then checked against the units' descriptions.

``Scene`` is the file's content, times in s, everything else as written. ``Scene.resolve`` looks at the FMUs'
descriptions (no code of theirs runs) and returns a ``ResolvedScene`` in which every name exists and every value is a
number in the unit that its variable declares: SI for the shipped units. Every fault is a ``SceneError`` that names
file and key.
"""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Callable, Iterable
from copy import deepcopy
from pathlib import Path
from typing import Any, Literal, NamedTuple, NoReturn, TypeVar, get_args

import msgspec

from towage.archive import Description, Value, Variable, read_description
from towage.errors import SceneError, TowageError
from towage.fmus.quantities import QuantityError, base_expression, dimension, parse_quantity, unit_definition

S = TypeVar("S", bound=msgspec.Struct)
Scheme = Literal["auto", "hermite", "extrapolate", "implicit", "jacobi", "gauss-seidel"]
Locate = Callable[[str], Path]
"""From the name of a shipped unit to its FMU; raises ``LookupError`` for a name it does not know."""

SHIPPED = Path(__file__).parent / "scenes"
_SCHEMES: tuple[str, ...] = get_args(Scheme)
Definition = tuple[tuple[int, ...], float, float]
"""Exponents of the base units, factor and offset of a unit."""
_ORIGIN = ("file", "source")
_SETTABLE = ("title", "description", "stop_time", "coupling", "record", "checks")
_EXCLUSIVE = {"coupling.step": "coupling.tolerance", "coupling.tolerance": "coupling.step"}
_TIMES = ("stop_time", "step", "interval", "settle")
_NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")
_CONNECTION = re.compile(r"\s*([^.\s]+)\.(.+?)\s*->\s*([^.\s]+)\.(.+?)\s*")


class UnitEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[units.NAME]``: a shipped unit's name or the path of an .fmu, and values as written."""

    fmu: str
    parameters: dict[str, Value] = {}


class Coupling(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[coupling]``: exactly one of ``step`` (s) and ``tolerance`` (relative error of the coupling) is given."""

    scheme: Scheme = "auto"
    step: float | None = None
    tolerance: float | None = None
    events: bool = True
    error_estimate: bool = True


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[record]``: interval in s, None for every communication point; variables, None for all numeric outputs."""

    interval: float | None = None
    variables: tuple[str, ...] | None = None


class SdofCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks.sdof]``: the run is repeated without ``cut``; ``settle`` in s, compared from there on."""

    cut: tuple[str, ...]
    driver: str
    motion: str
    tension: str
    tolerance: float = 0.05
    settle: float = 0.0


class Checks(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks]``; ``report_only`` names margins that do not decide."""

    sdof: SdofCheck | None = None
    report_only: tuple[str, ...] = ()


class Case(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[[cases]]``: values that replace those of the scene, under "unit.parameter", "coupling.step", "stop_time"."""

    name: str
    set: dict[str, Any] = {}


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
    """A unit that exists: its FMU, and the values set on it before the run, in the units its variables declare."""

    name: str
    path: Path
    description: Description
    parameters: dict[str, Value]


class ResolvedScene(msgspec.Struct, frozen=True):
    """A scene in which everything named exists and fits. ``record`` is (unit, variable); ``loops`` the algebraic ones,
    as "a.y -> b.u -> b.y -> a.u -> a.y", empty unless the scheme is implicit."""

    scene: Scene
    units: dict[str, ResolvedUnit]
    connections: tuple[Connection, ...]
    record: tuple[tuple[str, str], ...]
    loops: tuple[str, ...]


class SceneSummary(NamedTuple):
    """A shipped scene."""

    name: str
    title: str


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A scene file. Connections are spelled "unit.output -> unit.input", with single spaces.

    ``file`` and ``source`` are where it was read from and its text, None and "" for a scene made from a dict.
    """

    title: str
    stop_time: float
    units: dict[str, UnitEntry]
    coupling: Coupling
    description: str = ""
    connections: tuple[str, ...] = ()
    record: Record = Record()
    checks: Checks = Checks()
    cases: tuple[Case, ...] = ()
    file: Path | None = None
    source: str = ""

    @classmethod
    def load(cls, path_or_name: str | Path, search: Iterable[Path] = ()) -> Scene:
        """The scene in a file, or of a name in one of the directories of ``search`` or among the shipped ones."""
        path = _find(path_or_name, (*search, SHIPPED))
        try:
            text = path.read_text("utf-8")
            data = tomllib.loads(text)
        except (OSError, UnicodeDecodeError) as error:
            raise SceneError(f"cannot be read: {error}", file=path) from error
        except (tomllib.TOMLDecodeError, RecursionError) as error:
            raise SceneError(f"is not valid TOML: {error}", file=path) from error
        return msgspec.structs.replace(cls.from_dict(data, path), source=text)

    @classmethod
    def from_dict(cls, data: dict[str, Any], file: Path | None = None) -> Scene:
        """The scene in ``data``, as tomllib gives it; checked as far as that is possible without the units."""
        scene = _Reader(file).scene(deepcopy(data))
        for case in scene.cases:
            scene.case(case.name)
        return scene

    def case(self, name: str) -> Scene:
        """The scene with the values of a case; setting ``coupling.step`` drops the tolerance, and the reverse."""
        found = {case.name: case for case in self.cases}
        if name not in found:
            raise self.error(f"unknown case {name!r}" + _suggest(name, found), "cases")
        settings, key = found[name].set, f"cases.{name}.set"
        data = msgspec.to_builtins(msgspec.structs.replace(self, file=None, source="", cases=()))
        data = {field: value for field, value in data.items() if field not in (*_ORIGIN, "cases")}
        for target, other in _EXCLUSIVE.items():
            if target in settings and other not in settings:
                data["coupling"][other.removeprefix("coupling.")] = None
        for target, value in settings.items():
            head, _, rest = target.partition(".")
            *tables, last = ("units", head, "parameters", rest) if head in self.units else target.split(".")
            place: Any = data if head in _SETTABLE or head in self.units else None
            for table in tables:
                place = place.get(table) if isinstance(place, dict) else None
            if not isinstance(place, dict) or not last or (head not in self.units and last not in place):
                known = [*(f"{unit}.{last}" for unit in self.units), *_EXCLUSIVE, "coupling.scheme", "stop_time"]
                hint = _suggest(target, known)
                raise self.error(
                    f"{target!r} cannot be set: expected 'unit.parameter' or a key of the scene{hint}", key
                )
            place[last] = value
        try:
            scene = _Reader(self.file).scene(data)
        except SceneError as error:
            raise self.error(f"{error.key}: {error.args[0]}", key) from None
        return msgspec.structs.replace(scene, cases=self.cases, source=self.source)

    def without(self, connections: Iterable[str]) -> Scene:
        """The one-way scene: these connections left out, and with them the comparison that names them."""
        reader = _Reader(self.file)
        cut = {reader.connection(text, "connections") for text in connections}
        if missing := cut - set(self.connections):
            one = min(missing)
            raise self.error(f"there is no connection {one!r}" + _suggest(one, self.connections), "connections")
        rest = tuple(text for text in self.connections if text not in cut)
        checks = msgspec.structs.replace(self.checks, sdof=None)
        return msgspec.structs.replace(self, connections=rest, checks=checks)

    def resolve(self, locate: Locate) -> ResolvedScene:
        """Check everything, the cases too, against the descriptions of the units. Raises ``SceneError``, and
        ``FmuError`` for an FMU that is refused; a ``LookupError`` or ``OSError`` of ``locate`` becomes a ``SceneError``.
        """
        paths = {name: self._path(name, entry.fmu, locate) for name, entry in self.units.items()}
        read = {path: read_description(path) for path in dict.fromkeys(paths.values())}
        descriptions = {name: read[path] for name, path in paths.items()}
        resolved = _Resolver(self, descriptions).resolved()
        for case in self.cases:
            variant = msgspec.structs.replace(self.case(case.name), cases=())
            try:
                _Resolver(variant, descriptions).resolved()
            except SceneError as error:
                raise self.error(f"{error.key}: {error.args[0]}", f"cases.{case.name}.set") from None
        return resolved

    def _path(self, name: str, fmu: str, locate: Locate) -> Path:
        key = f"units.{name}.fmu"
        if fmu.endswith(".fmu"):
            path = (self.file.parent if self.file else Path()) / fmu
            if not path.is_file():
                raise self.error(f"there is no file {path}", key)
            return path
        try:
            return locate(fmu)
        except TowageError:
            raise
        except (LookupError, OSError) as error:
            raise self.error(
                f"no unit {fmu!r} ({error}): expected a shipped unit or the path of an .fmu", key
            ) from error

    def error(self, message: str, key: str) -> SceneError:
        """A fault of this scene."""
        return SceneError(message, file=self.file, key=key)


def available_scenes() -> tuple[SceneSummary, ...]:
    """The shipped scenes by name. Raises ``SceneError`` for one that cannot be read."""
    return tuple(SceneSummary(path.stem, Scene.load(path).title) for path in sorted(SHIPPED.glob("*.toml")))


def _find(path_or_name: str | Path, directories: tuple[Path, ...]) -> Path:
    given = Path(path_or_name)
    candidates = [given, *(d / f"{given.name}.toml" for d in directories if given.name == str(given))]
    for path in candidates:
        if path.is_file():
            return path
    names = sorted({path.stem for directory in directories for path in directory.glob("*.toml")})
    hint = _suggest(given.stem, names) or f"; known scenes: {', '.join(names) or 'none'}"
    raise SceneError(f"no such file or scene{hint}", file=given)


def _suggest(word: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(word, list(known), n=2, cutoff=0.6)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


class _Reader:
    """Turns the tables of a file into structures; knows nothing of the units' variables."""

    def __init__(self, file: Path | None) -> None:
        self.file = file

    def fail(self, message: str, key: str) -> NoReturn:
        raise SceneError(message, file=self.file, key=key)

    def scene(self, top: dict[str, Any]) -> Scene:
        """The scene; ``top`` is changed."""
        units = self.table(top.get("units", {}), "units")
        for name, entry in units.items():
            if not _NAME.fullmatch(name) or name in Scene.__struct_fields__:
                self.fail(f"{name!r} cannot name a unit: expected letters, digits, '_', and no key of a scene", "units")
            key = f"units.{name}.parameters"
            for parameter, value in self.table(self.table(entry, key[:-11]).get("parameters", {}), key).items():
                if not isinstance(value, (bool, int, float, str)):
                    self.fail(f"expected a number, a text or a truth value, got {value!r}", f"{key}.{parameter}")
            units[name] = self.convert(entry, UnitEntry, f"units.{name}")
        if "coupling" not in top:
            self.fail("missing: give it a step or a tolerance", "coupling")
        scheme = self.table(top["coupling"], "coupling").get("scheme")
        if isinstance(scheme, str) and scheme not in _SCHEMES:
            hint = _suggest(scheme, _SCHEMES)
            self.fail(f"unknown scheme {scheme!r}{hint}; expected one of: {', '.join(_SCHEMES)}", "coupling.scheme")
        top["coupling"] = self.convert(top["coupling"], Coupling, "coupling")
        top["record"] = self.convert(top.get("record", {}), Record, "record")
        checks = self.table(top.get("checks", {}), "checks")
        if checks.get("sdof") is not None:
            sdof = self.convert(checks["sdof"], SdofCheck, "checks.sdof")
            cut = tuple(self.connection(text, f"checks.sdof.cut[{i}]") for i, text in enumerate(sdof.cut))
            checks["sdof"] = msgspec.structs.replace(sdof, cut=cut)
        top["checks"] = self.convert(checks, Checks, "checks")
        if not isinstance(cases := top.get("cases", []), list | tuple):
            self.fail("expected an array of tables, [[cases]]", "cases")
        top["cases"] = tuple(self.convert(case, Case, f"cases[{index}]") for index, case in enumerate(cases))
        scene = self.convert(top, Scene, "")
        spelled = tuple(self.connection(text, f"connections[{i}]") for i, text in enumerate(scene.connections))
        scene = msgspec.structs.replace(scene, connections=spelled, file=self.file)
        self.check(scene)
        return scene

    def table(self, value: object, key: str) -> dict[str, Any]:
        if not isinstance(value, dict):
            self.fail(f"expected a table, got {value!r}", key)
        return value

    def convert(self, value: object, into: type[S], key: str) -> S:
        """A table as the structure ``into``, times in s."""
        content, fields = self.table(value, key), [f for f in into.__struct_fields__ if f not in _ORIGIN]
        for name in content:
            if name not in fields:
                hint = _suggest(name, fields) or f"; expected one of: {', '.join(fields)}"
                self.fail(f"unknown key{hint}", f"{key}.{name}".strip("."))
        for name in content.keys() & set(_TIMES):
            if isinstance(content[name], str):
                try:
                    content[name] = parse_quantity(content[name], "s")
                except QuantityError as error:
                    self.fail(str(error), f"{key}.{name}".strip("."))
        try:
            return msgspec.convert(content, into)
        except msgspec.ValidationError as error:
            message, _, place = str(error).partition(" - at `$")
            self.fail(message, (key + place.rstrip("`")).strip("."))

    def connection(self, text: str, key: str) -> str:
        """The connection in its one spelling."""
        match = _CONNECTION.fullmatch(text)
        if match is None:
            self.fail(f"{text!r} is no connection: expected 'unit.output -> unit.input'", key)
        return "{}.{} -> {}.{}".format(*match.groups())

    def check(self, scene: Scene) -> None:
        """Numbers and names that can be judged without the units."""
        coupling, sdof = scene.coupling, scene.checks.sdof
        if not scene.units:
            self.fail("a scene needs at least one unit", "units")
        if (coupling.step is None) == (coupling.tolerance is None):
            given = "neither is given" if coupling.step is None else "both are given"
            self.fail(f"exactly one of step and tolerance is needed, {given}", "coupling")
        values = {
            "stop_time": scene.stop_time,
            "coupling.step": coupling.step,
            "coupling.tolerance": coupling.tolerance,
            "record.interval": scene.record.interval,
            "checks.sdof.tolerance": sdof.tolerance if sdof else None,
        }
        for key, value in values.items():
            if value is not None and not (0.0 < value < math.inf):
                self.fail(f"{value} is out of range: expected a finite number above 0", key)
        if coupling.tolerance is not None and coupling.tolerance >= 1.0:
            self.fail(f"{coupling.tolerance} is out of range: a relative error is below 1", "coupling.tolerance")
        for key in ("coupling.step", "record.interval"):
            length = values[key]
            if length is not None and length > scene.stop_time:
                self.fail(f"{length} s is longer than stop_time, {scene.stop_time} s", key)
        if sdof and not (0.0 <= sdof.settle < scene.stop_time):
            self.fail(f"{sdof.settle} s is out of range: expected 0 s to {scene.stop_time} s", "checks.sdof.settle")
        names = [case.name for case in scene.cases]
        for index, name in enumerate(names):
            if not name.strip() or name in names[:index]:
                self.fail(f"case name {name!r} is empty or used twice", f"cases[{index}].name")


class _Resolver:
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
        loops = _loops(connections, self.descriptions)
        named = "; ".join(map(" -> ".join, loops))
        if loops and self.scene.coupling.scheme != "implicit":
            note = "" if all(map(self.declares, loops)) else " (outputs without declared dependencies count as direct)"
            raise self.fault(
                f"algebraic loop {named}{note}, which scheme {self.scene.coupling.scheme!r} cannot solve: "
                "use scheme 'implicit', or break the loop with a unit that has a state",
                "connections",
            )
        return ResolvedScene(self.scene, units, connections, record, tuple(map(" -> ".join, loops)))

    def fault(self, message: str, key: str) -> SceneError:
        return self.scene.error(message, key)

    def find(self, end: str, key: str) -> tuple[str, Variable]:
        """The variable that "unit.variable" names."""
        unit, _, name = end.strip().partition(".")
        if unit not in self.variables:
            raise self.fault(f"{end!r}: there is no unit {unit!r}{_suggest(unit, self.variables)}", key)
        if name not in self.variables[unit]:
            raise self.fault(f"{end!r}: {unit} has no variable {name!r}{_suggest(name, self.variables[unit])}", key)
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
            return tuple((unit, v.name) for unit, v in every if v.causality == "output" and v.type != "String")
        found = [self.find(name, f"record.variables[{index}]") for index, name in enumerate(names)]
        for index, (unit, variable) in enumerate(found):
            if variable.type == "String":
                raise self.fault(
                    f"{unit}.{variable.name} is a text: only numbers are recorded", f"record.variables[{index}]"
                )
        return tuple(dict.fromkeys((unit, variable.name) for unit, variable in found))

    def check_checks(self) -> None:
        checks = self.scene.checks
        for index, name in enumerate(checks.report_only):
            key = f"checks.report_only[{index}]"
            _, variable = self.find(name, key)
            if not variable.name.startswith("margin_"):
                raise self.fault(f"{name!r} is no margin: expected 'unit.margin_...'", key)
        if checks.sdof is None:
            return
        for index, cut in enumerate(checks.sdof.cut):
            if cut not in self.scene.connections:
                hint = _suggest(cut, self.scene.connections)
                raise self.fault(f"there is no connection {cut!r}{hint}", f"checks.sdof.cut[{index}]")
        for field in ("driver", "motion", "tension"):
            unit, variable = self.find(getattr(checks.sdof, field), f"checks.sdof.{field}")
            if variable.type != "Real":
                raise self.fault(f"{unit}.{variable.name} is {variable.type}, expected Real", f"checks.sdof.{field}")

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
