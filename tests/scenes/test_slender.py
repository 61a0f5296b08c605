"""The scenes of the towed slender body: against one system of equations, their verdicts, and whether a rigid body is enough."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy.linalg import expm

from towage.checks import simpler as judge_slender
from towage.checks.simpler import SimplerCheck
from towage.checks.track import Track
from towage.errors import SceneError
from towage.master.master import Master
from towage.models.numeric.ops import FLOATS
from towage.models.numeric.oscillator import driven
from towage.models.slender import sway_craft
from towage.models.slender.prepared import prepare
from towage.result.result import Finding, Result
from towage.scene.scene import Checks, Scene
from towage.tow_stability.stability import bodies

Array = NDArray[np.float64]


def scene(name: str, case: str | None = None, **changes: Any) -> Scene:
    loaded = Scene.load(name)
    loaded = loaded.case(case) if case else loaded
    loaded = replace(loaded, cases=(), coupling=replace(loaded.coupling, error_estimate=False))
    return replace(loaded, **changes)


def run(chosen: Scene) -> Result:
    result = Master(chosen, flavour="python").run()
    assert result.status == "done", result.message
    return result


def unblamed(result: Result) -> bool:
    """Whether nothing is held against a run but that its coupling error is not estimated here."""
    return result.verdict.word == "marginal" and "not estimated" in result.verdict.reason


def without_checks(chosen: Scene) -> Scene:
    return replace(chosen, checks=chosen.checks.without("sdof", "simpler"))


def simpler(result: Result) -> Finding:
    return next(c for c in result.checks if c.name == "simpler model")


def monolithic(chosen: Scene, h: float) -> tuple[Array, Array]:
    """(tail, craft lateral), m, every h of body and craft as one linear system, its matrix that of mid-step: exact for
    the free sway as a cubic over h, and of fourth order in h then at constant speed."""
    towed = bodies(chosen)[0]
    made, n = prepare(towed.parameters), prepare(towed.parameters).n
    resolved = Master(chosen, flavour="python").resolved.units["craft"]
    values = {v.name: v.start for v in resolved.description.variables if v.causality == "parameter"}
    p = sway_craft.Parameters(
        **{name: float(resolved.parameters.get(name, values[name])) for name in sway_craft.Parameters.__dataclass_fields__}
    )

    def free(t: float) -> tuple[float, float, float]:
        return driven(t, p.sway_amplitude, p.sway_period, p.sway_phase, p.ramp_time, FLOATS)

    z = np.zeros(2 * n + 2)
    z[1] = -towed.parameters.yaw_start * towed.parameters.length / 12.0**0.5
    rows = [(float(made.points[1] @ z[:n]), free(0.0)[0])]
    known: dict[float, Array] = {}

    def matrix(t: float) -> Array:
        speed, rate = sway_craft.tow_speed(t, p, FLOATS)
        if speed not in known:
            u = speed / made.speed
            a = np.zeros((2 * n + 6, 2 * n + 6))
            load = made.system.load(u) / made.tau
            a[: 2 * n, : 2 * n] = made.system.companion(u) / made.tau
            a[: 2 * n, 2 * n] = a[: 2 * n, 2 * n + 2] = load
            stiffness = (made.pull * speed**2 + made.constants.axial_mass * rate) / made.rope
            a[2 * n, 2 * n + 1] = 1.0
            a[2 * n + 1, :n] = stiffness * made.points[0] / p.mass
            a[2 * n + 1, 2 * n] = -(p.stiffness + stiffness) / p.mass
            a[2 * n + 1, 2 * n + 1] = -p.damping / p.mass
            a[2 * n + 1, 2 * n + 2] = -stiffness / p.mass
            for k in range(3):
                a[2 * n + 2 + k, 2 * n + 3 + k] = 1.0 / h
            known[speed] = expm(h * a)
        return known[speed]

    for k in range(round(chosen.stop_time / h)):
        (a, da, _), (b, db, _) = (free(t) for t in (k * h, (k + 1) * h))
        da, db = h * da, h * db
        cubic = [a, da, 2.0 * (3.0 * (b - a) - 2.0 * da - db), 6.0 * (da + db - 2.0 * (b - a))]
        z = (matrix((k + 0.5) * h) @ np.concatenate([z, cubic]))[: 2 * n + 2]
        rows.append((float(made.points[1] @ z[:n]), b + z[2 * n]))
    tail, lateral = np.array(rows).T
    return tail, lateral


@pytest.mark.parametrize(
    ("name", "case", "stop", "share", "limit"),
    [
        ("slender_stable", "20 t craft", 60.0, 2, 1e-6),
        ("slender_stable", "300 kg craft", 60.0, 2, 1e-6),
        ("slender_yaw", "full tail", 40.0, 1, 1e-6),
        ("slender_flutter", "full tail", 20.0, 1, 1e-5),
        ("slender_speed_ramp", None, 22.0, 1, 1e-4),
    ],
)
def test_coupled_run_equals_the_monolithic_solution(
    name: str, case: str | None, stop: float, share: int, limit: float
) -> None:
    """1e-6 of the motion at constant speed (two linear units in cubic coupling at H = 0.1 s), 1e-5 where all motion comes
    from a start that is a jump for the rope's force, 1e-4 on the ramp,
    which both take at mid-step."""
    chosen = without_checks(scene(name, case, stop_time=stop))
    result = run(chosen)
    tail, lateral = monolithic(chosen, 0.1 / share)
    for found, exact in ((result["body.tail"], tail[::share]), (result["craft.lateral"], lateral[::share])):
        assert np.max(np.abs(found - exact)) < limit * np.max(np.abs(exact))


def test_stable_body_behind_a_heavy_craft_is_valid() -> None:
    result = run(scene("slender_stable", "20 t craft", stop_time=180.0))
    assert unblamed(result)
    assert all(m.worst > 0.0 for m in result.margins)
    assert simpler(result).message.startswith("not enough")  # the rigid body of this shape yaws away


def test_light_craft_is_moved_by_the_rope() -> None:
    chosen = scene("slender_stable", "300 kg craft", stop_time=180.0)
    result = run(replace(chosen, checks=chosen.checks.without("simpler")))
    assert result.verdict.word == "invalid"
    assert result.comparison is not None and result.comparison.bound is not None
    assert result.comparison.bound > 0.05
    assert abs(result.comparison.amplitude) < result.comparison.bound


def test_yaw_grows_at_the_rate_that_the_unit_reports() -> None:
    result = run(without_checks(scene("slender_yaw", "full tail")))
    assert result.verdict.word == "invalid"
    assert result.verdict.reason.startswith("body.margin_stability")
    late = result.time > 40.0
    slope = np.polyfit(result.time[late], np.log(np.abs(result["body.yaw_angle"][late])), 1)[0]
    # after 40 s the growing root leads; the craft, which gives way and swings at its own 0.2 rad/s, changes it by 4 %
    assert slope == pytest.approx(float(result["body.growth_rate"][0]), rel=0.06)


def test_blunt_tail_takes_yaw_and_flutter_away() -> None:
    for name in ("slender_yaw", "slender_flutter"):
        result = run(without_checks(scene(name, "blunt tail")))
        assert unblamed(result)
        assert abs(result["body.yaw_angle"][-1]) < 0.5 * abs(result["body.yaw_angle"][0])


def test_flutter_oscillates_as_it_grows() -> None:
    result = run(without_checks(scene("slender_flutter", "full tail")))
    assert result.verdict.word == "invalid"
    tip = result["body.tip"][result.time > 20.0]
    assert np.sum(np.diff(np.sign(tip)) != 0.0) >= 2
    assert np.max(np.abs(tip)) > 2.0 * abs(result["body.tip"][0])


def test_rigid_body_is_enough_for_a_stiff_one() -> None:
    found = simpler(run(scene("slender_yaw", "blunt tail, stiff body")))
    assert found.level == "ok"
    assert found.message.startswith("enough")
    assert found.value is not None and found.value < 0.05


def test_rigid_body_is_not_enough_where_flexure_matters() -> None:
    found = simpler(run(scene("slender_yaw", "blunt tail")))
    assert found.message.startswith("not enough")
    assert found.value is not None and found.value > 1.0


def test_words_of_the_simpler_model() -> None:
    time = np.linspace(0.0, 10.0, 101)
    check = SimplerCheck(set={"body.flexible": 0}, motions=("b.x",), margin="b.margin_m")
    full = {"b.x": np.sin(time)}

    def word(factor: float, margin: float) -> str:
        other = {"b.x": factor * full["b.x"], "b.margin_m": np.full_like(time, margin)}
        return judge_slender.compare(check, time, Track(time, full), Track(time, other)).message.split(":")[0]

    assert [word(1.04, 0.5), word(1.04, -0.5), word(1.06, 0.5), word(0.9, -1.0)] == [
        "enough", "barely enough", "not enough", "not enough",
    ]  # fmt: skip
    short = judge_slender.compare(check, time, Track(time, full), Track(time[:50], {k: v[:50] for k, v in full.items()}))
    assert "ended early" in short.message
    rest = Track(time, {"b.x": 0.0 * time})
    still = judge_slender.compare(replace(check, margin=None), time, rest, Track(time, full))
    assert still.message.startswith("not enough")
    odd = time[::2]  # at other points of its own: between them it is a cubic
    assert judge_slender.compare(check, time, Track(time, full), Track(odd, {
        "b.x": full["b.x"][::2], "b.margin_m": np.ones_like(odd)
    })).message.startswith("enough")  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"motions": ("body.nothing",)}, "no variable"),
        ({"set": {"body.flexible": 0.0, "body.nothing": 1.0}}, "nothing"),
        ({"set": {"body.flexible": 2.0}}, "out of range"),
        ({"margin": "body.no_margin"}, "no variable"),
    ],
)
def test_faults_of_the_check_are_told(change: dict[str, Any], message: str) -> None:
    chosen = scene("slender_yaw", "full tail")
    with pytest.raises(SceneError, match=message):
        Master(replace(chosen, checks=Checks({"simpler": replace(chosen.checks.get("simpler"), **change)})), flavour="python")


def test_faults_of_the_file_are_told(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    good = Scene.load("slender_yaw").source
    for old, new, message in (
        ("[checks.simpler]", "[checks.simpler]\ntolerance = -1", "above 0"),
        ("[checks.simpler]", '[checks.simpler]\nsettle = "1000 s"', "out of range"),
        ('set = { "body.flexible" = 0 }', 'set = { "craft.flexible" = 0, "nobody.flexible" = 0 }', "nobody"),
    ):
        file.write_text(good.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(SceneError, match=message):
            Scene.load(file)
