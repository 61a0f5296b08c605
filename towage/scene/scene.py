"""Scenes: what is coupled to what, with which values; read from TOML.

``Scene`` is the file's content, times in s, everything else as written. `towage.scene.flavour.resolve` makes a
``ResolvedScene`` of it, in which every name exists. Every fault is a ``SceneError`` that names file and key.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from msgspec.structs import replace

from towage.errors import SceneError, suggest
from towage.registry import CHECKS, SCHEMES
from towage.scene.parts import Case, Checks, Coupling, Empty, Record, Transformation, UnitEntry
from towage.scene.scene_file import toml
from towage.scene.tables import Tables, find_file, plain, read_toml
from towage.systems.load import network_of, system_file, tables_of
from towage.systems.network import Note

__all__ = ["Case", "Checks", "Coupling", "Record", "Scene", "SceneSummary", "UnitEntry", "available_scenes"]

SHIPPED, ROUTES = (Path(__file__).parents[1] / name for name in ("scenes", "routes"))
_FIELDS = (
    "title", "description", "stop_time", "units", "connections", "transformations", "coupling", "record", "checks", "cases"
)  # fmt: skip
"""Keys of a scene file; the other fields of a `Scene` say where it comes from."""
_EXCLUSIVE = {"coupling.step": "coupling.tolerance", "coupling.tolerance": "coupling.step"}
_NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")


class SceneSummary(NamedTuple):
    """A shipped scene."""

    name: str
    title: str


class Scene(msgspec.Struct, frozen=True, kw_only=True):
    """A scene file. Connections are spelled "unit.output -> unit.input", with single spaces.

    ``transformations`` are by connection. ``chosen`` is the name of the case whose values are in it. ``file`` and ``source``
    are where it was read from and its text, None and "" for a scene made from a dict; ``notes`` what is to be said of a file of
    another format.
    """

    title: str
    stop_time: float
    units: dict[str, UnitEntry]
    coupling: Coupling
    description: str = ""
    connections: tuple[str, ...] = ()
    transformations: dict[str, Transformation] = {}
    record: Record = Record()
    checks: Checks = Checks()
    cases: tuple[Case, ...] = ()
    chosen: str = ""
    file: Path | None = None
    source: str = ""
    notes: tuple[Note, ...] = ()

    @classmethod
    def load(cls, path_or_name: str | Path, search: Iterable[Path] = ()) -> Scene:
        """The scene in a file, or of a name in one of the directories of ``search`` or among the shipped ones; or the system
        in a file of SSP or OSP (`towage.systems.load`). Raises `SceneError`."""
        if system_file(path_or_name):
            return _of_system(path_or_name)
        routes = (ROUTES,) if (ROUTES / f"{path_or_name}.toml").is_file() else ()  # refused by what it is
        path = find_file(path_or_name, (*search, SHIPPED, *routes), "scene")
        text, data = read_toml(path)
        return replace(cls.from_dict(data, path), source=text)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], file: Path | None = None) -> Scene:
        """The scene in ``data``, as tomllib gives it (numpy scalars are numbers too); checked with its cases as far as
        that is possible without the units. Raises `SceneError`."""
        scene = _read(plain(data), file)
        for case in scene.cases:
            scene.case(case.name)
        return scene

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain tables, as `from_dict` takes them; every key is there, None where it has no value."""
        data = {name: msgspec.to_builtins(getattr(self, name)) for name in _FIELDS}
        tables = {name: None for name in CHECKS.own if CHECKS.get(name).section}
        data["checks"] = {**tables, **data["checks"].pop("sections"), **data["checks"]}
        return data

    def case(self, name: str) -> Scene:
        """The scene with the values of a case and without any cases, so that it runs. Raises `SceneError`."""
        cases = {case.name: case for case in self.cases}
        if name not in cases:
            raise self.error(f"unknown case {name!r}" + suggest(name, cases), "cases")
        return replace(self.setting(cases[name].set, f"cases.{name}.set"), chosen=name)

    def setting(self, values: Mapping[str, Any], key: str) -> Scene:
        """The scene with other values and without cases; setting ``coupling.step`` drops the tolerance, and the reverse.

        ``values`` are as in a case: "unit.parameter", "unit.files.kind" or a key of the scene, a number or a text. Raises
        `SceneError` that names ``key``."""
        data = self.to_dict() | {"cases": ()}
        for target, other in _EXCLUSIVE.items():
            if target in values and other not in values:
                data["coupling"][other.removeprefix("coupling.")] = None
        for target, value in values.items():
            place, last = self._place(data, target, key)
            place[last] = plain(value)
        try:
            scene = _read(data, self.file)
        except SceneError as error:
            raise self.error(f"{error.key}: {error.args[0]}", key) from None
        notes = tuple(note for note in self.notes if note.key not in values)
        return replace(scene, source=self.source, chosen=self.chosen, notes=notes)

    def _place(self, data: dict[str, Any], target: str, key: str) -> tuple[dict[str, Any], str]:
        """The table in ``data`` that ``target`` names, and the key in it."""
        head, _, rest = target.partition(".")
        unit = head in self.units
        if unit and rest.startswith("files."):
            return self._file_place(data["units"][head]["files"], target, rest.removeprefix("files."), key)
        *tables, last = ("units", head, self.units[head].table(rest), rest) if unit else target.split(".")
        place: Any = data if unit or head not in ("units", "connections", "cases") else None
        for name in tables:
            place = place.get(name) if isinstance(place, dict) else None
        if not isinstance(place, dict) or not last or (not unit and last not in place):
            known = [*(f"{name}.{last}" for name in self.units), *_EXCLUSIVE, "coupling.scheme", "stop_time"]
            hint = suggest(target, known)
            expected = "expected 'unit.parameter', 'unit.input', 'unit.files.kind' or a key of the scene"
            raise self.error(f"{target!r} cannot be set: {expected}{hint}", key)
        return place, last

    def _file_place(self, files: dict[str, Any], target: str, rest: str, key: str) -> tuple[dict[str, Any], str]:
        """As `_place`, for a file of a unit, "unit.files.kind", or one entry of it, "unit.files.kind.file"."""
        kind, _, entry = rest.partition(".")
        if not entry:
            return files, kind
        if kind not in files:
            raise self.error(f"{target!r} cannot be set: the unit has no file {kind!r}{suggest(kind, files)}", key)
        if not isinstance(files[kind], dict):
            files[kind] = {"file": files[kind]}
        return files[kind], entry

    def with_values(self, values: Mapping[str, Any], option: str = "set") -> Scene:
        """The scene with ``values``, which prevail over those of its cases; its source says so. Raises `SceneError` that
        names ``option``."""
        changed = self.setting(values, option)
        taken = {*values, *(_EXCLUSIVE[key] for key in values if key in _EXCLUSIVE)}
        cases = tuple(replace(c, set={k: v for k, v in c.set.items() if k not in taken}) for c in self.cases)
        note = "".join(f"# {option} {key}={value}\n" for key, value in values.items())
        return replace(changed, cases=cases, source=f"{self.source.rstrip()}\n\n{note}" if self.source else "")

    def without(self, connections: Iterable[str]) -> Scene:
        """The scene with these connections left out, and the tables of checks, which name them. Raises `SceneError`."""
        cut = {Tables(self.file).connection(text, "connections") for text in connections}
        if missing := cut - set(self.connections):
            one = min(missing)
            raise self.error(f"there is no connection {one!r}" + suggest(one, self.connections), "connections")
        rest = tuple(text for text in self.connections if text not in cut)
        kept = {text: change for text, change in self.transformations.items() if text not in cut}
        return replace(self.without_comparisons(), connections=rest, transformations=kept)

    def without_comparisons(self) -> Scene:
        """The scene without the tables of its checks."""
        return replace(self, checks=self.checks.without(*self.checks.sections))

    def active_checks(self) -> list[Any]:
        """The checks (`towage.checks.check.Check`) that take part in its runs: the project's own that have no section,
        and those whose section it has."""
        own = [CHECKS.get(name) for name in CHECKS.own]
        foreign = [CHECKS.get(name) for name in self.checks.sections if name not in CHECKS.own]
        return [c for c in own if c.section is None or c.name in self.checks.sections] + foreign

    def error(self, message: str, key: str) -> SceneError:
        """A fault of this scene."""
        return SceneError(message, file=self.file, key=key)


def available_scenes() -> tuple[SceneSummary, ...]:
    """The shipped scenes by name. Raises ``SceneError`` for one that cannot be read."""
    return tuple(SceneSummary(path.stem, Scene.load(path).title) for path in sorted(SHIPPED.glob("*.toml")))


def _of_system(given: str | Path) -> Scene:
    """The system in a file of another format, as a scene."""
    network = network_of(given)
    data, notes = tables_of(network, (*_FIELDS, "file", "source"))
    scene = Scene.from_dict(data, network.file)
    return replace(scene, notes=notes, source=toml(scene))


def _read(data: dict[str, Any], file: Path | None) -> Scene:
    """The scene in plain tables."""
    tables = Tables(file)
    if "route" in data:
        tables.fail("a route is no scene: take it to towage route", "route")
    for name in data:
        if name not in _FIELDS:
            tables.unknown(name, _FIELDS, "")
    if "coupling" not in data:
        tables.fail("missing: give it a step or a tolerance", "coupling")
    if not isinstance(cases := data.get("cases", []), list | tuple):
        tables.fail("expected an array of tables, [[cases]]", "cases")
    converted = {
        "stop_time": tables.seconds(data.get("stop_time"), "stop_time"),
        "units": _units(tables, data.get("units", {})),
        "transformations": _transformations(tables, data.get("transformations", {})),
        "coupling": tables.structure(data["coupling"], Coupling, "coupling"),
        "record": tables.structure(data.get("record", {}), Record, "record"),
        "checks": _checks(tables, data.get("checks", {})),
        "cases": tuple(tables.structure(case, Case, f"cases[{index}]") for index, case in enumerate(cases)),
    }
    scene = tables.structure({key: converted.get(key, data[key]) for key in data}, Scene, "")
    connections = tuple(tables.connection(text, f"connections[{k}]") for k, text in enumerate(scene.connections))
    scene = replace(scene, connections=connections, file=file)
    _check(scene)
    active = {check.name: check for check in scene.active_checks()}
    sections = {name: active[name].read(scene, section) for name, section in scene.checks.sections.items()}
    return replace(scene, checks=Checks(sections, scene.checks.report_only))


def _units(tables: Tables, given: object) -> dict[str, UnitEntry]:
    units = {}
    for name, entry in tables.table(given, "units").items():
        if not _NAME.fullmatch(name) or name in (*_FIELDS, "file", "source"):
            tables.fail(f"{name!r} cannot name a unit: expected letters, digits, '_', and no key of a scene", "units")
        for kind in ("parameters", "inputs"):
            key = f"units.{name}.{kind}"
            given_values = tables.table(tables.table(entry, f"units.{name}").get(kind, {}), key)
            for variable, value in given_values.items():
                if not isinstance(value, (bool, int, float, str)):
                    tables.fail(f"expected a number, a text or a truth value, got {value!r}", f"{key}.{variable}")
        units[name] = unit = tables.structure(entry, UnitEntry, f"units.{name}")
        if twice := min(unit.parameters.keys() & unit.inputs.keys(), default=""):
            tables.fail(f"is set under parameters too, as {unit.parameters[twice]!r}", f"units.{name}.inputs.{twice}")
    return units


def _transformations(tables: Tables, given: object) -> dict[str, Transformation]:
    """``[transformations]``, by connections in their one spelling."""
    return {
        tables.connection(text, "transformations"): tables.structure(entry, Transformation, f"transformations.{text}")
        for text, entry in tables.table(given, "transformations").items()
    }


def _checks(tables: Tables, given: object) -> Checks:
    """``[checks]``, each table as the structure that its check brings."""
    rest = dict(tables.table(given, "checks"))
    sections = {}
    for name in [name for name in rest if name != "report_only"]:
        if name not in CHECKS or (CHECKS.get(name).section is None and name in CHECKS.own):
            own = (known for known in CHECKS.names() if known not in CHECKS.own or CHECKS.get(known).section)
            tables.unknown(name, (*own, "report_only"), "checks")
        table = rest.pop(name)
        if table is not None:
            sections[name] = tables.structure(table, CHECKS.get(name).section or Empty, f"checks.{name}")
    return replace(tables.structure(rest, Checks, "checks"), sections=sections)


def _check(scene: Scene) -> None:
    """Refuses numbers and names that cannot be right, whatever the units are."""
    coupling = scene.coupling
    if not scene.units:
        raise scene.error("a scene needs at least one unit", "units")
    if coupling.scheme != "auto" and coupling.scheme not in SCHEMES:
        names = ("auto", *SCHEMES.names())
        hint = suggest(coupling.scheme, names)
        raise scene.error(f"unknown scheme {coupling.scheme!r}{hint}; expected one of: {', '.join(names)}", "coupling.scheme")
    if (coupling.step is None) == (coupling.tolerance is None):
        given = "neither is given" if coupling.step is None else "both are given"
        raise scene.error(f"exactly one of step and tolerance is needed, {given}", "coupling")
    lengths = {"coupling.step": coupling.step, "record.interval": scene.record.interval}
    for key, value in ({"stop_time": scene.stop_time, "coupling.tolerance": coupling.tolerance} | lengths).items():
        if value is not None and not (0.0 < value < math.inf):
            raise scene.error(f"{value} is out of range: expected a finite number above 0", key)
    if coupling.tolerance is not None and coupling.tolerance >= 1.0:
        raise scene.error(f"{coupling.tolerance} is out of range: a relative error is below 1", "coupling.tolerance")
    for key, length in lengths.items():
        if length is not None and length > scene.stop_time:
            raise scene.error(f"{length} s is longer than stop_time, {scene.stop_time} s", key)
    for text, change in scene.transformations.items():
        if text not in scene.connections:
            hint = suggest(text, scene.connections)
            raise scene.error(f"there is no connection {text!r}{hint}", "transformations")
        if not math.isfinite(change.factor) or not math.isfinite(change.offset):
            raise scene.error("factor and offset must be finite", f"transformations.{text}")
    cases = [case.name for case in scene.cases]
    for index, name in enumerate(cases):
        if not name.strip() or name in cases[:index]:
            raise scene.error(f"case name {name!r} is empty or used twice", f"cases[{index}].name")
