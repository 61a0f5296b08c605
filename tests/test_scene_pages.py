"""What `benchmarks/scenes.py` measures for the page of a scene, kept as long as neither scene nor code change."""

from __future__ import annotations

import importlib
import json
import math
import runpy
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from towage.errors import TowageError
from towage.registry import SCHEMES
from towage.scene.select import select

ROOT = Path(__file__).parents[1]


@pytest.fixture
def programs(monkeypatch: pytest.MonkeyPatch) -> tuple[ModuleType, ModuleType]:
    """(scenes, scene_error), programs of ``benchmarks/``."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    return importlib.import_module("scenes"), importlib.import_module("scene_error")


def test_errors_of_a_lift_against_the_monolithic_solution(programs: tuple[ModuleType, ModuleType]) -> None:
    scenes, error = programs
    measured = error.precision(select("slack", None, {"stop_time": 20.0, "checks.sdof.settle": 8.0}))
    rows = {(row.scheme, row.signal): row for row in measured.rows}
    assert set(rows) == {(scheme, signal) for scheme in SCHEMES.own for signal in ("cradle.heave", "line.tension")}
    assert measured.reference.startswith("the monolithic solution")
    assert measured.heads == ("step 0.5 s", "step 0.25 s", "step 0.125 s", "step 0.0625 s")
    assert measured.left_out == 0
    assert rows["hermite", "cradle.heave"].order(measured.floor, 2.0) > 3.5
    assert rows["gauss-seidel", "cradle.heave"].order(measured.floor, 2.0) < 2.0
    assert rows["hermite", "line.tension"].errors[2] < 1e-3 * rows["gauss-seidel", "line.tension"].errors[2]
    text, curves = scenes._errors(json.loads(json.dumps(scenes._plain(asdict(measured)), allow_nan=False)))
    assert text.count("\n|") == 12
    assert "chaotic" not in text
    assert set(curves) == {"cradle.heave", "line.tension"}


def test_a_power_is_told_by_errors_that_tell_it(programs: tuple[ModuleType, ModuleType]) -> None:
    """Neither by those of a step that is too long, nor by those below what the reference is known to."""
    row = programs[1].Row("hermite", "a.x", (7.0, 0.16, 0.01, 1e-9), 4 * (1.0,), 4 * ("",))
    assert row.order(1e-6, 2.0) == pytest.approx(4.0)
    assert row.order(1e-6, 10.0) == pytest.approx(math.log10(16.0))
    assert row.order(0.01, 2.0) is None


def test_reference_of_a_scene_without_one_tells_how_far_it_is_known(
    programs: tuple[ModuleType, ModuleType], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And runs beyond the budget are left out, and counted."""
    scenes, error = programs
    monkeypatch.setattr(error, "BUDGET", -1.0)
    measured = error.precision(select("slender_stable", "20 t craft", {"stop_time": 20.0, "checks.sdof.settle": 8.0,
                                                                      "checks.simpler.settle": 8.0}))  # fmt: skip
    assert "an eighth of the step; the run before it differs by" in measured.reference
    assert "Richardson, order 4" in measured.reference
    assert measured.own < 1e-4
    assert measured.left_out == 5 * 4 - 1
    assert "runs were left out" in "\n".join(scenes._table(measured))


def test_what_was_measured_is_kept_until_scene_or_code_change(
    programs: tuple[ModuleType, ModuleType], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scenes, _ = programs
    made: list[str] = []

    def measured(case: Any) -> dict[str, Any]:
        made.append(case.chosen)
        if len(made) == 2:
            raise KeyboardInterrupt
        told: dict[str, Any] = {"date": "2026-01-02", "cpu": "a machine", "ladder_s": 1.0, "errors_s": 2.0}
        return told | {"ladder": {"refused": "it is a test"}, "errors": {"refused": "it is a test"}}

    monkeypatch.setattr(scenes, "measured", measured)
    scenes.write("docking", tmp_path, measures=False)
    assert not made and "Not measured" in (tmp_path / "scenes" / "docking.json").read_text()
    with pytest.raises(KeyboardInterrupt):
        scenes.write("docking", tmp_path)
    scenes.write("docking", tmp_path)  # goes on with the case that was not done
    scenes.write("docking", tmp_path)
    assert made == ["plastic capture", "soft, as in the thesis", "soft, as in the thesis"]
    assert "earlier version" not in (tmp_path / "scenes" / "docking.json").read_text()
    monkeypatch.setattr(scenes, "_code", lambda: ["other code"])
    scenes.write("docking", tmp_path, measures=False)
    assert "Measured 2026-01-02, a machine, with an earlier version" in (tmp_path / "scenes" / "docking.json").read_text()
    scenes.write("docking", tmp_path)
    assert len(made) == 5
    parts = runpy.run_path(str(ROOT / "docs" / "make_scenes.py"))["measured"]
    assert "No ladder: it is a test" in "\n".join(parts("docking", tmp_path / "scenes"))
    assert "Not measured: `python benchmarks/scenes.py light_body`." in parts("light_body", tmp_path / "scenes")


def test_what_cannot_be_measured_says_so(programs: tuple[ModuleType, ModuleType], monkeypatch: pytest.MonkeyPatch) -> None:
    scenes, error = programs

    def broken(*more: Any, **options: Any) -> None:
        raise TowageError("the unit crashed")

    monkeypatch.setattr(scenes, "simplest", broken)
    monkeypatch.setattr(scenes, "precision", broken)
    scene = select("slack")
    told = scenes.measured(scene)
    assert told["ladder"] == told["errors"] == {"refused": "the unit crashed"}
    assert scenes._errors(told["errors"]) == ("No errors: the unit crashed", {})
    assert error._tried(scene, 64.0, "hermite") == "refused"
    assert scenes._plain({"a": [math.inf, 1.23456789]}) == {"a": ["inf", 1.235]}
