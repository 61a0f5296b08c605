"""What a computed route is written as: a table of the voyage, CSV, parameters of the unit `voyage`, and a map.

A `Voyage` holds what the ship meets at instants of her route, SI and radians: heading clockwise from north (on a flat map
y is north), wave direction between course and travel of the waves, pi for head seas, both unwrapped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.files import atomic_write
from towage.models.route import voyage
from towage.models.route.maps import StereographicMap
from towage.models.route.plan import Plan, Problem, Route
from towage.models.sea.waves import peak_frequency
from towage.report.svg import save_figure

Array = NDArray[np.float64]
MILE, KNOT, HOUR = 1852.0, 1852.0 / 3600.0, 3600.0
CALM = 0.1
"""Height below which a period is that of this height, m."""


@dataclass(frozen=True)
class Voyage:
    """What the ship meets, columns of shape (n,): time, s; place on the plane of the map, m; heading and wave direction, rad;
    speed, m/s; wave height, m, and period, s."""

    time: Array
    x: Array
    y: Array
    heading: Array
    speed: Array
    wave_height: Array
    wave_period: Array
    wave_direction: Array


def voyage_table(problem: Problem, route: Route, count: int) -> Voyage:
    """The voyage at ``count`` instants at equal distances in time."""
    medium = problem.medium
    time = np.linspace(0.0, route.duration, count)
    if len(route.time) < 2:
        x, y = np.full(count, route.x[0]), np.full(count, route.y[0])
        dx, dy = np.ones(count), np.zeros(count)
    else:
        from scipy.interpolate import CubicSpline

        kind = "natural" if len(route.time) < 4 else "not-a-knot"
        spline = CubicSpline(route.time, np.column_stack([route.x, route.y]), bc_type=kind)
        (x, y), (dx, dy) = spline(time).T, spline(time, 1).T
    angle = np.unwrap(np.arctan2(dy, dx))
    scale = medium.map.scale(x, y)[0]
    sea = medium.field.at(x, y, time)
    period = medium.field.period(x, y, time)
    own = np.array([2.0 * math.pi / peak_frequency(max(h, CALM)) for h in sea.height])
    if isinstance(medium.map, StereographicMap):
        heading = np.unwrap(medium.map.bearing(x, y, angle))
    else:
        heading = 0.5 * math.pi - angle
    # k points to where the waves come from: they meet the ship head on where k lies along the course
    encounter = math.pi - np.unwrap(np.arctan2(sea.ky, sea.kx) - angle)
    return Voyage(
        time, x, y, heading, np.hypot(dx, dy) / scale if len(route.time) > 1 else 0.0 * x, sea.height,
        np.where(period > 0.0, period, own), encounter,
    )  # fmt: skip


def write_csv(path: Path, problem: Problem, route: Route, count: int = 101) -> None:
    """The voyage as CSV: hours, nautical miles or degrees, knots, metres, seconds, degrees."""
    v = voyage_table(problem, route, count)
    plane = problem.medium.map
    if isinstance(plane, StereographicMap):
        a, b = (np.degrees(c) for c in plane.to_geographic(v.x, v.y))
        names = "latitude_deg,longitude_deg"
    else:
        a, b = v.x / MILE, v.y / MILE
        names = "x_nmi,y_nmi"
    columns = [
        v.time / HOUR, a, b, np.degrees(v.heading) % 360.0, v.speed / KNOT, v.wave_height, v.wave_period,
        np.degrees(v.wave_direction) % 360.0,
    ]  # fmt: skip
    head = f"time_h,{names},heading_deg,speed_kn,wave_height_m,wave_period_s,wave_direction_deg"
    lines = [head] + [",".join(f"{value:.9g}" for value in row) for row in zip(*columns)]
    with atomic_write(path) as stream:
        stream.write(("\n".join(lines) + "\n").encode())


def unit_parameters(problem: Problem, route: Route) -> dict[str, float]:
    """Parameters of the unit `voyage` for a route, SI."""
    v = voyage_table(problem, route, voyage.POINTS)
    horizon = problem.medium.field.horizon
    parameters = {"duration": route.duration, "horizon": horizon if math.isfinite(horizon) else 0.0}
    for column in voyage.COLUMNS:
        parameters |= {f"{column}_{k}": float(f"{value:.7g}") for k, value in enumerate(getattr(v, column))}
    return parameters


def parameters_text(values: dict[str, float], prefix: str = "") -> str:
    """Parameters as lines of TOML, a column a paragraph; with ``prefix`` "voyage." for the ``set`` of a case."""
    lines, last = [], ""
    for name, value in values.items():
        column = name.rpartition("_")[0] if name[-1].isdigit() else ""
        if column != last:
            lines.append("")
        last = column
        key = f'"{prefix}{name}"' if prefix else name
        lines.append(f"{key} = {value!r}")
    return "\n".join(lines) + "\n"


def draw(path: Path, title: str, problem: Problem, plan: Plan, hours: Sequence[float] | None = None) -> None:
    """Map at one or more times (default: a quarter, half and three quarters of the voyage): contours of wave height,
    arrows the way the waves travel, all routes, and the ship where she is then."""
    from matplotlib.figure import Figure

    times = [h * HOUR for h in hours] if hours else [f * plan.best.duration for f in (0.25, 0.5, 0.75)]
    routes: list[tuple[str, Route, dict[str, Any]]] = [("best", plan.best, {"color": "#c8102e", "lw": 2.0})]
    routes += [(f"local minimum {k}", r, {"color": "#1f77b4", "ls": "--"}) for k, r in enumerate(plan.others, 2)]
    for name, other, dots in (("straight", plan.straight, ":"), ("geodesic", plan.geodesic, "-.")):
        if other is not None and (name == "straight" or other is not plan.straight):
            routes.append((name, other, {"color": "black", "ls": dots, "lw": 1.0}))
    xs, ys = (np.concatenate([np.ravel(getattr(r, c)) for _, r, _ in routes]) for c in ("x", "y"))
    pad = 0.12 * max(np.ptp(xs), np.ptp(ys), MILE)
    x = np.linspace(xs.min() - pad, xs.max() + pad, 90)
    y = np.linspace(ys.min() - 2.0 * pad, ys.max() + 2.0 * pad, 70)
    gx, gy = np.meshgrid(x, y)
    inside = problem.medium.field.inside(gx, gy)
    height = max(2.2, 6.0 * (y[-1] - y[0]) / (x[-1] - x[0]))
    figure = Figure(figsize=(8.0, (min(height, 6.0) + 0.5) * len(times)), layout="constrained")
    for k, t in enumerate(times):
        axes = figure.add_subplot(len(times), 1, k + 1)
        sea = problem.medium.field.at(gx, gy, np.full(gx.shape, t))
        waves = np.where(inside, sea.height, math.nan)
        if np.nanmax(waves) > np.nanmin(waves):
            lines = axes.contour(x / MILE, y / MILE, waves, levels=8, colors="0.55", linewidths=0.8)
            axes.clabel(lines, fmt="%.1f m", fontsize=7)
        if np.nanmax(waves) > 0.0:
            some = (slice(None, None, 10), slice(None, None, 9))
            shown = (inside & sea.directed)[some]
            axes.quiver(gx[some][shown] / MILE, gy[some][shown] / MILE, -sea.kx[some][shown], -sea.ky[some][shown],
                        color="0.75", scale=40, width=0.002)  # fmt: skip
        for area in problem.areas:
            mask = area.contains(gx, gy)
            if mask.any():
                axes.contourf(x / MILE, y / MILE, mask.astype(float), levels=[0.5, 1.5], colors=["#d9c9a3"])
        for name, route, style in routes:
            axes.plot(route.x / MILE, route.y / MILE, label=f"{name}, {route.duration / HOUR:.2f} h", **style)
            if len(route.time) > 1:
                place = [np.interp(t, route.time, c) / MILE for c in (route.x, route.y)]
                axes.plot(*place, "o", color=style["color"], ms=5)
        axes.set_aspect("equal")
        axes.set_title(f"{title}: {t / HOUR:.1f} h" if k == 0 else f"{t / HOUR:.1f} h", fontsize=9)
        axes.set_xlabel("nmi")
        if k == 0:
            axes.legend(fontsize=7, loc="best")
    save_figure(figure, path)
