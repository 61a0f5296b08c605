"""Wind and currents beside waves, and GRIB."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from netCDF4 import Dataset
from numpy.typing import NDArray

import towage
from tests.forecasts import Encoding, Scenario, scenario, write
from towage.errors import SceneError
from towage.models.route.grid import GridCurrent, GridField
from towage.models.route.maps import StereographicMap
from towage.routing.file import load
from towage.routing.forecast import contents

Array = NDArray[np.float64]
LAT, LON = np.arange(30.0, 65.0), np.arange(-60.0, 21.0)
SPHERE = ('[map]\nkind = "sphere"\n[route]\nstart = ["45 deg", "-45 deg"]\nend = ["48 deg", "-10 deg"]\n'
          '[ship]\nspeed = "19.3 kn"\n[sea]\nkind = "calm"\n')  # fmt: skip


def grid(path: Path, axes: tuple[tuple[str, Array, str], ...], columns: dict[str, tuple[float | Array, str, str]]) -> None:
    """A file of variables (values, units, standard name) over axes (name, places, units)."""
    with Dataset(path, "w") as out:
        for name, places, unit in axes:
            out.createDimension(name, len(places))
            axis = out.createVariable(name, "f8", (name,))
            axis[:] = places
            axis.units = unit
        for name, (values, unit, standard) in columns.items():
            variable = out.createVariable(name, "f8", [axis[0] for axis in axes])
            variable.units = unit
            if standard:
                variable.standard_name = standard
            variable[:] = np.broadcast_to(values, [len(axis[1]) for axis in axes])


GLOBE = (("lat", LAT, "degrees_north"), ("lon", LON, "degrees_east"))


def at(field: GridField | GridCurrent, plane: StereographicMap, place: tuple[float, float]) -> tuple[Array, Array]:
    x, y = plane.to_plane(*np.radians(place))
    return np.array([float(x)]), np.array([float(y)])


def test_a_current_keeps_its_speed_and_bearing_on_the_sphere(tmp_path: Path) -> None:
    east = 0.5 + 0.01 * (LON + 60.0)
    grid(tmp_path / "c.nc", GLOBE, {"uo": (100.0 * east, "cm s-1", "eastward_sea_water_velocity"), "vo": (0.8, "m/s", "")})
    (tmp_path / "r.toml").write_text(SPHERE + '[current]\nkind = "file"\nfile = "c.nc"\n', "utf-8")
    given = load(tmp_path / "r.toml")
    field, plane = given.problem.medium.current, given.problem.medium.map
    assert isinstance(field, GridCurrent) and isinstance(plane, StereographicMap)
    x, y = at(field, plane, (47.0, -30.0))
    flow = field.at(x, y, np.zeros(1))
    # second-order: the mesh of the plane
    assert float(np.hypot(flow.u, flow.w)[0]) == pytest.approx(math.hypot(0.8, 0.8), rel=2e-4)
    bearing = plane.bearing(x, y, np.arctan2(flow.w, flow.u))
    assert math.degrees(float(bearing[0])) == pytest.approx(45.0, abs=0.05)
    assert "c.nc has no times: the field stands still" in given.notes


def test_a_current_is_the_same_by_speed_and_direction(tmp_path: Path) -> None:
    grid(tmp_path / "a.nc", GLOBE, {"uo": (0.6, "m s-1", ""), "vo": (-0.8, "m s-1", "")})
    bearing = math.degrees(math.atan2(0.6, -0.8))
    knots = 3600.0 / 1852.0
    grid(tmp_path / "b.nc", GLOBE, {"current_speed": (knots, "knots", ""), "current_direction": (bearing, "degrees", "")})
    grid(tmp_path / "c.nc", GLOBE, {"s": (1.0, "m/s", "sea_water_speed"),
                                    "d": (bearing - 180.0, "degrees", "sea_water_velocity_from_direction")})  # fmt: skip
    flows = []
    for name in "abc":
        (tmp_path / "r.toml").write_text(SPHERE + f'[current]\nkind = "file"\nfile = "{name}.nc"\n', "utf-8")
        problem = load(tmp_path / "r.toml").problem
        flows.append(problem.medium.current.at(np.array([4e6]), np.array([-2e6]), np.zeros(1)))
    for other in flows[1:]:
        assert [float(v[0]) for v in other[:2]] == pytest.approx([float(v[0]) for v in flows[0][:2]], abs=1e-9)


def test_an_even_current_in_a_file_is_the_formula(tmp_path: Path) -> None:
    places = (("y", np.arange(-200.0, 201.0, 50.0), "km"), ("x", np.arange(-200.0, 601.0, 50.0), "km"))
    axes = (("time", np.array([0.0, 48.0]), "hours"), *places)
    grid(tmp_path / "c.nc", axes, {"u": (0.5, "m/s", ""), "v": (1.0, "m/s", "")})
    route = '[route]\nstart = [0, 0]\nend = ["300 km", "0 km"]\n[ship]\nspeed = "5 m/s"\n[sea]\nkind = "calm"\n[current]\n'
    hours = []
    for text in ('kind = "file"\nfile = "c.nc"\n', 'kind = "linear"\nvelocity = [0.5, 1.0]\n'):
        (tmp_path / "r.toml").write_text(route + text, "utf-8")
        found = towage.route(tmp_path / "r.toml", cells=8)
        assert found.plan.best.certified
        hours.append(found.plan.best.duration / 3600.0)
    closed = 300e3 / (0.5 + math.sqrt(25.0 - 1.0)) / 3600.0  # the ship holds up against the current across
    assert hours == pytest.approx([closed, closed], rel=1e-9)


@pytest.mark.parametrize("columns", [
    {"u10": (-5.0, "m s**-1", ""), "v10": (0.0, "m s**-1", "")},
    {"wind_speed": (5.0, "m/s", ""), "wdir": (90.0, "degrees", "wind_from_direction")},
])  # fmt: skip
def test_wind_for_a_sailing_boat(columns: dict[str, tuple[float | Array, str, str]], tmp_path: Path) -> None:
    """Dead upwind: tacking between 45 degrees, where she makes 5 kn."""
    axes = (("y", np.arange(-200.0, 201.0, 20.0), "km"), ("x", np.arange(-200.0, 301.0, 20.0), "km"))
    grid(tmp_path / "w.nc", axes, columns)
    (tmp_path / "r.toml").write_text(
        '[route]\nstart = [0, 0]\nend = ["100 km", "0 km"]\n[sea]\nkind = "calm"\n[wind]\nkind = "file"\nfile = "w.nc"\n'
        '[ship.wind_table]\nwinds = ["0 m/s", "10 m/s"]\nangles = ["45 deg", "90 deg", "150 deg"]\nends = "no-go"\n'
        'speeds = [["0 kn", "0 kn", "0 kn"], ["10 kn", "12 kn", "9 kn"]]\n', "utf-8",
    )  # fmt: skip
    found = towage.route(tmp_path / "r.toml", cells=8)
    closed = 100.0 / 1.852 / (5.0 * math.cos(math.radians(45.0)))
    assert found.plan.best.duration / 3600.0 == pytest.approx(closed, rel=1e-6)  # the table bulges beside its first angle
    assert found.plan.tacking == pytest.approx(1.0)
    assert any("beyond, the ship does not sail but tacks" in note for note in found.notes)


def test_a_wind_table_needs_a_wind(tmp_path: Path) -> None:
    (tmp_path / "r.toml").write_text(
        '[route]\nstart = [0, 0]\nend = [1e5, 0]\n[sea]\nkind = "calm"\n[ship.wind_table]\nwinds = [0]\nangles = [0, 3]\n'
        "speeds = [[1, 1]]\n", "utf-8",
    )  # fmt: skip
    with pytest.raises(SceneError, match="wind: this table is missing: the ship has a wind_table"):
        load(tmp_path / "r.toml")


def _grib(path: Path, given: Scenario) -> None:
    import eccodes

    with open(path, "wb") as out:
        for k, hour in enumerate(given.hours):
            for parameter, values in ((140229, given.height), (140230, given.bearing)):
                message = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
                keys = {
                    "dataDate": 20240228, "dataTime": 0, "forecastTime": int(hour), "Ni": len(given.lon), "Nj": len(given.lat),
                    "latitudeOfFirstGridPointInDegrees": given.lat[-1], "latitudeOfLastGridPointInDegrees": given.lat[0],
                    "longitudeOfFirstGridPointInDegrees": given.lon[0] % 360.0, "iDirectionIncrementInDegrees": 1.0,
                    "longitudeOfLastGridPointInDegrees": given.lon[-1] % 360.0, "jDirectionIncrementInDegrees": 1.0,
                    "paramId": parameter, "bitsPerValue": 24,
                }  # fmt: skip
                for key, value in keys.items():
                    eccodes.codes_set(message, key, value)
                eccodes.codes_set_values(message, values[k, ::-1].ravel())
                eccodes.codes_write(message, out)
                eccodes.codes_release(message)


def test_grib_is_the_same_field(tmp_path: Path) -> None:
    pytest.importorskip("cfgrib", reason="the extra grib is not installed")
    given = scenario("moving")
    write(tmp_path, "waves", given, Encoding())
    _grib(tmp_path / "waves.grib", given)
    fields = []
    for name in ("waves_0.nc", "waves.grib"):
        (tmp_path / "r.toml").write_text(f'{given.route}[sea]\nkind = "file"\nfile = "{name}"\n', "utf-8")
        field = load(tmp_path / "r.toml").problem.medium.field
        assert isinstance(field, GridField)
        fields.append(field)
    for name in ("height", "cos_angle", "sin_angle"):
        assert getattr(fields[0], name) == pytest.approx(getattr(fields[1], name), abs=2e-6)  # 24 bits a value
    assert fields[0].t == fields[1].t
    assert [path.name for path in tmp_path.iterdir() if "idx" in path.name] == []


def test_grib_without_its_extra_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = scenario("moving")
    (tmp_path / "waves.grib").write_bytes(b"GRIB, and then")
    (tmp_path / "r.toml").write_text(f'{given.route}[sea]\nkind = "file"\nfile = "waves.grib"\n', "utf-8")
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "cfgrib.py").write_text("raise ImportError('not here')\n")
    monkeypatch.syspath_prepend(tmp_path / "without")
    monkeypatch.setattr(contents, "_serving", {})  # another process reads, which finds that
    with pytest.raises(SceneError, match=r"waves.grib: is a GRIB file; to read it: pip install 'towage\[grib\]'"):
        load(tmp_path / "r.toml")
