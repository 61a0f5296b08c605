"""The minimal-time route of a ship through known waves: global start, certified local minimum, comparisons.

1. Dijkstra's method on a coarse lattice finds the basin of the global minimum (`graph`).
2. Safeguarded shooting from there, and from a fan of courses for the other basins, gives extremals (`shooting`);
   those with a conjugate point, off the data or through a forbidden area are dropped.
3. Where forbidden areas or limits (`limits`) touch the best extremal, or the polar is a table, the lattice path refined in a
   corridor is the answer: at its accuracy (1e-4 of the time and better), without certificate, and called so.
4. In an even sea the fastest way around discs and polygons is that of the visibility graph, exact (`visibility`).
5. `bound` says how much faster than the best route any other could be.

Comparisons: STRAIGHT keeps the plane direction (the source's program), the geodesic is the shortest way. What cannot be
answered raises `RouteError` with the reason; a part that cannot be compared is None with a note.

Assumptions: those of `medium` and `graph`. Source: Minimal-time ship routing (1964), programs MINVOY,
STRAIGHT.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from . import graph as route_graph
from . import visibility
from .areas import blocked, containing
from .bound import lower_bound
from .extremals import SAME, extremals, sailed
from .graph import Point
from .hulls import TACKS
from .limits import Kept, broken, kept
from .limits import error as limit_error
from .maps import FlatMap
from .medium import Medium
from .polar import KNOT
from .problem import Problem, Route, RouteError

STRAIGHT_LEGS = 240
CORRIDOR = 1e-4
"""Accuracy of a refined lattice path, as a share of its duration."""


@dataclass(frozen=True)
class Plan:
    """``best`` and the ``others`` (local minima, ascending), STRAIGHT and geodesic where they can be sailed; ``lower_bound``, s:
    no route is faster (nan: not known); shares of the time of the best voyage beyond the last forecast, beyond the polar's
    range, and tacking: on courses that she makes good only by tacks, of ways equally fast the straightest; ``notes`` for people;
    ``limits``: how the best route keeps each."""

    best: Route
    others: tuple[Route, ...]
    straight: Route | None
    geodesic: Route | None
    graph_time: float
    lower_bound: float
    beyond_horizon: float
    beyond_polar: float
    tacking: float
    notes: tuple[str, ...] = field(default=())
    limits: tuple[Kept, ...] = ()

    @property
    def saving(self) -> float | None:
        """Share of the straight route's time that the best one saves."""
        return None if self.straight is None else 1.0 - self.best.duration / self.straight.duration


def plan(
    problem: Problem, *, method: str = "safeguarded", cells: int = 20, radius: int = 3, fan: int = 8, fraction: float = 1.0
) -> Plan:
    """Solve a problem. ``method``: safeguarded; seed (the source's iteration, from the straight course, with ``fraction`` of its
    corrections); graph (lattice and corridor only). ``fan``: further starting courses, for the other basins. Raises
    `RouteError`."""
    if method not in ("safeguarded", "seed", "graph"):
        raise RouteError("input", f"method {method!r}: expected safeguarded, seed or graph")
    if not 0.0 < fraction <= 1.0 or (fraction < 1.0 and method != "seed"):
        raise RouteError("input", f"fraction {fraction:g}: expected more than 0, at most 1, and method seed")
    _check(problem)
    medium, start, end = problem.medium, problem.start, problem.end
    notes: list[str] = []
    if start == end:
        zero = np.zeros(1)
        here = Route("none", zero, zero + start[0], zero + start[1], certified=True)
        return Plan(here, (), here, here, 0.0, 0.0, 0.0, 0.0, 0.0, ("start and end are one place: nothing to sail",))
    straight = _along(problem, [start, end], "straight", notes)
    if isinstance(medium.map, FlatMap):
        geodesic = straight
    else:
        geodesic = _along(problem, medium.map.geodesic(start, end, STRAIGHT_LEGS), "geodesic", notes)
    routes, graph_time = [], math.nan
    if method != "graph" and visibility.applies(medium, problem.areas) and _in_the_way(problem):
        around = _around(problem)
        routes = [] if broken(kept(medium, around.time, around.x, around.y)) else [around]
    if not routes:
        routes, graph_time = _routes(problem, method, cells, radius, fan, fraction, notes)
    best = routes[0]
    horizon = max(0.0, 1.0 - medium.horizon / best.duration)
    if horizon > 0.0:
        notes.append(f"{horizon:.1%} of the voyage lies beyond the last forecast, whose field is kept")
    over, tacks = _shares(medium, best)
    if over > 0.0:
        notes.append(f"{over:.1%} of the voyage meets waves or wind beyond the range of polar {medium.polar.name}, held there")
    if tacks > 0.0:
        notes.append(f"tack: {tacks:.1%} of the voyage needs tacking on a hull chord of polar {medium.polar.name}")
    bound = best.duration if best.kind == "visibility" else lower_bound(problem, best.duration)
    limits = kept(medium, best.time, best.x, best.y)
    for one in limits:
        if one.beyond > 0.0:
            notes.append(f"limit {one.limit.name!r}: {one.beyond:.1%} of the voyage meets heights or periods beyond its table, "
                         "whose ends count there")  # fmt: skip
    if tacks > 0.0 and limits:
        notes.append("limits are asked for the course made good: on the tacks themselves the waves come from elsewhere")
    return Plan(best, tuple(routes[1:]), straight, geodesic, graph_time, bound, horizon, over, tacks, tuple(notes), limits)


def _in_the_way(problem: Problem) -> bool:
    """Whether areas lie on the straight line, which is fastest in an even sea."""
    (x0, y0), (x1, y1) = problem.start, problem.end
    return bool(blocked(problem.areas, *(np.array([v]) for v in (x0, y0, x1, y1)))[0])


def _around(problem: Problem) -> Route:
    """The fastest way around areas in an even sea."""
    path = visibility.shortest(problem.medium, problem.start, problem.end, problem.areas)
    if path is None:
        raise RouteError("unreachable", why_unreachable(problem))
    return Route("visibility", path.times, path.points[:, 0], path.points[:, 1], certified=True, error=0.0)


def _routes(
    problem: Problem, method: str, cells: int, radius: int, fan: int, fraction: float, notes: list[str]
) -> tuple[list[Route], float]:
    """(routes by time, duration of the lattice path)."""
    medium = problem.medium
    path = None
    if method != "seed":
        path = route_graph.search(medium, problem.start, problem.end, problem.areas, cells=cells, radius=radius)
        if path is None and not (medium.smooth and method != "graph"):
            raise RouteError("unreachable", why_unreachable(problem))
    routes: list[Route] = []
    if method != "graph" and medium.smooth:
        routes = extremals(problem, path, method, fan, fraction, notes)
    if not routes and method == "seed":
        if dropped := [note for note in notes if note.endswith(": dropped")]:
            raise RouteError("unreachable", "; ".join(dropped) + ": the safeguarded method looks for other ways")
        raise RouteError("diverged", "the source's iteration did not converge from the straight course: take half of its "
                         "corrections (fraction = 0.5), or the safeguarded method")  # fmt: skip
    if path is None and method != "seed":
        if not routes:
            raise RouteError("unreachable", why_unreachable(problem))
        notes.append("the lattice finds no way: other basins may have been missed")
    if path is not None and (not routes or routes[0].duration > path.duration):
        fine = route_graph.refine(medium, path, problem.areas)
        if not medium.smooth and not medium.limits:
            fine = route_graph.straightened(medium, fine, problem.areas)
        if broken(kept(medium, fine.times, fine.points[:, 0], fine.points[:, 1])):
            fine = path
            if (worst := broken(kept(medium, path.times, path.points[:, 0], path.points[:, 1]))) is not None:
                raise RouteError("unreachable", "no route: the way that the lattice finds breaks the limit "
                                 f"{worst.limit.name!r} at {worst.place}: try more meshes (cells), or leave later")  # fmt: skip
        if not routes or fine.duration < routes[0].duration * (1.0 - SAME):
            share = max(CORRIDOR, limit_error(medium))
            if medium.smooth and method != "graph":
                notes.append("no extremal is free of forbidden areas, within the limits and as fast as the lattice path: the "
                             f"answer is the refined lattice path, exact to about {share:g}, without certificate")  # fmt: skip
            routes.insert(0, Route("corridor", fine.times, fine.points[:, 0], fine.points[:, 1], error=share * fine.duration))
    return routes, path.duration if path else math.nan


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


def why_unreachable(problem: Problem) -> str:
    """Which obstacle closes every way."""
    medium = problem.medium
    (x0, y0), (x1, y1) = problem.start, problem.end
    reach = 0.55 * math.dist(problem.start, problem.end)
    x, y = np.meshgrid(*(np.linspace(min(a, b) - reach, max(a, b) + reach, 41) for a, b in ((x0, x1), (y0, y1))))
    still = np.zeros(x.shape)
    u, w = medium.current.at(x, y, still)[:2]
    drift = np.hypot(u, w)
    ship = medium.fastest(still, x, y) / medium.map.scale(x, y)[0] - drift
    if np.any(drift > ship):
        k = np.unravel_index(int(np.argmax(drift - ship)), x.shape)
        place = f"({x[k]:.6g}, {y[k]:.6g}) m"
        return (f"no route: the current is stronger than the ship, {drift[k] / KNOT:.3g} kn at {place}, where she makes at most "
                f"{ship[k] / KNOT:.3g} kn: she cannot hold her way against it to the end")  # fmt: skip
    if (closed := _limited(problem)) is not None:
        return closed
    causes = []
    if problem.areas:
        causes.append("forbidden areas")
    if math.isfinite(medium.horizon) or not bool(medium.inside(np.array([1e12]), np.array([1e12]))[0]):
        causes.append("the edge of the wave data")
    if not visibility.even(medium) or np.any(ship <= 0.0):
        causes.append("seas against which the ship makes no way")
    return "no route: every way to the end is closed by " + (" or ".join(causes) or "winds in which the ship makes no way")


def _limited(problem: Problem) -> str | None:
    """Which limit closes the straight way, where, and what to try; None where none does."""
    free = replace(problem, medium=replace(problem.medium, limits=()))
    way = _along(free, [problem.start, problem.end], "straight", [])
    found = kept(problem.medium, way.time, way.x, way.y) if way else ()
    worst = broken(found)
    if worst is None:
        return None
    return (f"no route within the limits: on the straight way {worst.limit.name!r} ({worst.limit.text}) is exceeded by "
            f"{worst.use - 1.0:.0%} at {worst.place}, and the lattice finds no way around: leave later or earlier, allow more, "
            "or lay the route by way of places that you choose")  # fmt: skip


def _along(problem: Problem, points: Sequence[Point], kind: str, notes: list[str]) -> Route | None:
    """The given line, sailed; None with a note where it cannot be."""
    line = sailed(points, STRAIGHT_LEGS)
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
    if (worst := broken(kept(problem.medium, times, line[:, 0], line[:, 1]))) is not None:
        notes.append(f"the {kind} route breaks the limit {worst.limit.name!r} ({worst.limit.text}) by {worst.use - 1.0:.0%} at "
                     f"{worst.place}")  # fmt: skip
        return None
    return Route(kind, times, line[:, 0], line[:, 1])


def _shares(medium: Medium, route: Route) -> tuple[float, float]:
    """Shares of the time on legs beyond the polar's range, and on legs that the ship makes good by tacking only: whose course
    through the water lies between the corners of a chord of the hull, where the table itself is slower."""
    spent = np.diff(route.time)
    x, y, t = (0.5 * (v[1:] + v[:-1]) for v in (route.x, route.y, route.time))
    m = medium.map.scale(x, y)[0]
    u, w = medium.current.at(x, y, t)[:2]
    vx, vy = (np.diff(place) / np.maximum(spent, 1e-300) / m - drift for place, drift in ((route.x, u), (route.y, w)))
    size = np.maximum(np.hypot(vx, vy), 1e-300)
    made, own, over = medium.frozen(t, x, y).sail(vx / size, vy / size)
    tacks = made > (1.0 + TACKS) * own
    return float(np.sum(spent * over) / route.duration), float(np.sum(spent * tacks) / route.duration)
