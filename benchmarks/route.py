"""Error against time of the ways to a minimal-time route, and the cost of an irregular sea; prints Markdown.

    python benchmarks/route.py [--repeat 3]

Peers: the source's own iteration, the graph alone, and the PyPI package ``weatherrouting`` (isochrones), where it is
installed and finishes. That package sails on a sphere: the problem is laid along the equator, which changes its times
by less than 0.1 %, and its polar diagram is a table of the same ellipse, wave feet written as knots of wind.
"""

from __future__ import annotations

import argparse
import datetime
import io
import json
import math
import time
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np

from towage.models.numeric.ops import FLOATS
from towage.models.route import graph as route_graph
from towage.models.route import shooting as route_shooting
from towage.models.route.plan import plan
from towage.models.route.polar import FOOT, KNOT
from towage.models.route.problem import Problem, RouteError
from towage.models.sea import heave_response, ship_in_sea
from towage.verify import sea as verify_sea

HOUR, MILE = 3600.0, 1852.0
STORMS = ("P7 static", "P7b static mild", "P8 moving")
LIMIT = 120.0
"""A peer that takes longer than this, s, is stopped."""


def cases() -> dict[str, tuple[Problem, float]]:
    """Problem and time of the global minimum, h."""
    text = (files("towage") / "reference" / "sea_and_route.json").read_text("utf-8")
    cases = {c["name"]: c for c in json.loads(text)["cases"] if c["name"] in STORMS}
    return {n: (verify_sea.problem(cases[n]["inputs"]), cases[n]["expected"]["local_minima_h"][0]) for n in STORMS}


def timed(work: Callable[[], float | None], repeat: int) -> tuple[float | None, float]:
    """(result in h, least CPU time in s)."""
    best, value = math.inf, None
    for _ in range(repeat):
        begin = time.process_time()
        value = work()
        best = min(best, time.process_time() - begin)
    return value, best


def by_plan(problem: Problem, **options: Any) -> float | None:
    """Time, h; None where there is no answer."""
    try:
        return plan(problem, **options).best.duration / HOUR
    except RouteError:
        return None


def by_graph(problem: Problem, cells: int, radius: int) -> float | None:
    """Time over the lattice alone, h."""
    path = route_graph.search(problem.medium, problem.start, problem.end, cells=cells, radius=radius)
    return path.duration / HOUR if path else None


def by_shooting(problem: Problem, steps: int) -> float | None:
    """Safeguarded shooting from the answer of a coarse graph, without fan and comparisons."""
    path = route_graph.search(problem.medium, problem.start, problem.end)
    if path is None:
        return None
    ahead = path.points[2]
    alpha = problem.medium.normal(0.0, *problem.start, math.atan2(*(ahead - problem.start)[::-1]))
    shots = route_shooting.shoot(problem.medium, problem.start, problem.end, [alpha], [path.duration], steps=steps)
    return float(shots.time[0]) / HOUR if shots.converged[0] else None


def by_isochrones(problem: Problem, step: float) -> float | None:
    """The package ``weatherrouting``, isochrones every ``step`` h; None where it does not finish."""
    import weatherrouting  # type: ignore[import-not-found,unused-ignore]
    from weatherrouting.routers.linearbestisorouter import (  # type: ignore[import-not-found,unused-ignore]
        LinearBestIsoRouter,
    )

    medium, start = problem.medium, datetime.datetime(2020, 1, 1)

    class Field(weatherrouting.Grib):  # type: ignore[misc,name-defined,unused-ignore]
        """The waves as the wind that the package expects: feet of height as knots."""

        def get_wind_at(self, t: datetime.datetime, lat: float, lon: float) -> tuple[float, float]:
            """(bearing that the waves come from, degrees; height, ft, as a speed in m/s)."""
            one = np.ones(1)
            sea = medium.field.at(lon * 60.0 * MILE * one, lat * 60.0 * MILE * one, (t - start).total_seconds() * one)
            bearing = 90.0 - math.degrees(math.atan2(sea.ky[0], sea.kx[0]))
            return bearing % 360.0, float(sea.height[0]) / FOOT * KNOT

    heights, angles = range(0, 49, 2), range(0, 181, 5)
    lines = ["TWA\\TWS\t" + "\t".join(map(str, heights))]
    for angle in angles:
        speeds = []
        for h in heights:
            a, b, c = medium.polar.axes(h * FOOT, FLOATS)[:3]  # type: ignore[union-attr]
            k, n = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            q, e = (k / a) ** 2 + (n / b) ** 2, -k * c / a**2
            speeds.append((e + math.sqrt(e * e - q * ((c / a) ** 2 - 1.0))) / q / KNOT)
        lines.append(f"{angle}\t" + "\t".join(f"{v:.4f}" for v in speeds))
    polar = weatherrouting.Polar("", f=io.StringIO("\n".join(lines) + "\n"))
    end = (problem.end[1] / MILE / 60.0, problem.end[0] / MILE / 60.0)
    routing = weatherrouting.Routing(LinearBestIsoRouter, polar, [(0.0, 0.0), end], Field(), start, start_position=(0.0, 0.0))
    routing.wp = 1
    begin = time.process_time()
    while not routing.end and time.process_time() - begin < LIMIT:
        outcome = routing.step(timedelta=step)
        if outcome.path:
            last = outcome.path[-1]
            left = last.point_distance(end)
            hours = (last.time - start).total_seconds() / HOUR
            return hours + left / max(float(last.speed or 0.0), 1.0)
    return None


def routes(repeat: int) -> None:
    """Error and CPU time of every way in every storm."""
    try:
        import weatherrouting  # noqa: F401

        peers = (2.0, 1.0)
    except ImportError:
        peers = ()
    ways: list[tuple[str, Callable[[Problem], float | None], int]] = [
        ("the source's iteration", lambda p: by_plan(p, method="seed"), 1),
        *((f"graph, 20 meshes, radius {r}", lambda p, r=r: by_graph(p, 20, r), repeat) for r in (1, 2, 3)),
        *((f"graph, 50 meshes, radius {r}", lambda p, r=r: by_graph(p, 50, r), 1) for r in (1, 3, 5, 8)),
        *((f"graph and safeguarded shooting, {n} steps", lambda p, n=n: by_shooting(p, n), repeat) for n in (16, 32)),
        ("`plan` (with second basin, certificate, straight)", lambda p: by_plan(p), repeat),
        ("graph refined in a corridor", lambda p: by_plan(p, method="graph"), 1),
        *((f"weatherrouting, isochrones every {s:g} h", lambda p, s=s: by_isochrones(p, s), 1) for s in peers),
    ]  # type: ignore[misc]
    problems = cases()
    print("| way | " + " | ".join(f"{name}: error h | CPU s" for name in problems) + " |")
    print("|---|" + "---|---|" * len(problems))
    for name, way, times in ways:
        cells = []
        for problem, exact in problems.values():
            value, cpu = timed(partial(way, problem), times)
            cells.append(f"{value - exact:+.1e} | {cpu:.2f}" if value is not None else f"none | {cpu:.2f}")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def basins() -> None:
    """What 41 starting courses end in."""
    print("\n| iteration | " + " | ".join(f"{n}: global / other minimum / saddle / none" for n in cases()) + " |")
    print("|---|" + "---|" * len(STORMS))
    for method, fraction in (("seed", 1.0), ("seed", 0.5), ("seed", 0.25), ("exact", 1.0), ("exact", 0.5), ("safeguarded", 1.0)):
        cells = []
        for problem, exact in cases().values():
            shots = route_shooting.shoot(
                problem.medium, problem.start, problem.end, np.linspace(-1.2, 1.2, 41), np.full(41, 60.0 * HOUR),
                method=method, fraction=fraction, steps=16, tolerance=1e-7,
            )  # fmt: skip
            good = shots.converged & (shots.j_exact > 0.0)
            best = good & (np.abs(shots.time / HOUR - exact) < 1e-4)
            counts = [best, good & ~best, shots.converged & ~good, ~shots.converged]
            cells.append(" / ".join(str(int(c.sum())) for c in counts))
        print(f"| {method}, fraction {fraction:g} | " + " | ".join(cells) + " |", flush=True)


def heave(repeat: int) -> None:
    """Cost of the irregular sea of `ship_in_sea` per component and evaluation."""
    print("\n| components | one evaluation, steady sea, us | changing sea, us | per component ns | new sea state, us |")
    print("|---|---|---|---|---|")
    for n in (25, 50, 100, 200):
        p = ship_in_sea.Parameters(174.65, 14.26, 7.77, 1.0, 0.0, 1.0, float(n), -1.0, 8.0, 1964.0, 10.0, 0.0, 4e7, 7e6,
                                   3e7, 0.05)  # fmt: skip
        u = ship_in_sea.Inputs(0.0, 6.0, 0.0, math.pi, 7.5)
        x, m = ship_in_sea.initial(p, FLOATS)
        x, m = ship_in_sea.transition(0.0, x, m, u, p, FLOATS)
        changing = x._replace(new_height=5.0)
        times = []
        for state in (x, changing):
            ship_in_sea.free_motion(0.0, state, p)
            best = math.inf
            for _ in range(repeat):
                begin = time.process_time()
                for k in range(2000):
                    ship_in_sea.free_motion(0.001 * k, state, p)
                best = min(best, (time.process_time() - begin) / 2000)
            times.append(best)
        begin = time.process_time()
        for k in range(50):
            heave_response.heave_amplitudes(6.0 + k, 0.5, 7.5, math.pi, p.hull, p.sea)
        new = (time.process_time() - begin) / 50
        print(f"| {n} | {times[0] * 1e6:.1f} | {times[1] * 1e6:.1f} | {times[0] / n * 1e9:.0f} | {new * 1e6:.0f} |")


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    routes(arguments.repeat)
    basins()
    heave(arguments.repeat)


if __name__ == "__main__":
    main()
