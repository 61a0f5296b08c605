"""What `benchmarks/scenes.py` measures for the page of a scene, kept as long as neither scene nor code change."""

from __future__ import annotations

import importlib
import json
import runpy
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
    assert rows["hermite", "cradle.heave"].order > 3.5
    assert rows["gauss-seidel", "cradle.heave"].order < 2.0
    assert rows["hermite", "line.tension"].errors[2] < 1e-3 * rows["gauss-seidel", "line.tension"].errors[2]
    text = "\n".join(scenes._table(measured))
    assert text.count("\n|") == 12
    assert "chaotic" not in text


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

    def ladder(case: Any) -> dict[str, str]:
        made.append(case.title)
        return {"ladder": "a table", "picture": ""}

    monkeypatch.setenv("TOWAGE_CACHE", str(tmp_path))
    monkeypatch.setattr(scenes, "_ladder", ladder)
    monkeypatch.setattr(scenes, "_errors", lambda case: {"errors": "errors", "curves": {"a.x": {"hermite": [(1.0, 0.1)]}}})
    scenes.write("slack", tmp_path / "out")
    scenes.write("slack", tmp_path / "out")
    assert len(made) == 1
    scenes._kept(select("slack", None, {"stop_time": 100.0}))
    monkeypatch.setattr(scenes, "code_digest", lambda module: "other code")
    scenes.write("slack", tmp_path / "out")
    assert len(made) == 3
    told = json.loads((tmp_path / "out" / "slack.json").read_text())
    assert "a table" in told["ladder"] and "slack_error.svg" in told["error"]
    parts = runpy.run_path(str(ROOT / "docs" / "make_scenes.py"))["measured"]
    assert "a table" in "\n".join(parts("slack", tmp_path / "out"))
    assert "Not measured: `python benchmarks/scenes.py light_body`." in parts("light_body", tmp_path / "out")


def test_what_cannot_be_measured_says_so(programs: tuple[ModuleType, ModuleType], monkeypatch: pytest.MonkeyPatch) -> None:
    scenes, error = programs

    def broken(*more: Any) -> None:
        raise TowageError("the unit crashed")

    monkeypatch.setattr(scenes, "simplest", broken)
    monkeypatch.setattr(scenes, "precision", broken)
    scene = select("slack")
    assert scenes._ladder(scene)["ladder"] == "No ladder: the unit crashed"
    assert scenes._errors(scene)["errors"] == "Not measured: the unit crashed"
    assert error._tried(scene, 64.0, "hermite") == "refused"
