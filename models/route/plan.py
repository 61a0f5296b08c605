"""The minimal-time route of a ship through known waves: global start, certified local minimum, comparisons.

1. Dijkstra's method on a coarse lattice finds the basin of the global minimum (`graph`).
2. Safeguarded shooting from there, and from a fan of courses for the other basins, gives extremals (`shooting`);
   those with a conjugate point, off the data or through a forbidden area are dropped.
3. Where forbidden areas touch the best extremal, or the polar is a table, the lattice path refined in a corridor is
   the answer: at its accuracy (1e-4 of the time and better), without certificate, and called so.

Comparisons: STRAIGHT keeps the plane direction (the source's program), the geodesic is the shortest way. What cannot be
answered raises `RouteError` with the reason; a part that cannot be compared is None with a note.

Assumptions: those of `medium` and `graph`. Source: Minimal-time ship routing (1964), programs MINVOY,
STRAIGHT.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..numeric.arrays import AnyArray
from . import graph as route_graph
from . import shooting as route_shooting
from .areas import Area, blocked, containing
from .graph import Path, Point
from .hulls import TACKS
from .maps import FlatMap
from .medium import Medium

SAME = 1e-5
"""Two extremals whose times and starting directions agree to this share are one."""
STRAIGHT_LEGS = 240


class RouteError(ValueError):
    """No route, and why. ``reason``: a word for programs (outside, forbidden, unreachable, diverged, input)."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True)
class Problem:
    """From ``start`` to ``end``, m, in ``medium`` without touching ``areas``; time 0 is the departure."""

    medium: Medium
    start: Point
    end: Point
    areas: tuple[Area, ...] = ()


@dataclass(frozen=True)
class Route:
    """A way to sail: ``time``, ``x``, ``y`` (n,) in s and m. ``kind``: extremal, corridor, straight, geodesic or none
    (start = end). ``certified``: a local minimum by Jacobi's condition, with ``j_exact`` and ``j_seed``, m/rad."""

    kind: str
    time: AnyArray
    x: AnyArray
    y: AnyArray
    certified: bool = False
    j_exact: float = math.nan
    j_seed: float = math.nan
    iterations: int = 0
    alpha: float = math.nan

    @property
    def duration(self) -> float:
        """Time of arrival, s."""
        return float(self.time[-1])


@dataclass(frozen=True)
class Plan:
    """``best`` and the ``others`` (local minima, ascending), STRAIGHT and geodesic where they can be sailed; shares of
    the best voyage beyond the last forecast, beyond the polar's range, and tacking; ``notes`` for people."""

    best: Route
    others: tuple[Route, ...]
    straight: Route | None
    geodesic: Route | None
    graph_time: float
    beyond_horizon: float
    beyond_polar: float
    tacking: float
    notes: tuple[str, ...] = field(default=())

    @property
    def saving(self) -> float | None:
        """Share of the straight route's time that the best one saves."""
        return None if self.straight is None else 1.0 - self.best.duration / self.straight.duration


def plan(
    problem: Problem, *, method: str = "safeguarded", cells: int = 20, radius: int = 3, fan: int = 8, steps: int = 32
) -> Plan:
    """Solve a problem. ``method``: safeguarded; seed (the source's iteration, from the straight course, as it was
    used); graph (lattice and corridor only). ``fan``: further starting courses, for the other basins. Raises
    `RouteError`."""
    if method not in ("safeguarded", "seed", "graph"):
        raise RouteError("input", f"method {method!r}: expected safeguarded, seed or graph")
    _check(problem)
    medium, start, end = problem.medium, problem.start, problem.end
    notes: list[str] = []
    if start == end:
        zero = np.zeros(1)
        here = Route("none", zero, zero + start[0], zero + start[1], certified=True)
        return Plan(here, (), here, here, 0.0, 0.0, 0.0, 0.0, ("start and end are one place: nothing to sail",))
    straight = _along(problem, [start, end], "straight", notes)
    if isinstance(medium.map, FlatMap):
        geodesic = straight
    else:
        geodesic = _along(problem, medium.map.geodesic(start, end, STRAIGHT_LEGS), "geodesic", notes)
    path = None
    if method != "seed":
        path = route_graph.search(medium, start, end, problem.areas, cells=cells, radius=radius)
        if path is None:
            raise RouteError("unreachable", _why_unreachable(problem))
    routes: list[Route] = []
    if method != "graph" and medium.smooth:
        routes = extremals(problem, path, method, fan, steps, notes)
    if not routes and method == "seed":
        raise RouteError("diverged", "the source's iteration did not converge from the straight course: use the "
                         "safeguarded method")  # fmt: skip
    if path is not None and (not routes or routes[0].duration > path.duration):
        fine = route_graph.refine(medium, path, problem.areas)
        if not routes or fine.duration < routes[0].duration * (1.0 - SAME):
            if medium.smooth and method != "graph":
                notes.append("no extremal is free of forbidden areas and as fast as the lattice path: the answer is the "
                             "refined lattice path, exact to about 1e-4, without certificate")  # fmt: skip
            routes.insert(0, Route("corridor", fine.times, fine.points[:, 0], fine.points[:, 1]))
    best = routes[0]
    horizon = max(0.0, 1.0 - medium.horizon / best.duration)
    if horizon > 0.0:
        notes.append(f"{horizon:.1%} of the voyage lies beyond the last forecast, whose field is kept")
    over, tacks = _shares(medium, best)
    if over > 0.0:
        notes.append(f"{over:.1%} of the voyage meets waves beyond the range of polar {medium.polar.name}, held there")
    if tacks > 0.0:
        notes.append(f"tack: {tacks:.1%} of the voyage needs tacking on a hull chord of polar {medium.polar.name}")
    return Plan(best, tuple(routes[1:]), straight, geodesic, path.duration if path else math.nan, horizon, over, tacks,
                tuple(notes))  # fmt: skip


def extremals(
    problem: Problem, path: Path | None, method: str, fan: int, steps: int, notes: list[str]
) -> list[Route]:
    """Distinct local minima that can be sailed, by time."""
    medium, start, end = problem.medium, problem.start, problem.end
    course = math.atan2(end[1] - start[1], end[0] - start[0])
    guess = path.duration if path else _calm_time(problem)
    courses = [course]
    if path is not None:
        ahead = path.points[min(len(path.points) - 1, 1 + len(path.points) // 8)]
        courses.insert(0, math.atan2(ahead[1] - start[1], ahead[0] - start[0]))
        courses += [course + 1.0 * (2.0 * k / (fan - 1) - 1.0) for k in range(fan)] if fan > 1 else []
    alpha = np.array([medium.normal(0.0, start[0], start[1], c) for c in courses])
    first = route_shooting.shoot(medium, start, end, alpha, np.full(len(alpha), guess), method=method, steps=16,
                                 iterations=40, tolerance=1e-6)  # fmt: skip
    kept: list[int] = []
    for k in np.argsort(first.time):
        if first.converged[k] and not any(
            abs(first.time[k] / first.time[o] - 1.0) < SAME and abs(math.sin(0.5 * (first.alpha[k] - first.alpha[o]))) < 1e-3
            for o in kept
        ):
            kept.append(int(k))
    if not kept:
        return []
    shots = route_shooting.shoot(medium, start, end, first.alpha[kept], first.time[kept], method=method, steps=32,
                                 iterations=60)  # fmt: skip
    routes = []
    good = [k for k in range(len(kept)) if shots.converged[k]]
    if not good:
        return []
    for k, way in zip(good, route_shooting.tracks(medium, start, shots.alpha[good], shots.time[good], steps)):
        name = f"the extremal of {way.time[-1] / 3600.0:.2f} h"
        outside = ~medium.inside(way.x, way.y)
        if np.any(outside):
            i = int(np.argmax(outside))
            notes.append(f"{name} leaves the data at ({way.x[i]:.6g}, {way.y[i]:.6g}) m, t = {way.time[i]:.6g} s: dropped")
        elif np.any(blocked(problem.areas, way.x[:-1], way.y[:-1], way.x[1:], way.y[1:])):
            notes.append(f"{name} crosses a forbidden area: dropped")
        elif method != "seed" and not way.certified:
            notes.append(f"{name} has a conjugate point and is no minimum: dropped")
        else:
            routes.append(Route("extremal", way.time, way.x, way.y, way.certified, float(way.j_exact[-1]),
                                float(shots.j_seed[k]), int(first.iterations[kept[k]] + shots.iterations[k]),
                                float(shots.alpha[k])))  # fmt: skip
    return sorted(routes, key=lambda r: r.duration)


def _check(problem: Problem) -> None:
    for name, place in (("start", problem.start), ("end", problem.end)):
        if not all(map(math.isfinite, place)):
            raise RouteError("input", f"the {name} {place} is not a place")
        if not bool(problem.medium.inside(np.array([place[0]]), np.array([place[1]]))[0]):
            raise RouteError("outside", f"the {name} ({place[0]:.6g}, {place[1]:.6g}) m lies outside the wave data")
        area = containing(problem.areas, *place)
        if area is not None:
            raise RouteError("forbidden", f"the {name} ({place[0]:.6g}, {place[1]:.6g}) m lies inside forbidden area "
                             f"{area.name!r}")  # fmt: skip


def _why_unreachable(problem: Problem) -> str:
    """Which obstacle closes every way."""
    causes = []
    if problem.areas:
        causes.append("forbidden areas")
    if math.isfinite(problem.medium.horizon) or not bool(
        problem.medium.inside(np.array([1e12]), np.array([1e12]))[0]
    ):
        causes.append("the edge of the wave data")
    causes.append("seas against which the ship makes no way")
    return "no route: every way to the end is closed by " + " or ".join(causes)


def _along(problem: Problem, points: Sequence[Point], kind: str, notes: list[str]) -> Route | None:
    """The given line, sailed; None with a note where it cannot be."""
    line = np.asarray(points, dtype=float)
    if len(line) == 2:
        line = line[0] + (line[1] - line[0]) * np.linspace(0.0, 1.0, STRAIGHT_LEGS + 1)[:, None]
    inside = problem.medium.inside(line[:, 0], line[:, 1])
    if not np.all(inside):
        notes.append(f"the {kind} route leaves the wave data")
        return None
    if np.any(blocked(problem.areas, line[:-1, 0], line[:-1, 1], line[1:, 0], line[1:, 1])):
        notes.append(f"the {kind} route crosses a forbidden area")
        return None
    times = route_graph.sail(problem.medium, line)
    if math.isinf(times[-1]):
        k = int(np.argmax(np.isinf(times)))
        notes.append(f"the {kind} route ends at ({line[k, 0]:.6g}, {line[k, 1]:.6g}) m: no way against the sea there")
        return None
    return Route(kind, times, line[:, 0], line[:, 1])


def _calm_time(problem: Problem) -> float:
    """A first guess of the time from the speed at the start."""
    x0, y0 = problem.start
    d = math.dist(problem.start, problem.end)
    one = np.ones(1)
    v = problem.medium.speed_along(0.0 * one, x0 * one, y0 * one, (problem.end[0] - x0) / d * one,
                                   (problem.end[1] - y0) / d * one)  # fmt: skip
    return d / max(float(v[0]), 1e-3)


def _shares(medium: Medium, route: Route) -> tuple[float, float]:
    """Shares of the time beyond the polar's range and on hull chords."""
    step = np.diff(route.time)
    weights = 0.5 * (np.concatenate([[0.0], step]) + np.concatenate([step, [0.0]])) / route.duration
    m = medium.map.scale(route.x, route.y)[0]
    u, w = medium.current.at(route.x, route.y, route.time)[:2]
    vx, vy = (np.gradient(place, route.time) / m - drift for place, drift in ((route.x, u), (route.y, w)))
    size = np.maximum(np.hypot(vx, vy), 1e-300)
    made, own, over = medium.sail(route.time, route.x, route.y, vx / size, vy / size)
    tacks = made > (1.0 + TACKS) * own
    return float(np.sum(weights * over)), float(np.sum(weights * tacks))
