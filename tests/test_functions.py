"""The functions behind the commands: values out, nothing written unless asked."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from towage.errors import SceneError
from towage.frequency_response.response import response
from towage.routing.route import route
from towage.scene.scene import Scene
from towage.scene.select import one_case, select
from towage.sweeps.sweep import sweep
from towage.tow_stability.stability import stability


@pytest.fixture(autouse=True)
def nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    yield
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_keeps_no_file_and_resumes_from_one(tmp_path_factory: pytest.TempPathFactory) -> None:
    values = {"stop_time": 20.0, "coupling.error_estimate": False, "checks.sdof": None}
    table = sweep("slack", "ship.heave_amplitude=1 ft:2 ft:2", set=values, workers=1)
    assert table.done.all() and table.design.points[:, 0].tolist() == pytest.approx([0.3048, 0.6096])
    out = tmp_path_factory.mktemp("sweep")
    kept = sweep("slack", ["ship.heave_amplitude=1 ft:2 ft:2"], set=values, workers=1, out=out)
    again = sweep("slack", ["ship.heave_amplitude=1 ft:2 ft:2"], set=values, workers=1, out=str(out), resume=True)
    for name, column in table.measures.items():
        np.testing.assert_array_equal(column, kept.measures[name])
        np.testing.assert_array_equal(column, again.measures[name])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scene": "sea_cliff"}, "several cases: choose one of '8 s wave'"),
        ({"scene": "slack", "sample": 2}, "only an ensemble has a sample"),
        ({"scene": "slack", "engine": "ensemble", "resume": True}, "an ensemble runs here"),
        ({"scene": "slack", "set": {"ship.heave_amplitud": 1.0}}, "heave_amplitude"),
    ],
)
def test_a_sweep_that_cannot_be_is_refused(options: dict[str, object], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        sweep(vary="ship.heave_amplitude=1 ft:2 ft:2", **options)  # type: ignore[arg-type]


def test_a_response_is_a_value_with_names() -> None:
    (tow,) = response("tow_600ft", frequencies=[0.05, 0.1])
    assert [row["frequency_hz"] for row in tow.rows()] == pytest.approx([0.05, 0.1])
    assert tow.rows()[0]["tension_top"] == abs(tow.gains[0].tension_top)
    assert tow.per == "1 m of heave of the towpoint"
    (heavier,) = response("tow_600ft", set={"tow.body_mass": 5000.0}, frequencies=0.1)
    assert heavier.rows()[0]["tension_top"] != tow.rows()[1]["tension_top"]
    for wrong in ([0.0], [], [[0.1]], [math.nan]):
        with pytest.raises(SceneError, match="above 0"):
            response("tow_600ft", frequencies=wrong)
    with pytest.raises(SceneError, match="no tow"):
        response("sea_cliff")


def test_stability_of_a_case(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    cache = tmp_path_factory.mktemp("cache")
    monkeypatch.setattr("towage.tow_stability.critical.cache", lambda: cache)
    (body,) = stability("slender_flutter", "blunt tail", u_max=4.0, map="tail_cut", values=[0.4])
    assert body.document()["stable_m_s"] == [[0.0, pytest.approx(3.0)]]
    assert [row.value for row in body.map] == [0.4]
    with pytest.raises(SceneError, match="tail_cut, rope_length, slenderness"):
        stability("slender_flutter", map="tail")
    with pytest.raises(SceneError, match="at most 14"):
        stability("slender_flutter", u_max=15.0)


def test_a_route_is_a_value(tmp_path: Path) -> None:
    planned = route("storm")
    assert planned.document()["best_h"] == pytest.approx(56.71651, abs=1e-5)
    planned.save_csv(tmp_path / "straight.csv", "straight", 3)
    assert len((tmp_path / "straight.csv").read_text("utf-8").splitlines()) == 4
    (tmp_path / "straight.csv").unlink()
    with pytest.raises(SceneError, match="known routes: pacific, storm"):
        route("nowhere")


def test_a_case_is_chosen_and_values_prevail() -> None:
    scene = Scene.load("sea_cliff")
    assert select(scene).cases == select(scene, "8 s wave").cases == ()
    chosen = select(scene, "8 s wave", {"ship.heave_period": 9.0})
    assert chosen.units["ship"].parameters["heave_period"] == 9.0
    with pytest.raises(SceneError, match="did you mean '8 s wave'"):
        one_case(scene, "8s wave")
