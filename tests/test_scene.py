"""Scenes: what is read, what it resolves to, and one test for each way in which a scene can be wrong."""

from __future__ import annotations

import math
import pickle
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from towage.checks.sdof_section import sdof_of
from towage.errors import FmuError, RunError, SceneError, TowageError
from towage.scene import scene as scene_module
from towage.scene.resolve import ResolvedConnection, ResolvedScene, check_all, described
from towage.scene.scene import Scene, available_scenes
from towage.units.store import Locate

FEET = 0.3048
UNIT_DEFINITIONS = '<Unit name="furlong"><BaseUnit m="1" factor="201.168"/></Unit><Unit name="odd"/>'

# name -> (causality, type element, dependencies of an output)
SHIP: dict[str, tuple[str, str, str | None]] = {
    "reaction": ("input", '<Real start="0" unit="N"/>', None),
    "heave": ("output", '<Real unit="m"/>', ""),
    "mode": ("output", "<Integer/>", None),
    "label": ("output", "<String/>", None),
    "margin_sdof": ("output", '<Real unit="1"/>', ""),
    "heave_rate": ("local", '<Real unit="m/s"/>', None),
    "heave_amplitude": ("parameter", '<Real start="1" unit="m" min="0" max="20"/>', None),
    "heave_period": ("parameter", '<Real start="8" unit="s" min="1e-9"/>', None),
    "mass": ("parameter", '<Real start="1e6" unit="kg"/>', None),
    "plain": ("parameter", '<Real start="1"/>', None),
    "reach": ("parameter", '<Real start="1" unit="furlong"/>', None),
    "strange": ("parameter", '<Real start="1" unit="odd"/>', None),
    "count": ("parameter", '<Integer start="3" min="0" max="5"/>', None),
    "wide": ("parameter", '<Boolean start="false"/>', None),
    "title": ("parameter", '<String start="x"/>', None),
    "unset": ("parameter", '<Real unit="m"/>', None),
    "port_mass": ("calculatedParameter", '<Real unit="kg"/>', None),
}
LINE: dict[str, tuple[str, str, str | None]] = {
    "top": ("input", '<Real start="0" unit="m"/>', None),
    "top_feet": ("input", '<Real start="0" unit="ft"/>', None),
    "untyped": ("input", '<Real start="0"/>', None),
    "on": ("input", '<Boolean start="false"/>', None),
    "tension": ("output", '<Real unit="N"/>', "top"),
    "margin_taut": ("output", '<Real unit="1"/>', "top"),
    "length": ("parameter", '<Real start="30" unit="m" min="0"/>', None),
    "static_tension": ("parameter", '<Real start="0" unit="N"/>', None),
}
LOOPED: dict[str, tuple[str, str, str | None]] = {
    "u": ("input", '<Real start="0" unit="m"/>', None),
    "y": ("output", '<Real unit="m"/>', "u"),
    "z": ("output", '<Real unit="m"/>', ""),
}
ARROWS: dict[str, tuple[str, str, str | None]] = {
    "pull -> ship.reaction": ("input", '<Real start="0" unit="N"/>', None),
    "up": ("output", '<Real unit="m"/>', ""),
}
DECLARED = {"ship": SHIP, "line": LINE, "looped": LOOPED, "vague": LOOPED, "arrows": ARROWS}


def build(path: Path, variables: dict[str, tuple[str, str, str | None]], vague: bool = False) -> None:
    """An FMU without a binary; ``vague``: it declares no dependencies."""
    index = {name: i for i, name in enumerate(variables, 1)}
    scalars, unknowns = "", ""
    for name, (causality, kind, depends) in variables.items():
        variability = "fixed" if "arameter" in causality else "continuous"
        scalars += (
            f'<ScalarVariable name="{name}" valueReference="{index[name]}" causality="{causality}" '
            f'variability="{variability}">{kind}</ScalarVariable>'
        )
        if causality == "output":
            known = "" if depends is None or vague else f'dependencies="{index[depends] if depends else ""}"'
            unknowns += f'<Unknown index="{index[name]}" {known}/>'
    text = (
        '<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>'
        f"<UnitDefinitions>{UNIT_DEFINITIONS}</UnitDefinitions><ModelVariables>{scalars}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure></fmiModelDescription>"
    )
    with zipfile.ZipFile(path, "w") as fmu:
        fmu.writestr("modelDescription.xml", text)


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("fmus")
    for name, variables in DECLARED.items():
        build(directory / f"{name}.fmu", variables, vague=name == "vague")
    return directory


def data(**changes: Any) -> dict[str, Any]:
    base: dict[str, Any] = {
        "title": "Ship and line",
        "stop_time": "160 s",
        "connections": ["ship.heave -> line.top", "line.tension -> ship.reaction"],
        "units": {"ship": {"fmu": "ship", "parameters": {}}, "line": {"fmu": "line", "parameters": {}}},
        "coupling": {"step": "0.1 s"},
    }
    return base | changes


def with_parameters(**parameters: Any) -> dict[str, Any]:
    return data(units={"ship": {"fmu": "ship", "parameters": parameters}, "line": {"fmu": "line"}})


def resolve(content: dict[str, Any], fmus: Path) -> ResolvedScene:
    def locate(name: str) -> Path:
        if name not in DECLARED:
            raise KeyError(name)
        return fmus / f"{name}.fmu"

    return _checked(Scene.from_dict(content), locate)


def _checked(scene: Scene, locate: Locate) -> ResolvedScene:
    """The scene itself resolved, after all of its cases were checked too."""
    check_all(scene, locate)
    return described(scene, locate)


def refused(content: dict[str, Any], key: str, says: str) -> None:
    with pytest.raises(SceneError, match=says) as caught:
        Scene.from_dict(content, Path("some.toml"))
    assert caught.value.key == key and caught.value.file == Path("some.toml")
    assert f"some.toml: {key}: " in str(caught.value)


def refused_when_resolved(content: dict[str, Any], fmus: Path, key: str, says: str) -> None:
    with pytest.raises(SceneError, match=says) as caught:
        resolve(content, fmus)
    assert caught.value.key == key


def test_defaults_and_times() -> None:
    scene = Scene.from_dict(data(stop_time="2 min", coupling={"step": "100 ms"}))
    assert scene.stop_time == 120.0 and scene.coupling.step == 0.1 and scene.coupling.tolerance is None
    assert scene.coupling.scheme == "auto" and scene.coupling.events and scene.coupling.error_estimate
    assert scene.record.interval is None and scene.record.variables is None and scene.checks.get("sdof") is None
    assert Scene.from_dict(data(stop_time=7)).stop_time == 7.0


def test_document_of_the_architecture_reads(tmp_path: Path) -> None:
    text = """
title = "Sea Cliff's cradle under Lulu"
description = "Example 1"
stop_time = "160 s"
connections = ["line.reaction   ->ship.reaction"]
[units.ship]
fmu = "ship"
[units.ship.parameters]
heave_amplitude = "4.4 ft"
[units.line]
fmu = "spring_line"
[coupling]
scheme = "hermite"
tolerance = 1e-5
events = true
error_estimate = true
[record]
interval = "0.1 s"
variables = ["ship.heave"]
[checks.sdof]
cut = ["line.reaction -> ship.reaction"]
driver = "ship.heave"
motion = "cradle.heave"
tension = "line.tension"
tolerance = 0.05
settle = "80 s"
[checks]
report_only = ["line.margin_taut"]
[[cases]]
name = "8 s wave"
set = { "ship.heave_period" = "8 s" }
"""
    path = tmp_path / "sea.toml"
    path.write_text(text, "utf-8")
    scene = Scene.load(path)
    assert scene.source == text and scene.file == path and scene.title == "Sea Cliff's cradle under Lulu"
    assert scene.connections == ("line.reaction -> ship.reaction",)
    assert scene.checks.get("sdof").cut == scene.connections
    assert scene.checks.get("sdof").settle == 80.0 and scene.checks.report_only == ("line.margin_taut",)
    case = scene.case("8 s wave")
    assert case.units["ship"].parameters == {"heave_amplitude": "4.4 ft", "heave_period": "8 s"}
    assert case.source == text and case.file == path and case.coupling == scene.coupling
    assert scene.units["ship"].parameters == {"heave_amplitude": "4.4 ft"}


def test_load_by_name_searches_directories_and_shipped_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = 'title = "{}"\nstop_time = 1\n[coupling]\nstep = 0.1\n[units.a]\nfmu = "a"\n'
    shipped, mine = tmp_path / "shipped", tmp_path / "mine"
    for directory, name in ((shipped, "lulu"), (shipped, "sea_cliff"), (mine, "lulu")):
        directory.mkdir(exist_ok=True)
        (directory / f"{name}.toml").write_text(text.format(f"{directory.name} {name}"))
    monkeypatch.setattr(scene_module, "SHIPPED", shipped)
    assert Scene.load("lulu").title == "shipped lulu" and Scene.load("lulu", [mine]).title == "mine lulu"
    assert available_scenes() == (("lulu", "shipped lulu"), ("sea_cliff", "shipped sea_cliff"))
    with pytest.raises(SceneError, match="did you mean 'sea_cliff'"):
        Scene.load("sea_clif")
    with pytest.raises(SceneError, match="known scenes: lulu, sea_cliff"):
        Scene.load("xyz")
    with pytest.raises(SceneError, match="no such file or scene"):
        Scene.load(tmp_path / "lulu.toml")


def test_shipped_scenes_read() -> None:
    assert [scene.name for scene in available_scenes()] == sorted(p.stem for p in scene_module.SHIPPED.glob("*.toml"))


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"title = \n", "not valid TOML: .*line 1"),
        (b"title = '\xff'", "cannot be read"),
        (b"x = 1\nx = 2", "not valid TOML"),
    ],
)
def test_files_that_are_no_toml(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=says) as caught:
        Scene.load(path)
    assert caught.value.file == path and str(path) in str(caught.value)


SDOF = {
    "cut": ["line.tension -> ship.reaction"],
    "driver": "ship.heave",
    "motion": "ship.heave",
    "tension": "line.tension",
}


@pytest.mark.parametrize(
    ("changes", "key", "says"),
    [
        ({"titel": "x"}, "titel", "unknown key; did you mean 'title'"),
        ({"file": "x"}, "file", "unknown key"),
        ({"source": "x"}, "source", "unknown key"),
        ({"units": {"a": {"fmu": "x", "parametres": {}}}}, "units.a.parametres", "did you mean 'parameters'"),
        ({"coupling": {"step": 1, "event": True}}, "coupling.event", "did you mean 'events'"),
        ({"record": {"every": 1}}, "record.every", "expected one of: interval, variables"),
        ({"checks": {"sdoff": SDOF}}, "checks.sdoff", "did you mean 'sdof'"),
        ({"checks": {"sdof": SDOF | {"tolerence": 1}}}, "checks.sdof.tolerence", "did you mean 'tolerance'"),
        ({"cases": [{"name": "a"}, {"name": "b", "sets": {}}]}, "cases[1].sets", "did you mean 'set'"),
        ({"title": 3}, "title", "Expected `str`, got `int`"),
        ({"units": []}, "units", "expected a table"),
        ({"units": {}}, "units", "at least one unit"),
        ({"units": {"a": "ship"}}, "units.a", "expected a table"),
        ({"units": {"a": {"parameters": {}}}}, "units.a", "missing required field `fmu`"),
        ({"units": {"a": {"fmu": 3}}}, "units.a.fmu", "Expected `str`"),
        ({"units": {"a.b": {"fmu": "x"}}}, "units", "'a.b' cannot name a unit"),
        ({"units": {"coupling": {"fmu": "x"}}}, "units", "'coupling' cannot name a unit"),
        ({"units": {"a": {"fmu": "x", "parameters": {"p": [1]}}}}, "units.a.parameters.p", r"got \[1\]"),
        ({"units": {"a": {"fmu": "x", "parameters": 3}}}, "units.a.parameters", "expected a table"),
        ({"connections": ["ship.heave line.top"]}, "connections[0]", "expected 'unit.output -> unit.input'"),
        ({"connections": ["ship -> line.top"]}, "connections[0]", "expected 'unit.output -> unit.input'"),
        ({"connections": "a.b -> c.d"}, "connections", "Expected `array`"),
        ({"stop_time": 0}, "stop_time", "above 0"),
        ({"stop_time": -1.0}, "stop_time", "above 0"),
        ({"stop_time": math.inf}, "stop_time", "finite"),
        ({"stop_time": math.nan}, "stop_time", "finite"),
        ({"stop_time": True}, "stop_time", "Expected `float`, got `bool`"),
        ({"stop_time": "160 ft"}, "stop_time", "'ft' is .*'s' is"),
        ({"stop_time": "160"}, "stop_time", "no unit"),
        ({"coupling": {}}, "coupling", "exactly one of step and tolerance is needed, neither"),
        ({"coupling": {"step": 1, "tolerance": 1e-5}}, "coupling", "both are given"),
        ({"coupling": {"step": 0}}, "coupling.step", "above 0"),
        ({"coupling": {"step": math.nan}}, "coupling.step", "out of range"),
        ({"coupling": {"step": "161 s"}}, "coupling.step", "longer than stop_time"),
        ({"coupling": {"step": "1 s per"}}, "coupling.step", "not a unit"),
        ({"coupling": {"tolerance": -1e-5}}, "coupling.tolerance", "above 0"),
        ({"coupling": {"tolerance": 1.0}}, "coupling.tolerance", "below 1"),
        ({"coupling": {"step": 1, "scheme": "hermit"}}, "coupling.scheme", "did you mean 'hermite'"),
        ({"coupling": {"step": 1, "scheme": 1}}, "coupling.scheme", "got `int`"),
        ({"coupling": 3}, "coupling", "expected a table"),
        ({"record": {"interval": 0}}, "record.interval", "above 0"),
        ({"record": {"interval": 200}}, "record.interval", "longer than stop_time"),
        ({"checks": {"sdof": SDOF | {"settle": 160}}}, "checks.sdof.settle", "out of range"),
        ({"checks": {"sdof": SDOF | {"tolerance": 0}}}, "checks.sdof.tolerance", "above 0"),
        ({"checks": {"sdof": SDOF | {"cut": ["a.b"]}}}, "checks.sdof.cut[0]", "no connection"),
        ({"checks": {"sdof": {"cut": []}}}, "checks.sdof", "missing required field `driver`"),
        ({"cases": {}}, "cases", "array of tables"),
        ({"cases": [{"name": "a"}, {"name": "a"}]}, "cases[1].name", "used twice"),
        ({"cases": [{"name": " "}]}, "cases[0].name", "empty"),
        ({"cases": [{"name": "a", "set": {"shp.mass": 1}}]}, "cases.a.set", "did you mean 'ship.mass'"),
        ({"cases": [{"name": "a", "set": {"ship": 1}}]}, "cases.a.set", "expected 'unit.parameter'"),
        ({"cases": [{"name": "a", "set": {"units.ship.fmu": "x"}}]}, "cases.a.set", "cannot be set"),
        ({"cases": [{"name": "a", "set": {"coupling.stp": 1}}]}, "cases.a.set", "did you mean 'coupling.step'"),
        ({"cases": [{"name": "a", "set": {"coupling.step.x": 1}}]}, "cases.a.set", "cannot be set"),
        ({"cases": [{"name": "a", "set": {"stop_time": -1}}]}, "cases.a.set", "stop_time: .*above 0"),
        ({"cases": [{"name": "a", "set": {"ship.mass": [1]}}]}, "cases.a.set", "units.ship.parameters.mass: "),
        ({"cases": [{"name": "a", "set": {"coupling.step": 1, "coupling.tolerance": 1e-3}}]}, "cases.a.set", "both"),
    ],
)  # fmt: skip
def test_refused_without_the_units(changes: dict[str, Any], key: str, says: str) -> None:
    refused(data(**changes), key, says)


@pytest.mark.parametrize("missing", ["title", "stop_time", "coupling"])
def test_missing_keys(missing: str) -> None:
    content = data()
    del content[missing]
    with pytest.raises(SceneError, match="missing"):
        Scene.from_dict(content)


def test_from_dict_leaves_its_argument_alone() -> None:
    content = data(checks={"sdof": SDOF})
    before = repr(content)
    Scene.from_dict(content)
    assert repr(content) == before


def test_resolved_values_are_si(fmus: Path) -> None:
    given = {
        "heave_amplitude": "4.4 ft", "mass": "2 long_ton", "heave_period": 8, "plain": 2, "reach": "1 km", "count": 4,
        "wide": True, "title": "a title", "reaction": "1 kip",
    }  # fmt: skip
    open_reaction = with_parameters(**given) | {"connections": ["ship.heave -> line.top"]}
    values = resolve(open_reaction, fmus).units["ship"].parameters
    assert values == {
        "heave_amplitude": pytest.approx(4.4 * FEET, rel=1e-15), "mass": pytest.approx(2 * 1016.0469088, rel=1e-15),
        "heave_period": 8.0, "plain": 2.0, "reach": pytest.approx(1000 / 201.168, rel=1e-15), "count": 4, "wide": True,
        "title": "a title", "reaction": pytest.approx(4448.2216152605, rel=1e-15),
    }  # fmt: skip
    assert {name: type(value) for name, value in values.items()}["heave_period"] is float
    assert resolve(data(), fmus).units["line"].parameters == {}


def test_resolved_connections_convert_between_units_of_one_dimension(fmus: Path) -> None:
    resolved = resolve(data(connections=["ship.heave -> line.top_feet", "ship.margin_sdof -> line.untyped"]), fmus)
    first, second = resolved.connections
    assert first[:4] == ("ship", "heave", "line", "top_feet") and first.factor == pytest.approx(1 / FEET, rel=1e-15)
    assert second == ResolvedConnection("ship", "margin_sdof", "line", "untyped", 1.0)
    assert str(second) == "ship.margin_sdof -> line.untyped"


def test_recorded_by_default_are_the_outputs(fmus: Path) -> None:
    assert resolve(data(), fmus).record == (
        ("ship", "heave"), ("ship", "mode"), ("ship", "label"), ("ship", "margin_sdof"),
        ("line", "tension"), ("line", "margin_taut"),
    )  # fmt: skip
    chosen = data(record={"variables": ["ship.heave_rate", "line.tension", "ship.heave_rate"]})
    assert resolve(chosen, fmus).record == (("ship", "heave_rate"), ("line", "tension"))


def test_references_follow_each_other_and_fall_back_to_start_values(fmus: Path) -> None:
    units = {
        "ship": {"fmu": "ship", "parameters": {"heave_amplitude": "= line.length", "reach": "=ship.heave_amplitude"}},
        "line": {"fmu": "line", "parameters": {"length": "10 ft"}},
    }
    ship = resolve(data(units=units), fmus).units["ship"].parameters
    assert ship["heave_amplitude"] == 10 * FEET and ship["reach"] == pytest.approx(10 * FEET / 201.168, rel=1e-15)
    units["line"]["parameters"] = {}
    with pytest.raises(SceneError, match="30.0 m.* is out of range: expected 0 to 20 m"):
        resolve(data(units=units), fmus)


def test_fmu_path_is_relative_to_the_scene_file(fmus: Path) -> None:
    units = {"ship": {"fmu": "ship.fmu"}, "line": {"fmu": str(fmus / "line.fmu")}}

    def locate(name: str) -> Path:
        raise AssertionError(name)

    resolved = described(Scene.from_dict(data(units=units), fmus / "scene.toml"), locate)
    assert resolved.units["ship"].path == fmus / "ship.fmu" == resolved.units["ship"].description.path
    with pytest.raises(SceneError, match="there is no file") as caught:
        described(Scene.from_dict(data(units={"a": {"fmu": "none.fmu"}}, connections=[]), fmus / "scene.toml"), locate)
    assert caught.value.key == "units.a.fmu"


def test_refused_fmu_and_errors_of_locate(fmus: Path, tmp_path: Path) -> None:
    (tmp_path / "broken.fmu").write_bytes(b"PK")
    scene = Scene.from_dict(data(units={"a": {"fmu": "broken.fmu"}}, connections=[]), tmp_path / "scene.toml")
    with pytest.raises(FmuError, match=r"broken\.fmu"):
        described(scene, lambda name: Path(name))
    refused_when_resolved(data(units={"a": {"fmu": "shp"}}, connections=[]), fmus, "units.a.fmu", "no unit 'shp'")


@pytest.mark.parametrize(
    ("connection", "says"),
    [
        ("shp.heave -> line.top", "no unit 'shp'; did you mean 'ship'"),
        ("ship.heav -> line.top", "ship has no variable 'heav'; did you mean 'heave'"),
        ("ship.heave -> line.tob", "line has no variable 'tob'; did you mean 'top'"),
        ("ship.heave -> line.tension", "line.tension is an output: expected an input"),
        ("ship.heave -> line.length", "line.length is a parameter: expected an input"),
        ("line.top -> ship.reaction", "line.top is an input: expected an output"),
        ("ship.heave_rate -> line.top", "ship.heave_rate is a local: expected an output"),
        ("ship.port_mass -> line.top", "ship.port_mass is a calculated parameter: expected an output"),
        ("ship.mode -> line.top", "joins Integer to Real"),
        ("ship.heave -> line.on", "joins Real to Boolean"),
        ("ship.heave -> ship.reaction", r"joins m \[m\] to N \[kg.m.s-2\]: .*same thing"),
        ("ship.heave -> line.top -> ship.reaction", "no variable"),
    ],
)
def test_bad_connections(fmus: Path, connection: str, says: str) -> None:
    refused_when_resolved(data(connections=["line.tension -> ship.reaction", connection]), fmus, "connections[1]", says)


def test_two_sources_on_one_input(fmus: Path) -> None:
    units = data()["units"] | {"other": {"fmu": "ship"}}
    content = data(units=units, connections=["ship.heave -> line.top", "other.heave->line.top"])
    refused_when_resolved(content, fmus, "connections[1]", "line.top has two sources: ship.heave and other.heave")


def test_the_ends_of_a_cut_connection_are_those_of_its_names(fmus: Path) -> None:
    """Names may hold arrows: a connection is not to be split by its text."""
    back = "line.tension -> buoy.pull -> ship.reaction"
    units = data()["units"] | {"buoy": {"fmu": "arrows"}}
    section = SDOF | {"cut": [back], "driver": "buoy.up", "motion": "buoy.up"}
    found = sdof_of(resolve(data(units=units, connections=["ship.heave -> line.top", back], checks={"sdof": section}), fmus))
    assert (found.reaction, found.ship, found.cut) == ("line.tension", "buoy", (back,))


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("heave_amplitud", 1, "no variable 'heave_amplitud'; did you mean 'heave_amplitude'"),
        ("heave", 1, "'heave' is an output: only parameters and inputs can be set"),
        ("heave_rate", 1, "'heave_rate' is a local"),
        ("port_mass", 1, "'port_mass' is a calculated parameter"),
        ("heave_amplitude", 20.5, "20.5 m is out of range: expected 0 to 20 m"),
        ("heave_amplitude", "70 ft", r"21\.3\d* m \(70 ft\) is out of range"),
        ("heave_amplitude", -1e-9, "out of range"),
        ("count", 6, "6 is out of range: expected 0 to 5"),
        ("mass", math.nan, "nan is not finite"),
        ("mass", math.inf, "inf is not finite"),
        ("mass", -math.inf, "not finite"),
        ("mass", 10**400, "not finite"),
        ("mass", True, "True is no Real"),
        ("mass", "heavy", "not a number"),
        ("mass", "3 ft", r"'ft' is \[m\], but 'kg' is \[kg\]"),
        ("mass", "3 tons", "long_ton, short_ton or t"),
        ("mass", "3", "no unit"),
        ("plain", "3 m", "plain declares no unit"),
        ("strange", "3 m", "'odd' of strange is defined nowhere"),
        ("count", 2.5, "2.5 is no Integer"),
        ("count", True, "True is no Integer"),
        ("count", "2", "'2' is no Integer"),
        ("wide", 1, "1 is no Boolean"),
        ("title", 3, "3 is no String"),
        ("mass", "= ship.mass", "circular reference ship.mass -> ship.mass"),
        ("mass", "= ship.mas", "no variable 'mas'; did you mean 'mass'"),
        ("mass", "= nowhere.mass", "no unit 'nowhere'"),
        ("mass", "= mass", "no unit 'mass'"),
        ("mass", "= ship.port_mass", "is a calculated parameter: its value is known only during a run"),
        ("mass", "= ship.heave", "is an output: its value is known only"),
        ("mass", "= ship.title", "is String, expected Real"),
        ("mass", "= ship.heave_period", "joins s .* to kg"),
        ("heave_amplitude", "= ship.unset", "has no start value"),
        ("count", "= ship.plain", "is no Integer"),
    ],
)
def test_bad_parameters(fmus: Path, name: str, value: Any, says: str) -> None:
    refused_when_resolved(with_parameters(**{name: value}), fmus, f"units.ship.parameters.{name}", says)


def test_circular_references_are_named_in_full(fmus: Path) -> None:
    units = {
        "ship": {"fmu": "ship", "parameters": {"unset": "= ship.heave_amplitude", "heave_amplitude": "= line.length"}},
        "line": {"fmu": "line", "parameters": {"length": "= ship.heave_amplitude"}},
    }
    cycle = "circular reference ship.heave_amplitude -> line.length -> ship.heave_amplitude"
    refused_when_resolved(data(units=units), fmus, "units.ship.parameters.heave_amplitude", cycle)


@pytest.mark.parametrize(
    ("changes", "key", "says"),
    [
        ({"record": {"variables": ["ship.heave", "ship.hieve"]}}, "record.variables[1]", "did you mean 'heave'"),
        ({"record": {"variables": ["heave"]}}, "record.variables[0]", "no unit 'heave'"),
        ({"checks": {"report_only": ["line.margin_tout"]}}, "checks.report_only[0]", "did you mean 'margin_taut'"),
        ({"checks": {"report_only": ["line.tension"]}}, "checks.report_only[0]", "no margin"),
        ({"checks": {"sdof": SDOF | {"driver": "ship.heav"}}}, "checks.sdof.driver", "did you mean 'heave'"),
        ({"checks": {"sdof": SDOF | {"tension": "ship.mode"}}}, "checks.sdof.tension", "is Integer, expected Real"),
        ({"checks": {"sdof": SDOF | {"cut": ["line.tensio -> ship.reaction"]}}}, "checks.sdof.cut[0]",
         "did you mean 'line.tension -> ship.reaction'"),
        ({"cases": [{"name": "a", "set": {"ship.mas": 1}}]}, "cases.a.set", "units.ship.parameters.mas: .*did you mean"),
        ({"cases": [{"name": "a", "set": {"line.length": "-1 m"}}]}, "cases.a.set", "out of range"),
        ({"cases": [{"name": "a", "set": {"record.variables": ["ship.x"]}}]}, "cases.a.set", r"record\.variables\[0\]"),
    ],
)  # fmt: skip
def test_refused_against_the_units(fmus: Path, changes: dict[str, Any], key: str, says: str) -> None:
    refused_when_resolved(data(**changes), fmus, key, says)


def test_everything_named_by_checks_may_exist(fmus: Path) -> None:
    assert resolve(data(checks={"sdof": SDOF, "report_only": ["line.margin_taut"]}), fmus).scene.checks.get("sdof")


def looped(a: str = "looped", b: str = "looped", scheme: str = "auto", back: str = "y") -> dict[str, Any]:
    return data(
        units={"a": {"fmu": a}, "b": {"fmu": b}},
        connections=["a.y -> b.u", f"b.{back} -> a.u"],
        coupling={"step": 0.1, "scheme": scheme},
    )


@pytest.mark.parametrize("scheme", ["auto", "hermite", "extrapolate", "jacobi", "gauss-seidel"])
def test_algebraic_loop_is_named_and_needs_the_implicit_scheme(fmus: Path, scheme: str) -> None:
    says = r"algebraic loop a\.y -> b\.u -> b\.y -> a\.u -> a\.y, which .* use scheme 'implicit'"
    refused_when_resolved(looped(scheme=scheme), fmus, "connections", says)


def test_algebraic_loop_with_the_implicit_scheme(fmus: Path) -> None:
    assert resolve(looped(scheme="implicit"), fmus).loops == ("a.y -> b.u -> b.y -> a.u -> a.y",)


def test_no_loop_where_a_unit_has_a_state_between(fmus: Path) -> None:
    assert resolve(looped(back="z"), fmus).loops == () == resolve(data(), fmus).loops


def test_undeclared_dependencies_count_as_direct(fmus: Path) -> None:
    refused_when_resolved(
        looped(b="vague", back="z"), fmus, "connections", r"b\.z -> a\.u .*without declared dependencies"
    )


def test_loops_through_one_unit_and_two_separate_loops(fmus: Path) -> None:
    content = data(
        units={name: {"fmu": "looped"} for name in "abc"},
        connections=["a.y -> a.u", "b.y -> c.u", "c.y -> b.u"],
        coupling={"step": 0.1, "scheme": "implicit"},
    )
    assert resolve(content, fmus).loops == ("a.y -> a.u -> a.y", "b.y -> c.u -> c.y -> b.u -> b.y")


def test_case_settings(fmus: Path) -> None:
    cases = [
        {"name": "long", "set": {"stop_time": "200 s", "ship.mass": "1 t", "record.interval": "1 s"}},
        {"name": "tight", "set": {"coupling.tolerance": 1e-6, "coupling.scheme": "hermite"}},
        {"name": "plain"},
    ]
    scene = Scene.from_dict(data(cases=cases), Path("some.toml"))
    long, tight = scene.case("long"), scene.case("tight")
    assert (long.stop_time, long.record.interval, long.units["ship"].parameters) == (200.0, 1.0, {"mass": "1 t"})
    assert (tight.coupling.step, tight.coupling.tolerance, tight.coupling.scheme) == (None, 1e-6, "hermite")
    assert scene.case("plain") == replace(scene, cases=(), chosen="plain") and long.file == scene.file
    assert long.cases == () and long.chosen == "long"
    with pytest.raises(SceneError, match="unknown case 'lang'; did you mean 'long'"):
        scene.case("lang")
    assert resolve(data(cases=cases), fmus).scene.cases == scene.cases


def test_without_leaves_the_one_way_scene(fmus: Path) -> None:
    scene = Scene.from_dict(data(checks={"sdof": SDOF, "report_only": ["line.margin_taut"]}))
    one_way = scene.without(["line.tension->ship.reaction"])
    assert one_way.connections == ("ship.heave -> line.top",) and len(scene.connections) == 2
    assert one_way.checks.get("sdof") is None and one_way.checks.report_only == ("line.margin_taut",)
    assert len(described(one_way, lambda name: fmus / f"{name}.fmu").connections) == 1
    with pytest.raises(SceneError, match="did you mean 'ship.heave -> line.top'"):
        scene.without(["ship.heave -> line.tob"])


@pytest.mark.parametrize(
    ("error", "text", "code"),
    [
        (SceneError("is bad", file=Path("a.toml"), key="units.ship"), "a.toml: units.ship: is bad", 2),
        (SceneError("is bad"), "is bad", 2),
        (FmuError("is bad", file=Path("a.fmu"), entry="x"), "a.fmu: x: is bad", 2),
        (RunError("is nan", unit="ship", variable="heave", time=1.5), "ship.heave, t = 1.5 s: is nan", 3),
        (RunError("stopped", time=0.0), "t = 0 s: stopped", 3),
    ],
)
def test_errors_say_where_and_survive_pickling(error: TowageError, text: str, code: int) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert str(error) == text == str(copy) and type(copy) is type(error) and error.exit_code == code
    assert copy.__dict__ == error.__dict__


words = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True)
spaces = st.sampled_from(["", " ", "   ", "\t"])


@given(words, words, words, words, spaces, spaces)
def test_connections_have_one_spelling(a: str, x: str, b: str, y: str, left: str, right: str) -> None:
    scene = Scene.from_dict(data(connections=[f"{left}{a}.{x}.0{right}->{left}{b}.{y}[1]{right}"]))
    assert scene.connections == (f"{a}.{x}.0 -> {b}.{y}[1]",)
    assert Scene.from_dict(data(connections=list(scene.connections))).connections == scene.connections


leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
trees = st.recursive(leaves, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner))
KEYS = ["title", "stop_time", "connections", "units", "coupling", "record", "checks", "cases", "other"]
tables = st.fixed_dictionaries(
    {
        "units": trees
        | st.dictionaries(words, st.dictionaries(st.sampled_from(["fmu", "parameters"]), trees), max_size=2),
        "checks": trees | st.dictionaries(st.sampled_from(["sdof", "report_only"]), trees),
        "cases": trees | st.lists(st.fixed_dictionaries({"name": trees, "set": trees}), max_size=2),
    }
)


@given(st.dictionaries(st.sampled_from(KEYS), trees) | tables)
def test_any_table_is_a_scene_or_a_scene_error(changes: dict[str, Any]) -> None:
    try:
        assert Scene.from_dict(data(**changes)).stop_time > 0.0
    except SceneError as error:
        assert error.key or "missing" in str(error)


@given(st.floats(min_value=1e-3, max_value=1e6), st.text(alphabet=st.characters(min_codepoint=32, max_codepoint=126)))
def test_round_trip_through_toml(stop_time: float, title: str) -> None:
    text = "".join("\\" + c if c in '"\\' else c for c in title)
    document = f'title = "{text}"\nstop_time = "{stop_time!r} s"\n[coupling]\ntolerance = 1e-3\n[units.a]\nfmu = "a"\n'
    scene = Scene.from_dict(tomllib.loads(document))
    assert (scene.title, scene.stop_time) == (title, stop_time)


def test_a_case_is_a_scene_of_its_own_and_keeps_its_name() -> None:
    cases = [{"name": "long", "set": {"stop_time": "200 s"}}, {"name": "other", "set": {"ship.mass": 1.0}}]
    scene = Scene.from_dict(data(cases=cases))
    long = scene.case("long")
    assert (long.chosen, long.cases, scene.chosen) == ("long", (), "")
    assert long.setting({"ship.mass": 2.0}, "test").chosen == "long"
    with pytest.raises(SceneError, match="unknown case 'other'"):
        long.case("other")


def test_a_scene_is_its_tables() -> None:
    whole = data(
        checks={"sdof": SDOF, "report_only": ["line.margin_taut"]},
        cases=[{"name": "long", "set": {"stop_time": "200 s"}}],
        record={"interval": "1 s"},
    )
    scene = Scene.from_dict(whole)
    tables = scene.to_dict()
    assert Scene.from_dict(tables) == scene and tables["checks"]["sdof"]["settle"] == 0.0
    assert tables["coupling"]["step"] == 0.1 and tables["coupling"]["tolerance"] is None


def test_values_prevail_over_those_of_cases() -> None:
    cases = [{"name": "a", "set": {"ship.mass": 1.0, "coupling.step": "1 s"}}, {"name": "b"}]
    scene = Scene.from_dict(data(cases=cases)).with_values({"ship.mass": 3.0, "coupling.tolerance": 1e-4})
    for name in "ab":
        chosen = scene.case(name)
        assert chosen.units["ship"].parameters["mass"] == 3.0
        assert (chosen.coupling.step, chosen.coupling.tolerance) == (None, 1e-4)


def test_variants_are_resolved_with_the_scene(fmus: Path) -> None:
    resolved = resolve(data(checks={"sdof": SDOF}), fmus)
    estimate, one_way, twin = resolved.variants
    assert (estimate.name, estimate.scene, estimate.coarse) == ("error estimate", None, True)
    assert one_way.name == "one-way run" and not one_way.coarse
    assert one_way.scene is not None and len(one_way.scene.connections) == 1 and one_way.scene.variants == ()
    assert twin.name == "one-way twin" and twin.scene is not None and twin.nudged
    assert twin.scene.connections == one_way.scene.connections
    assert resolve(data(coupling={"step": 0.1, "error_estimate": False}), fmus).variants == ()
    assert pickle.loads(pickle.dumps(resolved)) == resolved


def test_checks_without_a_section_are_no_keys_of_a_scene() -> None:
    for name in ("step", "error", "towing", "margins"):
        refused(data(checks={name: {}}), f"checks.{name}", "unknown key")
