"""One variable of one file in its canonical form: over (time, y, x), all ascending, SI, impossible values as no data.

Coordinates are found by CF standard name, units, or name. Further dimensions of length 1 are left out; of longer ones the
route file selects a value.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from towage.fmus.declare.quantities import QuantityError
from towage.routing.forecast import times as data_times
from towage.routing.forecast.contents import Contents, Variable
from towage.routing.forecast.meaning import Quantity, Wishes, sense
from towage.routing.forecast.times import Times
from towage.routing.forecast.units import expression, factor

Array = NDArray[np.float64]
_TIME = ("time", "valid_time", "t")
_PLACES: dict[bool, dict[str, tuple[str, tuple[str, ...]]]] = {
    True: {"y": ("latitude", ("latitude", "lat", "nav_lat")), "x": ("longitude", ("longitude", "lon", "nav_lon"))},
    False: {"y": ("projection_y_coordinate", ("y",)), "x": ("projection_x_coordinate", ("x",))},
}
"""Standard name and usual names of a coordinate, by whether the map is the globe."""
_LETTERS = {"y": "n", "x": "e"}
PACKED = 2.5e-4
"""Share of the possible range by which packed values may lie outside: 1 cm of a wave height."""


@dataclass(frozen=True)
class Layer:
    """``values`` (nt, ny, nx), nan where there are none, of ``variable``; ``y``, ``x`` ascending, degrees (longitudes in
    0 ... 360) or m. ``times`` is None where the file has none."""

    variable: Variable
    times: Times | None
    y: Array
    x: Array
    values: Array


def layer(
    contents: Contents, variable: Variable, quantity: Quantity, wishes: Wishes, globe: bool, notes: list[str]
) -> Layer:
    """The variable as a layer. Raises `SceneError` that names file, variable and attribute."""
    coordinates = _coordinates(contents, variable, globe)
    values, dims = variable.load(), list(variable.dims)
    for dim in [d for d in dims if d not in {c.dims[0] for c in coordinates.values()}]:
        axis = dims.index(dim)
        values = np.take(values, _chosen(contents, variable, dim, values.shape[axis], wishes), axis)
        dims.remove(dim)
    order = [dims.index(coordinates[role].dims[0]) for role in ("t", "y", "x") if role in coordinates]
    values = _si(np.transpose(values, order), variable, quantity, wishes, notes)
    times = data_times.read(coordinates["t"]) if "t" in coordinates else None
    if times is None:
        values = values[None]
    else:
        at = np.argsort(times.seconds, kind="stable")
        times, values = Times(times.seconds[at], times.calendar), values[at]
        again = np.diff(times.seconds) <= 0.0
        if again.any():
            raise coordinates["t"].fault("", f"the time {coordinates['t'].load().ravel()[at][int(np.argmax(again))]:g} stands "
                                         "there twice")  # fmt: skip
    y, values = _sorted(coordinates["y"], values, 1, globe)
    x, values = _sorted(coordinates["x"], values, 2, globe)
    return Layer(variable, times, y, x, values)


def _coordinates(contents: Contents, variable: Variable, globe: bool) -> dict[str, Variable]:
    """The coordinate variables of ``variable`` for y, x and, where there is one, t."""
    found: dict[str, Variable] = {}
    for role in ("t", "y", "x"):
        ranked = sorted(
            ((rank, v.name) for v in contents.values() if len(v.dims) == 1 and v.dims[0] in variable.dims
             and (rank := _rank(v, role, globe))), reverse=True,
        )  # fmt: skip
        if ranked:
            found[role] = contents[ranked[0][1]]
    for role in ("y", "x"):
        if role not in found:
            raise variable.fault("", _no_coordinate(contents, variable, role, globe))
    if found["y"].dims == found["x"].dims:
        raise variable.fault("", f"stands over single places (dimension {found['y'].dims[0]}), expected a grid")
    return found


def _rank(v: Variable, role: str, globe: bool) -> int:
    """How sure it is that a variable is the coordinate ``role``; 0: it is not."""
    standard, unit = v.text("standard_name"), v.text("units").lower()
    if role == "t":
        sure = standard == "time" or (" since " in unit and standard != "forecast_reference_time")
        return (2 if standard == "time" else 1) * sure + (v.name in _TIME) if sure or (v.name in _TIME and not standard) else 0
    name, names = _PLACES[globe][role]
    sure = standard == name or (globe and re.match(f"degrees?_?{_LETTERS[role]}", unit) is not None)
    usual = v.name.lower() in names and (not standard or standard == name)
    return 2 * sure + usual


def _no_coordinate(contents: Contents, variable: Variable, role: str, globe: bool) -> str:
    """Why there is no coordinate for ``role``."""
    name = _PLACES[globe][role][0]
    other = [v.name for v in contents.values() if _rank(v, role, not globe)]
    if other:
        kind = 'this needs map.kind = "sphere"' if not globe else 'a sphere needs latitude and longitude'
        return f"stands over {', '.join(other)}: {kind}"
    flat = [v.name for v in contents.values() if len(v.dims) > 1 and _rank(v, role, globe)]
    if flat:
        return (f"its {name} {flat[0]} has {len(contents[flat[0]].dims)} dimensions: a rotated or curved grid; bring it to "
                "regular latitudes and longitudes first (cdo remapbil, xesmf)")  # fmt: skip
    return (f"no coordinate for {name}: looked for standard_name {name} and for names {', '.join(_PLACES[globe][role][1])} "
            f"over one of {', '.join(variable.dims) or 'no dimensions'}; the file has {', '.join(sorted(contents))}")  # fmt: skip


def _chosen(contents: Contents, variable: Variable, dim: str, length: int, wishes: Wishes) -> int:
    """Which entry of a further dimension."""
    own = contents.get(dim)
    places = own.load().ravel() if own is not None and own.dims == (dim,) else np.arange(float(length))
    if dim in wishes.select:
        near = np.flatnonzero(np.isclose(places, wishes.select[dim], rtol=1e-6, atol=1e-9))
        if len(near) != 1:
            some = ", ".join(f"{place:g}" for place in places[:8])
            raise variable.fault(dim, f"{wishes.select[dim]:g} is not there; it has {some}{' ...' if length > 8 else ''}")
        return int(near[0])
    if length != 1:
        raise variable.fault("", f"has a further dimension {dim} of {length} entries; choose one: select = {{ {dim} = "
                             f"{places[0]:g} }}")  # fmt: skip
    return 0


def _si(values: Array, variable: Variable, quantity: Quantity, wishes: Wishes, notes: list[str]) -> Array:
    """SI values, nan for impossible ones; directions those they come from, but of a current those it goes to."""
    scale = unit_factor(variable, quantity.unit, wishes.units.get(quantity.name), notes, values)
    with np.errstate(invalid="ignore", over="ignore"):
        si = values * scale
        slack = PACKED * (quantity.high - quantity.low)
        wrong = (si < quantity.low - slack) | (si > quantity.high + slack)
    if wrong.any():
        known = np.isfinite(values)
        low, high = quantity.low / scale, quantity.high / scale
        shown = ", ".join(f"{value:g}" for value in np.unique(values[wrong])[:3])
        message = f"{int(wrong.sum())} of {int(known.sum())} values ({shown}) lie outside {low:g} to {high:g}, which nothing does"
        if wrong.sum() == known.sum():
            raise variable.fault("units", f"{message}: is {variable.text('units')!r} right?")
        notes.append(f"{variable.file.name}: {variable.name}: {message}: taken as no data")
        si = np.where(wrong, math.nan, si)
    if quantity.low == 0.0:
        si = np.maximum(si, 0.0)
    if quantity.sense and sense(variable, quantity, wishes, notes) != quantity.sense:
        si = si + math.pi
    return si


def unit_factor(variable: Variable, unit: str, wish: str | None, notes: list[str], values: Array) -> float:
    """What values are multiplied with to be ``unit``. Without an attribute ``units`` it is that of the route file (``wish``),
    or m, s, m/s and degrees, which is told."""
    given = variable.text("units")
    usual = "deg" if unit == "rad" else unit
    try:
        if wish and given and not math.isclose(factor(wish, unit), factor(given, unit), rel_tol=1e-12):
            raise variable.fault("units", f"the file says {given!r}, the route file {wish!r}")
        if given or wish:
            return factor(given or str(wish), unit)
    except QuantityError as error:
        raise variable.fault("units", f"{given or wish!r}: expected a unit as {usual!r} ({error})") from None
    if unit == "rad" and np.nanmax(np.abs(values), initial=0.0) <= 2.0 * math.pi:
        raise variable.fault("units", "is missing, and no value exceeds 2 pi: degrees or radians? Write units in the "
                             "route file")  # fmt: skip
    notes.append(f"{variable.file.name}: {variable.name}: no units: taken as {usual}")
    return factor(usual, unit)


def _sorted(coordinate: Variable, values: Array, axis: int, globe: bool) -> tuple[Array, Array]:
    """(places ascending, values with them); longitudes of the ``globe`` are degrees from 0 to 360, each once."""
    circle = globe and axis == 2
    raw = coordinate.load().ravel()
    if not np.all(np.isfinite(raw)):
        raise coordinate.fault("", f"{int(np.sum(~np.isfinite(raw)))} of {len(raw)} places are missing")
    unit = coordinate.text("units")
    wanted = "deg" if globe else "m"
    try:
        scale = factor(unit, wanted) if unit else 1.0
    except QuantityError as error:
        raise coordinate.fault("units", f"{unit!r}: expected a unit as {expression(wanted)!r} ({error})") from None
    places = raw * scale
    if circle:
        places = np.mod(places, 360.0)
        places[360.0 - places < 1e-9] = 0.0
    elif globe and np.max(np.abs(places)) > 90.0 + 1e-6:
        raise coordinate.fault("", f"a latitude of {places[np.argmax(np.abs(places))]:g} degrees, expected -90 to 90")
    at = np.argsort(places, kind="stable")
    places, values = places[at], np.take(values, at, axis)
    again = np.flatnonzero(np.diff(places) <= 1e-9)
    for k in again:
        if not circle or not np.array_equal(np.take(values, k, axis), np.take(values, k + 1, axis), equal_nan=True):
            raise coordinate.fault("", f"the place {places[k]:g} stands there twice, with different values")
    return np.delete(places, again), np.delete(values, again, axis)
