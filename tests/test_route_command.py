"""``towage route``, route files and forecasts: what is read, what is written, and one reason for each fault."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

from towage import cli
from towage.routing.file import SHIPPED

STORM = (SHIPPED / "storm.toml").read_text("utf-8")


def test_times_saving_and_certificate(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    table, picture = tmp_path / "storm.csv", tmp_path / "storm.svg"
    assert cli.main(["route", "storm", "--csv", str(table), "--map", str(picture), "--at", "20"]) == 0
    shown = capsys.readouterr().out
    for text in ("56.716510 h", "58.267338 h", "61.968521 h", "saving over the straight route: 8.48%", "local minimum"):
        assert text in shown
    rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
    assert len(rows) == 101
    assert float(rows[-1]["time_h"]) == pytest.approx(56.7165103, abs=1e-6)
    assert float(rows[-1]["x_nmi"]) == pytest.approx(1000.0, abs=1e-4) and abs(float(rows[-1]["y_nmi"])) < 1e-4
    assert all(0.0 < float(row["speed_kn"]) < 19.59 for row in rows)
    assert picture.read_text("utf-8").lstrip().startswith("<?xml")


def test_json_and_the_other_track(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert cli.main(["route", "pacific", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["best_h"] == pytest.approx(210.80314293, rel=1e-9)
    assert document["geodesic_h"] == pytest.approx(210.80314293, rel=1e-6)  # 240 chords
    assert document["certified"] and document["kind"] == "extremal" and document["other_minima_h"] == []
    table = tmp_path / "straight.csv"
    assert cli.main(["route", "pacific", "--csv", str(table), "--of", "straight", "--rows", "7"]) == 0
    rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
    assert len(rows) == 7 and float(rows[-1]["longitude_deg"]) == pytest.approx(-125.0, abs=1e-6)
    assert float(rows[-1]["time_h"]) > 210.9  # on the plane the straight line is no great circle


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('end = ["1000 nmi", "0 nmi"]', "", "route.end: expected two numbers"),
        ('"1000 nmi"', '"1000 kg"', "route.end"),
        ("sigma", "sigmo", "did you mean 'sigma'"),
        ('kind = "storm"', 'kind = "gale"', "sea.kind: expected one of"),
        ('"120 nmi"', '"-1 nmi"', "sea.sigma"),
        ('"120 nmi"', "nan", "finite number"),
        ("P2-S2-R2 (1957)", "P3", "ship.polar"),
        ("[ship]", '[ship]\nspeed = "10 kn"', "exactly one of polar, speed and table"),
        ("[ship]", "[ship", "not valid TOML"),
        ("[sea]", "[[forbidden]]\ncentre = [0.0, 0.0]\nradius = 1000.0\n[sea]", "start .* lies inside forbidden area 'area 1'"),
        ("[sea]", "[[forbidden]]\ncorners = [[0.0, 0.0]]\n[sea]", "forbidden.*corners"),
    ],
)
def test_faults_of_a_route_file(
    old: str, new: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert old in STORM
    file = tmp_path / "route.toml"
    file.write_text(STORM.replace(old, new, 1), "utf-8")
    assert cli.main(["route", str(file)]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert re.search(message, shown.err), shown.err


def test_failures_give_reasons_and_no_route(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wall = "[[forbidden]]\nname = 'wall'\ncorners = [[4e5, -4e6], [5e5, -4e6], [5e5, 4e6], [4e5, 4e6]]\n[sea]"
    file = tmp_path / "route.toml"
    file.write_text(STORM.replace("[sea]", wall), "utf-8")
    assert cli.main(["route", str(file)]) == 3
    assert "no route: every way to the end is closed by forbidden areas" in capsys.readouterr().err
    assert cli.main(["route", "storm", "--method", "seed"]) == 3
    assert "did not converge" in capsys.readouterr().err
    assert cli.main(["route", "storm", "--map", "x.gif"]) == 2
    assert cli.main(["route", "nowhere"]) == 2
    assert "known routes: pacific, storm" in capsys.readouterr().err
