"""``towage stability`` and the library behind it."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

from towage import cli
from towage.errors import SceneError
from towage.models.slender.coefficients import Body
from towage.scene.scene import Scene
from towage.tow_stability import critical
from towage.tow_stability.stability import bodies


@pytest.fixture(autouse=True)
def own_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cache of maps of this test's own; FMUs stay where they are."""
    monkeypatch.setattr(critical, "cache", lambda: tmp_path / "cache")


def test_row_of_the_thesis_body() -> None:
    row = critical.row(Body(), u_max=8.0)
    assert row.yaw == pytest.approx([3.379995896844, 7.935305114211], rel=1e-9)
    assert [u for u, _, grows in row.flutter if grows] == pytest.approx(
        [4.155665957281, 4.676593643981, 7.115966593942], rel=1e-7  # 20 shape functions
    )  # fmt: skip
    ((low, high),) = row.stable
    assert (low, high) == pytest.approx((3.379996, 4.155666), abs=1e-6)


def test_a_stable_body_has_one_window() -> None:
    assert critical.row(Body(tail_cut=0.4), u_max=6.0).stable == ((0.0, 6.0),)


def test_map_is_cached_and_reports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[float] = []
    values = [0.4, 0.9]
    first = critical.stability_map(Body(), "tail_cut", values, 5.0, lambda share, text: heard.append(share))
    assert heard == [0.0, 0.5, 1.0]
    assert len(list((tmp_path / "cache" / "stability").glob("*.json"))) == 2

    def never(*arguments: object, **options: object) -> critical.Row:
        raise AssertionError("computed again")

    monkeypatch.setattr(critical, "row", never)
    assert critical.stability_map(Body(), "tail_cut", values, 5.0) == first
    for file in (tmp_path / "cache" / "stability").glob("*.json"):
        file.write_text("{broken", encoding="utf-8")
    with pytest.raises(AssertionError, match="computed again"):  # a damaged row is none
        critical.stability_map(Body(), "tail_cut", values, 5.0)


def test_slenderness_keeps_the_drag_coefficients() -> None:
    body = critical.varied(Body(normal_drag=0.4), "slenderness", 80.0)
    assert (body.friction, body.normal_drag) == (2.0, 0.8)
    with pytest.raises(ValueError, match="more than 0.5"):
        critical.varied(Body(), "slenderness", 20.0)
    assert critical.varied(Body(tail_length=0.1), "end_length", 0.05) == Body(end_length=0.05)
    assert critical.varied(Body(), "tail_length", 0.05).ends.tail != Body().ends.tail
    with pytest.raises(ValueError, match="no map over"):
        critical.varied(Body(), "mass_ratio", 0.3)
    assert critical.default_values(Body(), "rope_length", 3) == pytest.approx([0.1, 1.0, 10.0])
    for end in (0.001, 0.015, 0.2):  # every default map exists
        other = Body(end_length=end, slenderness=600.0)
        for parameter in critical.RANGES:
            assert all(critical.varied(other, parameter, v) for v in critical.default_values(other, parameter, 5))


def test_argand_paths_start_with_rope_and_yaw() -> None:
    paths = critical.argand(Body(), np.linspace(0.3, 2.0, 10), count=3)
    assert [bool(p.oscillates[0]) for p in paths] == [False, True, True]


def test_bodies_of_a_scene() -> None:
    (towed,) = bodies(Scene.load("slender_yaw"))
    assert towed.name == "body"
    assert towed.speed_scale == pytest.approx(0.75, rel=1e-9)
    assert towed.body.friction == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(SceneError, match="slender_body"):
        bodies(Scene.load("sea_cliff"))


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--map", "tail_cut", "--points", "2", "--u-max", "5", "--progress", "none", "--out", str(tmp_path / "out")]
    assert cli.main(["stability", "slender_flutter", *options]) == 0
    text = capsys.readouterr().out
    assert "2.5350 m/s  (u = 3.379996)" in text
    assert "3.1167 m/s" in text
    assert "neutral with the tail cut at 0.521435" in text
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert names == {"body_argand.svg", "body_tail_cut.svg", "body_tail_cut.csv"}
    with (tmp_path / "out" / "body_tail_cut.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["kind"] for row in rows} == {"yaw", "flutter"}
    assert all(math.isfinite(float(row["tow_speed_m_s"])) for row in rows)


def test_command_in_json_with_values_and_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["stability", "slender_flutter", "--case", "blunt tail", "--json", "--u-max", "4", "--out", str(tmp_path)]
    assert cli.main(arguments) == 0
    (body,) = json.loads(capsys.readouterr().out)["bodies"]
    assert body["yaw_m_s"] == body["flutter"] == []
    assert body["stable_m_s"] == [[0.0, pytest.approx(3.0)]]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sea_cliff"], "no unit of the scene is a slender_body"),
        (["slender_yaw", "--set", "body.end_length=0.1"], "more than 0.5"),
        (["slender_yaw", "--set", "body.tail_cut=2"], "out of range"),
        (["nowhere"], "no such file or scene"),
    ],
)
def test_refusals(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["stability", *arguments, "--u-max", "2", "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("option", [["--points", "1"], ["--points", "x"], ["--u-max", "20"], ["--u-max", "nan"]])
def test_bad_options(option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["stability", "slender_yaw", *option])
    assert "expected a" in capsys.readouterr().err
