"""What a file recorded, played: values over time with exact rates.

    f(t) = h00 f_k + h10 d m_k + h01 f_k+1 + h11 d m_k+1,   tau = offset + pace t within [T_k, T_k+1],   d = T_k+1 - T_k

| symbol | meaning | unit |
|---|---|---|
| T_k, f_k, m_k | times, values and slopes of the rows | s, any, any/s |
| h | the cubics of Hermite in s = (tau - T_k)/d | - |
| pace, offset | seconds of the file that pass in a second; where it begins | 1, s |

The slopes are chosen when the file is read: those of the spline with continuous second derivatives (not-a-knot at the ends,
periodic where the first and the last row are equal), or those of Fritsch and Carlson, which keep every rise and fall of the rows
and have continuous first derivatives. Rates are the derivatives of the played values. Beyond the rows the run is refused
(``beyond`` = 0), the last row stays (1: the rate jumps to zero there), or it begins again (2, where the first and the last row
are equal).

Sources: C. de Boor, A Practical Guide to Splines (2001), chapter 4; F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17 (1980)
238-246. In C: ``runtime/kernel/series.c``.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, NamedTuple

from ..numeric.kernel import Kernel
from ..numeric.ops import Ops, Value
from ..protocol.model import AnyModel, Model, Requirement
from ..protocol.variables import Rate, output, parameter

REFUSED, HELD, REPEATED = 0.0, 1.0, 2.0
"""Values of ``beyond``."""
RATES = (1, 2, -1)
SLACK = 1e-9
"""How far beyond its rows a file is still at its end, relative to 1 s + |t|: rounding of a step's time."""


@dataclass(frozen=True, eq=False)
class Series:
    """``times``, s, ascending; of every column its name, unit, values and slopes; ``periodic``: the first row is the last."""

    times: tuple[float, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    slopes: tuple[tuple[float, ...], ...]
    periodic: bool

    def kernel(self) -> Kernel:
        """kernel(t, column, pace, offset, beyond) -> value, rate, second derivative."""
        head = (float(len(self.times)), float(len(self.names)))
        return Kernel(
            "series", self._run, RATES, (*head, *self.times, *(v for c in (*self.values, *self.slopes) for v in c))
        )

    def _run(self, t: float, column: float, pace: float, offset: float, beyond: float) -> tuple[float, ...]:
        tau, first, last = offset + pace * t, self.times[0], self.times[-1]
        if not first <= tau <= last:
            if beyond < 0.5:
                slack = SLACK * (1.0 + abs(tau))
                if not first - slack <= tau <= last + slack:
                    raise ArithmeticError(
                        f"the file holds {first:g} to {last:g} s, and {tau:g} s is asked for: beyond = 1 keeps its ends, 2 "
                        "repeats it"
                    )
                tau = min(max(tau, first), last)
            elif beyond < 1.5:
                return (self.values[int(column)][0 if tau < first else -1], 0.0, 0.0)
            else:
                tau = first + math.fmod(tau - first, last - first)
                tau += last - first if tau < first else 0.0
        k = min(max(bisect_right(self.times, tau) - 1, 0), len(self.times) - 2)
        f, m, d = self.values[int(column)], self.slopes[int(column)], self.times[k + 1] - self.times[k]
        s, rise = (tau - self.times[k]) / d, (f[k + 1] - f[k]) / d
        # f_k + s d (m_k + s (c + s e)), with the slopes m at both ends
        c, e = 3.0 * rise - 2.0 * m[k] - m[k + 1], m[k] + m[k + 1] - 2.0 * rise
        return (
            f[k] + s * d * (m[k] + s * (c + s * e)),
            pace * (m[k] + s * (2.0 * c + 3.0 * s * e)),
            pace * pace * (2.0 * c + 6.0 * s * e) / d,
        )


@dataclass(frozen=True)
class Parameters:
    """How the file is played. ``series`` is what was read, ``kernel`` plays it."""

    pace: Annotated[Value, parameter("1", 1.0, "Seconds of the file that pass in a second", min=0.0)]
    offset: Annotated[Value, parameter("s", 0.0, "Time of the file at time zero")]
    beyond: Annotated[
        Value,
        parameter("1", REFUSED, "Beyond the rows: 0 refused, 1 the last row stays, 2 begins again", min=0.0, max=2.0),
    ]

    series: ClassVar[Series]
    kernel: ClassVar[Kernel]


class State(NamedTuple):
    """None: everything follows from the time."""


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """None."""


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """No state."""
    return State(), Modes()


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """Only what ends as it begins can begin again."""
    text = "beyond: the last row of the file is not the first one, so that it cannot begin again without a jump"
    return ((1.0 if p.series.periodic else ops.where(p.beyond < 1.5, 1.0, -1.0), text),)


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Any, ops: Ops) -> tuple[Value, ...]:
    """The columns, then their rates."""
    played = [ops.kernel(p.kernel, t, k, p.pace, p.offset, p.beyond) for k in range(len(p.series.names))]
    return (*(column[0] for column in played), *(column[1] for column in played))


def playback(series: Series) -> AnyModel:
    """The model that plays ``series``; its outputs have the names and units of the columns."""
    columns = [(n, Annotated[Value, output(unit, "As recorded")]) for n, unit in zip(series.names, series.units)]
    rates = [(f"{n}_rate", Rate) for n in series.names]
    kind = NamedTuple("Outputs", [*columns, *rates])  # type: ignore[misc]

    def named(*arguments: Any) -> Any:
        return kind(*outputs(*arguments))

    named.__module__ = __name__
    given = type("Given", (Parameters,), {"series": series, "kernel": series.kernel(), "__annotations__": {}})
    return replace(EMPTY, Parameters=dataclass(frozen=True)(given), Outputs=kind, outputs=named)


EMPTY: AnyModel = Model(
    "playback",
    "Plays what a file recorded: values over time with exact rates",
    Parameters, State, Modes, Inputs, State,
    initial=initial, outputs=outputs, requirements=requirements,
)  # fmt: skip
"""Without a file there are no outputs."""


def straight(times: Sequence[float], name: str, values: Sequence[float]) -> Series:
    """A series of one column with its slopes at rest, for a unit without a file."""
    return Series(tuple(times), (name,), ("1",), (tuple(values),), ((0.0,) * len(values),), values[0] == values[-1])
