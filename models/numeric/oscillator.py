"""An oscillator with one degree of freedom, and the oscillation that drives it.

    m z'' + c z' + k z = -R,      y = r(t) a sin(omega t + phi), r of `ramp`

| symbol | meaning | unit |
|---|---|---|
| m, c, k | mass, damping, stiffness | kg, N s/m, N/m |
| R | reaction, against z | N |
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .ops import NEGLIGIBLE, Ops, Value
from .ramp import ramp

TURN = 2.0 * math.pi
"""rad."""


def acceleration(z: Value, rate: Value, reaction: Value, mass: Value, damping: Value, stiffness: Value) -> Value:
    """z'', m/s2."""
    return (-reaction - damping * rate - stiffness * z) / mass


def exact_oscillation(
    h: Value, z: Value, rate: Value, reaction: Sequence[Value], mass: Value, damping: Value, stiffness: Value, ops: Ops
) -> tuple[Value, Value]:
    """(z, z') after ``h``, s, for R = r0 + r1 s + r2 s^2 + r3 s^3 (``reaction``): the particular solution is a cubic too, the
    rest is the free oscillation in closed form (under- or overdamped)."""
    omega2 = stiffness / mass
    decay = 0.5 * damping / mass
    r0, r1, r2, r3 = reaction
    inverse = -1.0 / stiffness
    delay = damping / stiffness
    q3 = inverse * r3
    q2 = inverse * r2 - 3.0 * delay * q3
    q1 = inverse * r1 - 2.0 * delay * q2 - 6.0 * q3 / omega2
    q0 = inverse * r0 - delay * q1 - 2.0 * q2 / omega2
    z, rate = z - q0, rate - q1
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
    return (
        c * z + s * mixed + q0 + h * (q1 + h * (q2 + h * q3)),
        c * rate - s * (omega2 * z + decay * rate) + q1 + h * (2.0 * q2 + h * 3.0 * q3),
    )


def natural(mass: Value, damping: Value, stiffness: Value, ops: Ops) -> tuple[Value, Value]:
    """(sqrt(k/m), rad/s; c/(2 sqrt(k m)), -)."""
    omega = ops.sqrt(stiffness / mass)
    return omega, 0.5 * damping / (mass * omega)


def driven(
    t: Value, amplitude: Value, period: Value, phase: Value, ramp_time: Value, ops: Ops
) -> tuple[Value, Value, Value]:
    """y, its rate, 1/s, and second derivative, 1/s2, at ``t``, s; ``period`` and ``ramp_time`` in s."""
    omega = TURN / period
    angle = omega * t + phase
    sine, cosine = ops.sin(angle), ops.cos(angle)
    r, r1, r2 = ramp(t, ramp_time, ops)
    return (
        amplitude * r * sine,
        amplitude * (r1 * sine + omega * r * cosine),
        amplitude * ((r2 - omega * omega * r) * sine + 2.0 * omega * r1 * cosine),
    )


def margin_small(z: Value, amplitude: Value, share: Value, ops: Ops) -> Value:
    """1 - |z|/(share |amplitude|): how far a response stays small against what drives it; 1 where nothing does."""
    limit = share * ops.abs(amplitude)
    return ops.where(limit > NEGLIGIBLE, 1.0 - ops.abs(z) / ops.where(limit > NEGLIGIBLE, limit, 1.0), 1.0)
