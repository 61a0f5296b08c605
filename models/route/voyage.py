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

import math
from dataclasses import make_dataclass
from typing import Annotated, Any, NamedTuple

from ..numeric.ops import NEGLIGIBLE, Ops, Value
from ..protocol.model import AnyModel, Model
from ..protocol.variables import Quantity, Rate, margin, output, parameter

POINTS = 25
SEA_DIRECTION = "Angle between the course and the waves' travel; pi head sea"
COLUMNS = {
    "x": output("m", "Position on the route's plane, x", display="nmi"),
    "y": output("m", "Position on the route's plane, y", display="nmi"),
    "heading": output("rad", "Heading, clockwise from north", display="deg"),
    "speed": output("m/s", "Speed of the ship", display="kn"),
    "wave_height": output("m", "Significant wave height", display="ft"),
    "wave_period": output("s", "Peak period; 0: that of a Pierson-Moskowitz sea of this height"),
    "wave_direction": output("rad", SEA_DIRECTION, display="deg"),
}
"""What the table holds, and what comes out of it."""
STARTS = {"speed": 5.0, "wave_height": 3.0, "wave_direction": math.pi}
"""Of the columns that do not start at 0."""


def _points(column: str, meaning: Quantity) -> list[tuple[str, Any]]:
    """The fields of a column of the table."""
    return [
        (
            f"{column}_{k}",
            Annotated[Value, parameter(
                meaning.unit, STARTS.get(column, 0.0), f"{meaning.description}, at {k}/{POINTS - 1} of the duration",
                display=meaning.display,
            )],
        )
        for k in range(POINTS)
    ]  # fmt: skip


Parameters: Any = make_dataclass(
    "Parameters",
    [
        ("duration", Annotated[Value, parameter("s", 3600.0, "Duration of the voyage", display="h", min=1e-3)]),
        ("pace", Annotated[Value, parameter("1", 1.0, "Seconds of the voyage that pass in a second", min=0.0)]),
        ("horizon", Annotated[Value, parameter("s", 0.0, "Time of the last forecast; 0: none", display="h", min=0.0)]),
        *(field for column, meaning in COLUMNS.items() for field in _points(column, meaning)),
    ],
    frozen=True,
)


class State(NamedTuple):
    """None: everything follows from the time."""


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """None."""


class Outputs(NamedTuple):
    """The columns of the table, the share of the voyage done, and rates."""

    x: Annotated[Value, COLUMNS["x"]]
    y: Annotated[Value, COLUMNS["y"]]
    heading: Annotated[Value, COLUMNS["heading"]]
    speed: Annotated[Value, COLUMNS["speed"]]
    wave_height: Annotated[Value, COLUMNS["wave_height"]]
    wave_period: Annotated[Value, COLUMNS["wave_period"]]
    wave_direction: Annotated[Value, COLUMNS["wave_direction"]]
    progress: Annotated[Value, output("1", "Share of the voyage done")]
    margin_forecast: Annotated[Value, margin("1 - voyage time / horizon; 1 without a horizon")]
    x_rate: Rate
    y_rate: Rate
    heading_rate: Rate
    speed_rate: Rate
    wave_height_rate: Rate
    wave_period_rate: Rate
    wave_direction_rate: Rate


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
    both = []
    for part in (0, 1):
        w = [pair[part] for pair in pairs]
        inner, first, last = w[1:-1], w[0], w[-1]
        for k, factor in enumerate((3.0, -3.0, 1.0)):
            inner[k] = inner[k] + factor * first
            inner[-1 - k] = inner[-1 - k] + factor * last
        both.append(inner)
    return both[0], both[1]


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


VOYAGE: AnyModel = Model(
    "voyage",
    "Voyage along a computed route: position, heading, speed and the sea met, from a table",
    Parameters, State, Modes, Inputs, Outputs,
    initial=initial, outputs=outputs,
)  # fmt: skip
