"""``towage route``, route files and forecasts: what is read, what is written, and one reason for each fault."""

from __future__ import annotations

import csv
import datetime
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.io import netcdf_file

from towage import cli
from towage.errors import SceneError
from towage.models.route.areas import Cells
from towage.models.route.grid import GridField
from towage.models.route.maps import FlatMap, StereographicMap
from towage.routing.data import read
from towage.routing.file import SHIPPED, load

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


def test_json_and_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["route", "pacific", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["best_h"] == pytest.approx(210.80314293, rel=1e-9)
    assert document["geodesic_h"] == pytest.approx(210.80314293, rel=1e-6)  # 240 chords
    assert document["certified"] and document["kind"] == "extremal" and document["other_minima_h"] == []
    assert cli.main(["route", "pacific", "--parameters", "best"]) == 0
    shown = capsys.readouterr().out
    assert "duration = 758891" in shown and "heading_24" in shown


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
    import re

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


# ---- forecasts ----------------------------------------------------------------------------------------------------------

LATITUDES, LONGITUDES = np.arange(60.0, 29.0, -1.0), np.arange(-60.0, 1.0, 1.0)


def write(path: Path, land: bool = False, **changes: object) -> None:
    """A forecast of three days: waves of 2 + t m from the bearing of 270 degrees; north to south, as centres write them."""
    hours = np.arange(0.0, 73.0, 12.0)
    with netcdf_file(path, "w") as out:
        for name, values, unit in (
            ("time", hours, changes.get("unit", "hours since 2020-01-05 00:00:00")), ("latitude", LATITUDES, "degrees"),
            ("longitude", changes.get("longitude", LONGITUDES), "degrees"),
        ):
            out.createDimension(name, len(values))
            variable = out.createVariable(name, "d", (name,))
            variable[:] = values
            variable.units = unit
        shape = (len(hours), len(LATITUDES), len(LONGITUDES))
        height = np.broadcast_to((2.0 + hours / 24.0)[:, None, None], shape).copy()
        if land:
            height[:, 5:25, 25:30] = math.nan
        for name, data in (("swh", height), ("mwd", np.full(shape, 270.0)), ("pp1d", np.full(shape, 9.0))):
            if name != changes.get("without"):
                out.createVariable(name, "d", ("time", "latitude", "longitude"))[:] = data


def places(plane: StereographicMap) -> tuple[tuple[float, float], tuple[float, float]]:
    a, b = (plane.to_plane(*np.radians(p)) for p in ((45.0, -50.0), (48.0, -10.0)))
    return (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))


def field_of(path: Path, departure: datetime.datetime | None = None) -> tuple[GridField, Cells | None, StereographicMap]:
    plane = StereographicMap()
    return *read(path, plane, *places(plane), departure, {}), plane


def test_a_forecast_keeps_heights_directions_periods_and_times(tmp_path: Path) -> None:
    write(tmp_path / "waves.nc")
    field, _, plane = field_of(tmp_path / "waves.nc", datetime.datetime(2020, 1, 5, 6, tzinfo=datetime.UTC))
    x, y = (np.array([float(v)]) for v in plane.to_plane(math.radians(46.3), math.radians(-31.2)))
    sea = field.at(x, y, np.array([18 * 3600.0]))
    assert sea.height[0] == pytest.approx(3.0, abs=1e-12)  # 24 h after the start of the file, linear in time
    angle = math.atan2(sea.ky[0], sea.kx[0])
    assert math.degrees(float(plane.bearing(x, y, angle)[0])) == pytest.approx(270.0, abs=0.01)  # the plane's mesh
    assert field.period(x, y, np.zeros(1))[0] == pytest.approx(9.0)
    assert field.horizon == 66 * 3600.0


@pytest.mark.slow
def test_land_is_forbidden_and_the_route_goes_around(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path / "waves.nc", land=True)
    (tmp_path / "route.toml").write_text(
        '[map]\nkind = "sphere"\n[route]\nstart = ["45 deg", "-50 deg"]\nend = ["48 deg", "-10 deg"]\n'
        '[ship]\nspeed = "19.3 kn"\n[sea]\nkind = "file"\nfile = "waves.nc"\n', "utf-8",
    )  # fmt: skip
    assert cli.main(["route", str(tmp_path / "route.toml"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["kind"] == "corridor" and document["geodesic_h"] is None
    assert any("forbidden area" in note for note in document["notes"])
    given = load(tmp_path / "route.toml").problem
    assert document["best_h"] * 19.3 > 1.02 * document["distance_nmi"]
    assert bool(given.areas[0].contains(*(np.array([v]) for v in given.medium.map.to_plane(0.75, math.radians(-33.0))))[0])  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("changes", "message"),
    [({"without": "swh"}, "no variable for height"), ({"unit": "fortnights since 1964-01-01"}, "time has unit"),
     ({"longitude": np.concatenate([LONGITUDES[:-1], [1.7]])}, "longitude|x is not equidistant")],
)  # fmt: skip
def test_bad_forecasts(changes: dict[str, object], message: str, tmp_path: Path) -> None:
    write(tmp_path / "waves.nc", **changes)
    with pytest.raises(SceneError, match=message):
        field_of(tmp_path / "waves.nc")


def test_a_departure_outside_the_forecast(tmp_path: Path) -> None:
    write(tmp_path / "waves.nc")
    with pytest.raises(SceneError, match="outside the forecast"):
        field_of(tmp_path / "waves.nc", datetime.datetime(2021, 1, 1))


def test_files_that_are_no_forecast(tmp_path: Path) -> None:
    plane = FlatMap()
    (tmp_path / "a.nc").write_bytes(b"CDF\x01 nothing more")
    (tmp_path / "b.nc").write_bytes(b"\x89HDF\r\n")
    for name, message in (("a.nc", "netCDF"), ("b.nc", "netCDF"), ("c.nc", "cannot be read")):
        with pytest.raises(SceneError, match=message):
            read(tmp_path / name, plane, (0.0, 0.0), (1.0, 1.0), None, {})
