"""What several figures of the thesis on the docking platform are made of: orbits, transients, curves over frequency.

Steady motions are periodic orbits found by shooting; `Answer.methods` compares some of them with a long transient, and closed
forms with the integrated equation. Lengths over X0, r = omega/omega0, B = b X0/M, w = W/(K X0).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from towage.models.heave import linear, orbits, sdof
from towage.models.heave.shooting import flow
from towage.models.heave.system import Simulation, System
from towage.reproduce.items import Column
from towage.verify.cradle import dimensionless_system

Array = NDArray[np.float64]
DRAGS = (0.05, 0.1, 0.2, 0.3, 0.5, 1.0)
RATIOS = np.concatenate([np.linspace(0.2, 0.7, 11), np.linspace(0.725, 1.3, 24), np.linspace(1.4, 3.0, 17)])
SOME = ((0.3, 0.5, None), (0.3, 1.0, None), (1.0, 1.5, None))
"""(B, r, w) of the orbits that are compared."""
COUNTED = 40
"""Periods."""
TURN = 2.0 * math.pi


def line_tension(length: float, r: float) -> float:
    """The largest tension of Alvin's line, lb."""
    scale = 1040.0 * 100.0 / length * 4.4
    system = dimensionless_system(0.3, r, 8100.0 / scale)
    run = Simulation(system, 0.0, (0.0, 0.0))
    run.advance(COUNTED * system.period)
    run.restart()
    run.advance(2 * COUNTED * system.period)
    return run.tension_max * scale


def short(number: float) -> str:
    """Without the zero before the point, as the thesis prints it."""
    return f"{number:g}".removeprefix("0")


def as_complex(numbers: dict[str, float]) -> dict[str, complex]:
    """As `Answer` takes them."""
    return {name: complex(value) for name, value in numbers.items()}


def listed(numbers: dict[str, float]) -> dict[str, Column]:
    """A table of one column."""
    return {"what": list(numbers), "computed": list(numbers.values())}


def linear_motion(zeta: float, r: float) -> tuple[float, float]:
    """(amplitude over X0, lag, rad)."""
    return linear.response(1.0, 2.0 * zeta, 1.0, float(r))


def linear_system(zeta: float, r: float) -> System:
    """The SI models of the linear twin."""
    system = dimensionless_system(0.0, r, None)
    return replace(system, cradle=replace(system.cradle, linear_damping=2.0 * zeta))


@lru_cache
def orbit(drag: float, r: float, w: float | None = None) -> orbits.Orbit:
    """The steady motion."""
    return orbits.steady(dimensionless_system(drag, r, w))


@lru_cache
def curve(drag: float) -> list[orbits.Orbit]:
    """Steady motions at `RATIOS`."""
    return orbits.response_curve(dimensionless_system(drag, 1.0, None), [float(r) for r in RATIOS])


@lru_cache
def largest(drag: float) -> tuple[float, float]:
    """(r, Ymax) of the largest displacement over r."""
    ratio, steady = orbits.peak(dimensionless_system(drag, 1.0, None), 0.5, 1.2, points=15)
    return ratio, steady.heave_max


@lru_cache
def by_transients(points: Sequence[tuple[float, float, float | None]] = SOME) -> float:
    """Largest difference of the state of some orbits from that which a run from rest has reached after many periods."""
    worst = 0.0
    for drag, r, w in points:
        steady, system = orbit(drag, r, w), dimensionless_system(drag, r, w)
        largest = max(map(abs, steady.multipliers))
        count = 5 + math.ceil(math.log(1e-11) / math.log(largest))
        state = flow(system, (0.0, 0.0), count * system.period)
        worst = max(worst, max(abs(a - b) for a, b in zip(state, steady.state)) / steady.heave_max)
    return worst


def first_integral(drag: float, count: int) -> list[float]:
    """Extrema of a free decay from Y = 1: between them (1 + 2 B y) exp(-2 B y) is the same at y and -y'."""
    from scipy.optimize import brentq

    extrema, y = [], 1.0
    for _ in range(count):
        left = (1.0 + 2.0 * drag * y) * math.exp(-2.0 * drag * y)
        y = brentq(lambda z, left=left: (1.0 - 2.0 * drag * z) * math.exp(2.0 * drag * z) - left, 1e-9, y, xtol=1e-15)
        extrema.append(y)
    return extrema


def sdof_error() -> tuple[float, float, float]:
    """(r, error, eps) of the largest error of the amplitude in example one, zeta1 = .05 and B = .3."""
    pair = sdof.Pair(28.0, 2.0 * 0.05 * math.sqrt(72.0 * 28.0), 72.0, 1.617, 1.0, 0.3 * 1.617, 1.0)
    omega, error, eps = sdof.worst(pair)
    return omega / pair.cradle_frequency, error, eps
