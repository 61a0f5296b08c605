"""Layers of several files and quantities on one grid and one series of times, without holes where they can be filled.

A record without values is left out, so that the field is interpolated in time over it. A place that lacks values in fewer
than half of the records takes them from the records before and after; one that lacks more has no data. All of it is told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage.errors import SceneError
from towage.models.route.grid import Axis
from towage.routing.forecast.layers import Layer

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
UNEVEN = 1e-3
"""Share of a step by which the places of a regular grid may be off it."""


@dataclass(frozen=True)
class Gridded:
    """``values`` by quantity, (nt, ny, nx) over regular ``y``, ``x`` (degrees or m) and ``seconds`` (nt,) in ``calendar``
    (empty: no times); ``gone`` (ny, nx) has no data. Longitudes are to be taken from ``seam`` on, degrees: in the middle of what
    the data leave out, or where two places more on either side close the circle."""

    values: dict[str, Array]
    y: Axis
    x: Axis
    seconds: Array
    calendar: str
    gone: Mask
    seam: float


def combine(layers: Mapping[str, Sequence[Layer]], globe: bool, notes: list[str]) -> Gridded:
    """One grid of all layers, by quantity. Raises `SceneError` where they do not fit together."""
    every = [each for group in layers.values() for each in group]
    first = every[0]
    for each in every[1:]:
        ours, theirs = (layer.times.calendar if layer.times else "none" for layer in (first, each))
        if ours != theirs:
            raise each.variable.fault("", f"times are {theirs}, those of {first.variable.file.name}: {first.variable.name} are "
                                      f"{ours}")  # fmt: skip
    y, x = (_union([getattr(each, name) for each in every]) for name in ("y", "x"))
    for group in layers.values():
        for name, union in (("y", y), ("x", x)):
            own = _union([getattr(each, name) for each in group])
            if len(own) != len(union):
                raise group[0].variable.fault(name, f"has {len(own)} places, all variables together have {len(union)}: "
                                              "variables of one table must stand on one grid")  # fmt: skip
    seconds = np.unique(np.concatenate([each.times.seconds for each in every if each.times] or [np.zeros(1)]))
    values = {name: _placed(group, seconds, y, x) for name, group in layers.items()}
    order, axis_x = _around(x) if globe else (np.arange(len(x)), x)
    rows, ay = _regular(y, "latitude" if globe else "y", first, notes)
    columns, ax = _regular(axis_x, "longitude" if globe else "x", first, notes)
    full = {name: np.full((len(seconds), ay.count, ax.count), math.nan) for name in values}
    for name, part in values.items():
        full[name][:, rows[:, None], columns] = part[:, :, order]
    calendar = first.times.calendar if first.times else ""
    full, seconds, gone = _filled(full, seconds, calendar, first.variable.file, notes)
    if globe and abs(ax.count * ax.step - 360.0) < 0.5 * ax.step:
        pad = ((0, 0), (2, 2))
        full = {name: np.pad(part, ((0, 0), *pad), mode="wrap") for name, part in full.items()}
        gone = np.pad(gone, pad, mode="wrap")
        ax = Axis(ax.start - 2.0 * ax.step, ax.step, ax.count + 4)
        seam = ax.start + ax.step
    else:
        seam = ax.start - 0.5 * (360.0 - (ax.end - ax.start))
    return Gridded(full, ay, ax, seconds, calendar, gone, seam)


def _union(lists: Sequence[Array]) -> Array:
    """All places, ascending, those nearer to each other than `UNEVEN` of a step once."""
    places = np.unique(np.concatenate(lists))
    if len(places) < 2:
        return places
    steps: Array = np.diff(places)
    near = steps < UNEVEN * np.median(np.diff(lists[0]) if len(lists[0]) > 1 else steps)
    return np.asarray(places[np.concatenate([[True], ~near])])


def _placed(group: Sequence[Layer], seconds: Array, y: Array, x: Array) -> Array:
    """The layers of one quantity on the union of all axes."""
    whole = np.full((len(seconds), len(y), len(x)), math.nan)
    for each in group:
        at = [_nearest(seconds, each.times.seconds) if each.times else np.arange(1), _nearest(y, each.y), _nearest(x, each.x)]
        place = np.ix_(*at)
        both = np.isfinite(whole[place]) & np.isfinite(each.values)
        if np.any(np.abs(whole[place][both] - each.values[both]) > 1e-9 * (1.0 + np.abs(each.values[both]))):
            others = ", ".join(other.variable.file.name for other in group if other is not each)
            raise each.variable.fault("", f"differs from {others} at the same places and times; give files that do not overlap")
        whole[place] = np.where(np.isfinite(each.values), each.values, whole[place])
    return whole


def _nearest(places: Array, wanted: Array) -> NDArray[np.intp]:
    """Indices of the places nearest to those wanted."""
    right = np.clip(np.searchsorted(places, wanted), 1, max(1, len(places) - 1))
    if len(places) == 1:
        return np.zeros(len(wanted), dtype=int)
    closer = np.abs(places[right] - wanted) < np.abs(places[right - 1] - wanted)
    return np.asarray(np.where(closer, right, right - 1))


def _around(longitude: Array) -> tuple[NDArray[np.intp], Array]:
    """(order, places): longitudes from behind their widest gap on, ascending."""
    gaps = np.diff(np.concatenate([longitude, longitude[:1] + 360.0]))
    first = (int(np.argmax(np.round(gaps, 6))) + 1) % len(longitude)
    if np.ptp(gaps) < UNEVEN * np.median(gaps):
        first = 0  # the whole circle
    order = np.roll(np.arange(len(longitude)), -first)
    places = longitude[order]
    return order, np.where(np.arange(len(places)) < len(places) - first, places, places + 360.0)


def _regular(places: Array, name: str, layer: Layer, notes: list[str]) -> tuple[NDArray[np.intp], Axis]:
    """(indices of the places on the axis, a regular axis), which may have more places than are given."""
    if len(places) < 2:
        raise layer.variable.fault(name, "has one place, expected a grid of at least two")
    steps = np.diff(places)
    step = float(np.min(steps))
    parts = np.round(steps / step)
    step = float((places[-1] - places[0]) / parts.sum())
    index = np.concatenate([[0], np.cumsum(parts)]).astype(int)
    if np.max(np.abs(places - places[0] - step * index)) > UNEVEN * step * math.sqrt(len(places)) or len(index) * 8 < index[-1]:
        raise layer.variable.fault(name, f"is not equidistant: steps from {steps.min():g} to {steps.max():g}")
    if len(index) <= index[-1]:
        notes.append(f"{layer.variable.file.name}: {name}: {int(index[-1]) + 1 - len(index)} of {int(index[-1]) + 1} places are "
                     "missing: no data there")  # fmt: skip
    return index, Axis(float(places[0]), step, int(index[-1]) + 1)


def _filled(
    values: dict[str, Array], seconds: Array, calendar: str, file: Path, notes: list[str]
) -> tuple[dict[str, Array], Array, Mask]:
    """Holes in time filled and told; where they cannot be, ``gone``, with means of the neighbours as values."""
    missing = np.any([~np.isfinite(part) for part in values.values()], axis=0)
    empty = missing.all(axis=(1, 2))
    if empty.all():
        some = [name for name, part in values.items() if not np.isfinite(part).any()]
        raise SceneError(f"every value of {some[0] if some else ' or '.join(values)} is missing", file=file)
    if empty.any():
        at = ", ".join(_hours(s, seconds) for s in seconds[empty][:4])
        notes.append(f"{file.name}: {int(empty.sum())} of {len(empty)} records have no values ({at}): interpolated in time, or "
                     "cut off at an end")  # fmt: skip
        values, seconds, missing = {k: v[~empty] for k, v in values.items()}, seconds[~empty], missing[~empty]
    if calendar and len(seconds) > 1:
        _tell_gaps(seconds, file, notes)
    share = missing.mean(axis=0)
    gone = share >= 0.5
    if gone.all():
        raise SceneError("no place has values in more than half of the records: nothing is left to sail in", file=file)
    some = missing & ~gone
    if some.any():
        longest = _longest(some, seconds) / 3600.0
        notes.append(f"{file.name}: {int(some.any(axis=0).sum())} places lack {int(some.sum())} values for up to {longest:g} h: "
                     "filled in time")  # fmt: skip
        values = {name: _in_time(part, some, seconds, name == "direction") for name, part in values.items()}
    if gone.any():
        notes.append(f"{file.name}: {gone.mean():.1%} of its places have no data (land, or holes): forbidden")
    return values, seconds, gone


def _hours(second: float, seconds: Array) -> str:
    return f"{(second - seconds[0]) / 3600.0:g} h"


def _tell_gaps(seconds: Array, file: Path, notes: list[str]) -> None:
    """Say where records are wider apart than on both sides, and where their step changes."""
    step = np.diff(seconds)
    beside = np.stack([np.concatenate([step[1:2] if len(step) > 1 else step, step[:-1]]),
                       np.concatenate([step[1:], step[-2:-1] if len(step) > 1 else step])])  # fmt: skip
    gap = step > 1.5 * beside.max(axis=0)
    for k in np.flatnonzero(gap)[:4]:
        notes.append(f"{file.name}: no records between {_hours(seconds[k], seconds)} and {_hours(seconds[k + 1], seconds)} after "
                     f"its start, where they come every {beside[:, k].max() / 3600.0:g} h: interpolated in time")  # fmt: skip
    rest = step[~gap]
    if len(rest) and np.ptp(rest) > 1e-3 * rest.min():
        notes.append(f"{file.name}: records come every {rest.min() / 3600.0:g} to {rest.max() / 3600.0:g} h")


def _longest(missing: Mask, seconds: Array) -> float:
    """Longest time for which a place has no values, s."""
    last, longest = np.full(missing.shape[1:], seconds[0]), 0.0
    for k, second in enumerate(seconds):
        longest = max(longest, float(np.max(np.where(missing[k], second - last, 0.0))))
        last = np.where(missing[k], last, second)
    return longest


def _in_time(values: Array, some: Mask, seconds: Array, angle: bool) -> Array:
    """``values`` with those marked interpolated in time between records; held at the ends."""
    filled = values.copy()
    for j, i in zip(*np.nonzero(some.any(axis=0))):
        hole, column = some[:, j, i], values[:, j, i]
        known = ~hole
        given = np.unwrap(column[known]) if angle else column[known]
        filled[hole, j, i] = np.interp(seconds[hole], seconds[known], given)
    return filled


REACH = 4
"""Meshes beyond known values that interpolation looks at, and one more."""


def spread(values: Array, gone: Mask) -> Array:
    """(nt, ny, nx) with means of their neighbours at the places ``gone`` that are at most `REACH` meshes from known ones, for the
    interpolation next to them; further ones, which nothing looks at, get the mean of the record."""
    filled = np.where(gone, math.nan, values)
    ny, nx = gone.shape
    for _ in range(REACH):
        padded = np.pad(filled, ((0, 0), (1, 1), (1, 1)), constant_values=math.nan)
        total, count = np.zeros_like(filled), np.zeros_like(filled)
        for j in range(3):
            for i in range(3):
                near = padded[:, j : j + ny, i : i + nx]
                known = np.isfinite(near)
                total, count = total + np.where(known, near, 0.0), count + known
        filled = np.where(np.isnan(filled) & (count > 0), total / np.maximum(count, 1), filled)
    known = np.isfinite(filled)
    mean = np.where(known, filled, 0.0).sum(axis=(1, 2)) / np.maximum(known.sum(axis=(1, 2)), 1)
    return np.where(known, filled, mean[:, None, None])
