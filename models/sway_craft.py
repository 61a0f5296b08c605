"""Towing craft in sway: a prescribed lateral motion plus the response of its sway oscillator to the rope, and its speed.

    y(t) = r(t) a sin(omega t + phi) + z(t),    m z'' + c z' + k z = F
    U(t) = U0 + (U1 - U0) s^3 (10 - 15 s + 6 s^2),   s = (t - t0)/T within [0, 1]

| symbol | meaning | unit |
|---|---|---|
| y | ``lateral``: lateral position of the point that holds the rope, positive to port | m |
| a, omega, phi, r | amplitude, frequency 2 pi/period, phase and smooth start of the free sway, as of `ship` | m, rad/s, rad, - |
| m, c, k | mass with sway added mass, damping, stiffness of course keeping | kg, N s/m, N/m |
| F | ``lateral_force`` of the rope, positive to port | N |
| U | ``tow_speed``, a smooth change from U0 to U1 | m/s |

The oscillator, its exact step for a cubic F and the free motion are those of `ship`, with F = -R.

Assumptions: (1) one degree of freedom: no yaw of the craft; (2) a linear course keeper; (3) the pull of the rope along
the tow does not slow the craft. A craft that is free to drift has a small k, not none.

Source: the oscillator of `ship`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from . import ship
from .ops import NEGLIGIBLE, Ops, Value


@dataclass(frozen=True)
class Parameters:
    """SI. ``ramp_time`` = 0: the sway starts at once; ``speed_change_time`` = 0: the speed stays at ``speed_start``."""

    sway_amplitude: Value
    sway_period: Value
    sway_phase: Value
    ramp_time: Value
    mass: Value
    damping: Value
    stiffness: Value
    speed_start: Value
    speed_end: Value
    speed_change_start: Value
    speed_change_time: Value
    sdof_tolerance: Value


State, Modes = ship.State, ship.Modes


class Inputs(NamedTuple):
    """Force of the rope, N, positive to port."""

    lateral_force: Value


class Outputs(NamedTuple):
    """``free_lateral`` is the prescribed part of ``lateral``, m; ``margin_sdof`` tells how far the rope moves the craft."""

    lateral: Value
    free_lateral: Value
    tow_speed: Value
    margin_sdof: Value
    lateral_rate: Value
    free_lateral_rate: Value
    tow_speed_rate: Value


class Calculated(NamedTuple):
    """m, kg; sqrt(k/m), rad/s; c/(2 sqrt(k m)), -."""

    port_mass: Value
    natural_frequency: Value
    damping_ratio: Value


def oscillator(p: Parameters) -> ship.Parameters:
    """The craft as the oscillator of `ship`."""
    return ship.Parameters(
        p.sway_amplitude, p.sway_period, p.sway_phase, p.ramp_time, p.mass, p.damping, p.stiffness, p.sdof_tolerance
    )


def tow_speed(t: Value, p: Parameters, ops: Ops) -> tuple[Value, Value]:
    """U, m/s, and its rate, m/s2."""
    changes = p.speed_change_time > NEGLIGIBLE
    scale = ops.where(changes, 1.0 / ops.where(changes, p.speed_change_time, 1.0), 0.0)
    s = ops.minimum(1.0, ops.maximum(0.0, (t - p.speed_change_start) * scale))
    change = p.speed_end - p.speed_start
    return (
        p.speed_start + change * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
        change * 30.0 * s * s * (1.0 - s) * (1.0 - s) * scale,
    )


def initial(p: Parameters, ops: Ops) -> tuple[ship.State, ship.Modes]:
    """No response yet."""
    return ship.initial(oscillator(p), ops)


def derivatives(t: Value, x: ship.State, m: ship.Modes, u: Inputs, p: Parameters, ops: Ops) -> ship.State:
    """x' of the response."""
    return ship.derivatives(t, x, m, ship.Inputs(-u[0]), oscillator(p), ops)


def advance(
    t: Value, h: Value, x: ship.State, m: ship.Modes, coefficients: Sequence[Sequence[Value]], p: Parameters, ops: Ops
) -> ship.State:
    """Exact step of ``h``, s, for a force that is a cubic of time."""
    return ship.advance(t, h, x, m, [[-a for a in coefficients[0]]], oscillator(p), ops)


def outputs(t: Value, x: ship.State, m: ship.Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    lateral, _, free, margin, lateral_rate, _, free_rate = ship.outputs(
        t, x, m, ship.Inputs(-u[0]), ship.Inputs(-du[0]), oscillator(p), ops
    )
    speed, speed_rate = tow_speed(t, p, ops)
    return Outputs(lateral, free, speed, margin, lateral_rate, free_rate, speed_rate)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Constants of the oscillator."""
    mass, frequency, ratio = ship.calculated(oscillator(p), ops)
    return Calculated(mass, frequency, ratio)
