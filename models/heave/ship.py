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

With ``reaction`` not connected and no start displacement z = 0 and the unit is the pure driver that the SDOF models assume;
connected, it is the
two-way ship. The response is stepped exactly for a reaction that is a cubic of time over the step.

Source: MIT thesis 1969, section II (sinusoidal heave of the vessel) and example 1 (m1, K1 of Lulu); the superposition
of free motion and response is exact because the oscillator is linear.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import Ops, Value
from ..numeric.oscillator import acceleration, driven, exact_oscillation, margin_small, natural
from ..protocol.model import Model
from ..protocol.variables import Rate, calculated_parameter, input_variable, margin, output, parameter, state, tunable


@dataclass(frozen=True)
class FreeMotion:
    """The motion without the line, SI."""

    heave_amplitude: Annotated[Value, parameter("m", 1.0, "Amplitude of the free heave", display="ft")]
    heave_period: Annotated[Value, parameter("s", 8.0, "Period of the free heave", min=1e-9)]
    heave_phase: Annotated[
        Value, parameter("rad", 0.0, "Phase of the free heave: a sin(2 pi t / period + phase)", display="deg")
    ]


@dataclass(frozen=True)
class Oscillator:
    """What every heaving ship has, SI."""

    ramp_time: Annotated[Value, parameter("s", 0.0, "Duration of a smooth start; 0: none", min=0.0)]
    mass: Annotated[Value, tunable("kg", 1e6, "Mass with heave added mass", display="lb", min=1e-9)]
    damping: Annotated[Value, tunable("N.s/m", 0.0, "Linear heave damping", display="lbf.s/ft", min=0.0)]
    stiffness: Annotated[Value, tunable("N/m", 1e6, "Water-plane stiffness", display="lbf/ft", min=1e-12)]
    sdof_tolerance: Annotated[
        Value, parameter("1", 0.05, "Share of the free amplitude by which the line may move the ship", min=1e-9)
    ]


@dataclass(frozen=True)
class Start:
    """Where the oscillator begins: a free decay, where nothing else moves the ship."""

    start_displacement: Annotated[
        Value, parameter("m", 0.0, "Response at the start, as for a free decay", display="ft")
    ] = 0.0
    start_velocity: Annotated[Value, parameter("m/s", 0.0, "Its rate at the start", display="ft/s")] = 0.0


@dataclass(frozen=True)
class Parameters(Start, Oscillator, FreeMotion):
    """The motion without the line first, then the oscillator, then its start."""


class State(NamedTuple):
    """The response z and its rate."""

    response: Annotated[Value, state("m", "Response to the line's reaction")]
    response_rate: Annotated[Value, state("m/s", "Its time derivative")]


class Modes(NamedTuple):
    """No branches."""


Reaction = Annotated[
    Value,
    input_variable(
        "N", "Excess of the line's pull over its static value, down on the ship", display="lbf",
        unset="one way: the line does not move the ship",
    ),
]  # fmt: skip
Heave = Annotated[Value, output("m", "Heave of the point that holds the line, positive up", display="ft")]
Velocity = Annotated[Value, output("m/s", "Heave velocity, positive up", display="ft/s")]
FreeHeave = Annotated[Value, output("m", "Heave without the line's reaction", display="ft")]


class Inputs(NamedTuple):
    """From the line."""

    reaction: Reaction


class Outputs(NamedTuple):
    """``free_heave`` is the prescribed part of ``heave``; ``margin_sdof`` tells how far the line moves the ship."""

    heave: Heave
    velocity: Velocity
    free_heave: FreeHeave
    margin_sdof: Annotated[
        Value, margin("1 - |z| / (sdof_tolerance a), z the response to the line and a the free amplitude")
    ]
    heave_rate: Rate
    velocity_rate: Rate
    free_heave_rate: Rate


class Calculated(NamedTuple):
    """Constants of the heave oscillator."""

    port_mass: Annotated[Value, calculated_parameter("kg", "Mass seen by the line", tunable=True)]
    natural_frequency: Annotated[Value, calculated_parameter("rad/s", "sqrt(K1/m1)", tunable=True)]
    damping_ratio: Annotated[Value, calculated_parameter("1", "c1 / (2 sqrt(K1 m1))", tunable=True)]


def free_motion(t: Value, p: Parameters, ops: Ops) -> tuple[Value, Value, Value]:
    """Free heave, m, its rate, m/s, and acceleration, m/s2."""
    return driven(t, p.heave_amplitude, p.heave_period, p.heave_phase, p.ramp_time, ops)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """At the start displacement, at rest where none is given."""
    return State(p.start_displacement, p.start_velocity), Modes()


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Oscillator, ops: Ops) -> State:
    """x' of the response."""
    z, rate = x
    return State(rate, acceleration(z, rate, u.reaction, p.mass, p.damping, p.stiffness))


def advance(t: Value, h: Value, x: State, m: Modes, cubics: Inputs, p: Oscillator, ops: Ops) -> State:
    """Exact step of length ``h``, s, for a reaction that is a cubic of time."""
    z, rate = x
    z, rate = exact_oscillation(h, z, rate, cubics.reaction, p.mass, p.damping, p.stiffness, ops)
    return State(z, rate)


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables. ``margin_sdof`` = 1 - |z|/(e a), e = ``sdof_tolerance``: the one-degree-of-freedom models assume
    that the line does not move the ship (1 where the free motion has no amplitude)."""
    free, rate, free_rate2 = driven(t, p.heave_amplitude, p.heave_period, p.heave_phase, p.ramp_time, ops)
    z, z_rate = x
    z_rate2 = acceleration(z, z_rate, u.reaction, p.mass, p.damping, p.stiffness)
    small = margin_small(z, p.heave_amplitude, p.sdof_tolerance, ops)
    velocity = rate + z_rate
    return Outputs(free + z, velocity, free, small, velocity, free_rate2 + z_rate2, rate)


def calculated(p: Oscillator, ops: Ops) -> Calculated:
    """Constants of the heave oscillator."""
    return Calculated(p.mass, *natural(p.mass, p.damping, p.stiffness, ops))


SHIP = Model(
    "ship",
    "Ship in heave: prescribed free motion, plus the response of its heave oscillator to the line",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, derivatives=derivatives, advance=advance, outputs=outputs, calculated=calculated,
)  # fmt: skip
