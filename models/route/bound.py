"""A lower bound on the duration of every route.

    T >= f(end) - f(start)   for every f with h(x, t, grad f) <= 1 wherever a route no slower than the best can be

| symbol | meaning | unit |
|---|---|---|
| h | support function of the set of velocities over the ground (`medium`): the largest rate at which f can grow | 1 |
| f | linear on the triangles of a mesh | s |

f starts as the shortest times over a graph of the mesh, with the largest speed along each leg, smoothed. Where h exceeds 1 the
speeds are raised by as much, some `ROUNDS` times, and what is left is divided out, so that the condition holds whatever the
graph's error. Around the start, where a cone is no plane, f is the cone of the convex hull of all sets of velocities.

h is no sample but a bound over the whole of a cell and of a slab of time (`ranges`, `rates`), as is what is taken between nodes
where the cone meets f and where the mesh ends, so that the bound holds for every route, whatever the mesh: one that is too coarse
makes it small, not wrong. Cells that no route as fast as the best reaches in time are left out.

Assumptions: those of `medium`; forbidden areas are left out, which makes the bound smaller.

Source: the comparison with subsolutions of a Hamilton-Jacobi equation, as in M. G. Crandall, P.-L. Lions, Trans. AMS 277 (1983).
"""

from __future__ import annotations

import math

import numpy as np

from ..numeric.arrays import AnyArray
from .areas import Mask
from .maps import FlatMap
from .problem import Problem
from .ranges import Mesh, still
from .rates import ANGLES, AROUND, TURN, Reach, anywhere, of_cells

LEAST, MOST, TIMES, REACH, ROUNDS, PASSES = 60, 90, 25, 5, 5, 2
"""Meshes from start to end at least and at most, instants, reach of a leg of the graph in meshes, passes over the graph and of
the means of its times."""
MARGIN = 1.0 + 1e-9
"""Of the duration: the best route itself counts, whatever the rounding."""
SLOWEST = 1e-3
"""Of the largest speed: a leg of the graph takes no longer, so that all nodes have a time."""
NORMALS = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])


def lower_bound(problem: Problem, duration: float) -> float:
    """Time, s, that no route is faster than, if one takes ``duration``; nan where the sea changes within a mesh, or is given by a
    field of another make."""
    medium, (x0, y0), end = problem.medium, problem.start, problem.end
    distance = math.dist(problem.start, end)
    cells = max(LEAST, math.ceil(2.0 * distance / medium.detail))
    if cells > MOST:
        return math.nan
    back, side = cells // 5, math.ceil(0.55 * cells)
    i, j = np.meshgrid(np.arange(-back, cells + back + 1), np.arange(-side, side + 1), indexing="ij")
    step = distance / cells
    axes = np.array([[end[0] - x0, end[1] - y0], [y0 - end[1], end[0] - x0]]) / distance
    last = MARGIN * duration
    kept = [part.horizon for part in medium.parts if part.horizon < last]  # no interpolation over the end of a forecast
    count = 2 if all(map(still, medium.parts)) else TIMES
    instants = np.unique(np.concatenate([np.linspace(0.0, last, count), kept]))
    mesh = Mesh(x0 + step * (i * axes[0, 0] + j * axes[1, 0]), y0 + step * (i * axes[0, 1] + j * axes[1, 1]), instants, step)
    ends = anywhere(medium, problem.start), anywhere(medium, end)
    if ends[0] is None or ends[1] is None:
        return math.nan
    possible = _possible(problem, mesh, (ends[0], ends[1]))
    rates = of_cells(medium, mesh, possible)
    if rates is None:
        return math.nan
    most = rates.max(axis=(1, 2))
    away = np.hypot(i, j)
    corner = away >= REACH
    far = corner[:-1, :-1] & corner[1:, :-1] & corner[:-1, 1:] & corner[1:, 1:] & possible.any(axis=0)
    legs, faster = _legs(rates, step, axes), np.ones(i.shape)
    for _ in range(ROUNDS):
        time = _smooth(_shortest(legs, faster, (back, side)))
        rate = np.where(far, _rates(rates, time, step, axes), 0.0)
        scale = max(1.0, float(np.max(rate)))
        faster = faster * np.maximum(1.0, _around(rate[None])[0])
    cone = _cone(most, mesh.x - x0, mesh.y - y0)
    bound = 0.0
    if np.isfinite(time[_around(rates).max(axis=0) > 0.0]).all():
        bound = float(time[back + cells, side]) / scale + _least(cone - time / scale, away)
    straight = float(ends[0].time(medium.map.distance(problem.start, end)))
    straight = max(straight, float(np.max(_cone(most, end[0] - x0, end[1] - y0))))
    edge = (i == i.min()) | (i == i.max()) | (j == j.min()) | (j == j.max())
    return min(duration, _off_mesh(problem, mesh, edge, (ends[0], ends[1])), max(straight, bound))


def _off_mesh(problem: Problem, mesh: Mesh, edge: Mask, ends: tuple[Reach, Reach]) -> float:
    """Time, s, that no route over the edge of the mesh is faster than: to one of its nodes and on, less what half a mesh beside
    it saves."""
    plane, ((x0, y0), (x1, y1)) = problem.medium.map, (problem.start, problem.end)
    x, y, half = mesh.x[edge], mesh.y[edge], 0.5 * mesh.side
    aside = half / float(np.min(plane.scale(mesh.x, mesh.y)[0]))
    times: AnyArray = np.zeros(x.shape)
    for reach, place in zip(ends, (problem.start, problem.end)):
        times = times + reach.time(np.array([plane.distance(place, p) for p in zip(x.tolist(), y.tolist())]) - aside)
    if not isinstance(plane, FlatMap) or ends[0].growth > 0.0:
        return float(np.min(times))
    off = ends[0].supports
    ways = np.max(_cone(off, x - x0, y - y0), axis=0) + np.max(_cone(off, x1 - x, y1 - y), axis=0)
    saved = 2.0 * half / float(np.min(off)) if np.all(off > 0.0) else math.inf
    return float(np.min(np.maximum(times, ways - saved)))


def _around(cells: AnyArray) -> AnyArray:
    """The largest of the cells around every node, (k, nx, ny) of (k, nx - 1, ny - 1)."""
    padded = np.pad(cells, ((0, 0), (1, 1), (1, 1)))
    return np.asarray(np.max([padded[:, :-1, :-1], padded[:, 1:, :-1], padded[:, :-1, 1:], padded[:, 1:, 1:]], axis=0))


def _cone(most: AnyArray, dx: AnyArray | float, dy: AnyArray | float) -> AnyArray:
    """Times, s, of the planes whose upper envelope is the time for ways (dx, dy) with the convex hull of all sets of velocities,
    whose support is ``most``: (AROUND, ...)."""
    return np.array([(dx * c + dy * s) / m for (c, s), m in zip(NORMALS, most) if m > 0.0])


def _least(planes: AnyArray, away: AnyArray) -> float:
    """The least of an envelope of ``planes`` (k, nx, ny), given at nodes, over the edges of the mesh that part the cells around
    the start from the others: on an edge it is no smaller than its best plane at the worse end."""
    ring = (away >= REACH) & (away < REACH + 1.0 + math.sqrt(2.0))
    least, known = math.inf, np.isfinite(planes[0])  # where no route comes there is no time
    for first, last in ((np.s_[:-1, :], np.s_[1:, :]), (np.s_[:, :-1], np.s_[:, 1:])):
        here = ring[first] & ring[last] & known[first] & known[last]
        ends = (planes[(slice(None), *part)][:, here] for part in (first, last))
        edges = np.max(np.minimum(*ends), axis=0)
        least = min(least, float(np.min(edges)))
    return least


def _possible(problem: Problem, mesh: Mesh, ends: tuple[Reach, Reach]) -> Mask:
    """In which slabs a route that is as fast as the best may be in a cell, (nt - 1, nx - 1, ny - 1)."""
    x, y, reach = mesh.centres(mesh.x), mesh.centres(mesh.y), mesh.side / math.sqrt(2.0)
    scale = float(np.max(problem.medium.map.scale(mesh.x, mesh.y)[0]))
    first, left = (
        end.time(np.hypot(x - place[0], y - place[1]) - reach, scale) for end, place in zip(ends, (problem.start, problem.end))
    )
    last = mesh.t[-1] - left
    begins, done = mesh.t[:-1, None, None], mesh.t[1:, None, None]
    return np.asarray((done >= first) & (begins <= last) & (last >= first))


def _legs(rates: AnyArray, mesh: float, axes: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
    """(from, to, time) of legs between nodes, with the largest speed in the cells around their ends."""
    most = _around(rates)
    reached = most.max(axis=0) > 0.0
    floor = SLOWEST * float(most.max())
    nx, ny = most.shape[1:]
    number = np.arange(nx * ny).reshape(nx, ny)
    legs = []
    for a in range(-REACH, REACH + 1):
        for b in range(-REACH, REACH + 1):
            if math.gcd(a, b) != 1:
                continue
            along = NORMALS @ ((a * axes[0] + b * axes[1]) / math.hypot(a, b))
            ahead = along > 1e-6
            speed = np.maximum(np.min(most[ahead] / along[ahead, None, None], axis=0), floor)
            here = tuple(slice(max(0, -c), n - max(0, c)) for c, n in ((a, nx), (b, ny)))
            there = tuple(slice(max(0, c), n - max(0, -c)) for c, n in ((a, nx), (b, ny)))
            known = reached[here] & reached[there]
            fastest = np.maximum(speed[here], speed[there])
            legs.append((number[here][known], number[there][known], mesh * math.hypot(a, b) / fastest[known]))
    first, last, time = (np.concatenate(column) for column in zip(*legs))
    return first, last, time


def _shortest(legs: tuple[AnyArray, AnyArray, AnyArray], faster: AnyArray, source: tuple[int, int]) -> AnyArray:
    """Shortest times over the graph, s, (nx, ny), with speeds ``faster`` by a factor at the nodes."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    first, last, time = legs
    factor = faster.ravel()
    n = faster.size
    graph = csr_matrix((time / np.maximum(factor[first], factor[last]), (first, last)), shape=(n, n))
    start = source[0] * faster.shape[1] + source[1]
    return np.asarray(dijkstra(graph, indices=start).reshape(faster.shape))


def _smooth(time: AnyArray) -> AnyArray:
    """Means over nodes and their neighbours, `PASSES` times: the graph knows few directions, and its times have facets."""
    known = np.isfinite(time)
    values = np.where(known, time, 0.0)
    nx, ny = time.shape
    for _ in range(PASSES):
        sums, counts = (
            sum(np.pad(v, 1)[a : a + nx, b : b + ny] for a in range(3) for b in range(3)) for v in (values, known.astype(float))
        )
        values = np.where(known, sums / np.maximum(counts, 1.0), 0.0)
    return np.where(known, values, math.inf)


def _rates(rates: AnyArray, time: AnyArray, mesh: float, axes: AnyArray) -> AnyArray:
    """Bound of h of the two triangles of every cell, the larger one; without end where a node has no time."""
    a, b, c, d = time[:-1, :-1], time[1:, :-1], time[:-1, 1:], time[1:, 1:]
    known = np.isfinite(a + b + c + d)
    a, b, c, d = (np.where(known, v, 0.0) / mesh for v in (a, b, c, d))
    rate: AnyArray = np.zeros(a.shape)
    for along, across in ((b - a, d - b), (d - c, c - a)):
        lx, ly = along * axes[0, 0] + across * axes[1, 0], along * axes[0, 1] + across * axes[1, 1]
        place = np.mod(np.arctan2(ly, lx), 2.0 * math.pi) / TURN
        k = np.floor(place).astype(int)
        h = sum(np.sin(w * TURN) * np.take_along_axis(rates, (at % AROUND)[None], 0)[0]
                for at, w in ((k, k + 1.0 - place), (k + 1, place - k)))  # fmt: skip
        rate = np.maximum(rate, np.hypot(lx, ly) * h / math.sin(TURN))
    return np.where(known, rate, math.inf)
