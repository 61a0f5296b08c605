"""A voyage along a computed route: where the ship is, how she sails and what sea she meets.

    f(t) = sum_k f_k K(tau/d - k),   tau = min(pace t, duration),   d = duration/(POINTS - 1)

| symbol | meaning | unit |
|---|---|---|
| f | x, y (m), heading (rad), speed (m/s), wave height (m), peak period (s), wave direction (rad) | |
| f_k | its value at POINTS instants at equal distances in time, from departure to arrival | |
| K | cubic convolution kernel with a = -1/2 (Catmull-Rom); one more value at each end from a quadratic | - |
| tau, pace | time of the voyage; how many seconds of it pass in a second | s, - |

The route comes as a table, because it depends on a forecast that no unit should carry: ``towage route`` computes it and
writes the table. ``pace`` > 1 lets the ship see the sea of a long voyage in a short run: waves keep their own time, only
the sea state changes faster; there are ``pace`` times fewer waves, and their largest is smaller than that of the true
voyage by about sqrt(ln N/ln(N/pace)), N the number of waves.

Directions are unwrapped: heading clockwise from north, the wave direction between course and travel of the waves (pi:
head sea). Assumptions: (1) the ship keeps to the route and its times; (2) between the instants everything is smooth;
(3) after arrival the last sea stays. Source: Minimal-time ship routing (1964), equations (27)-(29) for the kernel.
"""

from __future__ import annotations

from dataclasses import make_dataclass
from typing import Any, NamedTuple

from .ops import NEGLIGIBLE, Ops, Value

POINTS = 25
COLUMNS = ("x", "y", "heading", "speed", "wave_height", "wave_period", "wave_direction")

Parameters: Any = make_dataclass(
    "Parameters",
    [(name, Value) for name in ("duration", "pace", "horizon")]
    + [(f"{column}_{k}", Value) for column in COLUMNS for k in range(POINTS)],
    frozen=True,
)


class State(NamedTuple):
    """None: everything follows from the time."""


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """None."""


class Outputs(NamedTuple):
    """Position on the route's plane, m; heading, rad; speed, m/s; sea; share of the voyage done."""

    x: Value
    y: Value
    heading: Value
    speed: Value
    wave_height: Value
    wave_period: Value
    wave_direction: Value
    progress: Value
    margin_forecast: Value
    x_rate: Value
    y_rate: Value
    heading_rate: Value
    speed_rate: Value
    wave_height_rate: Value
    wave_period_rate: Value
    wave_direction_rate: Value


def kernel(s: Value, ops: Ops) -> tuple[Value, Value]:
    """K(s) and K'(s)."""
    a = ops.abs(s)
    near = ops.where(a < 1.0, (1.5 * a - 2.5) * a * a + 1.0, ((-0.5 * a + 2.5) * a - 4.0) * a + 2.0)
    slope = ops.where(a < 1.0, (4.5 * a - 5.0) * a, (-1.5 * a + 5.0) * a - 4.0)
    within = a < 2.0
    return ops.where(within, near, 0.0), ops.where(within, ops.where(s > 0.0, slope, -slope), 0.0)


def weights(u: Value, ops: Ops) -> tuple[list[Value], list[Value]]:
    """Weights of the POINTS values at ``u`` in 0 ... POINTS - 1, and their derivatives."""
    pairs = [kernel(u - k, ops) for k in range(-1, POINTS + 1)]
    found = []
    for part in (0, 1):
        w = [pair[part] for pair in pairs]
        inner, first, last = w[1:-1], w[0], w[-1]
        for k, factor in enumerate((3.0, -3.0, 1.0)):
            inner[k] = inner[k] + factor * first
            inner[-1 - k] = inner[-1 - k] + factor * last
        found.append(inner)
    return found[0], found[1]


def initial(p: Any, ops: Ops) -> tuple[State, Modes]:
    """No state."""
    return State(), Modes()


def table(p: Any, column: str) -> list[Value]:
    """The POINTS values of a column."""
    return [getattr(p, f"{column}_{k}") for k in range(POINTS)]


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Any, ops: Ops) -> Outputs:
    """All observables. ``margin_forecast`` = 1 - tau/horizon; 1 where no horizon is given."""
    ahead = ops.maximum(0.0, p.pace * t)
    under_way = ops.where(ahead < p.duration, 1.0, 0.0)
    tau = ops.minimum(ahead, p.duration)
    share = tau / p.duration
    value, slope = weights(share * (POINTS - 1), ops)
    scale = under_way * p.pace * (POINTS - 1) / p.duration
    values, rates = [], []
    for column in COLUMNS:
        f = table(p, column)
        values.append(sum(w * v for w, v in zip(value, f)))
        rates.append(scale * sum(w * v for w, v in zip(slope, f)))
    known = ops.where(p.horizon > NEGLIGIBLE, 1.0 - tau / ops.where(p.horizon > NEGLIGIBLE, p.horizon, 1.0), 1.0)
    return Outputs._make([*values, share, known, *rates])
