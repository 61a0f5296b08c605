"""Wave forecasts from netCDF onto the plane of a route.

A file holds significant wave height (m) and the direction the waves come from (degrees clockwise from north), and
perhaps a peak period (s), over time and either latitude and longitude (degrees) or x and y (m). Classic netCDF is read
with scipy; netCDF 4 needs ``pip install xarray netCDF4``. Latitude and longitude are carried over to a regular grid of
the plane by the kernel of `models.route_grid`, at half their own mesh; missing values become a forbidden area.
"""

from __future__ import annotations

import datetime
import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.errors import SceneError
from towage.models.route.areas import Cells
from towage.models.route.grid import Axis, GridField
from towage.models.route.maps import RouteMap, StereographicMap

Array = NDArray[np.float64]
NAMES = {
    "height": ("swh", "hs", "VHM0", "significant_wave_height", "wave_height", "height"),
    "direction": ("mwd", "VMDR", "dir", "wave_direction", "direction"),
    "period": ("pp1d", "VTPK", "tp", "peak_period", "wave_period", "period"),
    "time": ("time", "valid_time", "t"),
    "y": ("latitude", "lat", "y"),
    "x": ("longitude", "lon", "x"),
}
SECONDS = {"s": 1.0, "sec": 1.0, "second": 1.0, "m": 60.0, "min": 60.0, "minute": 60.0, "h": 3600.0, "hr": 3600.0,
           "hour": 3600.0, "d": 86400.0, "day": 86400.0}  # fmt: skip
MOST_VALUES = 64_000_000
"""Of a forecast, unpacked."""
FARTHEST = 1e12
"""Of a place or time, in degrees, m or s."""
LARGEST = 500
"""Most nodes of the plane's grid along one axis."""


def read(
    path: Path, plane: RouteMap, start: tuple[float, float], end: tuple[float, float],
    departure: datetime.datetime | None, names: dict[str, str],
) -> tuple[GridField, Cells | None]:
    """The field on the plane, with time 0 at ``departure`` (None: the first time in the file), and the area without
    data. ``start`` and ``end``: m on the plane. ``names``: of variables, by the keys of `NAMES`, in place of the usual ones.
    Raises `SceneError` for a file that cannot be read or lacks a variable."""
    unknown = sorted(set(names) - set(NAMES))
    if unknown:
        raise SceneError(f"unknown {unknown[0]!r}; expected one of: {', '.join(NAMES)}", file=path, key="variables")
    content = _variables(path)

    def find(what: str, needed: bool = True) -> tuple[Array, str] | None:
        """(values, unit of measure) of the variable for ``what``; None where there is none and none is ``needed``."""
        for name in (names[what],) if what in names else NAMES[what]:
            if name in content:
                return content[name]
        if needed:
            raise SceneError(f"no variable for {what}: looked for {', '.join(NAMES[what])}; the file has "
                             f"{', '.join(sorted(content))}. Name it under sea.variables", file=path)  # fmt: skip
        return None

    height, bearing = find("height"), find("direction")
    x, y, time, period = find("x"), find("y"), find("time"), find("period", needed=False)
    assert height and bearing and x and y and time
    seconds = _seconds(time[0], time[1], departure, path)
    tx, ty, tt = _axis(x[0], "x", path), _axis(y[0], "y", path), _axis(seconds, "time", path)
    flip = -1 if y[0][-1] < y[0][0] else 1
    shape = (tt.count, ty.count, tx.count)
    raw = [v[0] for v in (height, bearing, *([period] if period else []))]
    if any(v.shape != shape for v in raw):
        raise SceneError(f"variables have shapes {', '.join(str(v.shape) for v in raw)}, expected (time, y, x) = {shape}",
                         file=path)  # fmt: skip
    missing = np.any([~np.isfinite(v) for v in raw], axis=0)[:, ::flip]
    if missing.all():
        raise SceneError("every value is missing", file=path)
    angle = np.radians(raw[1][:, ::flip])
    layers = [_filled(v, missing) for v in (raw[0][:, ::flip], np.cos(angle), np.sin(angle))]
    times = _filled(raw[2][:, ::flip], missing) if period else None
    gone = missing.any(axis=0)
    source = GridField(tx, ty, tt, layers[0], layers[1], layers[2], times)
    if not isinstance(plane, StereographicMap):
        # on a flat map x is east and y north: the angle from +x is 90 degrees minus the bearing
        field = GridField(tx, ty, tt, layers[0], cos_angle=layers[2], sin_angle=layers[1], peak_period=times)
        return field, Cells(tx.start, ty.start, tx.step, ty.step, gone, "no data") if gone.any() else None
    return _on_plane(source, gone, plane, start, end)


def _on_plane(
    source: GridField, gone: NDArray[np.bool_], plane: StereographicMap, start: tuple[float, float],
    end: tuple[float, float],
) -> tuple[GridField, Cells | None]:
    """A field of latitude and longitude, degrees, on a grid of the plane around the route."""
    reach = 0.65 * math.dist(start, end)
    low = [min(a, b) - reach for a, b in zip(start, end)]
    size = [abs(a - b) + 2.0 * reach for a, b in zip(start, end)]
    scale = float(plane.scale(start[0], start[1])[0])
    mesh = max(0.5 * math.radians(source.y.step) * plane.radius * scale, max(size) / LARGEST)
    ax, ay = (Axis(a, mesh, math.ceil(s / mesh) + 1) for a, s in zip(low, size))
    x, y = np.meshgrid(ax.start + mesh * np.arange(ax.count), ay.start + mesh * np.arange(ay.count))
    latitude, longitude = (np.degrees(v) for v in plane.to_geographic(x, y))
    longitude = source.x.start + np.mod(longitude - source.x.start, 360.0)
    layers: list[list[Array]] = [[], [], [], []]
    for k in range(source.t.count):
        values = source.values(longitude, latitude, np.full(x.shape, source.t.start + k * source.t.step))[0]
        angle = plane.direction(x, y, np.arctan2(values[2], values[1]))
        for layer, value in zip(layers, (np.maximum(values[0], 0.0), np.cos(angle), np.sin(angle), values[3])):
            layer.append(value)
    cells = Cells(source.x.start, source.y.start, source.x.step, source.y.step, gone)
    no_data = ~source.inside(longitude, latitude) | cells.contains(longitude, latitude)
    stacked = [np.array(layer) for layer in layers]
    area = Cells(ax.start, ay.start, mesh, mesh, no_data, "no data") if no_data.any() else None
    period = None if source.peak_period is None else stacked[3]
    return GridField(ax, ay, source.t, stacked[0], stacked[1], stacked[2], period), area


def _variables(path: Path) -> dict[str, tuple[Array, str]]:
    """Every numeric variable with its unit, missing values as nan."""
    try:
        with open(path, "rb") as stream:
            classic = stream.read(3) == b"CDF"
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", file=path) from error
    variables: dict[str, tuple[Array, str]] = {}
    if classic:
        from scipy.io import netcdf_file

        try:
            with reading.foreign(path, "netCDF file"), netcdf_file(path, "r", mmap=False, maskandscale=True) as content:
                for name, variable in content.variables.items():
                    unit: object = getattr(variable, "units", b"")
                    values: Array = np.ma.filled(np.ma.asarray(variable[:], dtype=float), math.nan)
                    variables[name] = values, unit.decode() if isinstance(unit, bytes) else str(unit)
        except reading.Refused as refused:
            raise SceneError(str(refused), file=path) from refused
        return variables
    try:
        import xarray  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        raise SceneError("is not a classic netCDF file; for netCDF 4: pip install xarray netCDF4", file=path) from None
    try:
        with reading.foreign(path, "netCDF file"), xarray.open_dataset(path, decode_times=False) as data:
            reading.limited(sum(column.size for column in data.variables.values()), MOST_VALUES, "values")
            for name, column in data.variables.items():
                if np.issubdtype(column.dtype, np.number):
                    variables[str(name)] = np.asarray(column, dtype=float), str(column.attrs.get("units", ""))
    except reading.Refused as refused:
        raise SceneError(str(refused), file=path) from refused
    return variables


def _seconds(values: Array, unit: str, departure: datetime.datetime | None, path: Path) -> Array:
    """Times in s after the departure."""
    match = re.fullmatch(r"(\w+?)s? since (\d{4}-\d{1,2}-\d{1,2})[T ]?(\d{1,2}:\d{2}(?::\d{2})?)?.*", unit.strip())
    if match is None:
        if unit.strip().rstrip("s") not in SECONDS or departure is not None:
            raise SceneError(f"time has unit {unit!r}, expected 'hours since 2020-01-01'", file=path, key="time")
        return np.asarray((values - values[0]) * SECONDS[unit.strip().rstrip("s")])
    if match[1] not in SECONDS:
        raise SceneError(f"time has unit {unit!r}, expected 'hours since 2020-01-01'", file=path, key="time")
    seconds = values * SECONDS[match[1]]
    if departure is None:
        return np.asarray(seconds - seconds[0])
    day = datetime.datetime.fromisoformat(
        "-".join(part.zfill(2) for part in match[2].split("-")) + "T" + (match[3] or "00:00").zfill(5)
    )
    aware = departure if departure.tzinfo else departure.replace(tzinfo=datetime.UTC)
    start = (aware - day.replace(tzinfo=datetime.UTC)).total_seconds()
    if not seconds[0] <= start <= seconds[-1]:
        raise SceneError(f"the departure {departure} lies outside the forecast, {(start - seconds[0]) / 3600.0:.1f} h after "
                         f"its start; it covers {(seconds[-1] - seconds[0]) / 3600.0:.1f} h", file=path, key="time")  # fmt: skip
    return np.asarray(seconds - start)


def _axis(values: Array, name: str, path: Path) -> Axis:
    """Ascending regular axis of given places."""
    v = np.sort(np.asarray(values, dtype=float).ravel())
    if not len(v) or not np.max(np.abs(v)) <= FARTHEST:
        raise SceneError(f"{name} has no values, or some that are no numbers below {FARTHEST:g}", file=path, key=name)
    if len(v) == 1:
        return Axis(float(v[0]), 1.0, 1)
    steps = np.diff(v)
    step = float(steps.mean())
    if not step > 0.0 or np.max(np.abs(steps - step)) > 1e-3 * step:
        raise SceneError(f"{name} is not equidistant", file=path, key=name)
    return Axis(float(v[0]), step, len(v))


def _filled(values: Array, missing: NDArray[np.bool_]) -> Array:
    """Missing values replaced by means of their neighbours, for the interpolation next to them."""
    filled = np.where(missing, math.nan, values)
    while np.isnan(filled).any():
        padded = np.pad(filled, ((0, 0), (1, 1), (1, 1)), constant_values=math.nan)
        near = np.stack([padded[:, 1 + j : padded.shape[1] - 1 + j, 1 + i : padded.shape[2] - 1 + i]
                         for j in (-1, 0, 1) for i in (-1, 0, 1)])  # fmt: skip
        known = np.isfinite(near)
        count = known.sum(axis=0)
        mean = np.where(known, near, 0.0).sum(axis=0) / np.maximum(count, 1)
        if not count.any(axis=(1, 2)).all():
            filled = np.where(np.isnan(filled), np.nanmean(filled), filled)
            break
        filled = np.where(np.isnan(filled) & (count > 0), mean, filled)
    return np.asarray(filled)


