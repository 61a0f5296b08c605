"""``towage response`` of a lift: orbits over frequency, limits, motions."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

import towage
from towage.cli import main
from towage.errors import SceneError
from towage.frequency_response.lift import LARGEST_HEAVE, lift_response
from towage.models.heave.orbits import at_frequency, steady
from towage.scene.monolithic import monolithic
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator
from towage.verify.monolithic import dimensionless_scene


def at_heave(scene: Scene, hertz: float, heave: float) -> tuple[float, float]:
    """(share of the time slack, largest tension, N) of the steady motion at another heave of the ship."""
    system = at_frequency(monolithic(described(scene, locator(None), open_ends=True)), 2.0 * math.pi * hertz)
    orbit = steady(replace(system, ship=replace(system.ship, heave_amplitude=heave)))
    return orbit.slack_fraction, orbit.tension_max


def test_limits_are_where_the_line_goes_slack_and_where_it_breaks() -> None:
    scene = Scene.load("slack").with_values({"line.breaking_load": 2.2e5})
    limit = lift_response(scene, frequencies=[0.125], limits=True).limits[0]
    assert at_heave(scene, 0.125, 0.999 * limit.slack)[0] == 0.0 < at_heave(scene, 0.125, 1.002 * limit.slack)[0]
    below, above = (at_heave(scene, 0.125, factor * limit.breaking)[1] for factor in (0.999, 1.001))
    assert below < 2.2e5 < above and limit.slack < limit.breaking and not limit.note


def test_a_line_without_breaking_load_has_no_such_limit_and_says_so() -> None:
    limit = lift_response("slack", frequencies=[0.125], limits=True).limits[0]
    assert math.isnan(limit.breaking) and limit.note == "the line has no breaking load"


def test_a_line_that_bears_all_is_not_broken_by_any_sea() -> None:
    scene = Scene.load("slack").with_values({"line.breaking_load": 1e12})
    answer = lift_response(scene, frequencies=[0.02], limits=True)
    assert answer.limits[0].breaking == math.inf and f"up to {LARGEST_HEAVE:g} m" in answer.limits[0].note
    assert answer.limit_rows()[0]["breaking"] is None


def test_a_taut_line_is_followed_once_and_a_slack_one_both_ways() -> None:
    assert {p.branch for p in lift_response("sea_cliff", frequencies=[0.05, 0.1]).points} == {"up"}
    answer = lift_response("slack", frequencies=[0.125, 0.1])
    assert [(p.branch, p.frequency_hz) for p in answer.points] == [
        ("up", 0.1),
        ("up", 0.125),
        ("down", 0.125),
        ("down", 0.1),
    ]
    assert answer.points[1].slack_fraction > 0.2 and answer.points[1].stable


def test_starts_are_followed_to_motions_of_many_periods() -> None:
    """B = 0.05, r = 2.5, w = 1 has coexisting motions (section 2 of the spec of the thesis)."""
    scene = dimensionless_scene(0.05, 2.5, 1.0)
    motions = lift_response(scene, frequencies=[2.5 / (2.0 * math.pi)], starts=2).motions
    assert motions and all(hasattr(m, "period") or hasattr(m, "lyapunov") for m in motions)


@pytest.mark.parametrize(
    ("scene", "options", "words"),
    [
        ("tow_600ft", {}, "no monolithic solution"),
        ("sea_cliff", {"frequencies": [0.0]}, "above 0"),
        ("slack", {"set": {"ship.heave_amplitude": 0.0}}, "the ship does not heave"),
    ],
)
def test_what_has_no_response_is_refused(scene: str, options: dict[str, object], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        towage.lift_response(scene, **options)


def test_the_command_writes_table_plot_and_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "response",
        "slack",
        "--from",
        "0.1",
        "--to",
        "0.125",
        "--points",
        "2",
        "--limits",
        "--out",
        str(tmp_path),
    ]
    assert main(command) == 0
    assert "breaks from, m" in capsys.readouterr().out
    rows = list(csv.DictReader((tmp_path / "lift_response.csv").read_text().splitlines()))
    assert len(rows) == 4 and (tmp_path / "lift_response.svg").is_file() and (tmp_path / "lift_limits.csv").is_file()
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["limits"][0]["breaking"] is None


@pytest.mark.parametrize(
    ("scene", "option", "words"),
    [("slack", "--excite=heave=1", "meant for a tow"), ("tow_600ft", "--limits", "meant for a lift"),
     ("slender_yaw", "--points=2", "no tow and no lift")],
)  # fmt: skip
def test_options_of_the_other_kind_are_refused(
    scene: str, option: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["response", scene, option, "--out", str(tmp_path)]) == 2
    assert words in capsys.readouterr().err
