"""Gridded data on the plane of a route: waves, wind or a current as the fields that routes are computed in.

Data over latitude and longitude are carried over to a regular grid of the plane around the route by the kernel of
`models.route.grid`, at half their own mesh; those over x and y stay where they are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from towage.models.route.areas import Cells
from towage.models.route.grid import Axis, GridCurrent, GridField, Knots, Layers
from towage.models.route.maps import RouteMap, StereographicMap
from towage.routing.forecast.combine import Gridded, spread

Array = NDArray[np.float64]
Place = tuple[float, float]
LARGEST = 500
"""Most nodes of the plane's grid along one axis."""


@dataclass(frozen=True)
class OnPlane:
    """``layers`` (n, nt, ny, nx) on the plane, each a scalar; at ``latitude`` and ``longitude`` (ny, nx), rad, on the
    globe."""

    x: Axis
    y: Axis
    t: Axis | Knots
    layers: Array
    no_data: Cells | None
    nodes: tuple[Array, Array] | None


def carry(data: Gridded, scalars: list[Array], seconds: Array, plane: RouteMap, start: Place, end: Place) -> OnPlane:
    """Scalars (nt, ny, nx) of ``data`` onto the plane, with times ``seconds`` after the departure."""
    t = _times(seconds)
    source = [spread(values, data.gone) if data.gone.any() else values for values in scalars]
    if not isinstance(plane, StereographicMap):
        area = Cells(data.x.start, data.y.start, data.x.step, data.y.step, data.gone, "no data") if data.gone.any() else None
        return OnPlane(data.x, data.y, t, np.array(source), area, None)
    reach = 0.65 * math.dist(start, end)
    low = [min(a, b) - reach for a, b in zip(start, end)]
    size = [abs(a - b) + 2.0 * reach for a, b in zip(start, end)]
    scale = float(plane.scale(start[0], start[1])[0])
    mesh = max(0.5 * math.radians(data.y.step) * plane.radius * scale, max(size) / LARGEST)
    ax, ay = (Axis(a, mesh, math.ceil(s / mesh) + 1) for a, s in zip(low, size))
    x, y = np.meshgrid(ax.places, ay.places)
    latitude, longitude = plane.to_geographic(x, y)
    north = np.degrees(latitude)
    east = data.seam + np.mod(np.degrees(longitude) - data.seam, 360.0)
    still, zero = Axis(0.0, 1.0, 1), np.zeros(x.shape)
    layers = np.empty((len(source), t.count, ay.count, ax.count))
    for k in range(t.count):
        record = Layers(data.x, data.y, still, np.stack([values[k : k + 1] for values in source], axis=-1))
        layers[:, k] = record.values(east, north, zero)[0]
    cells = Cells(data.x.start, data.y.start, data.x.step, data.y.step, data.gone)
    bare = ~record.inside(east, north) | cells.contains(east, north)
    area = Cells(ax.start, ay.start, mesh, mesh, bare, "no data") if bare.any() else None
    return OnPlane(ax, ay, t, layers, area, (x, y))


def _times(seconds: Array) -> Axis | Knots:
    """A regular axis where the times are regular."""
    if len(seconds) == 1:
        return Axis(float(seconds[0]), 1.0, 1)
    step = np.diff(seconds)
    if np.ptp(step) < 1e-6 * step.mean():
        return Axis(float(seconds[0]), float(step.mean()), len(seconds))
    return Knots(seconds)


def directed(
    data: Gridded, size: Array, bearing: Array, period: Array | None, seconds: Array, plane: RouteMap, start: Place, end: Place
) -> tuple[GridField, Cells | None]:
    """A field of a size (height or speed) that comes from ``bearing``, rad clockwise from north."""
    scalars = [size, np.cos(bearing), np.sin(bearing)] + ([] if period is None else [period])
    found = carry(data, scalars, seconds, plane, start, end)
    north, east = found.layers[1], found.layers[2]
    if isinstance(plane, StereographicMap) and found.nodes:
        angle = plane.direction(*found.nodes, np.arctan2(east, north))
        along, across = np.cos(angle), np.sin(angle)
    else:  # x is east and y north
        along, across = east, north
    own = None if period is None else found.layers[3]
    return GridField(found.x, found.y, found.t, np.maximum(found.layers[0], 0.0), along, across, own), found.no_data


def flowing(
    data: Gridded, east: Array, north: Array, seconds: Array, plane: RouteMap, start: Place, end: Place
) -> tuple[GridCurrent, Cells | None]:
    """A current of components to the east and to the north, m/s."""
    found = carry(data, [east, north], seconds, plane, start, end)
    u, w = found.layers
    if isinstance(plane, StereographicMap) and found.nodes:
        angle, speed = plane.direction(*found.nodes, np.arctan2(u, w)), np.hypot(u, w)
        u, w = speed * np.cos(angle), speed * np.sin(angle)
    return GridCurrent(found.x, found.y, found.t, u, w), found.no_data
