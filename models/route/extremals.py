"""Local minima of a route problem by shooting from many courses, with steps that their error decides.

Starts: the straight course, that of the lattice path, a fan, and courses that pass each storm on either side at some multiples of
its size. A first pass takes steps as long as what changes in the sea; what converges is shot again with twice as many steps until
the duration changes by less than `ACCURACY`. Its last change is the error that is told: the duration itself is better, by a
factor of 2^8 where the sea is smooth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..numeric.arrays import AnyArray
from .areas import blocked
from .graph import Path
from .limits import broken, kept
from .problem import Problem, Route
from .shooting import Shots, Track, shoot, tracks

SAME = 1e-5
"""Two extremals whose times and starting directions agree to this share are one."""
ACCURACY = 1e-8
"""Change of the duration, as a share, below which steps are short enough."""
COARSE, MOST = 16, 512
"""Least steps of the first pass, most of the last."""
ASIDE = (-2.5, -1.5, -0.75, 0.75, 1.5, 2.5)
"""Where courses pass a storm, in sizes of it."""


def extremals(
    problem: Problem, path: Path | None, method: str, fan: int, fraction: float, notes: list[str]
) -> list[Route]:
    """Distinct local minima that can be sailed, by time."""
    medium, start, end = problem.medium, problem.start, problem.end
    guess = path.duration if path else calm_time(problem)
    courses = _courses(problem, path, 1 if method == "seed" else fan, guess)
    alpha = np.array([medium.normal(0.0, start[0], start[1], c) for c in courses])
    coarse = int(np.clip(math.ceil(math.dist(start, end) / medium.detail), COARSE, MOST // 4))
    first = shoot(medium, start, end, alpha, np.full(len(alpha), guess), method=method, steps=coarse, fraction=fraction,
                  iterations=40 if method != "seed" else 80, tolerance=1e-6)  # fmt: skip
    kept = _distinct(first)
    if not kept:
        return []
    found, errors, steps = _converged(problem, first.alpha[kept], first.time[kept], method, fraction, 2 * coarse)
    routes = []
    good = [k for k in range(len(kept)) if found.converged[k]]
    for k, way in zip(good, tracks(medium, start, found.alpha[good], found.time[good], steps) if good else []):
        reason = _reason(problem, way, method)
        if reason:
            notes.append(f"the extremal of {way.time[-1] / 3600.0:.2f} h {reason}: dropped")
            continue
        iterations = int(first.iterations[kept[k]] + found.iterations[k])
        routes.append(Route("extremal", way.time, way.x, way.y, way.certified, float(way.j_exact[-1]), float(found.j_seed[k]),
                            iterations, float(found.alpha[k]), errors[k], way))  # fmt: skip
    return sorted(routes, key=lambda r: r.duration)


def _courses(problem: Problem, path: Path | None, fan: int, guess: float) -> list[float]:
    """Courses to start with, rad: the straight one, and without a ``fan`` no other (the source's way)."""
    (x0, y0), (x1, y1) = problem.start, problem.end
    course = math.atan2(y1 - y0, x1 - x0)
    if fan < 2:
        return [course]
    ahead = path.points[min(len(path.points) - 1, 1 + len(path.points) // 8)] if path else problem.end
    spread = 1.0 if path else math.pi
    courses = [math.atan2(ahead[1] - y0, ahead[0] - x0), course]
    courses += [course + spread * (2.0 * k / (fan - 1) - 1.0) for k in range(fan)]
    nx, ny = -math.sin(course), math.cos(course)
    for share in (0.25, 0.5, 0.75):
        for x, y, size in problem.medium.field.centres(share * guess):
            if abs((x - x0) * math.cos(course) + (y - y0) * math.sin(course) - share * math.dist(problem.start, problem.end)) < (
                0.25 * math.dist(problem.start, problem.end)
            ):
                courses += [math.atan2(y + a * size * ny - y0, x + a * size * nx - x0) for a in ASIDE]
    return courses


def _distinct(shots: Shots) -> list[int]:
    """Indices of converged shots that differ, by time."""
    kept: list[int] = []
    for k in np.argsort(shots.time):
        if shots.converged[k] and not any(
            abs(shots.time[k] / shots.time[o] - 1.0) < SAME and abs(math.sin(0.5 * (shots.alpha[k] - shots.alpha[o]))) < 1e-3
            for o in kept
        ):
            kept.append(int(k))
    return kept


def _converged(
    problem: Problem, alpha: AnyArray, time: AnyArray, method: str, fraction: float, steps: int
) -> tuple[Shots, list[float], int]:
    """(shots, their errors, s, steps): twice the steps until the durations hold."""
    before = np.full(len(alpha), math.nan)
    while True:
        shots = shoot(problem.medium, problem.start, problem.end, alpha, time, method=method, steps=steps, iterations=80,
                      fraction=fraction)  # fmt: skip
        error = np.abs(shots.time - before)
        good = shots.converged
        if not good.any() or np.all(error[good] <= ACCURACY * shots.time[good]) or 2 * steps > MOST:
            return shots, error.tolist(), steps
        alpha, time, before = shots.alpha, shots.time, shots.time.copy()
        steps *= 2


def _reason(problem: Problem, way: Track, method: str) -> str:
    """Why a track is no answer; empty if it is one."""
    outside = ~problem.medium.inside(way.x, way.y)
    if np.any(outside):
        i = int(np.argmax(outside))
        return f"leaves the data at ({way.x[i]:.6g}, {way.y[i]:.6g}) m, t = {way.time[i]:.6g} s"
    if np.any(blocked(problem.areas, way.x[:-1], way.y[:-1], way.x[1:], way.y[1:])):
        return "crosses a forbidden area"
    if (worst := broken(kept(problem.medium, way.time, way.x, way.y))) is not None:
        return f"breaks the limit {worst.limit.name!r} ({worst.limit.text}) by {worst.use - 1.0:.0%} at {worst.place}"
    if method != "seed" and not way.certified:
        return "has a conjugate point and is no minimum"
    return ""


def calm_time(problem: Problem) -> float:
    """A first guess of the time from the speed at the start."""
    x0, y0 = problem.start
    d = math.dist(problem.start, problem.end)
    one = np.ones(1)
    v = problem.medium.speed_along(0.0 * one, x0 * one, y0 * one, (problem.end[0] - x0) / d * one,
                                   (problem.end[1] - y0) / d * one)  # fmt: skip
    return d / max(float(v[0]), 1e-3)


def sailed(points: Sequence[tuple[float, float]] | AnyArray, legs: int) -> AnyArray:
    """A line of two points in ``legs`` equal legs; any other as it is."""
    line = np.asarray(points, dtype=float)
    if len(line) == 2:
        line = line[0] + (line[1] - line[0]) * np.linspace(0.0, 1.0, legs + 1)[:, None]
    return line
