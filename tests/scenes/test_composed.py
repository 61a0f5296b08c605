"""Scenes as one unit, against the reference that joins the same equations by hand (`models/heave/system.py`)."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import fmpy
import fmpy.validation
import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from towage.errors import SceneError
from towage.fmus.declare.dependencies import dependencies
from towage.fmus.declare.unit import Unit, load
from towage.fmus.native.build import build_unit
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError
from towage.master.master import Master
from towage.models.cable.units import tow_system
from towage.models.heave import ship
from towage.models.heave.system import Simulation
from towage.models.numeric.ops import FLOATS, NEVER
from towage.scene.compose import scene_unit, unit_of
from towage.scene.monolithic import monolithic
from towage.scene.resolve import ResolvedScene, described
from towage.scene.scene import Scene
from towage.units.store import locator
from towage.verify.monolithic import solve


def resolved(name: str, case: str | None = None, **values: float) -> ResolvedScene:
    """A shipped scene; ``values`` go to its cradle."""
    scene = Scene.load(name)
    scene = replace(scene.case(case) if case else scene, cases=())
    if values:
        cradle = scene.units["cradle"]
        changed = replace(cradle, parameters=cradle.parameters | values)
        scene = replace(scene, units=scene.units | {"cradle": changed})
    return described(scene, locator())


class Player:
    """A unit by names, from its start to its end."""

    def __init__(self, unit: Unit, **values: float) -> None:
        self.unit, self.it = unit, Instance(unit)
        self.set({name.replace("__", "."): v for name, v in values.items()})
        self.it.set_up(0.0, None)
        self.it.enter_initialization()
        self.it.exit_initialization()

    def set(self, values: dict[str, float]) -> None:
        self.it.set_values([self.unit.index[n] for n in values], list(values.values()))

    def __getitem__(self, name: str) -> float:
        return self.it.get_values([self.unit.index[name]])[0]

    def advance(self, end: float) -> Player:
        self.it.do_step(self.it.time, end - self.it.time)
        return self


CASES = [
    ("sea_cliff", "8 s wave", "cradle", "line", 60.0),
    ("slack", None, "cradle", "line", 160.0),
    ("docking", "plastic capture", "cradle", "line", 100.0),
    ("docking", "soft, as in the thesis", "cradle", "line", 100.0),
    ("alvin", "10 ft", "alvin", "line", 40.0),  # longer runs are chaotic: two references of 1e-11 part at 0.07/s
    ("alvin", "25 ft", "alvin", "line", 100.0),
    ("stiff_line", None, "cradle", "cradle", 30.0),
    ("light_body", None, "cradle", "line", 100.0),
]


@pytest.mark.parametrize(("scene", "case", "body", "line", "end"), CASES, ids=lambda v: str(v))
def test_composed_scene_equals_the_system_joined_by_hand(
    scene: str, case: str | None, body: str, line: str, end: float
) -> None:
    found = resolved(scene, case)
    player = Player(unit_of(found, scene), integration_tolerance=1e-10)
    time = np.linspace(0.0, end, 81)[1:]
    pairs = np.array([(player.advance(t)[f"{body}.heave"], player[f"{line}.tension"]) for t in time])
    exact = np.transpose(solve(found, time))
    error = np.max(np.abs(pairs - exact), axis=0) / np.max(np.abs(exact), axis=0)
    # 1e-10 for each of some thousand steps, damped; what is measured is 1e-11 to 4e-9
    assert np.all(error < 1e-8), error


def test_line_that_is_slack_for_a_moment_inside_a_step() -> None:
    """For 0.018 s at 106.95 s, 0.06 mm deep, between two outputs and away from mid-step."""
    scene = Scene.load("docking").case("plastic capture")
    ship = scene.units["ship"]
    ship = replace(ship, parameters=ship.parameters | {"heave_amplitude": 1.07})
    found = described(replace(scene, units=scene.units | {"ship": ship}, cases=()), locator())
    player = Player(unit_of(found, "docking"), integration_tolerance=1e-8)
    time = 0.125 * np.arange(1, 861)
    heave = np.array([player.advance(t)["cradle.heave"] for t in time])
    exact, _ = solve(found, time)
    assert np.max(np.abs(heave - exact)) < 1e-8 * np.max(np.abs(exact))  # the tolerance; a taut line is off by 1e-7


def test_docking_and_slack_at_the_same_moment() -> None:
    """The submersible comes aboard at the instant the line goes slack, as the reference has it to the last bit."""
    scene = resolved("slack")
    reference = Simulation(monolithic(scene))
    reference.advance(80.0)
    reference.restart()
    while reference.taut:
        reference.advance(reference.t + 0.01)
    low, high = reference.t - 0.01, reference.t
    while high - low > 1e-14 * high:
        middle = 0.5 * (low + high)
        probe = Simulation(monolithic(scene))
        low, high = (middle, high) if probe_is_taut(probe, middle) else (low, middle)
    both = resolved("slack", docking_time=high, submersible_mass=3e4, submersible_weight_in_water=1e3)
    after = Simulation(monolithic(both))
    player = Player(unit_of(both, "slack"), integration_tolerance=1e-11)
    assert player["next_event_time"] == high
    player.advance(high)
    assert (player["cradle.docked"], player["next_event_time"]) == (0.0, high)  # the limit from the left
    player.set({"cradle.submersible_velocity": 0.0})
    assert (player["cradle.docked"], player["next_event_time"]) == (1.0, NEVER)
    for end in (high, high + 1.0, high + 20.0):
        exact = after.advance(end)
        if end > high:
            player.advance(end)
        assert player["line.taut"] == float(after.taut)
        # 1e-11 a step, and the docking excites what damps slowly
        assert [player["cradle.heave"], player["cradle.velocity"]] == pytest.approx(exact[-2:], rel=1e-8, abs=1e-8)


def probe_is_taut(run: Simulation, end: float) -> bool:
    run.advance(end)
    return run.taut


def test_declaration_keeps_what_the_scene_says() -> None:
    unit = scene_unit("sea_cliff", "10 s wave")
    names = unit.index
    start = {v.name: v.start for v in unit.variables}
    assert start["ship.heave_period"] == 10.0
    assert start["line.static_tension"] == start["cradle.weight_in_water"] == pytest.approx(8 * 9964.01641818352)
    assert [v.name for v in unit.inputs] == ["cradle.submersible_velocity"]
    assert "line.freeze_branches" not in names and "cradle.integration_tolerance" not in names
    assert unit.model.integrated and unit.description == "Sea Cliff's cradle under Lulu"
    depends = dependencies(unit)
    assert depends["cradle.velocity"] == ("cradle.submersible_velocity",) and depends["line.tension"] == ()


def test_parameters_of_the_composed_unit_are_free() -> None:
    """The case is a matter of start values: setting them by hand gives the same run."""
    one = Player(scene_unit("sea_cliff", "10 s wave")).advance(20.0)
    two = Player(scene_unit("sea_cliff"), ship__heave_period=10.0).advance(20.0)
    assert one["cradle.heave"] == two["cradle.heave"]
    with pytest.raises(CallError, match="line: stiffness is 0"):
        Player(scene_unit("sea_cliff"), line__stiffness=0.0, line__axial_stiffness=0.0)


def test_what_cannot_be_composed_is_refused_with_the_reason() -> None:
    with pytest.raises(SceneError, match=r"cannot be composed: \w+ gives no rates"):
        scene_unit("slender_stable")


def test_tow_scene_equals_the_equations_joined_by_hand() -> None:
    """m z'' + c z' + k z = F, F = C q + D v + E v' with v' = free'' + z'' of the towpoint: the apparent mass -E joins m."""
    scene = resolved("tow_report_sample", "half a foot of heave")
    given = scene.units["ship"].parameters
    start = {v.name: v.start for v in load("ship").parameters}
    hull = ship.Parameters(**{f.name: given.get(f.name, start[f.name]) for f in fields(ship.Parameters)})
    start = {v.name: v.start for v in load("tow_system").parameters}
    tow = tow_system.Parameters(
        **{
            f.name: scene.units["tow"].parameters.get(f.name, start[f.name])
            for f in fields(tow_system.Parameters)
        }
    )
    (a,), (b,), c, d, e, _ = tow_system.prepare(tow)
    n = len(a)

    def motion(t: float, x: NDArray[np.float64]) -> tuple[float, float]:
        """Velocity and acceleration of the towpoint."""
        _, rate, free = ship.free_motion(t, hull, FLOATS)
        v = rate + x[n + 1]
        force = c[1] @ x[:n] + d[1, 1] * v + e[1, 1] * free
        return v, free + (force - hull.damping * x[n + 1] - hull.stiffness * x[n]) / (hull.mass - e[1, 1])

    def rates(t: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
        v, acceleration = motion(t, x)
        response = acceleration - ship.free_motion(t, hull, FLOATS)[2]
        return np.array([*(a @ x[:n] + b[:, 1] * v), x[n + 1], response, v])

    time = np.linspace(0.0, 12.0, 25)
    found = solve_ivp(rates, (0.0, 12.0), np.zeros(n + 3), "DOP853", time, rtol=1e-12, atol=1e-12)
    moving = np.array([motion(t, x) for t, x in zip(time, found.y.T)])
    heave = c[5] @ found.y[:n] + found.y[n + 2] + moving @ [d[5, 1], e[5, 1]]
    player = Player(unit_of(scene, "tow"), integration_tolerance=1e-12)
    for t, response, body in list(zip(time, found.y[n], heave))[1:]:
        player.advance(t)
        # 1e-12 a step on both sides, of displacements of 1e-4 and 0.1 m; tolerances are those of reduced coordinates
        assert player["ship.heave"] - player["ship.free_heave"] == pytest.approx(response, rel=1e-7, abs=1e-10)
        assert player["tow.body_heave"] == pytest.approx(body, rel=1e-7, abs=1e-8)


def test_stated_rates_of_a_tow_are_those_of_its_outputs() -> None:
    """Rates of forces contain u'', which follows from the composition: against central differences."""
    player = Player(scene_unit("tow_report_sample"), integration_tolerance=1e-12)
    names = ("tow.reaction_heave", "tow.tension_top", "tow.body_heave", "ship.velocity")
    step, seen = 1e-3, []
    for end in (3.0 - step, 3.0, 3.0 + step):
        player.advance(end)
        seen.append([player[n] for n in names] + [player[f"{n}_rate"] for n in names])
    before, now, after = np.array(seen)
    central = (after - before)[:4] / (2.0 * step)
    # the next term of the difference, (w h)^2/6, for the 26/s of the fastest state is 1e-4
    assert now[4:] == pytest.approx(central, rel=2e-4)


def test_parameters_of_a_linear_part_are_fixed() -> None:
    with pytest.raises(CallError, match=r"tow\.body_drag = 3 N: expected"):
        Player(scene_unit("tow_report_sample"), tow__body_drag=3.0)


@pytest.fixture(scope="module")
def slack_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The slack scene as a native FMU."""
    return build_unit(scene_unit("slack"), tmp_path_factory.mktemp("native"))[0]


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_native_fmu_of_a_scene_equals_the_reference(slack_fmu: Path, kind: str) -> None:
    """In fmpy; the line goes slack and taut inside its steps."""
    found = fmpy.simulate_fmu(
        str(slack_fmu), fmi_type=kind, stop_time=60.0, output_interval=0.5, relative_tolerance=1e-8,
        start_values={"integration_tolerance": 1e-10}, output=["cradle.heave", "line.tension"],
    )  # fmt: skip
    exact = np.transpose(solve(resolved("slack"), found["time"]))
    # co-simulation: as in process; model exchange: the host's own solver at 1e-8 a step
    limit = {"CoSimulation": 1e-8, "ModelExchange": 1e-5}[kind]
    for name, wanted in zip(("cradle.heave", "line.tension"), exact.T):
        assert np.max(np.abs(found[name] - wanted)) < limit * np.max(np.abs(wanted)), name


def test_native_fmu_of_a_scene_is_valid_and_runs_in_a_scene(slack_fmu: Path) -> None:
    assert fmpy.validation.validate_fmu(str(slack_fmu)) == []
    scene = Scene.from_dict({
        "title": "the scene in a scene", "stop_time": 20.0, "coupling": {"step": 0.5, "error_estimate": False},
        "units": {"whole": {"fmu": str(slack_fmu), "parameters": {"integration_tolerance": 1e-10}}},
        "record": {"variables": ["whole.cradle.heave", "whole.line.tension"]},
    })  # fmt: skip
    result = Master(scene, flavour="python").run()
    heave, tension = solve(resolved("slack"), result.time)
    assert result["whole.cradle.heave"] == pytest.approx(heave, abs=1e-8 * np.max(np.abs(heave)))
    assert result["whole.line.tension"] == pytest.approx(tension, rel=1e-8)
