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
from typing import NamedTuple

from .ops import NEGLIGIBLE, Ops, Value


@dataclass(frozen=True)
class Parameters:
    """SI. ``ramp_time`` 0: no ramp."""

    drag_amplitude: Value
    drag_phase: Value
    lift_amplitude: Value
    lift_phase: Value
    period: Value
    ramp_time: Value


class State(NamedTuple):
    """None: the forces follow from the time."""


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Lift on top of the prescribed one, N."""

    offset_lift: Value


class Outputs(NamedTuple):
    """Forces, N."""

    drag_change: Value
    lift_change: Value
    drag_change_rate: Value
    lift_change_rate: Value


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """No states."""
    return State(), Modes()


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """The forces and their rates."""
    omega = 2.0 * math.pi / p.period
    scale = ops.where(p.ramp_time > NEGLIGIBLE, 1.0 / ops.where(p.ramp_time > NEGLIGIBLE, p.ramp_time, 1.0), 0.0)
    s = ops.where(p.ramp_time > NEGLIGIBLE, ops.minimum(1.0, ops.maximum(0.0, t * scale)), 1.0)
    r = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    r1 = 30.0 * s * s * (1.0 - s) * (1.0 - s) * scale
    found = []
    for amplitude, phase in ((p.drag_amplitude, p.drag_phase), (p.lift_amplitude, p.lift_phase)):
        angle = omega * t + phase
        found.append((amplitude * r * ops.sin(angle), amplitude * (r1 * ops.sin(angle) + omega * r * ops.cos(angle))))
    (drag, drag_rate), (lift, lift_rate) = found
    return Outputs(drag, lift + u[0], drag_rate, lift_rate + du[0])
