"""Global start: Dijkstra's method on a time-dependent lattice, and the refinement of its path in a corridor.

    leg time = d mean(1/v) over the two Gauss points of the leg, v the speed the ship makes good along it

A lattice of mesh D/``cells`` lies along the line from start to end (D apart). Each node has legs to all nodes within
``radius`` meshes that are not hidden behind another. As waiting never helps (`medium`), the earliest arrival is
found in one sweep, whatever the field does with time. Limits (`limits`) are kept on the earliest way to every place alone: a
ship that would have to wait for the sea to pass is told to leave later. The result is too long by the angles that the lattice
lacks, whatever the mesh: 6 % for radius 1, 0.3 % for 3, 0.08 % for 5, 0.03 % for 8.

`refine` then moves the points of a path sideways: at every station 9 places across the path, earliest arrival by
dynamic programming from station to station, the spacing halved once nothing moves. It needs only speeds along legs, so
it serves forbidden areas and tables with hull chords; its error is that of legs of finite length, of the order of
(turn per leg)^2/12: 1e-4 and less of the time with 192 stations.

Assumptions: those of `medium` and `nodes`.

Source: E. W. Dijkstra, Numer. Math. 1 (1959) 269-271; E. Kaufman, R. L. Smith, IVHS J. 1 (1993) 1-11 (first in, first
out). The errors by radius are measured on the test problems.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..numeric.arrays import AnyArray
from .areas import Area, blocked
from .limits import exceeded
from .medium import Medium
from .nodes import lattice

Point = tuple[float, float]
GAUSS = (0.5 - math.sqrt(1.0 / 12.0), 0.5 + math.sqrt(1.0 / 12.0))
SLOWEST = 1e-3
"""A speed along a leg below this, m/s, counts as none."""

LONGER = 1e-6
"""Share by which a straight way may take longer than one of many legs: directions of a hull are 1/20 degree apart."""


@dataclass(frozen=True)
class Path:
    """Points (n, 2), m, and times of arrival (n,), s."""

    points: AnyArray
    times: AnyArray

    @property
    def duration(self) -> float:
        """Time of the last arrival, s."""
        return float(self.times[-1])


def leg_times(
    medium: Medium, t: AnyArray, x0: AnyArray, y0: AnyArray, x1: AnyArray, y1: AnyArray, areas: Sequence[Area], hint: float
) -> AnyArray:
    """Duration of straight legs that start at ``t``, s; infinite where an area, the end of the data, the sea or a limit is in
    the way. All arrays broadcast; ``hint`` is a likely duration per length, s/m."""
    dx, dy = x1 - x0, y1 - y0
    d = np.hypot(dx, dy)
    still = d == 0.0
    length = np.where(still, 1.0, d)
    px, py = dx / length, dy / length
    spent: AnyArray = np.zeros(np.broadcast(t, d).shape)
    guess = hint * d + 0.0 * spent
    for place in GAUSS:
        v = medium.speed_along(t + place * guess, x0 + place * dx, y0 + place * dy, px + 0.0 * t, py + 0.0 * t)
        part = np.where(v > SLOWEST, d / np.maximum(v, SLOWEST), math.inf)
        spent = spent + 0.5 * part
        guess = np.where(np.isfinite(part), part, guess)
    out = ~(medium.inside(x1 + 0.0 * t, y1 + 0.0 * t))
    if areas:
        out = out | blocked(areas, x0 + 0.0 * x1, y0 + 0.0 * y1, x1, y1)
    if medium.limits:
        out = out | exceeded(medium, t, np.where(out, math.inf, spent), x0, y0, dx, dy)
    return np.where(still, 0.0, np.where(out, math.inf, spent))


def search(
    medium: Medium, start: Point, end: Point, areas: Sequence[Area] = (), *, cells: int = 20, radius: int = 3,
    width: float = 0.55, behind: float = 0.15,
) -> Path | None:
    """Earliest arrival over a lattice of ``cells`` meshes from start to end, ``width`` D to either side and ``behind``
    D beyond both ends, and over places beside areas (`nodes`). None if no way leads to the end."""
    nodes = lattice(start, end, areas, cells, radius, width, behind)
    x, y, target = nodes.x, nodes.y, nodes.target
    here, distance = np.zeros(1), math.dist(start, end)
    ex, ey = (end[0] - start[0]) / distance, (end[1] - start[1]) / distance
    top = medium.speed_along(here, here + start[0], here + start[1], here + ex, here + ey)[0]
    hint = 1.0 / max(float(top), 1.0)
    arrival = np.full(len(x), math.inf)
    before = np.full(len(x), -1)
    settled = np.zeros(len(x), dtype=bool)
    arrival[nodes.source] = 0.0
    queue = [(0.0, nodes.source)]
    while queue:
        t, node = heapq.heappop(queue)
        if settled[node]:
            continue
        if node == target:
            break
        settled[node] = True
        ahead = nodes.ahead(node)
        ahead = ahead[~settled[ahead]]
        if not len(ahead):
            continue
        one = np.ones(len(ahead))
        reach = t + leg_times(medium, t * one, x[node] * one, y[node] * one, x[ahead], y[ahead], areas, hint)
        better = reach < arrival[ahead]
        for n, time in zip(ahead[better].tolist(), reach[better].tolist()):
            arrival[n] = time
            before[n] = node
            heapq.heappush(queue, (time, n))
    if not np.isfinite(arrival[target]):
        return None
    chain = [target]
    while chain[-1] != nodes.source:
        chain.append(int(before[chain[-1]]))
    chain.reverse()
    return Path(np.column_stack([x[chain], y[chain]]), arrival[chain])


def refine(
    medium: Medium, path: Path, areas: Sequence[Area] = (), *, levels: Sequence[int] = (24, 48, 96, 192), reach: int = 4,
    finest: float = 2e-5, passes: int = 30,
) -> Path:
    """Move a path of `search` sideways to a local minimum, with more and more stations (``levels``); the spacing ends at
    ``finest`` of the length, coarser on the coarser levels. At most ``passes`` sweeps a level."""
    length = float(np.sum(np.hypot(*np.diff(path.points, axis=0).T)))
    hint = path.duration / length
    offsets = np.arange(-reach, reach + 1)
    points = path.points
    spacing = length / levels[0] / reach
    for stations in levels:
        points = _subdivide(points, stations)
        best, target = math.inf, finest * length * (levels[-1] / stations) ** 2
        for _ in range(passes):
            tangent = np.gradient(points, axis=0)
            tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-300)[:, None]
            sideways = spacing * np.column_stack([-tangent[:, 1], tangent[:, 0]])
            chosen, arrival = _sweep(medium, points, sideways, offsets, areas, hint)
            points = points + chosen[:, None] * sideways
            if arrival > best * (1.0 - 1e-7) or not np.any(chosen):
                if spacing <= target:
                    break
                spacing *= 0.5
            best = min(best, arrival)
        spacing *= 2.0
    return Path(points, sail(medium, points))


def straightened(medium: Medium, path: Path, areas: Sequence[Area] = ()) -> Path:
    """Of ways that take as long, to `LONGER`, the straightest: a ship that tacks takes the same time for few long legs as for
    many short ones, and only the straight way says that she tacks. Pieces of half, a quarter, ... of the stations are tried."""
    points, times = path.points.copy(), path.times
    n = len(points)
    span = n - 1
    while span > 1:
        for first in range(0, n - span, max(1, span // 2)):
            last = first + span
            line = points[first] + (points[last] - points[first]) * np.linspace(0.0, 1.0, span + 1)[:, None]
            if np.array_equal(line, points[first : last + 1]) or not np.all(medium.inside(line[:, 0], line[:, 1])):
                continue
            if np.any(blocked(areas, *line[:-1].T, *line[1:].T)):
                continue
            spent = sail(medium, line, times[first])
            if spent[-1] - times[first] <= (times[last] - times[first]) * (1.0 + LONGER):
                points[first : last + 1] = line
                times = np.concatenate([times[:first], spent, sail(medium, points[last:], spent[-1])[1:]])
        span = (span + 1) // 2
    return Path(points, times)


def _subdivide(points: AnyArray, stations: int) -> AnyArray:
    """Legs cut into equal parts, about ``stations`` in all; the corners stay."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    rows = [points[:1]]
    for a, b, d in zip(points, points[1:], lengths):
        n = max(1, round(stations * d / lengths.sum()))
        rows.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
    return np.concatenate(rows)


def _sweep(
    medium: Medium, points: AnyArray, sideways: AnyArray, offsets: AnyArray, areas: Sequence[Area], hint: float
) -> tuple[AnyArray, float]:
    """Offsets of the earliest arrival through all stations, in units of ``sideways``, and its time."""
    n = len(points)
    arrival = np.zeros(1)
    place = points[:1]
    parents = []
    for k in range(1, n):
        ahead = points[k] + (offsets[:, None] * sideways[k] if k < n - 1 else np.zeros((1, 2)))
        legs = leg_times(
            medium, np.repeat(np.where(np.isfinite(arrival), arrival, 0.0)[:, None], len(ahead), 1),
            place[:, :1], place[:, 1:], ahead[None, :, 0], ahead[None, :, 1], areas, hint,
        )  # fmt: skip
        total = arrival[:, None] + legs
        parent = np.argmin(total, axis=0)
        parents.append(parent)
        arrival = total[parent, np.arange(len(ahead))]
        place = ahead
    at, chosen = 0, np.zeros(n)
    for k in range(n - 1, 1, -1):
        at = int(parents[k - 1][at])
        chosen[k - 1] = offsets[at]
    return chosen, float(arrival[0])


def sail(medium: Medium, points: AnyArray, start_time: float = 0.0) -> AnyArray:
    """Times of arrival (n,), s, along straight legs between ``points`` (n, 2): dt/ds = 1/v by one Runge-Kutta step of
    order 4 a leg. The first entry after which the course cannot be made good is infinite, and all later ones."""
    times = np.full(len(points), math.inf)
    times[0] = t = start_time
    for k in range(len(points) - 1):
        (x0, y0), (x1, y1) = points[k], points[k + 1]
        d = math.hypot(x1 - x0, y1 - y0)
        if d > 0.0:
            px, py = np.array([(x1 - x0) / d]), np.array([(y1 - y0) / d])

            def slowness(
                s: float, time: float, x0: float = x0, y0: float = y0, d: float = d, px: AnyArray = px, py: AnyArray = py
            ) -> float:
                v = medium.speed_along(np.array([time]), x0 + s * d * px, y0 + s * d * py, px, py)
                return d / float(v[0]) if v[0] > SLOWEST else math.inf

            k1 = slowness(0.0, t)
            if math.isinf(k1):
                return times
            k2 = slowness(0.5, t + 0.5 * k1)
            if math.isinf(k2):
                return times
            k3 = slowness(0.5, t + 0.5 * k2)
            k4 = slowness(1.0, t + k3) if math.isfinite(k3) else math.inf
            t += (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
            if math.isinf(t):
                return times
        times[k + 1] = t
    return times
