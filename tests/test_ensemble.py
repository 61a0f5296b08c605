"""Ensembles against the FMU path, against closed forms, and what they refuse."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace

pytest.importorskip("casadi")

from towage.ensemble.ensemble import Ensemble, measures
from towage.errors import RunError, SceneError
from towage.fmus.declare.unit import load
from towage.fmus.native.compiler import CompileError, compiler, host
from towage.scene.scene import Scene

try:
    compiler(host())
except CompileError as reason:
    pytest.skip(str(reason), allow_module_level=True)

AMPLITUDE = "ship.heave_amplitude"
EXACT = 1e-8
"""Relative to the largest value of an output: what an ensemble promises by default."""


def scene(name: str, stop: float) -> Scene:
    whole = Scene.load(name)
    chosen = whole.case(whole.cases[0].name) if whole.cases else whole
    return replace(chosen, cases=(), stop_time=stop, checks=chosen.checks.without("sdof"))


@pytest.mark.parametrize(
    ("name", "stop", "amplitudes"),
    [
        ("sea_cliff", 30.0, [0.6, 1.1, 1.7]),
        ("slack", 40.0, [0.6, 1.1, 1.7]),
        # docking at 62.5 s; at 117 s the line goes slack and taut again between two outputs, and not at mid-step
        ("docking", 120.0, [1.1013133208255159]),
        ("stiff_line", 8.0, [0.6, 1.1, 1.7]),
    ],
)
def test_consistency_with_the_fmu_path(name: str, stop: float, amplitudes: list[float]) -> None:
    members = Ensemble(scene(name, stop), {AMPLITUDE: amplitudes}).run(samples=2, tolerance=EXACT)
    assert members.done.all()
    assert len(members.samples) == min(2, len(amplitudes))
    assert all(sample.difference <= EXACT for sample in members.samples)


def test_docking_is_a_plastic_capture() -> None:
    """Momentum of cradle and submersible at the time of docking, which lies between two outputs."""
    mass = np.array([10.0, 1000.0, 42000.0])
    members = Ensemble(
        scene("docking", 2.0), {"cradle.submersible_mass": mass, "cradle.docking_time": [1.01] * 3,
                                "cradle.velocity_start": [0.5] * 3},
    ).run([1.01, 1.01 + 1e-9], ["cradle.velocity"], samples=0)  # fmt: skip
    before, after = members.series["cradle.velocity"].T
    own = (300.0 + 150.0) * 14.593902937206364
    # 1e-9 s at an acceleration of g or less, and the rounding of the slug
    np.testing.assert_allclose(after, before * own / (own + mass), rtol=1e-7)


def test_free_oscillation_in_closed_form() -> None:
    """A body without drag on its line, the ship at rest: y = y0 cos(omega t), while the line is taut."""
    y0 = np.array([0.01, 0.02, 0.05])
    k, m, weight = 5.0e4, 2.0e4, 5.0e4
    unit = load("cradle_on_line")
    fixed = {"stiffness": k, "mass": m, "added_mass": 0.0, "weight_in_water": weight, "drag_coefficient": 0.0}
    times = np.linspace(0.0, 20.0, 81)
    varied = {name: np.full(3, value) for name, value in fixed.items()} | {"heave_start": y0}
    members = Ensemble(unit, varied).run(times, ["heave", "tension"], samples=3)
    exact = y0[:, None] * np.cos(math.sqrt(k / m) * times)
    # 80 steps of at most 1e-8
    np.testing.assert_allclose(members.series["heave"], exact, rtol=0.0, atol=1e-8 * y0.max())
    np.testing.assert_allclose(members.high["tension"], weight + k * np.max(-exact, axis=1), rtol=1e-9)


def test_members_do_not_depend_on_their_neighbours() -> None:
    amplitudes = np.linspace(0.5, 2.0, 7)
    whole = Ensemble(scene("slack", 30.0), {AMPLITUDE: amplitudes}).run(samples=0)
    turned = Ensemble(scene("slack", 30.0), {AMPLITUDE: amplitudes[::-1]}).run(samples=0, threads=1)
    for name, low in whole.low.items():
        assert low.tolist() == turned.low[name][::-1].tolist(), name


def test_what_the_scene_makes_equal_follows() -> None:
    """line.static_tension is "= cradle.weight_in_water": at rest the tension is the weight."""
    weights = np.array([5e4, 8e4])
    still = Ensemble(scene("slack", 1.0), {"cradle.weight_in_water": weights, AMPLITUDE: [0.0, 0.0]}).run(samples=0)
    np.testing.assert_allclose(still.high["line.tension"], weights, rtol=1e-12)


def test_extremes_are_those_of_the_series() -> None:
    members = Ensemble(scene("slack", 20.0), {AMPLITUDE: [1.0, 1.5]}).run(series=["line.tension"], samples=0)
    series = members.series["line.tension"]
    assert members.high["line.tension"].tolist() == series.max(axis=1).tolist()
    assert members.low["line.tension"].tolist() == series.min(axis=1).tolist()


def test_a_coarse_run_is_refused_by_its_sample() -> None:
    ensemble = Ensemble(scene("slack", 40.0), {AMPLITUDE: [1.0, 1.5]})
    with pytest.raises(RunError, match=r"member [01] \(ship.heave_amplitude = 1.*differs from the FMU path by"):
        ensemble.run([0.0, 20.0, 40.0], accuracy=0.1, samples=2)


def test_refused_members_leave_the_others_alone() -> None:
    members = Ensemble(scene("slack", 5.0), {"cradle.mass": [1e4, -1.0, 2e4]}).run(samples=1)
    assert members.done.tolist() == [True, False, True]
    assert members.refused.tolist() == [False, True, False]
    assert "cradle.mass = -1 kg: expected" in members.message[1]
    assert np.isnan(members.high["cradle.heave"]).tolist() == [False, True, False]


def test_measures_are_columns_of_a_sweep() -> None:
    short = scene("slack", 20.0)
    columns, members = measures(short, [AMPLITUDE], [[0.5], [1.5]], samples=0)
    assert members.message == ("", "")
    margins = [name for name in columns if name.startswith("margin:")]
    shown = {f"margin:{name}" for name in short.checks.report_only}
    decisive = np.min([columns[name] for name in margins if name not in shown], axis=0)
    assert columns["worst_margin"].tolist() == decisive.tolist()
    assert columns["margin:line.margin_taut"][1] < 0.0 < columns["margin:line.margin_taut"][0]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Ensemble(scene("slack", 5.0), {}), "every varied parameter needs one value a member"),
        (
            lambda: Ensemble(scene("slack", 5.0), {AMPLITUDE: [1.0], "cradle.mass": [1.0, 2.0]}),
            "the same number for all",
        ),
        (lambda: Ensemble(scene("slack", 5.0), {"ship.heave_amplitud": [1.0]}), "did you mean 'ship.heave_amplitude'"),
        (lambda: Ensemble(scene("slack", 5.0), {AMPLITUDE: [1.0]}, ["line.tensio"]), "did you mean 'line.tension'"),
        (lambda: Ensemble(Scene.load("docking"), {AMPLITUDE: [1.0]}), "choose one of 'plastic capture', "),
        (lambda: Ensemble(scene("slack", 5.0), {AMPLITUDE: [1.0]}).run([1.0, 1.0]), "times: expected"),
        (lambda: Ensemble(load("cradle_on_line"), {"mass": [1e4]}).run(), "give the times of the outputs"),
    ],
)
def test_what_does_not_fit_is_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        make()


def test_without_a_compiler_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: object) -> None:
    monkeypatch.setenv("TOWAGE_CACHE", str(tmp_path))
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setitem(sys.modules, "ziglang", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(CompileError, match=r"no C compiler on this machine: pip install 'towage\[native\]'"):
        Ensemble(load("cradle_on_line"), {"mass": [1e4]})


def test_a_case_of_a_scene_by_name() -> None:
    by_name = Ensemble("docking", {AMPLITUDE: [1.0]}, ["cradle.heave"], "plastic capture").run([0.0, 1.0], samples=0)
    chosen = Scene.load("docking").case("plastic capture")
    by_value = Ensemble(replace(chosen, cases=()), {AMPLITUDE: [1.0]}, ["cradle.heave"]).run([0.0, 1.0], samples=0)
    assert by_name.high["cradle.heave"].tolist() == by_value.high["cradle.heave"].tolist()
