"""The largest rate at which anything can be gained in a cell: the support function of all velocities that a ship may have there.

    M_k = max over heights, directions of the sea and currents in the cell of h(n_k),   n_k one of `AROUND` directions
    h(l) <= (sin(v_k+1 - v) M_k + sin(v - v_k) M_k+1) |l|/sin(v_k+1 - v_k)   for l at angle v between those of n_k and n_k+1

The second line holds because a support function is convex and homogeneous. Heights are looked up in steps: within one the support
is largest at an end, give or take what the polar can change in half a step (`polar.steepest`; nothing for tables, whose sets of
velocities are linear between levels, and whose supports so are convex). Directions of waves within an angle g of the middle
one move the support by at most 2 sin(g/2) times the largest speed. Beside waves a wind table takes the largest factor of the
waves from any side.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..numeric.arrays import AnyArray
from .hulls import SAMPLES, Tabled, TablePolar, WindWavePolar, circle
from .medium import OPS, Medium
from .polar import Polar, SmoothPolar
from .ranges import FlowRange, Mesh, SeaRange, current_anywhere, of_current, of_sea, sea_anywhere

AROUND = 72
ANGLES = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
TURN = 2.0 * math.pi / AROUND
STEPS = 1000
"""Of the heights."""


class Most:
    """The largest of a table (levels, ...) between two levels: of each step, then of 2, 4, ... steps on end."""

    def __init__(self, edges: AnyArray, rows: AnyArray, off: float) -> None:
        self.edges = edges
        margin = 0.5 * off * np.diff(edges).reshape(-1, *([1] * (rows.ndim - 1)))
        self.runs = [np.maximum(rows[1:], rows[:-1]) + margin if len(edges) > 1 else rows]
        while len(self.runs[-1]) > 2 ** (len(self.runs) - 1):
            last, n = self.runs[-1], 2 ** (len(self.runs) - 1)
            self.runs.append(np.maximum(last[:-n], last[n:]))

    def between(self, low: AnyArray, high: AnyArray, column: AnyArray | None = None) -> AnyArray:
        """The largest between two levels, (n,), in columns (..., n) of the rows where they have any."""
        places = np.searchsorted(self.edges, low, side="right"), np.searchsorted(self.edges, high, side="left")
        a, b = (np.clip(k - 1, 0, max(0, len(self.edges) - 2)) for k in places)
        b = np.maximum(a, b)
        run = np.floor(np.log2(b - a + 1)).astype(int)
        found = np.zeros(np.shape(low) if column is None else column.shape)
        for n in np.unique(run).tolist():
            here, rows = run == n, self.runs[n]
            ends = a[here], b[here] - 2**n + 1
            one, two = (rows[i] if column is None else rows[i, column[..., here]] for i in ends)
            found[..., here] = np.maximum(one, two)
        return found


class Supports:
    """Supports of a polar, relative to where waves or wind come from, over levels ``low`` to ``high``."""

    def __init__(self, polar: SmoothPolar | TablePolar, low: float, high: float) -> None:
        edges = np.unique(np.linspace(low, max(low, high), STEPS))
        off = 0.0
        if isinstance(polar, TablePolar):
            levels = polar.table.levels
            edges = np.unique(np.concatenate([edges, levels[(levels > low) & (levels < high)]]))
            rows = _of_table(polar, edges)
        else:
            a, b, c = (np.asarray(v)[:, None] for v in polar.axes(edges, OPS)[:3])
            rows = np.hypot(a * np.cos(ANGLES), b * np.sin(ANGLES)) - c * np.cos(ANGLES)
            off = polar.steepest
        self.most = Most(edges, rows, off)
        self.top = Most(edges, rows.max(axis=1), off)

    def of(self, given: SeaRange) -> AnyArray:
        """Supports in all directions, (AROUND, cells), of cells (cells,)."""
        place = np.mod(ANGLES[:, None] - given.angle, 2.0 * math.pi) / TURN
        k = np.floor(place).astype(int)
        parts = ((k % AROUND, k + 1.0 - place), ((k + 1) % AROUND, place - k))
        both = sum(np.sin(w * TURN) * self.most.between(given.low, given.high, at) for at, w in parts) / math.sin(TURN)
        speed = self.top.between(given.low, given.high) / math.cos(0.5 * TURN)
        return np.asarray(np.minimum(both + 2.0 * np.sin(0.5 * given.half) * speed, speed))


def _of_table(polar: TablePolar, edges: AnyArray) -> AnyArray:
    """Supports at levels, no smaller than those of the mixture of its neighbours in the table."""
    theta = circle(SAMPLES)
    turn = np.cos(ANGLES[:, None] - theta) / math.cos(math.pi / SAMPLES)
    own = np.array([np.max(turn * polar.speed_along(np.full(SAMPLES, level), theta), axis=1) for level in polar.table.levels])
    low, high, share = polar.table.cell(edges)
    return np.asarray((1.0 - share)[:, None] * own[low] + share[:, None] * own[high])


def of_cells(medium: Medium, mesh: Mesh, possible: AnyArray) -> AnyArray | None:
    """M, (AROUND, nx - 1, ny - 1): the largest over the slabs in which a cell is ``possible`` (nt - 1, nx - 1, ny - 1); 0 where
    in none. None where the field is of another make."""
    sea, flow = of_sea(medium.field, mesh), of_current(medium.current, mesh)
    wind = of_sea(medium.wind, mesh) if medium.wind else None
    if sea is None or flow is None or (medium.wind is not None and wind is None):
        return None
    scale = np.maximum.reduce([medium.map.scale(mesh.x, mesh.y)[0][a, b] for a in _ENDS for b in _ENDS])
    most: AnyArray = np.zeros((AROUND, *possible.shape[1:]))
    supports = _supports(medium.polar, sea, wind)
    for slab, here in enumerate(possible):
        if here.any():
            parts = [SeaRange(*(v[slab][here] for v in given)) for given in (sea, wind) if given is not None]
            own = supports(parts[0], parts[-1])
            own = own + _drift(FlowRange(*(v[slab][here] for v in flow)))
            most[:, here] = np.maximum(most[:, here], scale[here] * own)
    return most


_ENDS = (slice(None, -1), slice(1, None))


def _supports(polar: Polar, sea: SeaRange, wind: SeaRange | None) -> Callable[[SeaRange, SeaRange | None], AnyArray]:
    """(sea, wind) of cells -> supports."""
    if isinstance(polar, WindWavePolar):
        assert wind is not None
        steps = np.linspace(float(sea.low.min()), float(sea.high.max()) + 1e-9, STEPS)
        low, high, share = polar.waves.cell(steps)
        largest = polar.waves.values.max(axis=1)
        factors = Most(steps, (1.0 - share) * largest[low] + share * largest[high], 0.0)
        table = TablePolar(polar.wind.levels.tolist(), polar.wind.angles.tolist(), polar.wind.values.tolist(), "wind",
                           polar.wind.ends, "wind")  # fmt: skip
        over = Supports(table, float(wind.low.min()), float(wind.high.max()))

        def slowed(sea: SeaRange, wind: SeaRange | None) -> AnyArray:
            assert wind is not None
            return np.asarray(over.of(wind) * factors.between(sea.low, sea.high))

        return slowed
    by_wind = isinstance(polar, TablePolar) and polar.needs_wind
    given = wind if by_wind else sea
    assert given is not None
    only = Supports(polar, float(given.low.min()), float(given.high.max()))
    return lambda sea, wind: only.of(wind if by_wind and wind is not None else sea)


def _drift(flow: FlowRange) -> AnyArray:
    """Largest u.n_k, (AROUND, cells)."""
    c, s = np.cos(ANGLES)[:, None], np.sin(ANGLES)[:, None]
    return np.asarray(np.maximum(c * flow.u_low, c * flow.u_high) + np.maximum(s * flow.w_low, s * flow.w_high))


class Reach(NamedTuple):
    """Supports of the velocities over the ground, (AROUND,), m/s, anywhere and at any time, and what they may gain, 1/s, a metre
    of distance from a place."""

    supports: AnyArray
    growth: float

    def time(self, distance: AnyArray | float, scale: float = 1.0) -> AnyArray:
        """Time, s, that no ship is faster than over a ``distance`` from or to the place, m on a plane of a ``scale``: she goes
        away from it by v + growth r at most."""
        v = scale * max(float(self.supports.max()), 1e-9) / math.cos(0.5 * TURN)
        g = scale * self.growth
        return np.asarray(distance / v if g == 0.0 else np.log1p(g * np.maximum(distance, 0.0) / v) / g)


def anywhere(medium: Medium, place: tuple[float, float]) -> Reach | None:
    """How fast ships may be around a ``place``, however far; None for a field of another make."""
    level = sea_anywhere(medium.field, *place)
    wind = sea_anywhere(medium.wind, *place) if medium.wind else None
    flow = current_anywhere(medium.current, *place)
    if level is None or flow is None or (medium.wind is not None and wind is None):
        return None
    own = _supports(medium.polar, level[0], wind[0] if wind else None)(level[0], wind[0] if wind else None)
    rise = flow[1] + sum(part[1] * _steepest(medium.polar) for part in (level, wind) if part and part[1] > 0.0)
    return Reach(np.asarray(own + _drift(flow[0]))[:, 0], rise)


def _steepest(polar: Polar) -> float:
    """Change of the speed in any direction with the height, 1/s; without end for tables, which no field that grows has."""
    if isinstance(polar, Tabled):
        return math.inf
    a, b, c = (float(v) for v in polar.axes(1.0, OPS)[3:])
    return max(polar.steepest, max(abs(a), abs(b)) + abs(c))
