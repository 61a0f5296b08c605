"""Ship in heave: a prescribed free motion plus the response of its heave oscillator to the pull of a line.

    x(t) = r(t) a sin(omega t + phi) + z(t),    m1 z'' + c1 z' + K1 z = -R(t)

| symbol | meaning | unit |
|---|---|---|
| x | heave of the point that holds the line, positive up | m |
| a, omega, phi | amplitude, frequency 2 pi/period and phase of the free motion | m, rad/s, rad |
| r | ramp s^3 (10 - 15 s + 6 s^2), s = min(1, t/ramp_time), twice continuously differentiable | - |
| z | response to the reaction | m |
| m1, c1, K1 | mass with added mass, linear damping, water-plane stiffness | kg, N s/m, N/m |
| R | ``reaction``: excess of the line's pull over its static value, positive down on the ship | N |

With ``reaction`` not connected z = 0 and the unit is the pure driver that the SDOF models assume; connected, it is the
two-way ship. The response is stepped exactly for a reaction that is a cubic of time over the step.

Source: MIT thesis 1969, section II (sinusoidal heave of the vessel) and example 1 (m1, K1 of Lulu); the superposition
of free motion and response is exact because the oscillator is linear.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from .ops import NEGLIGIBLE, Ops, Value


@dataclass(frozen=True)
class Parameters:
    """SI. ``ramp_time`` = 0: no ramp."""

    heave_amplitude: Value
    heave_period: Value
    heave_phase: Value
    ramp_time: Value
    mass: Value
    damping: Value
    stiffness: Value
    sdof_tolerance: Value


class State(NamedTuple):
    """Response z to the reaction, m, and its rate, m/s."""

    response: Value
    response_rate: Value


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Excess of the line's pull over its static value, N, positive down on the ship."""

    reaction: Value


class Outputs(NamedTuple):
    """``free_heave`` is the prescribed part of ``heave``, m; ``margin_sdof`` tells how far the line moves the ship."""

    heave: Value
    velocity: Value
    free_heave: Value
    margin_sdof: Value
    heave_rate: Value
    velocity_rate: Value
    free_heave_rate: Value


class Calculated(NamedTuple):
    """m1, kg; sqrt(K1/m1), rad/s; c1/(2 sqrt(K1 m1)), -."""

    port_mass: Value
    natural_frequency: Value
    damping_ratio: Value


def ramp(t: Value, ramp_time: Value, ops: Ops) -> tuple[Value, Value, Value]:
    """r and its first two time derivatives, 1, 1/s, 1/s2."""
    scale = ops.where(ramp_time > NEGLIGIBLE, 1.0 / ops.where(ramp_time > NEGLIGIBLE, ramp_time, 1.0), 0.0)
    s = ops.where(ramp_time > NEGLIGIBLE, ops.minimum(1.0, ops.maximum(0.0, t * scale)), 1.0)
    r = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    r1 = 30.0 * s * s * (1.0 - s) * (1.0 - s) * scale
    r2 = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * scale * scale
    return r, r1, r2


def free_motion(t: Value, p: Parameters, ops: Ops) -> tuple[Value, Value, Value]:
    """Free heave, m, its rate, m/s, and acceleration, m/s2."""
    omega = 2.0 * math.pi / p.heave_period
    phase = omega * t + p.heave_phase
    sine, cosine = ops.sin(phase), ops.cos(phase)
    r, r1, r2 = ramp(t, p.ramp_time, ops)
    a = p.heave_amplitude
    return (
        a * r * sine,
        a * (r1 * sine + omega * r * cosine),
        a * ((r2 - omega * omega * r) * sine + 2.0 * omega * r1 * cosine),
    )


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """No response yet."""
    return State(0.0, 0.0), Modes()


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x' of the response."""
    return State(x[1], (-u[0] - p.damping * x[1] - p.stiffness * x[0]) / p.mass)


def advance(
    t: Value, h: Value, x: State, m: Modes, coefficients: Sequence[Sequence[Value]], p: Parameters, ops: Ops
) -> State:
    """Exact step of length ``h``, s, for R(t + s) = r0 + r1 s + r2 s^2 + r3 s^3 (``coefficients[0]``): the particular
    solution is a cubic too, the rest is the free oscillation in closed form (under- or overdamped)."""
    omega2 = p.stiffness / p.mass
    decay = 0.5 * p.damping / p.mass
    r0, r1, r2, r3 = coefficients[0]
    inverse = -1.0 / p.stiffness
    delay = p.damping / p.stiffness
    q3 = inverse * r3
    q2 = inverse * r2 - 3.0 * delay * q3
    q1 = inverse * r1 - 2.0 * delay * q2 - 6.0 * q3 / omega2
    q0 = inverse * r0 - delay * q1 - 2.0 * q2 / omega2
    z, rate = x[0] - q0, x[1] - q1
    difference = omega2 - decay * decay
    b = ops.sqrt(ops.abs(difference))
    safe = ops.where(b * h > 1e-8, b, 1.0)
    fast, slow = ops.exp(-(decay + b) * h), ops.exp(-ops.abs(decay - b) * h)
    envelope = ops.exp(-decay * h)
    oscillates = difference > 0.0
    c = ops.where(oscillates, envelope * ops.cos(b * h), 0.5 * (slow + fast))
    s = ops.where(
        b * h > 1e-8,
        ops.where(oscillates, envelope * ops.sin(b * h), 0.5 * (slow - fast)) / safe,
        envelope * h,
    )
    mixed = rate + decay * z
    return State(
        c * z + s * mixed + q0 + h * (q1 + h * (q2 + h * q3)),
        c * rate - s * (omega2 * z + decay * rate) + q1 + h * (2.0 * q2 + h * 3.0 * q3),
    )


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables. ``margin_sdof`` = 1 - |z|/(e a), e = ``sdof_tolerance``: the one-degree-of-freedom models assume
    that the line does not move the ship (1 where the free motion has no amplitude)."""
    free, rate, acceleration = free_motion(t, p, ops)
    z, z_rate = x
    z_rate2 = derivatives(t, x, m, u, p, ops)[1]
    limit = p.sdof_tolerance * ops.abs(p.heave_amplitude)
    margin = ops.where(limit > NEGLIGIBLE, 1.0 - ops.abs(z) / ops.where(limit > NEGLIGIBLE, limit, 1.0), 1.0)
    velocity = rate + z_rate
    return Outputs(free + z, velocity, free, margin, velocity, acceleration + z_rate2, rate)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Constants of the heave oscillator."""
    omega = ops.sqrt(p.stiffness / p.mass)
    return Calculated(p.mass, omega, 0.5 * p.damping / (p.mass * omega))
