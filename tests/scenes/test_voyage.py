"""Scene `voyage_tow`: the route decides what the line carries."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from towage.master.master import Master
from towage.models.route import voyage
from towage.models.route.plan import plan
from towage.result.result import Result
from towage.routing.file import load
from towage.routing.output import unit_parameters
from towage.scene.scene import Scene

BEST, STRAIGHT = "best route", "straight route"


def run(scene: Scene, case: str) -> Result:
    result = Master(scene, case, flavour="python").run()
    assert result.status == "done"
    return result


def shortened(pace: float, stop: float) -> Scene:
    """The scene with a faster voyage and without the one-way run."""
    scene = Scene.load("voyage_tow")
    units = dict(scene.units)
    units["voyage"] = replace(units["voyage"], parameters={**units["voyage"].parameters, "pace": pace})
    return replace(scene, units=units, stop_time=stop, checks=scene.checks.without("sdof"))


@pytest.mark.parametrize("case", [BEST, STRAIGHT])
def test_the_table_is_that_of_the_route(case: str) -> None:
    given = load("storm")
    found = plan(given.problem)
    route = found.best if case == BEST else found.straight
    assert route is not None
    wanted = unit_parameters(given.problem, route)
    entry = Scene.load("voyage_tow").case(case).units["voyage"].parameters
    scale = {c: max(abs(wanted[f"{c}_{k}"]) for k in range(voyage.POINTS)) for c in voyage.COLUMNS}
    for name, value in wanted.items():
        size = scale.get(name.rpartition("_")[0], abs(value))
        assert entry[name] == pytest.approx(value, abs=2e-6 * size + 1e-9), name  # seven printed digits


@pytest.mark.slow
def test_the_straight_route_meets_the_storm_and_slackens_the_line() -> None:
    """Three times faster than the shipped scene: twenty minutes of waves."""
    results = {case: run(shortened(180.0, 1240.0), case) for case in (BEST, STRAIGHT)}
    best, straight = (results[c] for c in (BEST, STRAIGHT))
    assert straight.verdict.word == "invalid" and "margin_taut" in straight.verdict.reason
    assert best.verdict.word == "valid"
    peaks = [float(np.max(r.columns["line.tension"])) for r in (best, straight)]
    assert peaks[1] > 1.3 * peaks[0]
    heights = [float(np.max(r.columns["voyage.wave_height"])) for r in (best, straight)]
    assert heights[0] < 5.0 and heights[1] > 9.0  # the storm reaches 10.4 m, the best route stays outside
    worst = min(straight.margins, key=lambda m: m.worst)
    k = int(np.argmin(np.abs(straight.time - worst.time)))
    assert abs(straight.columns["voyage.x"][k] / 1852.0 - 500.0) < 250.0  # where the storm is


def test_the_sea_of_the_voyage_reaches_ship_and_line() -> None:
    """The first quarter of the straight route at thrice the pace: the line is taut until the storm is met."""
    result = run(shortened(180.0, 300.0), STRAIGHT)
    assert result.verdict.word == "valid"
    height, heave = result.columns["voyage.wave_height"], result.columns["ship.significant_heave"]
    assert height[0] == pytest.approx(1.22, abs=0.01) and height[-1] > 1.8 * height[0]
    assert heave[-1] > 1.5 * heave[0]
    assert float(np.ptp(result.columns["line.tension"])) > 1e3


@pytest.mark.slow
def test_the_shipped_scene() -> None:
    """The verdict of the whole voyage on both routes, the one-way run included."""
    results = {case: run(Scene.load("voyage_tow"), case) for case in (BEST, STRAIGHT)}
    assert results[BEST].verdict.word == "valid"
    assert results[STRAIGHT].verdict.word == "invalid" and "margin_taut" in results[STRAIGHT].verdict.reason
    for result in results.values():
        assert result.comparison is not None and result.comparison.word == "valid"
