"""What a sea, a wind or a current can be anywhere in a cell of a mesh, at any time of a slab: bounds, not samples.

    |f - I f| <= (2 d^2 f_ss + s^2 f_tt)/8

| symbol | meaning | unit |
|---|---|---|
| I f | multilinear between the eight corners of a square cell and a slab of time | any |
| d, s | side of the cell, length of the slab | m, s |
| f_ss, f_tt | bounds of the second derivatives along any direction of the plane, and in time, within them | any/m^2, any/s^2 |

so that f lies between the least and the largest corner, give or take the right side. Second derivatives of Gaussian storms have
closed bounds over distances; those of gridded data are linear between nodes along their own axis, and are bounded along the other
ones by the coefficients of Bernstein. Where a cell leaves the data all values of the data are possible. Directions lie within an
angle about that of the mean vector; where the vector may vanish, all are possible.

Source: the error of multilinear interpolation, P. J. Davis, Interpolation and Approximation (1975), chapter 3, axis by axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numeric.arrays import AnyArray
from .fields import Current, Field, LinearCurrent, LinearField, StormField, Storms, UniformField
from .grid import KERNEL, GridCurrent, GridField, Knots, Layers

BERNSTEIN = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 1.0 / 3.0, 0.0, 0.0], [1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
"""Coefficients of a cubic in Bernstein's basis from those of 1, s, s^2, s^3."""
SUM = 4.0 / 3.0
"""Bound of the sum of the absolute weights of the kernel of a grid."""
CURVED, TURNED = 2.0 * math.exp(-1.5), 2.5
"""Largest second derivatives, in sizes of a storm, of its height beyond one size, and of its swirl anywhere."""


class Mesh(NamedTuple):
    """Nodes ``x``, ``y`` (nx, ny), m, of square cells of ``side``; instants ``t`` (nt,), s, between which slabs lie."""

    x: AnyArray
    y: AnyArray
    t: AnyArray
    side: float

    def centres(self, values: AnyArray) -> AnyArray:
        """Means of the corners of every cell, (nx - 1, ny - 1)."""
        return np.asarray(0.25 * (values[1:, 1:] + values[1:, :-1] + values[:-1, 1:] + values[:-1, :-1]))


class SeaRange(NamedTuple):
    """Of every cell in every slab, (nt - 1, nx - 1, ny - 1): least and largest height, m, and directions within ``half`` of
    ``angle``, rad."""

    low: AnyArray
    high: AnyArray
    angle: AnyArray
    half: AnyArray


class FlowRange(NamedTuple):
    """Of every cell in every slab: least and largest components, m/s."""

    u_low: AnyArray
    u_high: AnyArray
    w_low: AnyArray
    w_high: AnyArray


def of_sea(field: Field, mesh: Mesh) -> SeaRange | None:
    """Heights and directions; None for a field of another make."""
    if isinstance(field, (UniformField, LinearField)):
        height = field.at(*_nodes(mesh)).height
        zero = 0.0 * _low(height)
        return SeaRange(_low(height), _high(height), zero + field.angle, zero)
    if isinstance(field, StormField):
        field = Storms(field.background, (field,), field.angle)
    if isinstance(field, Storms):
        height, wx, wy = (part[0] for part in field.parts(*_nodes(mesh)))
        curved, turned = _storm_bends(field, mesh)
        angle, half = _directions(wx, wy, turned) if turned.any() else (0.0 * curved + field.angle, 0.0 * curved)
        return SeaRange(_low(height) - curved, _high(height) + curved, angle, half)
    if isinstance(field, GridField):
        low, high, (_, wx, wy), bends = _grid(field.layers, mesh, 3)
        return SeaRange(low[0], high[0], *_directions(wx, wy, np.hypot(bends[1], bends[2])))
    return None


def of_current(current: Current, mesh: Mesh) -> FlowRange | None:
    """Components; None for a current of another make."""
    if isinstance(current, LinearCurrent):
        flow = current.at(*_nodes(mesh))
        u, w = (part + 0.0 * mesh.t[:, None, None] for part in flow[:2])
        return FlowRange(_low(u), _high(u), _low(w), _high(w))
    if isinstance(current, GridCurrent):
        low, high, _, _ = _grid(current.layers, mesh, 2)
        return FlowRange(low[0], high[0], low[1], high[1])
    return None


def sea_anywhere(field: Field, x: float, y: float) -> tuple[SeaRange, float] | None:
    """(range, growth): heights and directions at all times and places; beyond them, by ``growth`` a metre of distance from
    (``x``, ``y``), further heights. None for a field of another make."""
    swirls, growth, angle = False, 0.0, 0.0
    if isinstance(field, (UniformField, LinearField)):
        low = high = float(field.at(*(np.array([v]) for v in (x, y, 0.0))).height[0])
        growth, angle = math.hypot(*field.gradient) if isinstance(field, LinearField) else 0.0, field.angle
    elif isinstance(field, (StormField, Storms)):
        storms = field.storms if isinstance(field, Storms) else (field,)
        low, high = (field.background + sum(pick(storm.peak, 0.0) for storm in storms) for pick in (min, max))
        swirls, angle = any(storm.swirl for storm in storms), field.angle
    elif isinstance(field, GridField):
        low, high = (float(v[0]) for v in _whole(field.layers))
        swirls = True
    else:
        return None
    return SeaRange(*(np.array([v]) for v in (low, high, angle, math.pi if swirls else 0.0))), growth


def current_anywhere(current: Current, x: float, y: float) -> tuple[FlowRange, float] | None:
    """As `sea_anywhere`; growth in m/s a metre."""
    if isinstance(current, LinearCurrent):
        u, w = (float(v[0]) for v in current.at(*(np.array([v]) for v in (x, y, 0.0)))[:2])
        return FlowRange(*(np.array([v]) for v in (u, u, w, w))), float(np.linalg.norm(current.gradient))
    if isinstance(current, GridCurrent):
        lows, highs = _whole(current.layers)
        return FlowRange(*(np.array([float(v)]) for v in (lows[0], highs[0], lows[1], highs[1]))), 0.0
    return None


def still(part: Field | Current) -> bool:
    """Whether it is the same at all times."""
    if isinstance(part, (GridField, GridCurrent)):
        return part.layers.t.count == 1
    storms = part.storms if isinstance(part, Storms) else (part,) if isinstance(part, StormField) else ()
    return all(storm.velocity == (0.0, 0.0) for storm in storms)


def _nodes(mesh: Mesh) -> tuple[AnyArray, AnyArray, AnyArray]:
    """x, y, t of all nodes at all instants, (nt, nx, ny)."""
    x, y, t = np.broadcast_arrays(mesh.x[None], mesh.y[None], mesh.t[:, None, None])
    return x, y, t


def _corners(values: AnyArray) -> list[AnyArray]:
    """The eight corners of every cell and slab."""
    ends = (slice(None, -1), slice(1, None))
    return [values[a, b, c] for a in ends for b in ends for c in ends]


def _low(values: AnyArray) -> AnyArray:
    return np.asarray(np.minimum.reduce(_corners(values)))


def _high(values: AnyArray) -> AnyArray:
    return np.asarray(np.maximum.reduce(_corners(values)))


def _directions(wx: AnyArray, wy: AnyArray, bend: AnyArray) -> tuple[AnyArray, AnyArray]:
    """(angle, half) of a vector at the nodes that lies off its interpolation by at most ``bend``."""
    xs, ys = _corners(wx), _corners(wy)
    angle = np.arctan2(sum(ys), sum(xs))
    c, s = np.cos(angle), np.sin(angle)
    along = np.minimum.reduce([c * x + s * y for x, y in zip(xs, ys)]) - bend
    across = np.maximum.reduce([np.abs(c * y - s * x) for x, y in zip(xs, ys)]) + bend
    return angle, np.where(along > 0.0, np.arctan2(across, np.maximum(along, 1e-300)), math.pi)


def _storm_bends(field: Storms, mesh: Mesh) -> tuple[AnyArray, AnyArray]:
    """How far height, m, and direction vector lie off their interpolation."""
    x, y = mesh.centres(mesh.x), mesh.centres(mesh.y)
    middle, slab = 0.5 * (mesh.t[1:] + mesh.t[:-1])[:, None, None], np.diff(mesh.t)[:, None, None]
    curved, turned = 0.0 * (x + middle), 0.0 * (x + middle)
    for storm in field.storms:
        speed = math.hypot(*storm.velocity)
        dx, dy = (v - c - u * middle for v, c, u in zip((x, y), storm.centre, storm.velocity))
        reach = mesh.side / math.sqrt(2.0) + 0.5 * speed * slab
        r = np.maximum(0.0, np.hypot(dx, dy) - reach) / storm.sigma
        size = (2.0 * mesh.side**2 + (speed * slab) ** 2) / (8.0 * storm.sigma**2)
        e = np.exp(-0.5 * r * r)
        # |(s.r)^2 - 1| e for unit s, from r on outwards; e (r + 1) and its slopes for the swirl
        steepest = np.where(r < math.sqrt(3.0), np.maximum(np.maximum(1.0, r * r - 1.0) * e, CURVED), (r * r - 1.0) * e)
        curved = curved + abs(storm.peak) * size * steepest
        if storm.swirl:
            far = (np.maximum(1.0, r * r - 1.0) * (r + 1.0) + 2.0 * r) * e
            turned = turned + size * np.where(r < 2.0, TURNED, far)
    return curved, turned


def _grid(layers: Layers, mesh: Mesh, count: int) -> tuple[list[AnyArray], list[AnyArray], list[AnyArray], list[AnyArray]]:
    """Of the first ``count`` quantities of a grid: least and largest values over cells and slabs, the values at the nodes, and
    how far they lie off the interpolation."""
    from scipy.ndimage import maximum_filter

    values = np.stack([layers.values(mesh.x, mesh.y, np.full(mesh.x.shape, t))[0, :count] for t in mesh.t.tolist()], axis=1)
    space, time = _second_derivatives(layers, count)
    x, y = mesh.centres(mesh.x), mesh.centres(mesh.y)
    i, j = layers.x.place(x.ravel())[0].reshape(x.shape), layers.y.place(y.ravel())[0].reshape(x.shape)
    first, last = layers.t.place(mesh.t[:-1])[0], layers.t.place(mesh.t[1:])[0]
    slab = np.diff(mesh.t)
    known = layers.inside(mesh.x, mesh.y)
    whole = known[1:, 1:] & known[1:, :-1] & known[:-1, 1:] & known[:-1, :-1]
    lows, highs = _whole(layers)
    bends: list[AnyArray] = []
    for n in range(count):
        rows = []
        for a, b, s in zip(first.tolist(), last.tolist(), slab.tolist()):
            most = (2.0 * mesh.side**2 * space[n, a : b + 1].max(axis=0) + s * s * time[n, a : b + 1].max(axis=0)) / 8.0
            rows.append(np.where(whole, maximum_filter(most, 3, mode="nearest")[j, i], highs[n] - lows[n]))
        bends.append(np.array(rows))
    low = [np.where(whole, _low(v) - b, lo) for v, b, lo in zip(values, bends, lows)]
    high = [np.where(whole, _high(v) + b, hi) for v, b, hi in zip(values, bends, highs)]
    return low, high, list(values), bends


def _whole(layers: Layers) -> tuple[AnyArray, AnyArray]:
    """Least and largest values of every quantity, (n,), anywhere and at any time."""
    data = layers._data.reshape(-1, layers._data.shape[-1])
    low, high = data.min(axis=0), data.max(axis=0)
    spread = 0.5 * (high - low) * SUM * SUM * _time_sum(layers)
    return 0.5 * (low + high) - spread, 0.5 * (low + high) + spread


def _kernels(layers: Layers) -> AnyArray:
    """Powers by weights of every interval of time, (intervals, 4, 4)."""
    if isinstance(layers.t, Knots):
        return layers.t._kernels
    return np.broadcast_to(KERNEL, (max(1, layers.t.count - 1), 4, 4))


def _time_sum(layers: Layers) -> float:
    """Bound of the sum of the absolute weights in time."""
    return 1.0 if layers.t.count == 1 else float(np.abs(BERNSTEIN @ _kernels(layers)).sum(axis=-1).max())


def _second_derivatives(layers: Layers, count: int) -> tuple[AnyArray, AnyArray]:
    """Bounds of the second derivatives in space along any direction, and in time, of the cells of the grid and the intervals of
    time, (count, nt, ny, nx) each."""
    data = np.moveaxis(layers._data[..., :count], -1, 0)
    if layers.t.count == 1:
        data = data[:, 1:2]
    hx, hy = layers.x.step, layers.y.step
    xx = SUM * _spread(_bent(data, 3), 2) / hx**2
    yy = SUM * _spread(_bent(data, 2), 3) / hy**2
    xy = np.maximum.reduce([np.abs(v) for u in _slopes(data, 3) for v in _slopes(u, 2)]) / (hx * hy)
    space = np.maximum(xx, yy) + xy  # of a symmetric matrix no more than its largest diagonal entry and the other
    if layers.t.count == 1:
        return space, 0.0 * space
    near = np.lib.stride_tricks.sliding_window_view(data, 4, axis=1)
    kernels = _kernels(layers)
    steps = np.diff(layers.t.places)[:, None, None]
    ends = [np.einsum("thyxj,hj->thyx", near, row) for row in (2.0 * kernels[:, 2], 2.0 * kernels[:, 2] + 6.0 * kernels[:, 3])]
    bent = np.maximum(*map(np.abs, ends)) / steps**2
    time = SUM * SUM * _spread(_spread(bent, 2), 3)
    return _time_sum(layers) * _spread(space, 1), time


def _windows(values: AnyArray, axis: int) -> list[AnyArray]:
    """Four neighbours along an axis."""
    n = values.shape[axis] - 3
    return [np.take(values, range(k, k + n), axis=axis) for k in range(4)]


def _bent(values: AnyArray, axis: int) -> AnyArray:
    """Largest second derivative of the kernel's cubic, times the square of the mesh."""
    a, b, c, d = _windows(values, axis)
    return np.maximum(np.abs(2.0 * a - 5.0 * b + 4.0 * c - d), np.abs(-a + 4.0 * b - 5.0 * c + 2.0 * d))


def _slopes(values: AnyArray, axis: int) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Coefficients of Bernstein of the first derivative, times the mesh."""
    a, b, c, d = _windows(values, axis)
    return 0.5 * (c - a), 0.5 * (a - d) + 2.5 * (c - b), 0.5 * (d - b)


def _spread(values: AnyArray, axis: int) -> AnyArray:
    """The largest of four neighbours along an axis."""
    return np.asarray(np.maximum.reduce(_windows(values, axis)))
