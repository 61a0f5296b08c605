"""The minimal-time route of a route file, what it saves, and what it is written as."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from towage.errors import SceneError, TowageError
from towage.models.route.plan import Plan, plan
from towage.models.route.problem import Route, RouteError
from towage.routing.chart import draw
from towage.routing.file import RouteFile, load
from towage.routing.output import HOUR, MILE, ROWS, write_csv, write_gpx, write_source_table

Which = Literal["best", "straight"]
CELLS, RADIUS = 20, 3
"""Meshes of the graph from start to end, and the reach of one of its legs, by default."""
_REFUSED = ("input", "outside", "forbidden")
"""Reasons of a `RouteError` that lie in the file."""


@dataclass(frozen=True)
class PlannedRoute:
    """``given``: what the file says. ``plan``: the best route, other local minima, the straight route and the geodesic."""

    given: RouteFile
    plan: Plan
    cells: int
    radius: int

    @property
    def distance(self) -> float:
        """From start to end along the geodesic of the map, m."""
        problem = self.given.problem
        return problem.medium.map.distance(problem.start, problem.end)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed and filled in the data, and what the plan left out, for people."""
        return (*self.given.notes, *self.plan.notes)

    def document(self) -> dict[str, Any]:
        """Times in h, distance in nautical miles, the certificate (j in m/rad) and shares of the voyage, as plain data;
        None for what there is not."""
        best, hours = self.plan.best, self._hours()
        return {
            "title": self.given.title, "kind": best.kind, "best_h": best.duration / HOUR,
            "other_minima_h": [other.duration / HOUR for other in self.plan.others],
            "error_h": _finite(best.error / HOUR), "lower_bound_h": _finite(self.plan.lower_bound / HOUR),
            "straight_h": hours["straight"], "geodesic_h": hours["geodesic"], "graph_h": hours["graph"],
            "saving": self.plan.saving, "distance_nmi": self.distance / MILE, "certified": best.certified,
            "j_exact_m_per_rad": _finite(best.j_exact), "j_seed_m_per_rad": _finite(best.j_seed),
            "beyond_forecast": self.plan.beyond_horizon, "beyond_polar": self.plan.beyond_polar,
            "tacking": self.plan.tacking,
            "limits": [
                {"name": one.limit.name, "limit": one.limit.text, "margin": _finite(1.0 - one.use), "time_h": one.time / HOUR,
                 "x_nmi": one.x / MILE, "y_nmi": one.y / MILE, "beyond_table": one.beyond} for one in self.plan.limits
            ],
            "notes": self.notes,
        }  # fmt: skip

    def text(self) -> str:
        """A few lines for a terminal."""
        best, hours = self.plan.best, self._hours()
        lines = [f"{self.given.title}: {self.distance / MILE:.1f} nmi"]
        error = f", within {best.error / HOUR:.1e} h" if best.error > 0.0 else ""
        lines.append(f"  best route        {best.duration / HOUR:12.6f} h   ({best.kind}{error})")
        second = next((f"{other.duration / HOUR:12.6f} h   (local minimum)" for other in self.plan.others), "")
        lines.append(f"  second best       {second or '     none found'}")
        for name in ("straight", "geodesic"):
            time = hours[name]
            lines.append(f"  {name:17} {time:12.6f} h" if time is not None else f"  {name:17}       none")
        if hours["graph"] is not None:
            lines.append(f"  graph             {hours['graph']:12.6f} h   ({self.cells} meshes, radius {self.radius})")
        if self.plan.saving is not None:
            lines.append(f"  saving over the straight route: {self.plan.saving:.2%}")
        if math.isfinite(self.plan.lower_bound) and best.duration > 0.0:
            least, gap = self.plan.lower_bound / HOUR, 1.0 - self.plan.lower_bound / best.duration
            lines.append(f"  lower bound       {least:12.6f} h   (no route is faster; {gap:.2%} below the best)")
        elif best.duration > 0.0:
            lines.append("  lower bound               none   (the sea changes within its mesh)")
        if best.kind == "visibility":
            lines.append("  certificate: global minimum, the shortest path of the visibility graph")
        elif best.certified and math.isfinite(best.j_exact):
            lines.append(f"  certificate: local minimum, j_exact = {best.j_exact / MILE:.6g} nmi/rad > 0 along the track "
                         f"(source's j = {best.j_seed / MILE:.6g})")  # fmt: skip
        elif not best.certified:
            lines.append("  certificate: none")
        for one in self.plan.limits:
            lines.append(f"  limit {one.limit.name!r}, {one.limit.text}: margin {1.0 - one.use:.3f}, at most {one.use:.1%} of it"
                         f", at {one.place}")  # fmt: skip
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def save_csv(self, path: Path, of: Which = "best", rows: int = ROWS) -> None:
        """The track of a route: hours, nautical miles or degrees, knots, metres, seconds; the unit `playback` plays it. Raises
        `TowageError`."""
        write_csv(path, self.given.problem, self._route(of), rows)

    def save_gpx(self, path: Path, of: Which = "best", rows: int = ROWS) -> None:
        """The track of a route as GPX 1.1, for a plotter; times where the file has a departure. Raises `TowageError` on a flat
        map, which has no latitudes."""
        write_gpx(path, self.given, self._route(of), rows)

    def save_source_table(self, path: Path) -> None:
        """What the source prints along the track of an extremal: LAMBDA, S, J, Q. Raises `TowageError` for another kind."""
        write_source_table(path, self.given.problem, self.plan.best)

    def save_map(self, path: Path, hours: Sequence[float] | None = None) -> None:
        """Waves and routes at these hours (default: a quarter, half and three quarters of the voyage), as .svg, .png or
        .pdf. Raises `TowageError`."""
        draw(path, self.given.title, self.given.problem, self.plan, hours)

    def _route(self, of: Which) -> Route:
        chosen = self.plan.best if of == "best" else self.plan.straight
        if chosen is None:
            raise TowageError(f"{self.given.path}: there is no {of} route: {'; '.join(self.notes)}")
        return chosen

    def _hours(self) -> dict[str, float | None]:
        named = {"straight": self.plan.straight, "geodesic": self.plan.geodesic}
        hours = {name: other.duration / HOUR if other else None for name, other in named.items()}
        return hours | {"graph": self.plan.graph_time / HOUR if math.isfinite(self.plan.graph_time) else None}


def route(
    file: str | Path,
    *,
    method: Literal["safeguarded", "seed", "graph"] | None = None,
    cells: int = CELLS,
    radius: int = RADIUS,
    fraction: float | None = None,
) -> PlannedRoute:
    """The minimal-time route of a route file, or of a shipped one ("storm", "pacific"): what ``towage route`` does.

        towage.route("storm").document()["best_h"]

    ``method``: in place of the file's: safeguarded; seed, the iteration of the source (NPS 1964) as it was used; graph,
    the lattice and its refinement alone. ``cells``: meshes of the graph from start to end; ``radius``: reach of a leg,
    meshes. ``fraction``: of the corrections of the method seed, in place of the file's; the source took 0.5. Nothing is written.

    Raises `SceneError` for a file that cannot be read or asks for what there is not, `TowageError` where no route exists.
    """
    given = load(file)
    try:
        planned = plan(given.problem, method=method or given.method, cells=cells, radius=radius,
                       fraction=given.fraction if fraction is None else fraction)  # fmt: skip
    except RouteError as error:
        if error.reason in _REFUSED:
            raise SceneError(str(error), file=given.path) from error
        raise TowageError(f"{given.path}: {error}") from error
    return PlannedRoute(given, planned, cells, radius)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
