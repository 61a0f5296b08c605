"""Small forecasts that the tests write themselves: one field in many encodings, and the hours that each must give.

The fields are Gaussian hills of wave height on meshes of whole degrees, rounded to 1/256 m and 1/16 degree so that every
encoding here (float32, packed integers, feet, centimetres) carries them without loss.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from netCDF4 import Dataset
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scenario:
    """A field ``height`` (t, y, x), m, and ``bearing`` (t, y, x), degrees, waves come FROM; nan where there are no data.
    ``hours`` after 28 February 2024, UTC. ``globe``: longitudes go all the way around. ``route``: the rest of a route file."""

    hours: Array
    lat: Array
    lon: Array
    height: Array
    bearing: Array
    route: str
    globe: bool = False


def hill(lat: Array, lon: Array, centre: tuple[float, float], width: float, peak: float = 6.0) -> Array:
    """Height, m, on the mesh of ``lat`` and ``lon``, degrees."""
    north, around = np.meshgrid(lat, lon, indexing="ij")
    east = ((around - centre[1] + 180.0) % 360.0 - 180.0) * np.cos(np.radians(centre[0]))
    return np.asarray(1.0 + peak * np.exp(-((north - centre[0]) ** 2 + east**2) / (2.0 * width**2)))


def _route(start: str, end: str, departure: str) -> str:
    leaves = f"departure = {departure}\n" if departure else ""
    return (f'[map]\nkind = "sphere"\n[route]\nstart = [{start}]\nend = [{end}]\n{leaves}'
            '[ship]\npolar = "P2-S2-R2 (1957)"\n')  # fmt: skip


def scenario(name: str) -> Scenario:
    """regional (with land), global (the route crosses the date line), moving (a storm that moves north)."""
    hours = np.arange(0.0, 121.0, 12.0)
    if name == "global":
        lat, lon = np.arange(25.0, 66.0), np.arange(0.0, 360.0)
        height = np.broadcast_to(hill(lat, lon, (45.0, 175.0), 5.0), (1, len(lat), len(lon)))
        hours, bearing = hours[:1], 280.0
        route = _route('"40 deg", "160 deg"', '"46 deg", "-165 deg"', "2024-02-28T00:00:00Z")
    elif name == "regional":
        lat, lon = np.arange(35.0, 62.0), np.arange(-40.0, 12.0)
        height = np.stack([hill(lat, lon, (47.0, -16.0), 4.0, 5.0 + h / 60.0) for h in hours])
        height[:, 20:24, 30:34] = np.nan
        route, bearing = _route('"49 deg", "-30 deg"', '"45 deg", "0 deg"', "2024-02-28T06:00:00Z"), 250.0
    elif name == "moving":
        lat, lon = np.arange(32.0, 64.0), np.arange(-45.0, 12.0)
        height = np.stack([hill(lat, lon, (40.0 + h / 4.0, -15.0), 3.0, 8.0) for h in hours])
        route, bearing = _route('"50 deg", "-30 deg"', '"46 deg", "-2 deg"', "2024-02-28T18:00:00Z"), 235.0
    else:
        raise ValueError(name)
    height = np.round(height * 256.0) / 256.0
    turn = np.round((bearing + 3.0 * (height - 1.0)) * 16.0) / 16.0
    return Scenario(hours, lat, lon, height, turn, route, globe=name == "global")


def case(name: str) -> Scenario:
    """Fields of forecasts that people had and that were once read wrongly, by the first letters of their cases: r01 a hill in the
    Bay of Biscay, r03 one on the date line, r02 a storm that moves north, r05 land of a box. The hours that they must give are
    those of one plain encoding, computed when the cases were collected."""
    lat, lon = np.arange(30.0, 65.0), np.arange(-40.0, 20.0)
    hours, bearing = np.zeros(1), 250.0
    if name == "r01":
        lon = np.arange(0.0, 360.0)
        height = hill(lat, lon, (47.0, -10.0), 4.0)[None]
        route = _route('"49 deg", "-30 deg"', '"45 deg", "8 deg"', "")
    elif name == "r03":
        lat, lon, bearing = np.arange(25.0, 66.0), np.arange(0.0, 360.0), 280.0
        height = hill(lat, lon, (45.0, 175.0), 5.0)[None]
        route = _route('"35 deg", "141 deg"', '"48 deg", "-126 deg"', "")
    elif name == "r05":
        lat, lon, bearing = np.arange(40.0, 60.0, 0.5), np.arange(-40.0, 5.0, 0.5), 270.0
        north, east = np.meshgrid(lat, lon, indexing="ij")
        land = (east > -22.0) & (east < -14.0) & (north > 44.0) & (north < 54.0)
        height = np.where(land, np.nan, 4.0)[None]
        route = _route('"49 deg", "-35 deg"', '"49 deg", "0 deg"', "")
    else:
        hours = np.arange(0.0, 121.0, 1.0)
        height = np.stack([hill(lat, lon, (40.0 + h / 4.0, -15.0), 3.0, 8.0) for h in hours])
        route = _route('"50 deg", "-35 deg"', '"46 deg", "0 deg"', "2024-02-28T18:00:00Z")
    return Scenario(hours, lat, lon, height, np.full_like(height, bearing), route)


@dataclass(frozen=True)
class Encoding:
    """How a field is written; what is not said is as centres write it."""

    names: tuple[str, str] = ("swh", "mwd")
    standard: tuple[str, str] = ("", "")
    long_name: str = ""
    height_unit: tuple[str, float] = ("m", 1.0)
    bearing_unit: tuple[str, float] = ("degrees", 1.0)
    to: bool = False
    kind: str = "f8"
    missing: Any = np.nan
    missing_attribute: str = "_FillValue"
    order: tuple[int, ...] = (0, 1, 2)
    single: str = ""
    lat_order: NDArray[np.intp] | None = None
    lon_order: NDArray[np.intp] | None = None
    lon_start: float = -180.0
    time: tuple[str, float] = ("hours since 2024-02-28 00:00:00", 1.0)
    time_shift: float = 0.0
    time_order: NDArray[np.intp] | None = None
    calendar: str = ""
    axis_names: tuple[str, str, str] = ("time", "latitude", "longitude")
    axis_units: tuple[str, str] = ("degrees_north", "degrees_east")
    axis_factor: float = 1.0
    form: str = "NETCDF3_CLASSIC"
    split: str = ""
    crop: tuple[float, float] | None = None
    records: NDArray[np.intp] | None = None
    extra: dict[str, str] = field(default_factory=dict)


def write(folder: Path, stem: str, given: Scenario, way: Encoding) -> list[Path]:
    """The files of an encoding."""
    if way.records is not None:
        keep = way.records
        given = replace(given, hours=given.hours[keep], height=given.height[keep], bearing=given.bearing[keep])
    if way.crop:
        kept = (given.lon >= way.crop[0]) & (given.lon <= way.crop[1])
        given = replace(given, lon=given.lon[kept], height=given.height[:, :, kept], bearing=given.bearing[:, :, kept])
    parts: list[tuple[slice, slice, tuple[int, ...]]] = [(slice(None), slice(None), (0, 1))]
    if way.split == "time" and len(given.hours) > 2:
        middle = len(given.hours) // 2
        parts = [(slice(None, middle), slice(None), (0, 1)), (slice(middle, None), slice(None), (0, 1))]
    elif way.split == "place":
        parts = [(slice(None), slice(None, 20), (0, 1)), (slice(None), slice(20, None), (0, 1))]
    elif way.split == "variable":
        parts = [(slice(None), slice(None), (0,)), (slice(None), slice(None), (1,))]
    paths = []
    for k, (times, places, which) in enumerate(parts):
        paths.append(folder / f"{stem}_{k}.nc")
        _write(paths[-1], given, way, times, places, which)
    return paths


def _write(path: Path, given: Scenario, way: Encoding, times: slice, places: slice, which: tuple[int, ...]) -> None:
    hours, lon = given.hours[times], given.lon[places]
    t = np.arange(len(hours)) if way.time_order is None or way.split == "time" else way.time_order
    y = np.arange(len(given.lat)) if way.lat_order is None else way.lat_order
    x = np.arange(len(lon)) if way.lon_order is None or way.split == "place" else way.lon_order
    around = way.lon_start + np.mod(lon - way.lon_start, 360.0)
    axes = (
        (hours[t] + way.time_shift) * way.time[1], given.lat[y] * way.axis_factor, around[x] * way.axis_factor,
    )  # fmt: skip
    with Dataset(path, "w", format=way.form) as data:
        for name, values, unit in zip(way.axis_names, axes, (way.time[0], *way.axis_units)):
            data.createDimension(name, len(values))
            variable = data.createVariable(name, "f8", (name,))
            variable[:] = values
            variable.units = unit
            if name == way.axis_names[0] and way.calendar:
                variable.calendar = way.calendar
        dims = [way.axis_names[k] for k in way.order]
        if way.single:
            data.createDimension(way.single, 1)
            dims.insert(1, way.single)
        bearing = (given.bearing + (180.0 if way.to else 0.0)) % 360.0
        columns = ((given.height, way.height_unit), (bearing, way.bearing_unit))
        for k in which:
            values, (unit, factor) = columns[k]
            block = values[times][:, :, places][t][:, y][:, :, x] * factor
            block = np.transpose(block, way.order).reshape([len(data.dimensions[name]) for name in dims])
            _variable(data, way, k, dims, block, unit, factor)


def _variable(data: Dataset, way: Encoding, k: int, dims: list[str], block: Array, unit: str, factor: float) -> None:
    missing = way.missing
    packed = way.kind.startswith("i")
    if packed:
        missing = -32767 if way.kind == "i2" else -(2**31) + 1
    fill = {"fill_value": missing} if way.missing_attribute == "_FillValue" and missing == missing else {}
    variable = data.createVariable(way.names[k], way.kind, dims, **fill)
    variable.set_auto_maskandscale(False)
    variable.units = unit
    if way.missing_attribute == "missing_value" and missing == missing:
        variable.setncattr("missing_value", np.array(missing, dtype=way.kind))
    if way.standard[k]:
        variable.standard_name = way.standard[k]
    if k == 1 and way.long_name:
        variable.long_name = way.long_name
    for name, value in way.extra.items():
        variable.setncattr(name, value)
    gone = np.isnan(block)
    if packed:
        scale, offset = factor / (256.0, 16.0)[k], (8.0, 180.0)[k] * factor
        variable.scale_factor, variable.add_offset = scale, offset
        raw = np.where(gone, missing, np.round((np.where(gone, offset, block) - offset) / scale))
        variable[:] = raw.astype(way.kind)
    else:
        variable[:] = np.where(gone, missing, block).astype(way.kind)


def random_encoding(given: Scenario, seed: int, crops: bool = True) -> Encoding:
    """A way to write the field, chosen by ``seed``; ``crops``: perhaps a part of it, around the route."""
    rng = np.random.default_rng(seed)

    def pick(*values: Any) -> Any:
        return values[int(rng.integers(len(values)))]

    to = bool(rng.integers(2))
    word = "to" if to else "from"
    known = (("swh", "mwd"), ("hs", "dir"), ("VHM0", "VMDR"))
    names, standard, long_name = pick(
        (pick(*known), ("sea_surface_wave_significant_height", f"sea_surface_wave_{word}_direction"), ""),
        (("a", "b"), ("sea_surface_wave_significant_height", f"sea_surface_wave_{word}_direction"), ""),
        (pick(*known), ("", ""), f"mean direction the waves {'travel to' if to else 'come from'}, degrees"),
        (("wave_height", f"wave_{word}_direction"), ("", f"sea_surface_wave_{word}_direction"), ""),
    )
    kind = pick("f8", "f4", "i2", "i4")
    exact = pick(("m", 1.0), ("cm", 100.0), ("metres", 1.0))
    rough = pick(("ft", 1.0 / 0.3048), ("feet", 1.0 / 0.3048), ("km", 1e-3))
    angle = pick(("degrees", 1.0), ("degree", 1.0), ("degrees_true", 1.0), ("Degree true", 1.0))
    # the calendars of this world: Julian dates lie 13 days behind
    calendar, day = pick(("", "2024-02-28"), ("standard", "2024-02-28"), ("proleptic_gregorian", "2024-02-28"),
                         ("julian", "2024-02-15"))  # fmt: skip
    zone, shift = pick(("", 0.0), (" +02:00", 2.0), (" -05:30", -5.5), ("Z", 0.0))
    unit, factor = pick(("hours", 1.0), ("seconds", 3600.0), ("minutes", 60.0), ("days", 1.0 / 24.0))
    origin = f"{day} {pick('00:00:00', '0:0:0', '00:00')}" if zone != "Z" else f"{day}T00:00:00"
    crop = pick(None, (float(rng.integers(95, 115)), float(rng.integers(250, 300)))) if given.globe and crops else None
    n, m = len(given.hours), len(given.lat)
    k = len(given.lon) if crop is None else int(np.sum((given.lon >= crop[0]) & (given.lon <= crop[1])))
    lon_order = pick(np.arange(k), np.arange(k)[::-1], np.roll(np.arange(k), int(rng.integers(k))), rng.permutation(k))
    radians = bool(rng.integers(4) == 0)
    fill = pick((np.nan, ""), (-999.0, ""), (1e20, "_FillValue"), (9999.0, "missing_value"), (-32768.0, "_FillValue"))
    return Encoding(
        names, standard, long_name, rough if kind == "f8" and rng.integers(2) else exact,
        ("radian", np.pi / 180.0) if kind == "f8" and rng.integers(2) else angle, to, kind, *fill,
        order=tuple(int(v) for v in rng.permutation(3)), single=pick("", "", "depth", "number"),
        lat_order=pick(np.arange(m), np.arange(m)[::-1], rng.permutation(m)), lon_order=lon_order,
        lon_start=float(pick(-180.0, 0.0, 20.0, -360.0)), time=(f"{unit} since {origin}{zone}", factor), time_shift=shift,
        time_order=pick(np.arange(n), np.arange(n)[::-1]), calendar=calendar,
        axis_names=pick(("time", "latitude", "longitude"), ("valid_time", "lat", "lon"), ("T", "Y", "X")) if not radians
        else ("time", "lat", "lon"),
        axis_units=("radians", "radians") if radians else pick(("degrees_north", "degrees_east"), ("degree_N", "degree_E")),
        axis_factor=np.pi / 180.0 if radians else 1.0,
        form=pick("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF4", "NETCDF4_CLASSIC"),
        split=pick("", "", "time", "place", "variable"), crop=crop,
    )  # fmt: skip
