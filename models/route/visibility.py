"""The fastest way around discs and polygons in an even sea: the shortest path of the visibility graph.

    time = sum of straight legs, d/v(direction), and arcs along discs, integral r d(angle)/v(direction)

In a sea that is the same everywhere and always, with a convex set of velocities, straight lines are fastest, so that the
fastest way is a taut string: common tangents of discs and corners, and arcs between them. A node is a place on a circle and
the sense in which the way turns there; corners, start and end are circles without radius. A leg that passes through an area is
no edge. The path is exact, and the global optimum.

Assumptions: a flat map; velocities as above; discs may overlap.

Source: T. Lozano-Perez, M. A. Wesley, Comm. ACM 22 (1979) 560-570; tangents of discs: T. Asano, Proc. 1st Symp. Comput. Geom.
(1985); E. W. Dijkstra, Numer. Math. 1 (1959) 269-271.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..numeric.arrays import AnyArray
from .areas import Area, Cells, Disc, Mask, Polygon, blocked
from .fields import LinearCurrent, UniformField
from .graph import Path, Point
from .maps import FlatMap
from .medium import Medium
from .polar import ConstantPolar

ARC = math.radians(2.0)
"""Longest step along an arc between two points of the path."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
Speed = Callable[[AnyArray], AnyArray]


def even(medium: Medium) -> bool:
    """Whether ship and current are the same everywhere and always."""
    sea = isinstance(medium.field, UniformField) or isinstance(medium.polar, ConstantPolar)
    wind = medium.wind is None or isinstance(medium.wind, UniformField)
    current = isinstance(medium.current, LinearCurrent) and medium.current.uniform
    return sea and wind and current and isinstance(medium.map, FlatMap) and math.isinf(medium.horizon)


def applies(medium: Medium, areas: Sequence[Area]) -> bool:
    """Whether `shortest` answers."""
    return even(medium) and not any(isinstance(area, Cells) for area in areas)


def shortest(medium: Medium, start: Point, end: Point, areas: Sequence[Area]) -> Path | None:
    """The fastest way, or None if there is none."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    def speed(direction: AnyArray) -> AnyArray:
        zero = np.zeros_like(direction)
        return medium.speed_along(zero, zero + start[0], zero + start[1], np.cos(direction), np.sin(direction))

    discs = [area for area in areas if isinstance(area, Disc)]
    corners = [corner for area in areas if isinstance(area, Polygon) for corner in area.corners.tolist()]
    centres = np.array([start, end, *corners, *[(disc.x, disc.y) for disc in discs]], dtype=float)
    radii = np.concatenate([np.zeros(2 + len(corners)), [disc.radius for disc in discs]])
    graph = _Graph(centres, radii)
    graph.add_tangents(areas, speed)
    graph.add_arcs(areas, speed)
    rows, columns, times = graph.edges()
    n = len(graph.place)
    time, before = dijkstra(csr_matrix((times, (rows, columns)), shape=(n, n)), indices=0, return_predecessors=True)
    if not math.isfinite(time[1]):
        return None
    chain = [1]
    while chain[-1] != 0:
        chain.append(int(before[chain[-1]]))
    return graph.path(chain[::-1], speed)


class _Graph:
    """Nodes: first the circles without radius, one each (start, end, corners), then (circle, angle, sense). Edges: node, node,
    time."""

    def __init__(self, centres: AnyArray, radii: AnyArray) -> None:
        self.centres, self.radii = centres, radii
        self.place: list[tuple[int, float, int]] = [(k, 0.0, 0) for k in np.flatnonzero(radii == 0.0).tolist()]
        self._from: list[AnyArray] = []
        self._to: list[AnyArray] = []
        self._time: list[AnyArray] = []

    def add_tangents(self, areas: Sequence[Area], speed: Speed) -> None:
        """Straight legs that touch two circles and pass through no area, both ways."""
        i, j = np.triu_indices(len(self.radii), 1)
        i, j = np.repeat(i, 4), np.repeat(j, 4)
        si, sj = np.tile([1.0, 1.0, -1.0, -1.0], len(i) // 4), np.tile([1.0, -1.0, 1.0, -1.0], len(i) // 4)
        ri, rj = self.radii[i], self.radii[j]
        once = ((si > 0.0) | (ri > 0.0)) & ((sj > 0.0) | (rj > 0.0))
        d = np.hypot(*(self.centres[j] - self.centres[i]).T)
        cosine = (si * ri - sj * rj) / np.maximum(d, 1e-300)
        kept = once & (np.abs(cosine) <= 1.0) & (d > 0.0)
        i, j, si, sj, ri, rj, cosine = (v[kept] for v in (i, j, si, sj, ri, rj, cosine))
        towards = np.arctan2(*(self.centres[j] - self.centres[i]).T[::-1])
        normal = towards + np.arccos(cosine)
        n = np.column_stack([np.cos(normal), np.sin(normal)])
        p, q = self.centres[i] + (si * ri)[:, None] * n, self.centres[j] + (sj * rj)[:, None] * n
        length = np.hypot(*(q - p).T)
        clear = (length > 0.0) & ~_through(areas, p, q)
        i, j, si, sj, n, p, q, length = (v[clear] for v in (i, j, si, sj, n, p, q, length))
        u = (q - p) / length[:, None]
        turn = np.sign(n[:, 0] * u[:, 1] - n[:, 1] * u[:, 0])
        direction = np.arctan2(u[:, 1], u[:, 0])
        for back, v in ((1, speed(direction)), (-1, speed(direction + math.pi))):
            a = self._nodes(i, np.arctan2(si * n[:, 1], si * n[:, 0]), back * si * turn)
            b = self._nodes(j, np.arctan2(sj * n[:, 1], sj * n[:, 0]), back * sj * turn)
            self._add(*((a, b) if back > 0 else (b, a)), np.where(v > 0.0, length / np.where(v > 0.0, v, 1.0), math.inf))

    def add_arcs(self, areas: Sequence[Area], speed: Speed) -> None:
        """Ways along discs between the places where tangents touch them."""
        circle = np.array([c for c, _, _ in self.place])
        angle = np.array([a for _, a, _ in self.place])
        sense = np.array([s for _, _, s in self.place])
        for k in np.flatnonzero(self.radii > 0.0):
            for s in (1, -1):
                nodes = np.flatnonzero((circle == k) & (sense == s))
                if len(nodes) < 2:
                    continue
                order = nodes[np.argsort(s * angle[nodes] % (2.0 * math.pi))]
                first, last = order, np.roll(order, -1)
                sweep = (s * (angle[last] - angle[first])) % (2.0 * math.pi)
                clear = self._clear(int(k), angle[first], s * sweep, areas)
                first, last, sweep = first[clear], last[clear], sweep[clear]
                self._add(first, last, _arc_time(self.radii[k], angle[first], s * sweep, speed))

    def _clear(self, k: int, first: AnyArray, sweep: AnyArray, areas: Sequence[Area]) -> Mask:
        """Whether arcs of circle ``k`` lie outside of all areas: asked between all places where the circle enters one."""
        (x, y), r = self.centres[k], self.radii[k]
        cuts = [_cuts(area, x, y, r) for area in areas]
        breaks = np.concatenate([*cuts, np.zeros(0)])
        free = np.ones(len(first), dtype=bool)
        for n, (a, turn) in enumerate(zip(first, sweep)):
            sign = math.copysign(1.0, turn)
            inner = np.sort((sign * (breaks - a)) % (2.0 * math.pi))
            ends = np.concatenate([[0.0], inner[inner < abs(turn)], [abs(turn)]])
            middle = a + sign * 0.5 * (ends[1:] + ends[:-1])
            middle = middle[np.diff(ends) > 1e-9]
            px, py = x + r * np.cos(middle), y + r * np.sin(middle)
            free[n] = not any(np.any(area.contains(px, py)) for area in areas)
        return free

    def _nodes(self, circle: AnyArray, angle: AnyArray, sense: AnyArray) -> AnyArray:
        """Indices of nodes, new ones but for circles without radius."""
        numbers = []
        for c, a, s in zip(circle.tolist(), angle.tolist(), sense.tolist()):
            if self.radii[c] == 0.0:
                numbers.append(c)
            else:
                numbers.append(len(self.place))
                self.place.append((c, a, int(s)))
        return np.array(numbers, dtype=int)

    def _add(self, first: AnyArray, last: AnyArray, time: AnyArray) -> None:
        known = np.isfinite(time)
        self._from.append(first[known])
        self._to.append(last[known])
        self._time.append(np.maximum(time[known], 1e-12))

    def edges(self) -> tuple[AnyArray, AnyArray, AnyArray]:
        """(from, to, time, s), the fastest of equal pairs."""
        first, last, time = (np.concatenate(v) for v in (self._from, self._to, self._time))
        order = np.lexsort((time, last, first))
        first, last, time = first[order], last[order], time[order]
        new = np.concatenate([[True], (np.diff(first) != 0) | (np.diff(last) != 0)])
        return first[new], last[new], time[new]

    def _at(self, node: int) -> AnyArray:
        circle, angle, _ = self.place[node]
        return np.asarray(self.centres[circle] + self.radii[circle] * np.array([math.cos(angle), math.sin(angle)]))

    def path(self, chain: Sequence[int], speed: Speed) -> Path:
        """The way through nodes, arcs in steps of at most `ARC`."""
        points, times = [self._at(chain[0])], [0.0]
        for a, b in pairwise(chain):
            circle, angle, sense = self.place[a]
            p, q = self._at(a), self._at(b)
            if self.place[b][0] == circle and sense:
                sweep = sense * ((sense * (self.place[b][1] - angle)) % (2.0 * math.pi))
                n = max(1, math.ceil(abs(sweep) / ARC))
                ends = angle + sweep * np.arange(n) / n
                spent = _arc_time(self.radii[circle], ends, np.full(n, sweep / n), speed)
                turned = ends + sweep / n
                points += list(self.centres[circle] + self.radii[circle] * np.column_stack([np.cos(turned), np.sin(turned)]))
                times += list(times[-1] + np.cumsum(spent))
            elif math.dist(p, q) > 0.0:
                v = speed(np.array([math.atan2(q[1] - p[1], q[0] - p[0])]))[0]
                points.append(q)
                times.append(times[-1] + math.dist(p, q) / float(v))
        return Path(np.array(points), np.array(times))


def _arc_time(radius: float, first: AnyArray, sweep: AnyArray, speed: Speed) -> AnyArray:
    """Times along arcs from angles ``first`` over signed ``sweep``: Gauss's rule on pieces of at most 1/8 of a turn."""
    pieces = 8
    total: AnyArray = np.zeros_like(first)
    for k in range(pieces):
        for node, weight in zip(_NODES, _WEIGHTS):
            angle = first + sweep * (k + 0.5 * (1.0 + node)) / pieces
            v = speed(angle + np.sign(sweep) * 0.5 * math.pi)
            spent = np.where(v > 0.0, radius * np.abs(sweep) / np.where(v > 0.0, v, 1.0), math.inf)
            total = total + 0.5 * weight / pieces * spent
    return total


def _through(areas: Sequence[Area], p: AnyArray, q: AnyArray) -> Mask:
    """Whether legs p q, (n, 2), pass through an area; asked of a polygon between all lines along its edges."""
    through = blocked([area for area in areas if not isinstance(area, Polygon)], *p.T, *q.T)
    for area in areas:
        if isinstance(area, Polygon):
            d = q - p
            a, b = area.corners, np.roll(area.corners, -1, axis=0)
            e = b - a
            across = d[:, None, 0] * e[:, 1] - d[:, None, 1] * e[:, 0]
            parallel = np.abs(across) < 1e-12 * np.hypot(*d.T)[:, None] * np.hypot(*e.T)
            offset = a - p[:, None]
            at = (offset[..., 0] * e[:, 1] - offset[..., 1] * e[:, 0]) / np.where(parallel, 1.0, across)
            ends = np.sort(np.clip(np.where(parallel, 0.0, at), 0.0, 1.0), axis=1)
            ends = np.concatenate([np.zeros((len(p), 1)), ends, np.ones((len(p), 1))], axis=1)
            middle = 0.5 * (ends[:, 1:] + ends[:, :-1])
            inside = area.contains(p[:, :1] + middle * d[:, :1], p[:, 1:] + middle * d[:, 1:])
            through |= np.any(inside & (np.diff(ends, axis=1) > 1e-9), axis=1)
    return through


def _cuts(area: Area, x: float, y: float, r: float) -> AnyArray:
    """Angles at which a circle meets the edge of an area."""
    if isinstance(area, Disc):
        d = math.hypot(area.x - x, area.y - y)
        if not abs(r - area.radius) < d < r + area.radius:
            return np.zeros(0)
        half = math.acos((r * r + d * d - area.radius**2) / (2.0 * r * d))
        towards = math.atan2(area.y - y, area.x - x)
        return np.array([towards - half, towards + half])
    assert isinstance(area, Polygon)
    a, e = area.corners - (x, y), np.roll(area.corners, -1, axis=0) - area.corners
    qa, qb, qc = (e * e).sum(axis=1), (a * e).sum(axis=1), (a * a).sum(axis=1) - r * r
    root = qb * qb - qa * qc
    kept = (root > 0.0) & (qa > 0.0)
    ends = []
    for sign in (1.0, -1.0):
        s = (-qb[kept] + sign * np.sqrt(root[kept])) / qa[kept]
        on = (s >= 0.0) & (s <= 1.0)
        at = a[kept][on] + s[on][:, None] * e[kept][on]
        ends.append(np.arctan2(at[:, 1], at[:, 0]))
    return np.concatenate(ends)
