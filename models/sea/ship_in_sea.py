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
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple

from ..heave import ship
from ..numeric.ops import FLOATS, Ops, Value
from ..numeric.oscillator import acceleration, exact_oscillation
from ..numeric.ramp import ramp, ramp_integral
from ..protocol.model import Model, Requirement
from ..protocol.variables import Rate, input_variable, margin, output, parameter
from . import heave_response, waves
from .changing_sea import Heave, Sea, changing_heave, doppler, steady_heave
from .waves import GRAVITY

SLOW = 0.1
"""Relative change a wave period at which a sea no longer changes slowly."""
CALM = 0.1
"""Least height from which a period follows, m."""


@dataclass(frozen=True)
class HullAndWaves:
    """Box of the hull and components of the sea, SI."""

    length: Annotated[Value, parameter("m", 100.0, "Length of the ship", display="ft", min=1e-3)]
    breadth: Annotated[Value, parameter("m", 15.0, "Breadth", display="ft", min=1e-3)]
    draught: Annotated[Value, parameter("m", 5.0, "Draught", display="ft", min=1e-3)]
    block_coefficient: Annotated[Value, parameter("1", 0.7, "Block coefficient", min=0.1, max=1.0)]
    smith_oblique: Annotated[
        Value, parameter("1", 0.0, "Smith factor: 0 exp(-k T), 1 exp(-k |cos beta| T)", min=0.0, max=1.0)
    ]
    peakedness: Annotated[
        Value, parameter("1", 1.0, "gamma of JONSWAP; 1: Bretschneider and Pierson-Moskowitz", min=1.0, max=10.0)
    ]
    components: Annotated[Value, parameter("1", 100.0, "Number of wave components", min=1.0, max=300.0)]
    spreading: Annotated[
        Value,
        parameter("1", -1.0, "s of the directional distribution cos^2s; negative: long-crested", min=-1.0, max=40.0),
    ]
    directions: Annotated[Value, parameter("1", 8.0, "Number of wave directions, more than s + 2", min=1.0, max=48.0)]
    seed: Annotated[Value, parameter("1", 1964.0, "Seed of the phases, a whole number", min=0.0, max=9e15)]
    update_interval: Annotated[
        Value, parameter("s", 10.0, "Time between looks at the sea, which it then follows smoothly", min=1e-3)
    ]


@dataclass(frozen=True)
class Parameters(ship.Oscillator, HullAndWaves):
    """Hull and waves first, then the oscillator of `ship`."""

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
    """The line as in `ship`, and the sea, which only the scene can know: its start values may be meant, or forgotten."""

    reaction: ship.Reaction
    wave_height: Annotated[Value, input_variable("m", "Significant wave height", start=2.0, display="ft")]
    wave_period: Annotated[
        Value, input_variable("s", "Peak period; 0: that of a Pierson-Moskowitz sea of this height", unset="as for 0")
    ]
    wave_direction: Annotated[
        Value,
        input_variable(
            "rad", "Angle between the course and the waves' travel; pi head sea", start=math.pi, display="deg"
        ),
    ]
    speed: Annotated[Value, input_variable("m/s", "Speed of the ship", display="kn")]


class Outputs(NamedTuple):
    """As in `ship`; ``significant_heave`` is four times the standard deviation of the heave without the line."""

    heave: ship.Heave
    velocity: ship.Velocity
    free_heave: ship.FreeHeave
    significant_heave: Annotated[
        Value, output("m", "Significant heave (double amplitude) without the line", display="ft")
    ]
    margin_sdof: Annotated[
        Value, margin("1 - |z| / (sdof_tolerance a), z the response to the line and a the significant amplitude")
    ]
    margin_froude: Annotated[Value, margin("1 - V / (0.3 sqrt(g L))")]
    margin_slow_sea: Annotated[
        Value, margin("1 - change of the sea a wave period / 0.1, the worst of height, frequency and direction")
    ]
    heave_rate: Rate
    velocity_rate: Rate
    free_heave_rate: Rate


Calculated = ship.Calculated


def sea_of(u: Inputs) -> Sea:
    """The sea that the inputs describe."""
    height = u.wave_height if u.wave_height > 0.0 else 0.0
    frequency = waves.peak_frequency(height if height > CALM else CALM, u.wave_period)
    return Sea(height, frequency, u.wave_direction, u.speed)


def _seas(x: State) -> tuple[Sea, Sea]:
    """The sea that was left, and the one that is approached."""
    return (
        Sea(x.old_height, x.old_frequency, x.old_direction, x.old_speed),
        Sea(x.new_height, x.new_frequency, x.new_direction, x.new_speed),
    )


def free_motion(t: float, x: State, p: Parameters) -> Heave:
    """Heave without the line, m, its rate and acceleration, and its variance, m2, without the ramp."""
    old, new = _seas(x)
    since, period = t - (x.first_look + x.looks * p.update_interval), p.update_interval
    (c0, d0), (c1, d1) = doppler(old), doppler(new)
    # how much of the new rates has come in since the last look, s
    area = 0.0 if old == new else ramp_integral(since, period, FLOATS)
    phases = (
        x.peak_phase + (x.peak_phase_low + old.frequency * since + (new.frequency - old.frequency) * area),
        x.doppler_cos + (x.doppler_cos_low + c0 * since + (c1 - c0) * area),
        x.doppler_sin + (x.doppler_sin_low + d0 * since + (d1 - d0) * area),
    )
    if old == new:
        return steady_heave(phases, old, p.sea, p.hull)
    blending = ramp(min(1.0, max(0.0, since / period)) * period, period, FLOATS)
    return changing_heave(phases, old, new, blending, p.sea, p.hull)


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """Enough directions for the spread (`waves`)."""
    text = "directions do not resolve cos^2s with s = spreading: give more than spreading + 2 directions"
    enough = round(p.directions) - round(p.spreading) - 2
    return ((enough if p.spreading >= 0.0 else 1.0, text),)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """At rest; the sea is looked at with the first inputs."""
    return State(*(0.0,) * 11, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), Modes()


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Until the first step the sea at the start is what the inputs say."""
    if x.under_way > 0.5:
        return x, m
    sea = sea_of(u)
    return State(*x[:8], t, 0.0, *sea, *sea, 0.0), m


def _carry(total: float, low: float, more: float) -> tuple[float, float]:
    """total + low + ``more`` with the rounding error of the sum (T. J. Dekker's two-sum)."""
    term = more + low
    result = total + term
    added = result - total
    return result, (total - (result - added)) + (term - added)


def advance(t: Value, h: Value, x: State, m: Modes, cubics: Inputs, p: Parameters, ops: Ops) -> State:
    """Exact step of the response, as `ship.advance`, and the looks that fall due within the step."""
    z, z_rate = x.response, x.response_rate
    z, z_rate = exact_oscillation(h, z, z_rate, cubics.reaction, p.mass, p.damping, p.stiffness, ops)
    x = State(z, z_rate, *x[2:18], 1.0)
    interval = p.update_interval
    while True:
        due = x.first_look + (x.looks + 1.0) * interval
        if due > (t + h) * (1.0 + 4e-16):
            return x
        s = due - t
        x = _looked(x, sea_of(Inputs(*(a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in cubics))), interval)


def _looked(x: State, sea: Sea, interval: Value) -> State:
    """The state after a look that finds ``sea``: phases at its time, and that sea the one to approach."""
    old, new = _seas(x)
    (c0, d0), (c1, d1) = doppler(old), doppler(new)
    half = 0.5 * interval
    return State(
        x.response, x.response_rate,
        *_carry(x.peak_phase, x.peak_phase_low, half * (old.frequency + new.frequency)),
        *_carry(x.doppler_cos, x.doppler_cos_low, half * (c0 + c1)),
        *_carry(x.doppler_sin, x.doppler_sin_low, half * (d0 + d1)),
        x.first_look, x.looks + 1.0, *new, *sea, 1.0,
    )  # fmt: skip


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables. ``margin_sdof`` = 1 - |z|/(e a), a the significant amplitude of the free heave."""
    value, rate, rate2, variance = free_motion(t, x, p)
    r, r1, r2 = ramp(t, p.ramp_time, ops)
    free, free_rate = r * value, r * rate + r1 * value
    free_rate2 = r * rate2 + 2.0 * r1 * rate + r2 * value
    z, z_rate = x.response, x.response_rate
    z_rate2 = acceleration(z, z_rate, u.reaction, p.mass, p.damping, p.stiffness)
    deviation = math.sqrt(variance)
    limit = 2.0 * p.sdof_tolerance * deviation
    sdof = 1.0 - abs(z) / limit if limit > 0.0 else 1.0
    speed = max(abs(x.old_speed), abs(x.new_speed))
    froude = 1.0 - speed / math.sqrt(GRAVITY * p.length) / heave_response.FROUDE_LIMIT
    return Outputs(
        free + z, free_rate + z_rate, free, 4.0 * deviation, sdof, froude, _slow(*_seas(x), p),
        free_rate + z_rate, free_rate2 + z_rate2, free_rate,
    )  # fmt: skip


def _slow(old: Sea, new: Sea, p: Parameters) -> float:
    """1 - (relative change of height, of frequency, and of direction in rad, a peak period)/0.1, the worst of them."""
    height, frequency = max(old.height, new.height), max(new.frequency, old.frequency)
    change = max(
        abs(new.height - old.height) / height if height > CALM else 0.0,
        abs(new.frequency - old.frequency) / frequency,
        2.0 * abs(math.sin(0.5 * (new.direction - old.direction))) if height > CALM else 0.0,
    )
    slow: float = 1.0 - change * 2.0 * math.pi / frequency / p.update_interval / SLOW
    return slow


def calculated(p: Parameters, ops: Ops) -> ship.Calculated:
    """Constants of the heave oscillator, as in `ship`."""
    return ship.calculated(p, FLOATS)


SHIP_IN_SEA = Model(
    "ship_in_sea",
    "Ship in an irregular sea: closed-form heave response, plus that of its oscillator to the line",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, advance=advance, outputs=outputs, transition=transition, calculated=calculated,
    requirements=requirements,
    floats_only="its components are tables made from the seed in integer arithmetic, and their number is a parameter",
)  # fmt: skip
