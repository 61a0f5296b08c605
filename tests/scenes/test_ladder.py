"""The ladder of models: rungs of every family, their errors and costs, the one that is enough, and bad input."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

import towage
from towage.checks.signals import component, difference
from towage.checks.track import Track
from towage.cli import main
from towage.errors import SceneError
from towage.ladder import simplest as ladders
from towage.ladder.axis import Level, Seen, Trial, Unfit, moved
from towage.ladder.lift import elastic
from towage.ladder.measure import Asked, Shown, asked, bare, errors, word
from towage.ladder.report import document, ladder_of, markdown, text, write_report
from towage.ladder.rungs import Rung, axes_of, rungs_of
from towage.ladder.simplest import Ladder, recommended, scene_of, simplest
from towage.ladder.tow import wire as towed_wire
from towage.ladder.wire import cabled
from towage.models.cable.parameters import TowParameters
from towage.models.heave.linear import equal_loss, equivalent_damping, transient
from towage.result.records import Statistic
from towage.result.result import Result
from towage.scene.parts import Record
from towage.scene.resolve import described
from towage.scene.scene import Scene, available_scenes
from towage.scene.scene_file import toml
from towage.scene.select import select
from towage.units.store import locator

HEAVY = str(Path(__file__).parent / "verdict" / "heavy_weather_linear.toml")
"""Heavy weather on `tow_system`."""
SHORT = {"stop_time": 40.0, "checks.sdof.settle": 16.0}
"""Two waves of `sea_cliff` after her start."""


@pytest.fixture(scope="module")
def lift() -> Ladder:
    return simplest("sea_cliff", "8 s wave", set=SHORT)


def rung(ladder: Ladder, *levels: str) -> Rung:
    return next(rung for rung in ladder.rungs if rung.levels == levels)


def trial(name: str, case: str | None = None, values: Mapping[str, Any] | None = None, mean: float = 0.0) -> Trial:
    """Of a scene that was not run: its outputs swing by 1 about ``mean`` in its own period of 8 s."""
    scene = select(name, case, values)
    time = np.linspace(0.0, 40.0, 401)
    first = Trial(scene, {}, Seen(Track(time, {}), 8.0), locator())
    variables = [f"{n}.{v.name}" for n, unit in first.resolved.units.items() for v in unit.description.variables]
    track = Track(time, {name: mean + np.sin(2.0 * math.pi * time / 8.0) for name in variables})
    return Trial(scene, {name: name for name in variables}, Seen(track, 8.0), locator())


def test_a_lift_has_its_rungs_with_errors_and_costs(lift: Ladder) -> None:
    assert len(lift.rungs) == 16
    assert all(r.errors and r.cost > 0.0 and r.ratio > 0.0 for r in lift.rungs if not r.reason)
    assert [r.levels[1:] for r in lift.rungs if r.reason] == 2 * [("nonlinear wire", "linear drag")]
    fullest = rung(lift, "two ways", "nonlinear wire", "quadratic drag")
    assert lift.fullest == fullest
    assert (fullest.error, fullest.ratio, fullest.leaves_out) == (0.0, 1.0, ())
    assert [r for r in lift.rungs if r.given] == [rung(lift, "two ways", "with slack", "quadratic drag")]
    assert lift.enough is not None
    assert lift.enough.error <= lift.tolerance
    assert lift.own_error < lift.tolerance


def test_errors_are_those_of_the_written_scene(lift: Ladder, tmp_path: Path) -> None:
    """The scene file of a rung, run by `towage.run`, is as far from the run of the fullest as the ladder says."""
    runs = {}
    for name, chosen in (("simple", rung(lift, "one way", "always taut", "linear drag")), ("full", lift.fullest)):
        path = tmp_path / f"{name}.toml"
        path.write_text(toml(moved(scene_of(lift, chosen), tmp_path)))
        runs[name] = towage.run(path)
    settled = runs["full"].time >= lift.settle
    told = rung(lift, "one way", "always taut", "linear drag").errors
    assert told is not None
    units = [scene_of(lift, lift.fullest).units[name].parameters for name in ("line", "line")]
    weight = float(units[0]["wire_weight"]) * float(units[0]["wire_length"])
    for full, simple, signal, more in (
        ("line.body_heave", "cradle.heave", "cradle.heave", 0.0), ("line.tension_top", "line.tension", "line.tension", weight),
    ):  # fmt: skip
        found = difference(runs["full"][full][settled] - more, runs["simple"][simple][settled])
        for kind, size in found._asdict().items():
            assert size == pytest.approx(told[f"{kind} of {signal}"].error, rel=1e-9, abs=1e-12)


def test_one_way_agrees_with_the_sdof_check(lift: Ladder) -> None:
    """The same two runs, compared by the check: of these two only the line is no wire."""
    comparison = towage.run("sea_cliff", "8 s wave", set=SHORT).comparison
    one, two = (rung(lift, ways, "with slack", "quadratic drag") for ways in ("one way", "two ways"))
    assert comparison and one.errors and two.errors
    name = "amplitude of cradle.heave"
    between = (1.0 + one.errors[name].error) / (1.0 + two.errors[name].error) - 1.0
    assert between == pytest.approx(comparison.amplitude, abs=1e-6)


def test_what_is_shown(lift: Ladder, tmp_path: Path) -> None:
    shown = text(lift)
    assert shown.isascii()
    assert len(shown.splitlines()) == 1 + 1 + 16 + 3 + 1
    assert "recommended" in shown and "not asked: Is the sea regular? (no ship_in_sea drives it)" in shown
    told = json.loads(json.dumps(document(lift), allow_nan=False))
    assert told["enough"] == lift.enough.name if lift.enough else False
    assert len(told["rungs"]) == 16
    assert markdown(lift).count("\n|") == 18
    assert markdown(ladder_of(told)) == markdown(lift)
    page = write_report([lift], tmp_path / "report.html").read_text("utf-8")
    assert page.count("<svg") == 1 and "Scene file of the recommended model" in page


@pytest.mark.parametrize("name", [scene.name for scene in available_scenes()])
def test_every_shipped_scene_has_rungs_that_fit_or_say_why(name: str) -> None:
    scene = Scene.load(name)
    base = trial(name, scene.cases[0].name if scene.cases else None)
    axes, absent = axes_of(base)
    rungs = rungs_of(base, axes)
    assert len(axes) + len(absent) == 6
    assert all(bool(r.trial) != bool(r.reason) for r in rungs)
    assert sum(r.trial is not None for r in rungs) >= 2
    for r in rungs:
        if r.trial:  # what is written is what was made
            again = Scene.from_dict(tomllib.loads(toml(structs.replace(r.trial.scene, cases=()))))
            assert (again.units, again.connections, again.coupling) == (
                r.trial.scene.units, r.trial.scene.connections, r.trial.scene.coupling,
            )  # fmt: skip


def test_a_tow_becomes_spring_linear_and_nonlinear() -> None:
    for name, case in (("tow_600ft", "half a foot of heave"), ("tow_two_units", None), (HEAVY, "3 m of heave")):
        base = trial(name, case)
        made = {r.levels: r for r in rungs_of(base, axes_of(base)[0]) if r.trial}
        kinds = {
            levels[1]: {unit.fmu for unit in r.trial.scene.units.values()} - {"ship", "towed_body"}
            for levels, r in made.items() if r.trial
        }  # fmt: skip
        assert kinds["massless spring EA/L"] == {"spring_line", "cradle"}
        assert kinds["nonlinear wire"] == {"wire"}
        assert kinds["linear cable"] <= {"tow_system", "tow_cable"}
        assert len(made) == 8


@pytest.mark.parametrize(
    ("name", "case", "within"), [(HEAVY, "3 m of heave", 0.02), ("tow_600ft", "half a foot of heave", 0.001)]
)
def test_a_tow_and_the_wire_that_takes_its_place_are_one(name: str, case: str, within: float) -> None:
    """There and back: what the `wire` of a tow becomes as a towing unit is that tow. What it cannot describe it names."""
    base = trial(name, case)
    there = towed_wire(base)
    back = cabled(there)
    assert {unit.description.model_name for unit in back.resolved.units.values()} == {"ship", "tow_system"}
    for field in fields(TowParameters):
        if field.name != "perturbation_limit":
            assert back.value("tow", field.name) == pytest.approx(base.value("tow", field.name), rel=1e-12), field.name
    # drag, weight and stretch: the steady pull of both at the ship, of segments to second order against elements of the fourth:
    # 12 lump a twelfth of the weight and drag at each end
    steady = [towage.run(bare(made.scene).setting({"stop_time": 0.2}, "test"))["tow.tension_top"][0] for made in (there, base)]
    assert steady[1] == pytest.approx(steady[0], rel=within)


def test_a_force_aft_is_one_forward_of_the_other_sign() -> None:
    there = towed_wire(trial("float_quadrant2", None, {"tow.axial_stiffness": 4e6}))
    (connection,) = (c for c in there.resolved.connections if c.target == "body_force_surge")
    assert connection.factor == -1.0 and connection.source == "drag_change"
    assert cabled(there).value("tow", "quadrant") == 2.0
    ten = {"tow.loading_form": 2.0, "tow.normal_a0": 1.0, "tow.tangential_a0": 0.1}
    general = trial("tow_600ft", "half a foot of heave", ten)
    with pytest.raises(Unfit, match="the wire does not know ten coefficients"):
        towed_wire(general)


def test_a_wire_has_its_rungs_with_the_weight_that_a_spring_does_not_bear() -> None:
    base = trial("deep_lift", mean=2.0)
    made = {r.levels: r for r in rungs_of(base, axes_of(base)[0])}
    assert [levels for levels, r in made.items() if r.reason] == [
        (f"nonlinear wire{finer}", "linear drag") for finer in (", half as fine", "")
    ]
    sprung = made["with slack", "quadratic drag"].trial
    assert sprung and set(sprung.scene.units) == {"ship", "wire", "wire_body"}
    assert sprung.names["wire.tension_top"] == sprung.names["wire.tension_body"] == "wire.tension"
    assert sprung.more["wire.tension_top"] == pytest.approx(2950.0 * 374.48)
    assert sprung.more["wire.tension_body"] == 0.0
    elastic = made["elastic wire", "quadratic drag"].trial
    assert elastic and elastic.names["wire.tension_top"] == "wire.tension_top"
    assert elastic.more["wire.tension_top"] == pytest.approx(0.0, abs=1e-6)
    halved = made["nonlinear wire, half as fine", "quadratic drag"].trial
    assert halved and halved.value("wire", "elements") == 2.0  # of four, as many as the tolerance of the shape needs
    paid = trial("deep_lift", None, {"wire.current_surge": 0.5})
    found = [r.reason for r in rungs_of(paid, axes_of(paid)[0]) if r.levels[0] == "with slack"]
    assert found and "wire.current_surge is not zero" in found[0]


def test_irregular_motions_are_compared_by_statistics() -> None:
    """Two records of one sea are the same motion; one a tenth larger is not; a short one tells nothing."""
    random = np.random.default_rng(3)
    time = np.arange(0.0, 4000.0, 0.5)

    def sea(scale: float) -> np.ndarray:
        omegas, phases = np.linspace(0.5, 0.9, 300), random.uniform(0.0, 2.0 * math.pi, 300)
        heave: np.ndarray = scale * np.cos(np.outer(time, omegas) + phases).sum(axis=1) / math.sqrt(150.0)
        return heave

    base = trial("slack")
    question = Asked(("cradle.heave",), True, "ship.heave", 0.0, 0.25, time, statistical=True)
    full = Shown(Track(time, {"cradle.heave": sea(1.0), "ship.heave": sea(1.0)}), base)
    same, larger = (Shown(Track(time, {"cradle.heave": sea(scale)}), base) for scale in (1.0, 2.0))
    told = errors(question, full, same)
    assert set(told) == {"standard deviation of cradle.heave", "largest tenth of cradle.heave"}
    assert word(told, 0.25) == "valid" and all(one.half_width > 0.0 for one in told.values())
    assert errors(question._replace(statistical=False), full, same)["rms of cradle.heave"].error > 1.0
    assert word(errors(question, full, larger), 0.25) == "invalid"
    assert word(errors(question._replace(times=time[:400]), full, same), 0.25) == "not judged"


def test_levels_that_do_not_fit_say_why() -> None:
    """Once each, and they take part in no other rung."""
    reasons = {
        ("slack", None): "line goes slack", ("docking", "plastic capture"): "changes its weight by docking",
        ("tow_report_sample", "half a foot of heave"): "axial_stiffness is not known",
        ("slender_stable", "20 t craft"): "",
    }  # fmt: skip
    for (name, case), reason in reasons.items():
        base = trial(name, case)
        found = [r.reason for r in rungs_of(base, axes_of(base)[0]) if not r.trial]
        assert (any(reason in text for text in found) and len(found) <= 3) if reason else not found


def test_linear_drag_on_a_line_that_pushes_is_the_closed_form() -> None:
    """The units of the linear rungs against the transient of the linear theory, through tensions that no line has."""
    mass, damping, stiffness, amplitude, omega = 2e4, 3e3, 4e4, 1.5, 1.1
    ship = {"heave_amplitude": amplitude, "heave_period": 2.0 * math.pi / omega}
    body = {"mass": mass, "weight_in_water": 1e4, "drag_coefficient": 0.0, "linear_damping": damping}
    lines = {
        "cradle": {"fmu": "cradle", "parameters": body},
        "line": {"fmu": "spring_line", "parameters": {"stiffness": stiffness, "static_tension": 1e4, "never_slack": 1.0}},
    }
    joined = {"cradle": {"fmu": "cradle_on_line", "parameters": body | {"stiffness": stiffness, "never_slack": 1.0}}}
    wires = ["ship.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension"]
    for units, wired, tension in (
        (lines, wires, "line.tension"), (joined, ["ship.heave -> cradle.heave_top"], "cradle.tension"),
    ):  # fmt: skip
        run = towage.run(Scene.from_dict({
            "title": "Linear", "stop_time": 20.0, "coupling": {"step": 0.05, "error_estimate": False}, "connections": wired,
            "units": {"ship": {"fmu": "ship", "parameters": ship}, **units},
        }))  # fmt: skip
        exact = np.array([transient(float(t), mass, damping, stiffness, amplitude, omega)[0] for t in run.time])
        assert np.abs(run["cradle.heave"] - exact).max() < 2e-5 * np.abs(exact).max()  # the step of the coupling
        assert run[tension].min() < -1e4
        assert not run.events


def test_the_sdof_estimate_knows_no_linear_damping() -> None:
    """It says none, and not that of a body without drag."""
    values = {"stop_time": 20.0, "checks.sdof.settle": 4.0, "coupling.error_estimate": False}
    assert [
        towage.run("slack", set=values | {"cradle.linear_damping": damping}).comparison.estimate is None  # type: ignore[union-attr]
        for damping in (0.0, 1e3)
    ] == [False, True]


def test_a_wire_is_an_elastic_bar() -> None:
    """150 t and 100 t of water on 3000 m of 45 kg/m, EA = 5e8 N, 10 s: steady motion of the load and top tension a metre of
    the ship against the bar with a mass at its end, u = cos kx + B sin kx, EA u'(L) = m omega^2 u(L)."""
    omega, length, speed, extension, mass = 2.0 * math.pi / 10.0, 3000.0, 1e4 / 3.0, 5e8, 250e3
    ship = {"heave_amplitude": 0.2, "heave_period": 10.0, "ramp_time": 100.0, "mass": 3e7, "stiffness": 2e7, "damping": 5e6}
    line = {"axial_stiffness": extension, "length": length, "wave_speed": speed, "static_tension": "= load.weight_in_water"}
    scene = Scene.from_dict({
        "title": "A manifold", "stop_time": 300.0, "coupling": {"step": 0.1},
        "connections": ["ship.heave -> line.heave_top", "load.heave -> line.heave_bottom", "line.tension -> load.line_tension"],
        "units": {
            "ship": {"fmu": "ship", "parameters": ship}, "line": {"fmu": "spring_line", "parameters": line},
            "load": {"fmu": "cradle", "parameters": {"mass": 150e3, "added_mass": 100e3, "weight_in_water": 1.28e6}},
        },
    })  # fmt: skip
    time = np.linspace(0.0, 300.0, 3001)
    heave = {"ship.heave": 0.2 * np.sin(omega * time), "line.tension": np.full_like(time, 1e6)}
    made = elastic(Trial(scene, {"line.tension": "line.tension"}, Seen(Track(time, heave), 200.0), locator()))
    assert made.names == {"line.tension": "line.tension_top"}
    run = towage.run(bare(made.scene))
    late = run.time >= 200.0
    top, load, tension = (
        abs(component(run.time[late], run[name][late], omega)) for name in ("ship.heave", "load.heave", "line.tension_top")
    )
    k = omega / speed
    cos, sin, stiff, inertia = math.cos(k * length), math.sin(k * length), extension * k, mass * omega**2
    b = (inertia * cos + stiff * sin) / (stiff * cos - inertia * sin)
    assert (cos + b * sin, stiff * b) == pytest.approx((3.531, 472.55e3), rel=2e-4)  # another's solution of the same bar
    assert (load / top, tension / top) == pytest.approx((cos + b * sin, stiff * b), rel=3e-3)  # segments, and what still rings


def test_drag_without_drag_is_not_linearised() -> None:
    base = trial("sea_cliff", "8 s wave", {"cradle.drag_area": 0.0})
    (linear,) = [r for r in rungs_of(base, axes_of(base)[0]) if r.levels == ("linear drag",)]
    assert linear.reason == "cradle has no quadratic drag"


def test_equal_loss_is_lorentz_for_a_harmonic_motion() -> None:
    phase = np.linspace(0.0, 2.0 * math.pi, 2001)[:-1]
    assert equal_loss(7.0, (0.3 * 1.2 * np.cos(phase)).tolist()) == pytest.approx(equivalent_damping(7.0, 1.2, 0.3), rel=1e-5)
    assert equal_loss(7.0, [0.0, 0.0]) == 0.0
    normal = np.random.default_rng(1).normal(size=200_000)
    assert equal_loss(1.0, normal.tolist()) == pytest.approx(math.sqrt(8.0 / math.pi), rel=0.01)


def test_a_regular_wave_has_variance_and_period_of_the_sea() -> None:
    base = trial("voyage_tow", "best route")
    made = next(r for r in rungs_of(base, axes_of(base)[0]) if r.trial and r.levels[0] == "regular wave")
    assert made.trial
    units = made.trial.scene.units
    assert set(units) == {"ship", "line", "cradle"}  # the voyage told the ship of the sea, and of nothing else
    assert units["ship"].parameters["heave_amplitude"] == pytest.approx(1.0, rel=5e-3)
    assert units["ship"].parameters["heave_period"] == pytest.approx(8.0, rel=2e-2)


def test_the_cheapest_of_equals_leaves_most_out() -> None:
    def made(error: float, cost: float) -> Rung:
        return Rung((f"{error} {cost}",), (), None, errors={"rms of a.x": Statistic(error, 0.0)}, cost=cost)

    rungs = [made(0.2, 1.0), made(-0.04, 1.4), made(0.01, 1.0), made(0.0, 5.0)]

    def chosen(tolerance: float, own: float | None = 0.0, half: float = 0.0, moving: bool = True) -> tuple[Rung | None, str]:
        question = Asked(("a.x",), True, "", 0.0, tolerance, np.arange(100.0))
        return recommended(rungs, question, None if own is None else {"rms of a.x": Statistic(own, half)}, moving)

    assert chosen(0.05)[0] is rungs[1]  # 1.4 and 1.0 are one cost
    assert chosen(0.03)[0] is rungs[2]
    assert chosen(0.005)[0] is rungs[3]
    for own in (0.06, math.inf, math.nan, None):
        assert chosen(0.05, own)[0] is None
    assert chosen(0.05, 0.06)[1].endswith("itself changes by 6 %: take a shorter step")
    assert "+- 10 %: run 1e+03 s longer" in chosen(0.05, 0.02, 0.1)[1]
    assert "nothing moves" in chosen(0.05, moving=False)[1]


def test_differences_of_signals_at_rest() -> None:
    time = np.linspace(0.0, 10.0, 101)
    still, moving = np.full_like(time, 5.0), np.sin(time)
    assert difference(still, still) == (0.0, 0.0, 0.0)
    assert difference(still, moving).worst == math.inf
    assert difference(moving, 0.0 * time).worst == pytest.approx(1.0, abs=0.5)
    assert difference(moving, 1.1 * moving)[:1] == pytest.approx((0.1,))


def test_a_rung_that_fails_costs_itself_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A unit that crashes in two ways with linear drag: the other rungs keep their errors."""
    scene = select("slack", None, {"stop_time": 4.0, "checks.sdof.settle": 1.0})
    real = ladders.run_isolated

    def broken(resolved: Any, *more: Any) -> Result:
        result = real(resolved, *more)
        if len(resolved.connections) == 4 and resolved.units["cradle"].parameters.get("linear_damping"):
            result.status, result.message = "failed", "the unit crashed"
        return result

    monkeypatch.setattr(ladders, "run_isolated", broken)
    ladder = simplest(scene)
    failed = [r for r in ladder.rungs if r.reason.startswith("failed: the unit crashed")]
    assert len(failed) > 1 and all(r.levels[0] == "two ways" for r in failed)
    kept = sum(r.errors is not None for r in ladder.rungs)
    assert kept >= 6 and kept + sum(bool(r.reason) for r in ladder.rungs) == len(ladder.rungs)
    assert "failed: the unit crashed" in text(ladder)


def test_nothing_moves() -> None:
    ladder = simplest("slack", set={"ship.heave_amplitude": 0.0, "stop_time": 4.0, "checks.sdof.settle": 1.0})
    assert ladder.enough is None
    assert ladder.note.startswith("nothing moves")
    assert "nothing moves" in text(ladder) and "not judged" in markdown(ladder)


def test_one_unit_has_one_rung() -> None:
    scene = {
        "title": "A ship", "stop_time": 4.0, "units": {"ship": {"fmu": "ship"}}, "coupling": {"step": 0.1}, "connections": [],
    }  # fmt: skip
    ladder = simplest(Scene.from_dict(scene))
    assert [r.name for r in ladder.rungs] == ["the scene as it is"]
    assert ladder.enough is ladder.rungs[0]
    assert len(ladder.absent) == 6


def test_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SceneError, match="tolerance: -1.0 is out of range: expected a finite number above 0"):
        simplest("slack", tolerance=-1.0)
    with pytest.raises(SceneError, match="several cases: choose one of"):
        simplest("sea_cliff")
    assert main(["simplest", "storm", "--out", str(tmp_path)]) == SceneError.exit_code
    assert "storm.toml: route: a route is no scene: take it to towage route" in capsys.readouterr().err


def test_a_scene_without_motion_or_tension_is_refused() -> None:
    scene = select("float_quadrant2")
    result = Result("", "", "", "done", "", np.zeros(2), {"tow.margin_slack": np.zeros(2)}, {"tow.margin_slack": "1"})
    with pytest.raises(SceneError, match="no motion and no tension to compare models by"):
        asked(described(scene, locator(None)), result, None)


def test_a_record_says_nothing_of_the_runs_of_rungs() -> None:
    """It cuts no steps: every communication point is compared, whatever the scene records."""
    for scene in (select("slack", None, {"record.interval": 0.05}), select("alvin", "25 ft", {"record.interval": 7.9})):
        assert bare(scene).record == Record()


def test_the_command_writes_a_scene_that_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--set", "stop_time=8", "--set", "checks.sdof.settle=2", "--progress", "none", "--out", str(tmp_path), "--json"]
    assert main(["simplest", "slack", "--tolerance", "0.5", *options]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [Path(file).name for file in told["files"]] == ["slack.toml", "ladder.json", "report.html"]
    written = towage.run(tmp_path / "slack.toml")
    assert written.status == "done"
    assert told["ladders"][0]["enough"] in written.title


def test_a_level_of_another_package_may_refuse() -> None:
    def never(trial: Trial) -> Trial:
        raise Unfit("not today")

    from towage.ladder.axis import Axis

    axis = Axis("mood", "Is it?", lambda trial: "", (Level("grim", "joy", never), Level("gay")))
    rungs = rungs_of(trial("slack"), [axis])
    assert [(r.name, r.reason) for r in rungs] == [("grim", "not today"), ("gay", "")]
