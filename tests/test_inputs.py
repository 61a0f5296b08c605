"""Inputs that are neither connected nor set, constants for them, and bodies that cannot be: every unit, every kind of scene."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import towage
from towage import cli
from towage.ensemble.rows import refusals
from towage.errors import SceneError
from towage.fmus import UNITS
from towage.fmus.declare.interface import Interface
from towage.fmus.declare.unit import load
from towage.fmus.describe.fmi2 import native_model_description
from towage.fmus.native.trace import trace
from towage.fmus.python.values import CallError
from towage.models.numeric.ops import FLOATS
from towage.models.protocol.model import refusal_of
from towage.models.protocol.physical import GRAVITY
from towage.scene.compose import unit_of
from towage.scene.flavour import resolve
from towage.scene.resolve import check_all, described
from towage.scene.scene import Scene, available_scenes
from towage.units.archive import read_description
from towage.units.store import locator

from .fmus.native_instance import REFUSED, NativeInstance, unit_library
from .fmus.test_instance import Player

NEEDED = {
    "spring_line": {"heave_top", "heave_bottom"},
    "cradle": {"line_tension"},
    "cradle_on_line": {"heave_top"},
    "slender_body": {"tow_speed"},
    "tow_cable": {"body_velocity_surge", "body_velocity_heave"},
    "towed_body": {"force_surge", "force_heave"},
}
"""Inputs without which a unit means nothing."""
PERHAPS = {
    "slender_body": {"craft_lateral"},
    "ship_in_sea": {"wave_height", "wave_direction", "speed"},
    "tow_system": {"velocity_heave"},
    "wire": {"velocity_heave"},
    "tow_cable": {"top_velocity_heave"},
}
"""Inputs that may have been forgotten: a warning. All others have a meaning when they are left open."""
INPUTS = [(name, v.name) for name in UNITS for v in load(name).inputs]
SHIP = {"heave_amplitude": "2 ft", "heave_period": "8 s", "mass": "900 long_ton", "stiffness": "72 tonf_long/ft"}
HEAVE: dict[str, Any] = {
    "title": "ship, line, cradle",
    "stop_time": "1 s",
    "connections": [
        "ship.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension",
        "line.reaction -> ship.reaction",
    ],
    "units": {
        "ship": {"fmu": "ship", "parameters": SHIP},
        "line": {
            "fmu": "spring_line", "parameters": {"stiffness": 1e5, "static_tension": "= cradle.weight_in_water"},
        },
        "cradle": {"fmu": "cradle", "parameters": {"mass": "35 long_ton", "weight_in_water": "8 tonf_long"}},
    },
    "coupling": {"step": 0.1},
}  # fmt: skip


def heave(connections: list[str] | None = None, **units: dict[str, Any]) -> Scene:
    """The scene of ship, line and cradle; ``units`` are parameters that replace or add to those above."""
    data = copy.deepcopy(HEAVE)
    for unit, parameters in units.items():
        data["units"][unit]["parameters"] = {**data["units"][unit]["parameters"], **parameters}
    return Scene.from_dict(data if connections is None else data | {"connections": connections})


def alone(unit: str, inputs: dict[str, Any], fmu: str = "") -> Scene:
    """A scene of one unit that is connected to nothing."""
    data = {
        "title": unit, "stop_time": "1 s", "coupling": {"step": 0.1},
        "units": {"it": {"fmu": fmu or unit, "parameters": _starts(unit), "inputs": inputs}},
    }  # fmt: skip
    return Scene.from_dict(data)


def _starts(unit: str) -> dict[str, float]:
    """The parameters of the unit's reference run."""
    names = {v.name for v in load(unit).parameters}
    return {name: value for name, value in load(unit).start.items() if name in names}


def refused(scene: Scene, key: str, *says: str) -> str:
    """The message of a scene that is refused for ``key`` by a run and by ``towage validate`` alike."""
    messages = []
    for ask in (described, check_all):
        with pytest.raises(SceneError) as caught:
            ask(scene, locator())
        assert caught.value.key == key
        messages.append(str(caught.value))
    assert messages[0] == messages[1]
    for text in says:
        assert text in messages[0]
    return messages[0]


# ---- what the units say ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", UNITS)
def test_every_input_is_needed_or_has_a_meaning_or_may_be_forgotten(name: str) -> None:
    inputs = load(name).inputs
    assert {v.name for v in inputs if v.needed} == NEEDED.get(name, set())
    assert {v.name for v in inputs if not v.needed and not v.unset} == PERHAPS.get(name, set())
    assert not [v for v in inputs if v.needed and v.unset]


@pytest.mark.parametrize("name", UNITS)
def test_the_fmu_says_the_same(name: str) -> None:
    described_inputs = [v for v in read_description(locator()(name)).variables if v.causality == "input"]
    assert [(v.name, v.needed, v.unset) for v in described_inputs] == [
        (v.name, v.needed, v.unset) for v in load(name).inputs
    ]
    native = ElementTree.fromstring(native_model_description(Interface(load(name)), name, "guid", ()))
    entries = native.iterfind("VendorAnnotations/Tool/Interface/Inputs/*")
    said = {e.get("name"): (e.get("needed"), e.get("unset")) for e in entries}
    assert said == {
        v.name: ("true", None) if v.needed else (None, v.unset) for v in load(name).inputs if v.needed or v.unset
    }


@pytest.mark.parametrize("name", UNITS)
def test_a_parameter_that_is_needed_has_an_example_in_the_unit_and_is_asked_of_a_scene(name: str) -> None:
    needed = {v.name for v in load(name).parameters if v.needed}
    assert needed == ({"axial_stiffness"} if name == "tow_cable" else set())
    assert {v.name for v in read_description(locator()(name)).variables if v.needed and v.causality == "parameter"} == needed
    for parameter in needed:
        data = alone(name, {v.name: v.start for v in load(name).inputs}).to_dict()
        assert resolve(Scene.from_dict(data))
        del data["units"]["it"]["parameters"][parameter]
        refused(Scene.from_dict(data), f"units.it.parameters.{parameter}", "is not set, and it needs it", "give that of yours")


# ---- neither connected nor set ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "open_input"), INPUTS, ids=[f"{u}.{i}" for u, i in INPUTS])
@pytest.mark.parametrize("by", ["name", "file"])
def test_an_open_input_is_refused_or_told_or_meant(name: str, open_input: str, by: str) -> None:
    """Each input of each unit left open alone, the unit given by its name and by its FMU alone."""
    fmu = str(locator()(name).resolve()) if by == "file" else name
    others = {v.name: v.start for v in load(name).inputs if v.name != open_input}
    scene = alone(name, others, fmu)
    if open_input in NEEDED.get(name, ()):
        refused(scene, f"units.it.inputs.{open_input}", f"it.{open_input} is neither connected nor set, and it needs it")
    else:
        told = (f"it.{open_input}",) if open_input in PERHAPS.get(name, ()) else ()
        assert check_all(scene, locator()) == described(scene, locator()).forgotten == told
    every = {v.name: v.start for v in load(name).inputs}
    assert check_all(alone(name, every, fmu), locator()) == ()


def test_a_towed_body_without_a_speed_is_refused_with_the_crafts_speed() -> None:
    data = {
        "title": "craft and body", "stop_time": "1 s", "coupling": {"step": 0.1},
        "units": {"craft": {"fmu": "sway_craft"}, "body": {"fmu": "slender_body"}},
        "connections": ["craft.lateral -> body.craft_lateral"],
    }  # fmt: skip
    refused(
        Scene.from_dict(data), "units.body.inputs.tow_speed", "body.tow_speed is neither connected nor set",
        'connect "craft.tow_speed -> body.tow_speed"', "[units.body.inputs] tow_speed = ...",
    )  # fmt: skip
    data["connections"].append("craft.tow_speed -> body.tow_speed")  # type: ignore[attr-defined]
    assert check_all(Scene.from_dict(data), locator()) == ()


@pytest.mark.parametrize(
    ("left_out", "place", "offer"),
    [
        (0, "line.heave_top", "ship.heave -> line.heave_top"),
        (1, "line.heave_bottom", "cradle.heave -> line.heave_bottom"),
        (2, "cradle.line_tension", "line.tension -> cradle.line_tension"),
    ],
)
def test_a_missing_connection_of_a_lift_is_refused_with_what_fits(left_out: int, place: str, offer: str) -> None:
    connections = [text for k, text in enumerate(HEAVE["connections"]) if k != left_out]
    unit, _, name = place.partition(".")
    message = refused(heave(connections), f"units.{unit}.inputs.{name}", f"{place} is neither connected nor set", offer)
    assert "velocity" not in message and "margin" not in message, "only what measures the same is offered"
    assert check_all(heave(), locator()) == ()


def test_a_ship_without_the_lines_reaction_is_meant_so() -> None:
    assert check_all(heave(HEAVE["connections"][:3]), locator()) == ()


def test_where_nothing_fits_a_constant_is_offered_alone() -> None:
    message = refused(alone("slender_body", {}), "units.it.inputs.tow_speed", "no output of another unit measures the same")
    assert "[units.it.inputs] tow_speed = ..." in message and "connect" not in message.replace("neither connected", "")


def test_connections_cut_for_a_one_way_run_are_no_missing_inputs() -> None:
    """Even one that its unit needs: the variant leaves it out on purpose."""
    sdof = {"driver": "ship.heave", "motion": "cradle.heave", "tension": "line.tension"}
    for cut in HEAVE["connections"][2:]:
        scene = Scene.from_dict(HEAVE | {"checks": {"sdof": sdof | {"cut": [cut]}}})
        assert described(scene, locator()).forgotten == ()
        assert check_all(scene, locator()) == ()


def test_what_does_not_run_the_scene_takes_open_ends() -> None:
    """Critical speeds, gains and a unit made of the scene: the open input is varied or becomes one of the unit."""
    (found,) = towage.stability(alone("slender_body", {}))
    assert found.limits
    assert towage.response(alone("tow_cable", {}), frequencies=[0.1])
    scene = heave(HEAVE["connections"][1:])
    unit = unit_of(described(scene, locator(), open_ends=True), "lift")
    assert [(v.name, v.needed) for v in unit.inputs] == [
        ("line.heave_top", True), ("cradle.submersible_velocity", False),
    ]  # fmt: skip


def test_a_forgotten_input_is_one_warning_of_the_run() -> None:
    result = towage.run(alone("slender_body", {"tow_speed": "3 m/s"}), flavour="python")
    (told,) = [finding for finding in result.checks if finding.name == "inputs"]
    assert result.status == "done" and told.level == "warning"
    assert told.message.startswith("it.craft_lateral is neither connected nor set and keeps the start value")
    both = towage.run(alone("tow_system", {}), flavour="python")
    (told,) = [finding for finding in both.checks if finding.name == "inputs"]
    assert told.message.startswith("it.velocity_heave is neither")
    still = towage.run(alone("tow_system", {"velocity_surge": 0, "velocity_heave": 0}), flavour="python")
    assert not [finding for finding in still.checks if finding.name == "inputs"]


@pytest.mark.parametrize("name", [scene.name for scene in available_scenes()])
def test_shipped_scenes_leave_nothing_open_and_hold_no_impossible_body(name: str) -> None:
    assert check_all(Scene.load(name), locator()) == ()


def test_validate_tells_of_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = 'title = "t"\nstop_time = 1\n[coupling]\nstep = 0.1\n[units.body]\nfmu = "slender_body"\n'
    open_speed, open_craft = tmp_path / "speed.toml", tmp_path / "craft.toml"
    open_speed.write_text(text)
    open_craft.write_text(text + '[units.body.inputs]\ntow_speed = "3 m/s"\n')
    assert cli.main(["validate", str(open_speed)]) == SceneError.exit_code
    assert "body.tow_speed is neither connected nor set" in capsys.readouterr().err
    assert cli.main(["validate", str(open_craft)]) == 0
    assert "warning  inputs: body.craft_lateral is neither connected nor set" in capsys.readouterr().out


# ---- constants -------------------------------------------------------------------------------------------------------


def test_constants_have_units_of_measure_references_cases_and_a_place_of_their_own() -> None:
    data = copy.deepcopy(HEAVE) | {"connections": HEAVE["connections"][2:]}
    data["units"]["line"]["inputs"] = {"heave_top": "10 ft", "heave_bottom": "= line.heave_top"}
    data["cases"] = [{"name": "low", "set": {"line.heave_top": "1 ft"}}]
    scene = Scene.from_dict(data)
    for chosen, feet in ((scene, 10.0), (scene.case("low"), 1.0), (scene.with_values({"line.heave_top": "2 ft"}), 2.0)):
        values = described(chosen, locator()).units["line"].parameters
        assert values["heave_top"] == values["heave_bottom"] == pytest.approx(0.3048 * feet, rel=1e-15)
        assert "heave_top" not in chosen.units["line"].parameters
    assert Scene.from_dict(scene.to_dict()) == scene


def test_a_constant_under_parameters_is_still_taken_and_runs_the_same() -> None:
    """As scenes had it before there was a table for it."""
    new = heave(HEAVE["connections"][2:])
    old = heave(HEAVE["connections"][2:], line={"heave_top": 0.3, "heave_bottom": 0.0})
    data = new.to_dict()
    data["units"]["line"]["inputs"] = {"heave_top": 0.3, "heave_bottom": 0.0}
    runs = [towage.run(scene, flavour="python") for scene in (Scene.from_dict(data), old)]
    assert np.ptp(runs[0].columns["cradle.heave"]) > 1e-3, "the constant pulls"
    assert all(np.array_equal(runs[0].columns[name], values) for name, values in runs[1].columns.items())


@pytest.mark.parametrize(
    ("inputs", "key", "says"),
    [
        ({"heave_top": 0.0}, "units.line.inputs.heave_top", "line.heave_top is connected to ship.heave"),
        ({"length": 3.0}, "units.line.inputs.length", "'length' is a parameter: set it in [units.line.parameters]"),
        ({"heave_tob": 3.0}, "units.line.inputs.heave_tob", "did you mean 'heave_top'"),
        ({"heave_bottom": "3 kg"}, "units.line.inputs.heave_bottom", "kg"),
        ({"tension": 3.0}, "units.line.inputs.tension", "'tension' is an output: only parameters and inputs can be set"),
    ],
)
def test_constants_that_cannot_be_are_refused(inputs: dict[str, Any], key: str, says: str) -> None:
    connections = [text for text in HEAVE["connections"] if "heave_bottom" not in text]
    data = heave(connections).to_dict()
    data["units"]["line"]["inputs"] = {"heave_bottom": 0.0} | inputs
    refused(Scene.from_dict(data), key, says)


def test_a_value_stands_in_one_table() -> None:
    data = copy.deepcopy(HEAVE)
    data["units"]["line"]["inputs"] = {"stiffness": 3.0}
    with pytest.raises(SceneError, match="is set under parameters too") as caught:
        Scene.from_dict(data)
    assert caught.value.key == "units.line.inputs.stiffness"
    for bad, key in (({"heave_top": [1]}, "units.line.inputs.heave_top"), (3, "units.line.inputs")):
        data["units"]["line"]["inputs"] = bad
        with pytest.raises(SceneError) as caught:
            Scene.from_dict(data)
        assert caught.value.key == key


# ---- bodies that cannot be -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("mass", "weight"), [("20 kg", "150 kN"), ("20 t", "250 kN")])
def test_a_cradle_heavier_in_water_than_in_air_is_refused(mass: str, weight: str) -> None:
    message = refused(
        heave(cradle={"mass": mass, "weight_in_water": weight}), "units.cradle.parameters",
        "weight_in_water is above mass * g",
    )  # fmt: skip
    assert re.search(r"\(mass = \d+ kg, weight_in_water = \d+ N\)", message)


@given(mass=st.floats(1.0, 1e7), share=st.floats(0.0, 10.0))
def test_weight_in_water_may_reach_that_in_air_and_no_more(mass: float, share: float) -> None:
    p = {"mass": mass, "weight_in_water": share * mass * GRAVITY}
    assert bool(_unmet("cradle", p)) == (share > 1.0 + 1e-6) or abs(share - 1.0) < 2e-6


def test_a_problem_without_dimensions_has_no_gravity() -> None:
    """M = K = X0 = 1 with any weight, in a medium that is no water; its own medium is bounded by mercury alone."""
    for density in (0.0, 0.6, 2000.0):
        assert not _unmet("cradle", {"mass": 1.0, "weight_in_water": 200.0, "water_density": density})
    for density in (920.0, 1000.0, 1240.0):
        assert _unmet("cradle", {"mass": 1.0, "weight_in_water": 200.0, "water_density": density})


def _unmet(name: str, values: dict[str, float]) -> str:
    unit = load(name)
    assert unit.model.requirements
    p = unit.model.Parameters(**{v.name: values.get(v.name, v.start) for v in unit.parameters})
    return refusal_of(unit.model.requirements(p, FLOATS))


STIFF = {"stiffness": 1e5}
IMPOSSIBLE: list[tuple[str, dict[str, float], str]] = [
    ("cradle", {"mass": 100.0, "weight_in_water": 990.0}, "weight_in_water is above mass"),
    ("cradle", {"water_density": 528e3}, "water_density is above"),
    (
        "cradle", {"docking_time": 1.0, "submersible_mass": 100.0, "submersible_weight_in_water": 990.0},
        "submersible_weight_in_water is above submersible_mass",
    ),
    ("cradle_on_line", STIFF | {"mass": 100.0, "weight_in_water": 990.0}, "weight_in_water is above mass"),
    ("cradle_on_line", STIFF | {"mass": 1e3, "weight_in_water": 9e3, "breaking_load": 8e3}, "reaches breaking_load"),
    (
        "cradle_on_line", STIFF | {"docking_time": 1.0, "submersible_mass": 1.0, "submersible_weight_in_water": 10.0},
        "submersible_weight_in_water is above submersible_mass",
    ),
    ("spring_line", STIFF | {"static_tension": 9e3, "breaking_load": 8e3}, "static_tension, which the line carries at rest"),
    ("slender_body", {"mass_per_length": 2e3}, "mass_per_length is more than osmium"),
    ("slender_body", {"water_density": 1.025e6}, "water_density is above"),
    *(
        (tow, values, says)
        for tow in ("tow_system", "tow_cable")
        for values, says in (
            ({"cable_weight": 9.0, "axial_stiffness": 1e6}, "cable_weight is above cable_mass"),
            ({"body_weight_in_water": 9e3, "axial_stiffness": 1e6}, "body_weight_in_water is above body_mass"),
            ({"water_density": 1.025e6, "axial_stiffness": 1e6}, "water_density is above"),
        )
    ),
]  # fmt: skip


@pytest.mark.parametrize(("name", "values", "says"), IMPOSSIBLE)
def test_what_cannot_be_is_refused_by_scene_and_unit(name: str, values: dict[str, float], says: str) -> None:
    inputs = {v.name: v.start for v in load(name).inputs}
    scene = alone(name, inputs)
    data = scene.to_dict()
    data["units"]["it"]["parameters"] |= values
    message = refused(Scene.from_dict(data), "units.it.parameters", says)
    assert all(f"{n} = " in message for n in values if n in says.split()), "the numbers are told"
    with pytest.raises(CallError, match=re.escape(says)):
        Player(name, **values)


@pytest.mark.parametrize("name", ["cradle", "cradle_on_line", "spring_line"])
def test_the_native_flavour_refuses_alike(name: str, tmp_path: Path) -> None:
    """Its requirements as an ensemble asks them, and its library when it is initialised."""
    unit = load(name)
    library = unit_library(trace(unit), tmp_path)
    variables = unit.parameters + unit.inputs
    places = {v.name: k for k, v in enumerate(variables)}
    for values, says in [(v, s) for n, v, s in IMPOSSIBLE if n == name]:
        table = np.tile([v.start or 0.0 for v in variables], (2, 1))
        table[:, places.get("stiffness", places.get("mass"))] = 1e5  # type: ignore[index]
        table[1, [places[n] for n in values]] = list(values.values())
        reasons = refusals(unit, trace(unit), table)
        assert list(reasons) == [1] and says in reasons[1]
        refusing = NativeInstance(library, trace(unit), **values)
        assert refusing.initialized == REFUSED and refusing.message == reasons[1]


@pytest.mark.parametrize("name", UNITS)
def test_no_unit_takes_a_negative_mass_or_density(name: str) -> None:
    for v in load(name).parameters:
        if v.unit in ("kg", "kg/m", "kg/m3"):
            assert (v.min is not None and v.min >= 0.0) or _unmet(name, {v.name: -1.0}), v.name


def test_a_unit_of_which_only_the_file_is_known_refuses_when_it_starts(tmp_path: Path) -> None:
    inputs = {"line_tension": 0.0}
    data = alone("cradle", inputs, str(locator()("cradle").resolve())).to_dict()
    data["units"]["it"]["parameters"] |= {"mass": 20.0, "weight_in_water": 150e3}
    with pytest.raises(towage.RunError, match="weight_in_water is above mass"):
        towage.run(Scene.from_dict(data), flavour="python")


def test_resolving_for_a_run_asks_the_same() -> None:
    with pytest.raises(SceneError, match="weight_in_water is above mass"):
        resolve(heave(cradle={"mass": "20 kg"}), flavour="python")
