"""Scenes: what is coupled to what, with which values; read from TOML, then checked against the units' descriptions.

``Scene`` is the file's content, times in s, everything else as written. ``Scene.resolve`` looks at the FMUs'
descriptions (no code of theirs runs) and returns a ``ResolvedScene`` in which every name exists and every value is a
number in the unit that its variable declares: SI for the shipped units. Every fault is a ``SceneError`` that names
file and key.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, TypeVar

import msgspec

from towage.errors import SceneError, TowageError, suggest
from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.registry import SCHEMES
from towage.units.archive import read_description
from towage.units.description import Value

if TYPE_CHECKING:
    from towage.scene.resolve import ResolvedScene

S = TypeVar("S", bound=msgspec.Struct)
Locate = Callable[[str], Path]
"""From the name of a shipped unit to its FMU; raises ``LookupError`` for a name it does not know."""

SHIPPED = Path(__file__).parents[1] / "scenes"
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

    scheme: str = "auto"
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


class SimplerCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks.simpler]``: the run is repeated with the values ``set``, which make a model simpler, and ``motions`` are
    compared from ``settle``, s, on. ``margin`` of the simpler run tells what the simpler model says of itself."""

    set: dict[str, Any]
    motions: tuple[str, ...]
    margin: str | None = None
    tolerance: float = 0.05
    settle: float = 0.0


class Checks(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks]``; ``report_only`` names margins that do not decide."""

    sdof: SdofCheck | None = None
    simpler: SimplerCheck | None = None
    report_only: tuple[str, ...] = ()


class Case(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[[cases]]``: values that replace those of the scene, under "unit.parameter", "coupling.step", "stop_time"."""

    name: str
    set: dict[str, Any] = {}


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
        """The scene in ``data``, as tomllib gives it (numpy scalars are numbers too); checked as far as that is possible
        without the units."""
        scene = _Reader(file).scene(_plain(data))
        for case in scene.cases:
            scene.case(case.name)
        if scene.checks.simpler:
            scene.simpler()
        return scene

    def case(self, name: str) -> Scene:
        """The scene with the values of a case; setting ``coupling.step`` drops the tolerance, and the reverse."""
        found = {case.name: case for case in self.cases}
        if name not in found:
            raise self.error(f"unknown case {name!r}" + suggest(name, found), "cases")
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
                hint = suggest(target, known)
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
            raise self.error(f"there is no connection {one!r}" + suggest(one, self.connections), "connections")
        rest = tuple(text for text in self.connections if text not in cut)
        checks = msgspec.structs.replace(self.checks, sdof=None, simpler=None)
        return msgspec.structs.replace(self, connections=rest, checks=checks)

    def simpler(self) -> Scene:
        """The scene with the values of ``checks.simpler``, and without the comparisons."""
        check = self.checks.simpler
        if check is None:
            raise self.error("missing", "checks.simpler")
        bare = msgspec.structs.replace(self, checks=msgspec.structs.replace(self.checks, sdof=None, simpler=None))
        name = "checks.simpler"
        changed = msgspec.structs.replace(bare, cases=(Case(name, check.set),)).case(name)
        return msgspec.structs.replace(changed, cases=())

    def resolve(self, locate: Locate) -> ResolvedScene:
        """Check everything, the cases too, against the descriptions of the units. Raises ``SceneError``, and
        ``FmuError`` for an FMU that is refused; a ``LookupError`` or ``OSError`` of ``locate`` becomes a ``SceneError``.
        """
        from towage.scene.resolve import Resolver  # it is about scenes and so imports this module

        paths = {name: self._path(name, entry.fmu, locate) for name, entry in self.units.items()}
        read = {path: read_description(path) for path in dict.fromkeys(paths.values())}
        descriptions = {name: read[path] for name, path in paths.items()}
        resolved = Resolver(self, descriptions).resolved()
        for case in self.cases:
            variant = msgspec.structs.replace(self.case(case.name), cases=())
            try:
                Resolver(variant, descriptions).resolved()
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
    hint = suggest(given.stem, names) or f"; known scenes: {', '.join(names) or 'none'}"
    raise SceneError(f"no such file or scene{hint}", file=given)


def _plain(value: Any) -> Any:
    """A copy in plain Python types."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value.item() if hasattr(value, "item") else value


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
        if isinstance(scheme, str) and scheme != "auto" and scheme not in SCHEMES:
            names = ("auto", *SCHEMES.names())
            hint = suggest(scheme, names)
            self.fail(f"unknown scheme {scheme!r}{hint}; expected one of: {', '.join(names)}", "coupling.scheme")
        top["coupling"] = self.convert(top["coupling"], Coupling, "coupling")
        top["record"] = self.convert(top.get("record", {}), Record, "record")
        checks = self.table(top.get("checks", {}), "checks")
        if checks.get("sdof") is not None:
            sdof = self.convert(checks["sdof"], SdofCheck, "checks.sdof")
            cut = tuple(self.connection(text, f"checks.sdof.cut[{i}]") for i, text in enumerate(sdof.cut))
            checks["sdof"] = msgspec.structs.replace(sdof, cut=cut)
        if checks.get("simpler") is not None:
            checks["simpler"] = self.convert(checks["simpler"], SimplerCheck, "checks.simpler")
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
                hint = suggest(name, fields) or f"; expected one of: {', '.join(fields)}"
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
        coupling, sdof, simpler = scene.coupling, scene.checks.sdof, scene.checks.simpler
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
            "checks.simpler.tolerance": simpler.tolerance if simpler else None,
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
        if simpler and not (0.0 <= simpler.settle < scene.stop_time):
            self.fail(f"{simpler.settle} s is out of range: expected 0 s to {scene.stop_time} s", "checks.simpler.settle")
        names = [case.name for case in scene.cases]
        for index, name in enumerate(names):
            if not name.strip() or name in names[:index]:
                self.fail(f"case name {name!r} is empty or used twice", f"cases[{index}].name")
