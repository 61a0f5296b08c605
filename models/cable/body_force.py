"""Oscillating drag and lift of a towed body, as waves or its own control give them: a prescribed force.

    dD = r(t) a_D sin(omega t + phi_D),   dL = r(t) a_L sin(omega t + phi_L)

| symbol | meaning | unit |
|---|---|---|
| dD, dL | change of drag, aft, and of lift, up | N |
| a, phi, omega | amplitudes, phases, frequency 2 pi/period | N, rad, rad/s |
| r | ramp s^3 (10 - 15 s + 6 s^2), s = min(1, t/ramp_time) | - |

In the source's convention Re(D1 exp(-i omega t)) the amplitude is |D1| and sin(omega t + phi) stands for
cos(omega t - atan2(Im D1, Re D1)). The input ``offset_lift`` adds to the lift and is 0 unless connected.

Source: small-perturbation report on towed cables, Equations [9] [10] with [43] [44] (program OMFLO).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import Ops, Value
from ..numeric.ramp import ramp
from ..protocol.model import AnyModel, Model
from ..protocol.variables import Rate, input_variable, output, parameter


@dataclass(frozen=True)
class Parameters:
    """SI."""

    drag_amplitude: Annotated[Value, parameter("N", 0.0, "Amplitude of the drag", display="lbf")]
    drag_phase: Annotated[
        Value, parameter("rad", 0.0, "Phase of the drag: a sin(2 pi t / period + phase)", display="deg")
    ]
    lift_amplitude: Annotated[Value, parameter("N", 0.0, "Amplitude of the lift", display="lbf")]
    lift_phase: Annotated[
        Value, parameter("rad", 0.0, "Phase of the lift: a sin(2 pi t / period + phase)", display="deg")
    ]
    period: Annotated[Value, parameter("s", 8.0, "Period of both", min=1e-9)]
    ramp_time: Annotated[Value, parameter("s", 0.0, "Duration of a smooth start; 0: none", min=0.0)]


class State(NamedTuple):
    """None: the forces follow from the time."""


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """What a control surface adds."""

    offset_lift: Annotated[
        Value, input_variable("N", "Lift on top of the prescribed one", display="lbf", unset="the prescribed lift alone")
    ]


class Outputs(NamedTuple):
    """The forces and their rates."""

    drag_change: Annotated[Value, output("N", "Change of the body's drag, aft", display="lbf")]
    lift_change: Annotated[Value, output("N", "Change of the body's lift, up", display="lbf")]
    drag_change_rate: Rate
    lift_change_rate: Rate


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """No states."""
    return State(), Modes()


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """The forces and their rates."""
    omega = 2.0 * math.pi / p.period
    r, r1, _ = ramp(t, p.ramp_time, ops)
    drag, lift = omega * t + p.drag_phase, omega * t + p.lift_phase
    return Outputs(
        p.drag_amplitude * r * ops.sin(drag),
        p.lift_amplitude * r * ops.sin(lift) + u.offset_lift,
        p.drag_amplitude * (r1 * ops.sin(drag) + omega * r * ops.cos(drag)),
        p.lift_amplitude * (r1 * ops.sin(lift) + omega * r * ops.cos(lift)) + du.offset_lift,
    )


BODY_FORCE: AnyModel = Model(
    "body_force", "Oscillating drag and lift of a towed body, prescribed", Parameters, State, Modes, Inputs, Outputs,
    initial=initial, outputs=outputs,
)  # fmt: skip
