"""A lower bound on the duration of every route.

    T >= f(end) - f(start)   for every f with h(x, t, grad f) <= 1 wherever a route no slower than the best can be

| symbol | meaning | unit |
|---|---|---|
| h | support function of the set of velocities over the ground (`medium`): the largest rate at which f can grow | 1 |
| f | linear on the triangles of a mesh | s |

f starts as the shortest times over a graph of the mesh, with the largest speed along each leg at any of the possible times,
smoothed. Where h exceeds 1 the speeds are raised by as much, some `ROUNDS` times, and what is left is divided out, so that
the condition holds whatever the graph's error. Around the start, where a cone is no plane, f is the cone of the convex hull of
all sets of velocities. Nodes that no route as fast as the best reaches in time are left out.

Assumptions: h of a triangle is the largest at the corners of its cell and at `TIMES` instants, which errs by the square of the
mesh over the length within which the sea changes; no ship is faster off the mesh than on it; forbidden areas are left out, which
makes the bound smaller.

Source: the comparison with subsolutions of a Hamilton-Jacobi equation, as in M. G. Crandall, P.-L. Lions, Trans. AMS 277 (1983).
"""

from __future__ import annotations

import math

import numpy as np

from ..numeric.arrays import AnyArray
from .areas import Mask
from .medium import ANGLES, AROUND, Frozen
from .problem import Problem

LEAST, MOST, TIMES, REACH, ROUNDS = 48, 90, 11, 5, 5
"""Meshes from start to end at least and at most, instants, reach of a leg of the graph in meshes, and passes over the graph."""
MARGIN = 1.05
"""Of the duration: places a little off the best route count too, so that no edge of the mesh is near it."""


def lower_bound(problem: Problem, duration: float) -> float:
    """Time, s, that no route is faster than, if one takes ``duration``; nan where the sea changes within a mesh."""
    (x0, y0), end = problem.start, problem.end
    distance = math.dist(problem.start, end)
    cells = max(LEAST, math.ceil(2.0 * distance / problem.medium.detail))
    if cells > MOST:
        return math.nan
    back, side = cells // 5, math.ceil(0.55 * cells)
    i, j = np.meshgrid(np.arange(-back, cells + back + 1), np.arange(-side, side + 1), indexing="ij")
    mesh = distance / cells
    ex, ey = (end[0] - x0) / distance, (end[1] - y0) / distance
    x, y = x0 + mesh * (i * ex - j * ey), y0 + mesh * (i * ey + j * ex)
    instants = np.linspace(0.0, MARGIN * duration, TIMES)
    now = problem.medium.frozen(*np.broadcast_arrays(instants[:, None, None], x, y))
    supports = [now.support(math.cos(n), math.sin(n)) for n in ANGLES]
    speeds = np.max(supports, axis=0) / math.cos(math.pi / AROUND)
    top = float(speeds.max())
    if not top > 0.0:
        return math.nan
    possible = _possible(problem, x, y, instants, top)
    most = np.array([np.max(np.where(possible, support, 0.0)) for support in supports])
    axes = np.array([[ex, ey], [-ey, ex]])
    away = np.hypot(i, j)
    corner = away >= REACH
    far = corner[:-1, :-1] & corner[1:, :-1] & corner[:-1, 1:] & corner[1:, 1:]
    legs, faster = _legs(now, possible, mesh, axes), np.ones(x.shape)
    for _ in range(ROUNDS):
        time = _smooth(_shortest(legs, faster, (back, side)))
        rate = np.where(far, _rates(now, possible, time, mesh, axes), 0.0)
        scale = max(1.0, float(np.max(rate)))
        padded = np.pad(np.maximum(rate, 1.0), 1, constant_values=1.0)
        faster = faster * np.max([padded[:-1, :-1], padded[1:, :-1], padded[:-1, 1:], padded[1:, 1:]], axis=0)
    ring = (away >= REACH) & (away < REACH + math.sqrt(2.0)) & np.isfinite(time)
    bound = 0.0
    if ring.any() and np.isfinite(time[back + cells, side]):
        cone = _cone(most, (x - x0)[ring], (y - y0)[ring])
        bound = float(time[back + cells, side]) / scale + float(np.min(cone - time[ring] / scale))
    true, plane = float((speeds / now.scale).max()), problem.medium.map
    edge = (i == i.min()) | (i == i.max()) | (j == j.min()) | (j == j.max())
    lengths = [plane.distance(problem.start, p) + plane.distance(p, end) for p in zip(x[edge].tolist(), y[edge].tolist())]
    ways = _cone(most, x[edge] - x0, y[edge] - y0) + _cone(most, end[0] - x[edge], end[1] - y[edge])
    around = float(np.min(np.maximum(np.array(lengths) / true, ways)))
    straight = _cone(most, np.array([end[0] - x0]), np.array([end[1] - y0]))
    return min(duration, around, max(plane.distance(problem.start, end) / true, float(straight[0]), bound))


def _cone(most: AnyArray, dx: AnyArray, dy: AnyArray) -> AnyArray:
    """Times, s, for ways (dx, dy) with the convex hull of all sets of velocities, whose support in `ANGLES` is ``most``."""
    along = np.array([dx * math.cos(n) + dy * math.sin(n) for n in ANGLES])
    known = most[:, None] > 0.0
    return np.asarray(np.max(np.where(known, along / np.where(known, most[:, None], 1.0), 0.0), axis=0))


def _possible(problem: Problem, x: AnyArray, y: AnyArray, instants: AnyArray, top: float) -> Mask:
    """At which instants a route that is as fast as the best may be near a node, (nt, nx, ny)."""
    first = np.hypot(x - problem.start[0], y - problem.start[1]) / top
    last = instants[-1] - np.hypot(x - problem.end[0], y - problem.end[1]) / top
    at, step = instants[:, None, None], instants[1] - instants[0]
    return np.asarray((at >= first - step) & (at <= last + step) & (last >= first))


def _legs(now: Frozen, possible: Mask, mesh: float, axes: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
    """(from, to, time) of legs between nodes, with the largest speed at their ends and at any possible instant."""
    nx, ny = possible.shape[1:]
    number = np.arange(nx * ny).reshape(nx, ny)
    legs = []
    for a in range(-REACH, REACH + 1):
        for b in range(-REACH, REACH + 1):
            if math.gcd(a, b) != 1:
                continue
            p = (a * axes[0] + b * axes[1]) / math.hypot(a, b)
            speed = np.where(possible, now.along(*np.broadcast_arrays(p[0], p[1], now.scale)[:2]), 0.0).max(axis=0)
            here = tuple(slice(max(0, -c), n - max(0, c)) for c, n in ((a, nx), (b, ny)))
            there = tuple(slice(max(0, c), n - max(0, -c)) for c, n in ((a, nx), (b, ny)))
            fastest = np.maximum(speed[here], speed[there])
            known = (speed[here] > 0.0) & (speed[there] > 0.0)
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
    """Means over nodes and their neighbours, `ROUNDS` times: the graph knows few directions, and its times have facets."""
    known = np.isfinite(time)
    values = np.where(known, time, 0.0)
    nx, ny = time.shape
    for _ in range(ROUNDS):
        sums, counts = (
            sum(np.pad(v, 1)[a : a + nx, b : b + ny] for a in range(3) for b in range(3)) for v in (values, known.astype(float))
        )
        values = np.where(known, sums / np.maximum(counts, 1.0), 0.0)
    return np.where(known, values, math.inf)


def _rates(now: Frozen, possible: Mask, time: AnyArray, mesh: float, axes: AnyArray) -> AnyArray:
    """h of the two triangles of every cell, the larger one, at its corners; 0 where one is left out."""
    a, b, c, d = time[:-1, :-1], time[1:, :-1], time[:-1, 1:], time[1:, 1:]
    known = np.isfinite(a + b + c + d)
    a, b, c, d = (np.where(known, v, 0.0) / mesh for v in (a, b, c, d))
    rate: AnyArray = np.zeros(a.shape)
    nx, ny = a.shape
    for along, across in ((b - a, d - b), (d - c, c - a)):
        lx, ly = along * axes[0, 0] + across * axes[1, 0], along * axes[0, 1] + across * axes[1, 1]
        for p in (0, 1):
            for q in (0, 1):
                corner = (slice(None), slice(p, p + nx), slice(q, q + ny))
                h = np.where(possible[corner], now.part(corner).support(lx, ly), 0.0)
                rate = np.maximum(rate, h.max(axis=0))
    return np.where(known, rate, 0.0)
