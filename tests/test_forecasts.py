"""Forecasts: one field in many encodings gives one answer, and what cannot be meant is refused by file, variable, attribute."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from netCDF4 import Dataset

import towage
from tests.forecasts import Encoding, Scenario, case, random_encoding, scenario, write
from towage.errors import SceneError
from towage.models.route.areas import Cells
from towage.models.route.grid import GridField
from towage.routing.file import RouteFile, load

FIELDS = ("regional", "global", "moving")


def route_file(folder: Path, given: Scenario, way: Encoding, stem: str = "waves", sea: str = "") -> Path:
    """A route file beside its data."""
    names = [path.name for path in write(folder, stem, given, way)]
    file = folder / f"{stem}.toml"
    file.write_text(f'{given.route}[sea]\nkind = "file"\nfile = {names}\n{sea}', "utf-8")
    return file


def loaded(folder: Path, given: Scenario, way: Encoding, stem: str = "waves", sea: str = "") -> RouteFile:
    return load(route_file(folder, given, way, stem, sea))


def field_of(given: RouteFile) -> GridField:
    field = given.problem.medium.field
    assert isinstance(field, GridField)
    return field


def same_field(one: RouteFile, two: RouteFile, within: float = 1e-9) -> bool:
    """Whether two fields agree where both have data."""
    a, b = field_of(one), field_of(two)
    x, y = np.meshgrid(a.x.places, a.y.places)
    open_sea = np.ones(x.shape, dtype=bool)
    for area in (*one.problem.areas, *two.problem.areas):
        open_sea &= ~area.contains(x, y)
    open_sea[:, :2] = open_sea[:, -2:] = False  # cells beside a crop have other neighbours
    return a.height.shape == b.height.shape and all(
        np.max(np.abs(getattr(a, name) - getattr(b, name))[:, open_sea]) < within for name in ("height", "cos_angle", "sin_angle")
    )


@pytest.mark.parametrize("name", FIELDS)
def test_random_encodings_of_one_field_give_one_field(name: str, tmp_path: Path) -> None:
    given = scenario(name)
    plain = loaded(tmp_path, given, Encoding())
    for seed in range(5):
        way = random_encoding(given, seed, crops=False)
        assert same_field(plain, loaded(tmp_path, given, way, f"seed{seed}")), f"seed {seed}: {way}"


def test_the_next_forecast_can_be_written_in_the_place_of_the_last(tmp_path: Path) -> None:
    """HDF5 locks what it reads: the process that reads lets go of a file when it is done."""
    given, way = scenario("global"), Encoding(form="NETCDF4")
    plain = loaded(tmp_path, given, way)
    higher = loaded(tmp_path, replace(given, height=given.height + 1.0), way)
    assert np.max(np.abs(field_of(higher).height - field_of(plain).height - 1.0)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", FIELDS)
def test_forty_random_encodings_give_one_answer(name: str, tmp_path: Path) -> None:
    given = scenario(name)

    def hours(way: Encoding) -> float:
        return towage.route(route_file(tmp_path, given, way), cells=12, radius=2).plan.best.duration / 3600.0

    plain = hours(Encoding())
    for seed in range(40):
        assert hours(random_encoding(given, seed)) == pytest.approx(plain, abs=1e-6), f"seed {seed}"


SIX_HOURLY = np.arange(0, 121, 6)
GFS = np.concatenate([np.arange(0, 48), np.arange(48, 121, 3)])
NEXT_DAY = "hours since 2024-02-29 00:00:00"
CASES: list[Any] = [  # case, encoding, hours, tolerance
    ("r01", Encoding(), 82.97396, 1e-5),  # 0 ... 359, the route crosses Greenwich
    ("r01", Encoding(lon_start=-180.0), 82.97396, 1e-5),  # 0 ... 179, -180 ... -1
    ("r01", Encoding(lon_start=-180.0, lon_order=np.roll(np.arange(360), 180)), 82.97396, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, time=("hours since 2024-02-28 00:00:00 +02:00", 1.0), time_shift=2.0), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, to=True, standard=("", "sea_surface_wave_to_direction")), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, height_unit=("ft", 1.0 / 0.3048)), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, height_unit=("cm", 100.0)), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, bearing_unit=("radian", math.pi / 180.0)), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, single="depth"), 73.02375, 1e-5),
    ("r02", Encoding(records=SIX_HOURLY, time=("hours since 2024-02-28 6:00:00", 1.0), time_shift=-6.0), 73.02375, 1e-5),
    ("r02", Encoding(records=np.delete(SIX_HOURLY, 8)), 73.02, 1e-2),  # what interpolation over the gap costs
    ("r02", Encoding(records=GFS), 73.02, 1e-2),  # what the coarser file costs
    # 32 fixed steps, as the case was collected, give 205.600717; 64 to 1024 steps agree to 3e-8 h
    ("r03", Encoding(lon_start=-180.0, lon_order=np.roll(np.arange(360), 180)), 205.600704, 1e-5),
    ("r03", Encoding(crop=(120.0, 260.0)), 205.600704, 1e-5),
    ("r05", Encoding(), 77.91385, 1e-5),
    ("r05", Encoding(missing=-999.0, missing_attribute=""), 77.91385, 1e-5),
]


@pytest.mark.parametrize(
    ("name", "way", "hours", "within"),
    [c if k in (1, 11) else pytest.param(*c, marks=pytest.mark.slow) for k, c in enumerate(CASES)],
)
def test_hours_of_forecasts_that_people_had(name: str, way: Encoding, hours: float, within: float, tmp_path: Path) -> None:
    found = towage.route(route_file(tmp_path, case(name), way))
    assert found.plan.best.duration / 3600.0 == pytest.approx(hours, abs=within)


@pytest.mark.parametrize("name", ["r01", "r02", "r03", "r05"])
def test_fields_of_forecasts_that_people_had(name: str, tmp_path: Path) -> None:
    given = case(name)
    ways = [way for key, way, _, within in CASES if key == name and within < 1e-3]
    plain = loaded(tmp_path, given, ways[0])
    for way in ways[1:]:
        assert same_field(plain, loaded(tmp_path, given, way, "other")), way


@pytest.mark.slow
@pytest.mark.parametrize("way", [Encoding(records=SIX_HOURLY, calendar="noleap"),
                                 Encoding(records=SIX_HOURLY, time=(NEXT_DAY, 1.0))])  # fmt: skip
def test_a_calendar_without_leap_days(way: Encoding, tmp_path: Path) -> None:
    """The day after 28 February 2024 is 1 March."""
    given = replace(case("r02"), route=case("r02").route.replace("2024-02-28T18", "2024-03-01T06"))
    assert towage.route(route_file(tmp_path, given, way)).plan.best.duration / 3600.0 == pytest.approx(72.37116, abs=1e-5)


def test_calendars_of_models_and_their_missing_days(tmp_path: Path) -> None:
    given = case("r02")
    march = replace(given, route=given.route.replace("2024-02-28T18", "2024-03-01T06"))
    fields = [loaded(tmp_path, march, way) for way in (Encoding(records=SIX_HOURLY, calendar="noleap"),
              Encoding(records=SIX_HOURLY, time=(NEXT_DAY, 1.0)))]  # fmt: skip
    assert same_field(*fields) and field_of(fields[0]).t.start == field_of(fields[1]).t.start
    leap = replace(given, route=given.route.replace("2024-02-28T18", "2024-02-29T06"))
    with pytest.raises(SceneError, match="is no day of its calendar noleap"):
        loaded(tmp_path, leap, Encoding(calendar="noleap"))
    with pytest.raises(SceneError, match=r"time: calendar: 'lunar': expected one of: standard"):
        loaded(tmp_path, given, Encoding(calendar="lunar"))


# ---- what is told ---------------------------------------------------------------------------------------------------------


def same_areas(one: RouteFile, two: RouteFile) -> bool:
    """Whether the same places have no data; those off the file's edge have none either."""
    (a,), (b,) = one.problem.areas, two.problem.areas
    return isinstance(a, Cells) and isinstance(b, Cells) and np.array_equal(a.mask, b.mask)


def notes(given: RouteFile) -> str:
    return "\n".join(given.notes)


def test_missing_records_and_values_are_filled_in_time_and_told(tmp_path: Path) -> None:
    given = scenario("moving")
    plain = loaded(tmp_path, given, Encoding())
    height = given.height.copy()
    height[4] = np.nan
    empty = loaded(tmp_path, replace(given, height=height), Encoding())
    assert re.search(r"1 of 11 records have no values \(48 h\): interpolated in time", notes(empty))
    assert "no records between 36 h and 60 h after its start, where they come every 12 h" in notes(empty)
    assert field_of(empty).t.count == 10 and same_areas(empty, plain)
    height = given.height.copy()
    height[5, 10:12, 20:24] = np.nan
    holes = loaded(tmp_path, replace(given, height=height), Encoding())
    assert "8 places lack 8 values for up to 12 h: filled in time" in notes(holes)
    assert same_areas(holes, plain) and not notes(plain)
    mean = 0.5 * (given.height[4, 10, 20] + given.height[6, 10, 20])
    a = field_of(holes)
    plane = holes.problem.medium.map
    x, y = (np.array([float(v)]) for v in plane.to_plane(*np.radians((given.lat[10], given.lon[20]))))  # type: ignore[union-attr]
    assert a.at(x, y, np.array([42.0 * 3600.0])).height[0] == pytest.approx(mean, abs=0.15)  # the plane's own mesh


def test_land_and_impossible_values_are_forbidden_and_told(tmp_path: Path) -> None:
    given = case("r05")
    said = loaded(tmp_path, given, Encoding(missing=-999.0, missing_attribute=""))
    assert "swh: 285 of 3600 values (-999) lie outside 0 to 40, which nothing does: taken as no data" in notes(said)
    assert "7.9% of its places have no data" in notes(said)
    plain = loaded(tmp_path, given, Encoding())
    assert same_areas(said, plain)


def test_a_row_that_is_missing_in_place_is_told(tmp_path: Path) -> None:
    given = scenario("moving")
    kept = np.delete(np.arange(len(given.lat)), 12)
    said = loaded(tmp_path, replace(given, lat=given.lat[kept], height=given.height[:, kept], bearing=given.bearing[:, kept]),
                  Encoding())  # fmt: skip
    assert "latitude: 1 of 32 places are missing: no data there" in notes(said) and said.problem.areas


def test_what_is_assumed_is_told(tmp_path: Path) -> None:
    given = scenario("moving")
    naive = replace(given, route=given.route.replace("18:00:00Z", "18:00:00"))
    assert "names no zone: taken as UTC" in notes(loaded(tmp_path, naive, Encoding()))
    bare = Encoding(height_unit=("", 1.0))
    assert "swh: no units: taken as m" in notes(loaded(tmp_path, given, bare))
    own = 'variables = { direction = "wv" }\n'
    assert "wv: nothing says whether" in notes(loaded(tmp_path, given, Encoding(names=("swh", "wv")), sea=own))
    assert "wv" not in notes(loaded(tmp_path, given, Encoding(names=("swh", "wv")), sea=own + 'direction_is = "from"\n'))


def test_units_and_entries_that_the_route_file_gives(tmp_path: Path) -> None:
    given = scenario("moving")
    plain = loaded(tmp_path, given, Encoding())
    feet = Encoding(height_unit=("", 1.0 / 0.3048))
    assert same_field(plain, loaded(tmp_path, given, feet, sea='units = { height = "ft" }\n'))
    file = route_file(tmp_path, given, Encoding(), "several")
    with Dataset(tmp_path / "members.nc", "w") as out, Dataset(tmp_path / "several_0.nc") as data:
        for name, size in (*((d, len(data.dimensions[d])) for d in data.dimensions), ("number", 2)):
            out.createDimension(name, size)
        for name, v in data.variables.items():
            members = ("number",) if v.ndim == 3 else ()
            copy = out.createVariable(name, "f8", (*members, *v.dimensions))
            copy.units = v.units
            copy[:] = np.stack([v[:] + 1.0, v[:]]) if members else v[:]
    text = file.read_text("utf-8").replace("several_0.nc", "members.nc")
    file.write_text(text, "utf-8")
    with pytest.raises(SceneError, match=r"members.nc: swh: has a further dimension number of 2 entries; choose one: select"):
        load(file)
    file.write_text(text + "select = { number = 1 }\n", "utf-8")
    assert same_field(plain, load(file))
    file.write_text(text + "select = { number = 7 }\n", "utf-8")
    with pytest.raises(SceneError, match=r"swh: number: 7 is not there; it has 0, 1"):
        load(file)


# ---- what is refused ------------------------------------------------------------------------------------------------------


def change(name: str, **attributes: Any) -> Callable[[Dataset], None]:
    def to(data: Dataset) -> None:
        for key, value in attributes.items():
            if value is None:
                data[name].delncattr(key)
            else:
                data[name].setncattr(key, value)

    return to


def values(name: str, index: Any, value: float) -> Callable[[Dataset], None]:
    def to(data: Dataset) -> None:
        data[name][index] = value

    return to


def by_turns(data: Dataset) -> None:
    """Every place has a value in one of three records, its neighbours in others."""
    heights = data["swh"][:]
    heights[np.indices(heights.shape).sum(axis=0) % 3 != 0] = math.nan
    data["swh"][:] = heights


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (change("swh", units="furlong"), "swh: units: 'furlong': expected a unit as 'm'"),
        (change("swh", units="s"), "swh: units: 's': expected a unit as 'm'"),
        (change("swh", units="cm", scale_factor=1e5), "swh: units: .* lie outside 0 to 4000, which nothing does: is 'cm' right"),
        (change("mwd", units=None, scale_factor=0.01), "mwd: units: is missing, and no value exceeds 2 pi"),
        (change("mwd", standard_name="wind_from_direction"), "no variable for direction.*mwd has standard_name wind_from_dir"),
        (change("mwd", standard_name="sea_surface_wave_from_direction", long_name="direction the waves travel to"),
         "mwd: standard_name and long_name: one says that the direction is the one they come from"),
        (change("swh", standard_name="sea_surface_wave_from_direction"), "swh: units: 'm': expected a unit as 'deg'"),
        (change("time", units="hours"), "its times have no origin"),
        (change("time", units="fortnights since 2024-01-01"), "time: units: 'fortnights since 2024-01-01': expected 'hours"),
        (change("time", units="months since 2024-01-01"), "time: units"),
        (change("time", units="hours since 2024-01"), "time: units: 'hours since 2024-01': expected 'hours since"),
        (change("time", units="furlongs"), "time: units: 'furlongs': expected 'hours since"),
        (change("latitude", units="m", standard_name="latitude"), "latitude: units: 'm': expected a unit as 'deg'"),
        (values("latitude", 3, 95.0), "latitude: .* -90 to 90|latitude: is not equidistant"),
        (values("latitude", 3, 36.3), "latitude: is not equidistant"),
        (values("longitude", 3, math.nan), "longitude: 1 of 57 places are missing"),
        (values("longitude", 3, -41.0), "longitude: the place 319 stands there twice"),
        (values("time", 3, 24.0), "time: the time 24 stands there twice"),
        (values("time", 3, math.nan), "time: 1 of 11 times are missing"),
        (values("swh", slice(None), math.nan), "every value of height is missing"),
        (by_turns, "no place has values in more than half of the records"),
        (change("time", units="hours since 2025-01-01"), "departure .* lies outside the forecast"),
    ],
)  # fmt: skip
def test_files_that_cannot_be_meant(spoil: Callable[[Dataset], None], message: str, tmp_path: Path) -> None:
    file = route_file(tmp_path, scenario("moving"), Encoding(form="NETCDF4"))
    with Dataset(tmp_path / "waves_0.nc", "a") as data:
        spoil(data)
    with pytest.raises(SceneError, match=message) as caught:
        load(file)
    assert "waves_0.nc" in str(caught.value)


def test_other_files_that_cannot_be_meant(tmp_path: Path) -> None:
    given = scenario("moving")
    with pytest.raises(SceneError, match=r"no variable for height: looked for .*; the file has latitude, longitude, mwd, time"):
        loaded(tmp_path, given, Encoding(names=("wet", "mwd")))
    with pytest.raises(SceneError, match=r"no variable 'hs'; the file has"):
        loaded(tmp_path, given, Encoding(), sea='variables = { height = "hs" }\n')
    with pytest.raises(SceneError, match=r"sea.variables.hight: unknown key; did you mean 'height'"):
        loaded(tmp_path, given, Encoding(), sea='variables = { hight = "hs" }\n')
    with pytest.raises(SceneError, match=r"swh: units: the file says 'm', the route file 'ft'"):
        loaded(tmp_path, given, Encoding(), sea='units = { height = "ft" }\n')
    with pytest.raises(SceneError, match='map.kind = "sphere"'):
        loaded(tmp_path, replace(given, route='[route]\nstart = [0, 0]\nend = [1e6, 0]\n[ship]\nspeed = "10 kn"\n'), Encoding())
    file = route_file(tmp_path, given, Encoding(axis_names=("time", "row", "column"), axis_units=("1", "1")), "unnamed")
    with pytest.raises(SceneError, match=r"swh: no coordinate for latitude: looked for standard_name latitude"):
        load(file)


def test_files_that_disagree_and_grids_that_differ(tmp_path: Path) -> None:
    given = scenario("moving")
    file = route_file(tmp_path, given, Encoding(), "one")
    write(tmp_path, "two", replace(given, height=given.height + 0.5), Encoding())
    text = file.read_text("utf-8")
    file.write_text(text.replace("['one_0.nc']", "['one_0.nc', 'two_0.nc']"), "utf-8")
    with pytest.raises(SceneError, match=r"two_0.nc: swh: differs from one_0.nc at the same places and times"):
        load(file)
    write(tmp_path, "two", given, Encoding(calendar="noleap"))
    with pytest.raises(SceneError, match=r"two_0.nc: swh: times are noleap, those of one_0.nc: swh are world"):
        load(file)
    write(tmp_path, "split", given, Encoding(split="variable"))
    half = replace(given, lat=given.lat[::2], height=given.height[:, ::2], bearing=given.bearing[:, ::2])
    write(tmp_path, "coarse", half, Encoding(split="variable"))
    file.write_text(text.replace("['one_0.nc']", "['split_0.nc', 'coarse_1.nc']"), "utf-8")
    with pytest.raises(SceneError, match=r"coarse_1.nc: mwd: y: has 16 places, all variables together have 32"):
        load(file)


def test_curved_grids_are_refused_with_the_way_out(tmp_path: Path) -> None:
    way = Encoding(axis_names=("time", "rlat", "rlon"), axis_units=("degrees", "degrees"), form="NETCDF4")
    file = route_file(tmp_path, scenario("moving"), way)
    with Dataset(tmp_path / "waves_0.nc", "a") as data:
        for name, unit in (("lat", "degrees_north"), ("lon", "degrees_east")):
            data.createVariable(name, "f8", ("rlat", "rlon")).units = unit
    with pytest.raises(SceneError, match=r"swh: its latitude lat has 2 dimensions: a rotated or curved grid; bring it to"):
        load(file)


def test_files_that_are_no_forecast(tmp_path: Path) -> None:
    file = route_file(tmp_path, scenario("moving"), Encoding())
    for content, message in ((b"CDF\x01 nothing more", "not a readable netCDF"), (b"\x89HDF\r\n", "not a readable netCDF"),
                             (b"hours,height", "neither a netCDF nor a GRIB file")):  # fmt: skip
        (tmp_path / "waves_0.nc").write_bytes(content)
        with pytest.raises(SceneError, match=message):
            load(file)
    (tmp_path / "waves_0.nc").unlink()
    with pytest.raises(SceneError, match=r"waves_0.nc: cannot be read"):
        load(file)
