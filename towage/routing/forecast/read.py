"""Waves, wind and currents of data files, as fields on the plane of a route.

    field, no_data = waves(files, Wishes(), Frame(plane, start, end, departure), notes)

Time 0 is the departure, or the first time in the files where none is given. What was assumed, left out or filled goes into
``notes``, sentences for people. Every fault is a `SceneError` that names file, variable and attribute.
"""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage.errors import SceneError
from towage.models.route.areas import Cells
from towage.models.route.grid import GridCurrent, GridField
from towage.models.route.maps import FlatMap, RouteMap
from towage.routing.forecast import plane as on_plane
from towage.routing.forecast import times as data_times
from towage.routing.forecast.combine import Gridded, combine
from towage.routing.forecast.contents import opened
from towage.routing.forecast.layers import Layer, layer
from towage.routing.forecast.meaning import CURRENT, WAVES, WIND, Quantity, Wishes, find, missing

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The plane, start and end on it, m, and the departure."""

    plane: RouteMap
    start: tuple[float, float]
    end: tuple[float, float]
    departure: datetime.datetime | None = None


def waves(files: Sequence[Path], wishes: Wishes, frame: Frame, notes: list[str]) -> tuple[GridField, Cells | None]:
    """Height, direction and, where there is one, peak period; and the area without data."""
    data = _gridded(files, WAVES, (("height", "direction"),), ("period",), wishes, frame, notes)
    values = data.values
    return on_plane.directed(data, values["height"], values["direction"], values.get("period"),
                             _after_departure(data, frame, files[0], notes), frame.plane, frame.start, frame.end)  # fmt: skip


def wind(files: Sequence[Path], wishes: Wishes, frame: Frame, notes: list[str]) -> tuple[GridField, Cells | None]:
    """The true wind: its speed, m/s, as ``height``, and where it comes from; and the area without data."""
    data = _gridded(files, WIND, (("u", "v"), ("speed", "direction")), (), wishes, frame, notes)
    if "u" in data.values:
        size, bearing = np.hypot(data.values["u"], data.values["v"]), np.arctan2(-data.values["u"], -data.values["v"])
    else:
        size, bearing = data.values["speed"], data.values["direction"]
    return on_plane.directed(data, size, bearing, None, _after_departure(data, frame, files[0], notes), frame.plane,
                             frame.start, frame.end)  # fmt: skip


def current(files: Sequence[Path], wishes: Wishes, frame: Frame, notes: list[str]) -> tuple[GridCurrent, Cells | None]:
    """The surface current, and the area without data."""
    data = _gridded(files, CURRENT, (("u", "v"), ("speed", "direction")), (), wishes, frame, notes)
    if "u" in data.values:
        east, north = data.values["u"], data.values["v"]
    else:
        east = data.values["speed"] * np.sin(data.values["direction"])
        north = data.values["speed"] * np.cos(data.values["direction"])
    seconds = _after_departure(data, frame, files[0], notes)
    return on_plane.flowing(data, east, north, seconds, frame.plane, frame.start, frame.end)


def _gridded(
    files: Sequence[Path], quantities: tuple[Quantity, ...], ways: tuple[tuple[str, ...], ...], more: tuple[str, ...],
    wishes: Wishes, frame: Frame, notes: list[str],
) -> Gridded:
    """The quantities of the first of ``ways`` that the files have all of, and of ``more`` what there is."""
    globe = not isinstance(frame.plane, FlatMap)
    known = {quantity.name: quantity for quantity in quantities}
    layers: dict[str, list[Layer]] = {}
    seen: dict[str, str] = {}
    for file in files:
        with opened(file, notes) as groups:
            for contents in groups:
                for name, quantity in known.items():
                    variable = find(contents, quantity, wishes)
                    if variable is None:
                        seen.setdefault(name, missing(contents, quantity, wishes))
                    else:
                        layers.setdefault(name, []).append(layer(contents, variable, quantity, wishes, globe, notes))
    for way in ways:
        if all(name in layers for name in way):
            return combine({name: layers[name] for name in (*way, *more) if name in layers}, globe, notes)
    way = max(ways, key=lambda names: sum(name in layers for name in names))
    raise SceneError("; ".join(seen[name] for name in way if name not in layers), file=files[0])


def _after_departure(data: Gridded, frame: Frame, file: Path, notes: list[str]) -> Array:
    """Times in s after the departure."""
    seconds, departure = data.seconds, frame.departure
    if not data.calendar:
        notes.append(f"{file.name} has no times: the field stands still")
        return np.zeros(1)
    if departure is None:
        return np.asarray(seconds - seconds[0])
    if data.calendar == "relative":
        raise SceneError("its times have no origin: expected units as 'hours since 2020-01-01' for a voyage with a departure",
                         file=file, key="time")  # fmt: skip
    try:
        start = data_times.departure_seconds(departure, data.calendar)
    except ValueError as error:
        raise SceneError(f"the departure {departure} is no day of its calendar {data.calendar}: {error}", file=file,
                         key="time") from None  # fmt: skip
    if departure.tzinfo is None:
        notes.append(f"the departure {departure} names no zone: taken as UTC")
    if len(seconds) > 1 and not seconds[0] <= start <= seconds[-1]:
        raise SceneError(f"the departure {departure} lies outside the forecast, {(start - seconds[0]) / 3600.0:.1f} h after its "
                         f"start; it covers {(seconds[-1] - seconds[0]) / 3600.0:.1f} h", file=file, key="time")  # fmt: skip
    return np.asarray(seconds - start)
