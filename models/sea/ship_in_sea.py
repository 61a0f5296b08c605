"""Ship in an irregular sea: heave in waves that change slowly, plus the response of her heave oscillator to a line.

    x(t) = r(t) sum_i A_i(t) cos(phi_i(t)) + z(t),     m1 z'' + c1 z' + K1 z = -R(t)
    phi_i = x_i P - x_i^2 (cos(mu_i) C - sin(mu_i) D) + e_i
    P' = omega_p,   C' = omega_p^2 V cos(beta)/g,   D' = omega_p^2 V sin(beta)/g
    A_i = RAO(x_i omega_p, V, beta + mu_i) sqrt(2 m0 w_i)

| symbol | meaning | unit |
|---|---|---|
| x | heave of the point that holds the line, positive up | m |
| x_i, w_i, e_i, mu_i | frequency over omega_p, share of m0, phase and direction of component i (`waves`) | -, -, rad, rad |
| omega_p, m0 | peak frequency, Hs^2/16 | rad/s, m2 |
| V, beta | speed; angle between the course and the waves' travel, pi = head sea | m/s, rad |
| P, C, D | integrals that carry all the phases: the Doppler shift is in the phase, not in the spectrum | rad |
| r, z, m1, c1, K1, R | ramp, response, oscillator and reaction as in `ship`, whose functions these are | |

The spectrum is never transformed to encounter frequencies, where its Jacobian is singular at omega = g/(2 V cos beta).
As x_i stays when the sea changes, a change of height, period, direction or speed makes no jump: every
``update_interval`` the unit looks at its inputs, and over the next interval amplitudes, omega_p and the rates of C and
D go over to the new sea by the ramp of `ship`. Its heave thus lags the sea by up to two intervals, its velocity
is the exact derivative of its heave, and phases between two looks are closed forms: P, C and D advance once an
interval, with the rounding error carried along, so that ten hours drift by less than 1e-9 rad.

Assumptions: those of `waves`, `heave_response` and `ship`; (1) the sea changes little in one wave period
(`margin_slow_sea`: the limit is a tenth of height, period or a radian of direction a wave period); (2) Froude number
below 0.3 (`margin_froude`); (3) the line holds the ship at her centre.

Sources: as in `waves`, `heave_response`, `ship`. The components are tables made once from fixed parameters, with
integer arithmetic for the phases: for floats, not for tracing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

from ..heave import ship
from ..numeric.ops import FLOATS, Ops, Value
from . import heave_response, waves
from .waves import GRAVITY

SLOW = 0.1
"""Relative change a wave period at which a sea no longer changes slowly."""
CALM = 0.1
"""Least height from which a period follows, m."""


@dataclass(frozen=True)
class Parameters:
    """SI; ``spreading`` < 0: long-crested, else the s of cos^2s. Names in common with `ship` mean the same."""

    length: Value
    breadth: Value
    draught: Value
    block_coefficient: Value
    smith_oblique: Value
    peakedness: Value
    components: Value
    spreading: Value
    directions: Value
    seed: Value
    update_interval: Value
    ramp_time: Value
    mass: Value
    damping: Value
    stiffness: Value
    sdof_tolerance: Value

    @property
    def hull(self) -> heave_response.Hull:
        """Box of the hull."""
        return heave_response.Hull(self.length, self.breadth * self.block_coefficient, self.draught, self.smith_oblique)

    @cached_property
    def sea(self) -> heave_response.Components:
        """The components, made at first use."""
        return heave_response.components(
            round(self.components), round(self.seed), self.peakedness, round(self.spreading), round(self.directions)
        )


class State(NamedTuple):
    """Response as in `ship`; P, C and D at the last look, rad, each with its rounding error; the time of the first look
    and the number of the last; the sea that was left and the one that is approached; whether a step was done."""

    response: Value
    response_rate: Value
    peak_phase: Value
    peak_phase_low: Value
    doppler_cos: Value
    doppler_cos_low: Value
    doppler_sin: Value
    doppler_sin_low: Value
    first_look: Value
    looks: Value
    old_height: Value
    old_frequency: Value
    old_direction: Value
    old_speed: Value
    new_height: Value
    new_frequency: Value
    new_direction: Value
    new_speed: Value
    under_way: Value


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Reaction as in `ship`, N; significant height, m; peak period, s (0: from the height, Pierson-Moskowitz); angle
    between course and travel of the waves, rad (pi: head sea); speed, m/s."""

    reaction: Value
    wave_height: Value
    wave_period: Value
    wave_direction: Value
    speed: Value


class Outputs(NamedTuple):
    """As in `ship`; ``significant_heave``: four times the standard deviation of the heave without the line, m."""

    heave: Value
    velocity: Value
    free_heave: Value
    significant_heave: Value
    margin_sdof: Value
    margin_froude: Value
    margin_slow_sea: Value
    heave_rate: Value
    velocity_rate: Value
    free_heave_rate: Value


Calculated = ship.Calculated
Sea = tuple[float, float, float, float]
"""Height, m, peak frequency, rad/s, direction, rad, speed, m/s."""


def sea_of(u: Sequence[Value]) -> Sea:
    """The sea that the inputs describe."""
    height = u[1] if u[1] > 0.0 else 0.0
    return height, waves.peak_frequency(height if height > CALM else CALM, u[2]), u[3], u[4]


@lru_cache(maxsize=64)
def _table(sea: Sea, components: heave_response.Components, hull: heave_response.Hull) -> tuple[
    tuple[float, ...], tuple[float, ...], float
]:
    """Amplitudes, m, and frequencies of encounter, rad/s, of all components, and the variance of their sum, m2."""
    height, omega_p, direction, speed = sea
    amplitudes = heave_response.heave_amplitudes(height, omega_p, speed, direction, hull, components)
    c, s = _doppler(sea)
    rates = tuple(
        x * omega_p - x * x * (mc * c - ms * s) for x, mc, ms in zip(components.x, components.cos, components.sin)
    )
    return amplitudes, rates, 0.5 * math.fsum(a * a for a in amplitudes)


def _doppler(sea: Sea) -> tuple[float, float]:
    """C' and D', rad/s."""
    scale = sea[1] * sea[1] * sea[3] / GRAVITY
    return scale * math.cos(sea[2]), scale * math.sin(sea[2])


def free_motion(t: float, x: Sequence[float], p: Parameters) -> tuple[float, float, float, float]:
    """Heave without the line, m, its rate and acceleration, and its variance, m2, without the ramp."""
    old: Sea = (x[10], x[11], x[12], x[13])
    new: Sea = (x[14], x[15], x[16], x[17])
    since = t - (x[8] + x[9] * p.update_interval)
    sea, hull = p.sea, p.hull
    a0, w0, v0 = _table(old, sea, hull)
    (c0, d0), omega0 = _doppler(old), old[1]
    value = rate = acceleration = 0.0
    sin, cos = math.sin, math.cos
    if old == new:
        phase_p = x[2] + (x[3] + omega0 * since)
        phase_c = x[4] + (x[5] + c0 * since)
        phase_d = x[6] + (x[7] + d0 * since)
        for a, w, n, mc, ms, e in zip(a0, w0, sea.x, sea.cos, sea.sin, sea.phase):
            phi = n * (phase_p - n * (mc * phase_c - ms * phase_d)) + e
            along, across = a * cos(phi), a * w * sin(phi)
            value += along
            rate -= across
            acceleration -= w * w * along
        return value, rate, acceleration, v0
    a1, w1, _ = _table(new, sea, hull)
    (c1, d1), omega1 = _doppler(new), new[1]
    period = p.update_interval
    s = min(1.0, max(0.0, since / period))
    blend, blend1, blend2 = ship.ramp(s * period, period, FLOATS)
    area = period * s**4 * (2.5 - 3.0 * s + s * s)
    phase_p = x[2] + (x[3] + omega0 * since + (omega1 - omega0) * area)
    phase_c = x[4] + (x[5] + c0 * since + (c1 - c0) * area)
    phase_d = x[6] + (x[7] + d0 * since + (d1 - d0) * area)
    variance = 0.0
    for b0, b1, f0, f1, n, mc, ms, e in zip(a0, a1, w0, w1, sea.x, sea.cos, sea.sin, sea.phase):
        phi = n * (phase_p - n * (mc * phase_c - ms * phase_d)) + e
        da, dw = b1 - b0, f1 - f0
        a, w = b0 + blend * da, f0 + blend * dw
        sine, cosine = sin(phi), cos(phi)
        value += a * cosine
        rate += blend1 * da * cosine - a * w * sine
        acceleration += (blend2 * da - a * w * w) * cosine - (2.0 * blend1 * da * w + a * blend1 * dw) * sine
        variance += a * a
    return value, rate, acceleration, 0.5 * variance


def requirements(p: Parameters, ops: Ops) -> tuple[tuple[Value, str], ...]:
    """Enough directions for the spread (`waves`)."""
    text = "directions do not resolve cos^2s with s = spreading: give more than spreading + 2 directions"
    enough = round(p.directions) - round(p.spreading) - 2
    return ((enough if p.spreading >= 0.0 else 1.0, text),)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """At rest; the sea is looked at with the first inputs."""
    return State(*(0.0,) * 11, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), Modes()


def transition(t: Value, x: State, m: Modes, u: Sequence[Value], p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Until the first step the sea at the start is what the inputs say."""
    if x[18] > 0.5:
        return x, m
    sea = sea_of(u)
    return State(*x[:8], t, 0.0, *sea, *sea, 0.0), m


def _carry(total: float, low: float, more: float) -> tuple[float, float]:
    """total + low + ``more`` with the rounding error of the sum (T. J. Dekker's two-sum)."""
    term = more + low
    result = total + term
    gone = result - total
    return result, (total - (result - gone)) + (term - gone)


def advance(
    t: Value, h: Value, x: State, m: Modes, coefficients: Sequence[Sequence[Value]], p: Parameters, ops: Ops
) -> State:
    """Exact step of the response, as `ship.advance`, and the looks that fall due within the step."""
    z, z_rate = ship.advance(t, h, ship.State(x[0], x[1]), ship.Modes(), coefficients, _oscillator(p), ops)
    x = State(z, z_rate, *x[2:18], 1.0)
    interval = p.update_interval
    while True:
        due = x[8] + (x[9] + 1.0) * interval
        if due > (t + h) * (1.0 + 4e-16):
            return x
        s = due - t
        sea = sea_of([a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in coefficients])
        old: Sea = (x[10], x[11], x[12], x[13])
        new: Sea = (x[14], x[15], x[16], x[17])
        (c0, d0), (c1, d1) = _doppler(old), _doppler(new)
        half = 0.5 * interval
        x = State(
            x[0], x[1], *_carry(x[2], x[3], half * (old[1] + new[1])), *_carry(x[4], x[5], half * (c0 + c1)),
            *_carry(x[6], x[7], half * (d0 + d1)), x[8], x[9] + 1.0, *new, *sea, 1.0,
        )  # fmt: skip


def _oscillator(p: Parameters) -> ship.Parameters:
    """The parameters of `ship` that its response needs."""
    return ship.Parameters(0.0, 1.0, 0.0, 0.0, p.mass, p.damping, p.stiffness, p.sdof_tolerance)


def outputs(t: Value, x: State, m: Modes, u: Sequence[Value], du: Sequence[Value], p: Parameters, ops: Ops) -> Outputs:
    """All observables. ``margin_sdof`` = 1 - |z|/(e a), a the significant amplitude of the free heave."""
    value, rate, acceleration, variance = free_motion(t, x, p)
    r, r1, r2 = ship.ramp(t, p.ramp_time, ops)
    free, free_rate = r * value, r * rate + r1 * value
    free_rate2 = r * acceleration + 2.0 * r1 * rate + r2 * value
    z, z_rate = x[0], x[1]
    z_rate2 = ship.derivatives(t, ship.State(z, z_rate), ship.Modes(), ship.Inputs(u[0]), _oscillator(p), ops)[1]
    deviation = math.sqrt(variance)
    limit = 2.0 * p.sdof_tolerance * deviation
    sdof = 1.0 - abs(z) / limit if limit > 0.0 else 1.0
    speed = max(abs(x[13]), abs(x[17]))
    froude = 1.0 - speed / math.sqrt(GRAVITY * p.length) / heave_response.FROUDE_LIMIT
    return Outputs(
        free + z, free_rate + z_rate, free, 4.0 * deviation, sdof, froude, _slow(x, p),
        free_rate + z_rate, free_rate2 + z_rate2, free_rate,
    )  # fmt: skip


def _slow(x: Sequence[float], p: Parameters) -> float:
    """1 - (relative change of height, of frequency, and of direction in rad, a peak period)/0.1, the worst of them."""
    height = max(x[10], x[14])
    change = max(
        abs(x[14] - x[10]) / height if height > CALM else 0.0,
        abs(x[15] - x[11]) / max(x[15], x[11]),
        2.0 * abs(math.sin(0.5 * (x[16] - x[12]))) if height > CALM else 0.0,
    )
    margin: float = 1.0 - change * 2.0 * math.pi / max(x[15], x[11]) / p.update_interval / SLOW
    return margin


def calculated(p: Parameters, ops: Ops) -> ship.Calculated:
    """Constants of the heave oscillator, as in `ship`."""
    return ship.calculated(_oscillator(p), FLOATS)
