"""Scene `voyage_tow`: the route decides what the line carries."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from towage.errors import SceneError
from towage.master.master import Master
from towage.models.route.plan import plan
from towage.result.result import Result
from towage.routing.file import load
from towage.routing.output import write_csv
from towage.scene.files import declared
from towage.scene.scene import SHIPPED, Scene

BEST, STRAIGHT = "best route", "straight route"
TABLES = {BEST: "voyage_best.csv", STRAIGHT: "voyage_straight.csv"}


def run(scene: Scene, case: str) -> Result:
    result = Master(scene, case, flavour="python").run()
    assert result.status == "done"
    return result


def shortened(pace: float, stop: float) -> Scene:
    """The scene with a faster voyage and without the one-way run."""
    scene = Scene.load("voyage_tow").with_values({"voyage.pace": pace, "stop_time": stop})
    return scene.without_comparisons()


@pytest.mark.parametrize("case", [BEST, STRAIGHT])
def test_the_table_is_that_of_the_route(case: str, tmp_path: Path) -> None:
    given = load("storm")
    found = plan(given.problem)
    route = found.best if case == BEST else found.straight
    assert route is not None
    write_csv(tmp_path / "made.csv", given.problem, route)
    assert Scene.load("voyage_tow").case(case).units["voyage"].files["series"]["file"] == TABLES[case]
    shipped, made = (np.loadtxt(p, delimiter=",", skiprows=1) for p in (SHIPPED / TABLES[case], tmp_path / "made.csv"))
    assert shipped == pytest.approx(made, rel=1e-6, abs=1e-6)  # nine printed digits of an iteration that ends at 1e-10


def test_a_case_chooses_the_file_of_a_unit() -> None:
    scene = Scene.load("voyage_tow")
    ends = {}
    for case in (BEST, STRAIGHT):
        chosen = scene.case(case)
        unit = declared(chosen, "voyage")
        assert set(unit.terminals["sea"]) == {"wave_height", "wave_period", "wave_direction", "speed"}
        ends[case] = unit.model.Parameters.series.times[-1] / 3600.0
    assert ends == pytest.approx({BEST: 56.716510, STRAIGHT: 61.968521}, abs=1e-5)
    whole = scene.with_values({"voyage.files.series": "voyage_straight.csv"})
    assert whole.units["voyage"].files == {"series": "voyage_straight.csv"}
    again = whole.with_values({"voyage.files.series.unwrap": ["heading"]})
    assert again.units["voyage"].files == {"series": {"file": "voyage_straight.csv", "unwrap": ["heading"]}}
    with pytest.raises(SceneError, match="'voyage.files.serie.file' cannot be set: the unit has no file 'serie'; did you mean"):
        scene.with_values({"voyage.files.serie.file": "x.csv"})
    with pytest.raises(SceneError, match="takes no file 'log': it takes series"):
        declared(scene.with_values({"voyage.files.log": "x.csv"}), "voyage")
    with pytest.raises(SceneError, match=r"nowhere.csv: No such file"):
        declared(scene.with_values({"voyage.files.series.file": "nowhere.csv"}), "voyage")


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
