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

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import NEGLIGIBLE, Ops, Value
from ..numeric.oscillator import acceleration, driven, exact_oscillation, margin_small, natural
from ..numeric.ramp import ramp
from ..protocol.model import Model
from ..protocol.variables import Rate, calculated_parameter, input_variable, margin, output, parameter, state


@dataclass(frozen=True)
class Parameters:
    """SI."""

    sway_amplitude: Annotated[Value, parameter("m", 0.1, "Amplitude of the free sway", display="ft")]
    sway_period: Annotated[Value, parameter("s", 12.0, "Period of the free sway", min=1e-9)]
    sway_phase: Annotated[
        Value, parameter("rad", 0.0, "Phase of the free sway: a sin(2 pi t / period + phase)", display="deg")
    ]
    ramp_time: Annotated[Value, parameter("s", 0.0, "Duration of a smooth start of the sway; 0: none", min=0.0)]
    mass: Annotated[Value, parameter("kg", 1e5, "Mass with sway added mass", display="lb", min=1e-9)]
    damping: Annotated[Value, parameter("N.s/m", 0.0, "Linear sway damping", display="lbf.s/ft", min=0.0)]
    stiffness: Annotated[Value, parameter("N/m", 1e3, "Stiffness of course keeping", display="lbf/ft", min=1e-12)]
    speed_start: Annotated[Value, parameter("m/s", 1.0, "Tow speed at the start", display="kn", min=0.0)]
    speed_end: Annotated[Value, parameter("m/s", 1.0, "Tow speed after the change", display="kn", min=0.0)]
    speed_change_start: Annotated[Value, parameter("s", 0.0, "Time at which the speed begins to change")]
    speed_change_time: Annotated[Value, parameter("s", 0.0, "Duration of the change of speed; 0: none", min=0.0)]
    sdof_tolerance: Annotated[
        Value, parameter("1", 0.05, "Share of the free amplitude by which the rope may move the craft", min=1e-9)
    ]


class State(NamedTuple):
    """The response z and its rate."""

    response: Annotated[Value, state("m", "Response to the rope's force")]
    response_rate: Annotated[Value, state("m/s", "Its time derivative")]


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """From the rope."""

    lateral_force: Annotated[
        Value,
        input_variable(
            "N", "Lateral force of the rope, positive to port", display="lbf",
            unset="one way: the rope does not move the craft",
        ),
    ]  # fmt: skip


class Outputs(NamedTuple):
    """``free_lateral`` is the prescribed part of ``lateral``; ``margin_sdof`` tells how far the rope moves the craft."""

    lateral: Annotated[
        Value, output("m", "Lateral position of the point that holds the rope, positive to port", display="ft")
    ]
    free_lateral: Annotated[Value, output("m", "Lateral position without the rope", display="ft")]
    tow_speed: Annotated[Value, output("m/s", "Tow speed", display="kn")]
    margin_sdof: Annotated[
        Value, margin("1 - |z| / (sdof_tolerance a), z the response to the rope and a the free amplitude")
    ]
    lateral_rate: Rate
    free_lateral_rate: Rate
    tow_speed_rate: Rate


class Calculated(NamedTuple):
    """Constants of the oscillator."""

    port_mass: Annotated[Value, calculated_parameter("kg", "Mass seen by the rope")]
    natural_frequency: Annotated[Value, calculated_parameter("rad/s", "sqrt(k/m)")]
    damping_ratio: Annotated[Value, calculated_parameter("1", "c / (2 sqrt(k m))")]


def tow_speed(t: Value, p: Parameters, ops: Ops) -> tuple[Value, Value]:
    """U, m/s, and its rate, m/s2."""
    change = ops.where(p.speed_change_time > NEGLIGIBLE, p.speed_end - p.speed_start, 0.0)
    risen, rate, _ = ramp(t - p.speed_change_start, p.speed_change_time, ops, change)
    return p.speed_start + risen, rate


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """No response yet."""
    return State(0.0, 0.0), Modes()


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x' of the response."""
    z, rate = x
    return State(rate, acceleration(z, rate, -u.lateral_force, p.mass, p.damping, p.stiffness))


def advance(t: Value, h: Value, x: State, m: Modes, cubics: Inputs, p: Parameters, ops: Ops) -> State:
    """Exact step of ``h``, s, for a force that is a cubic of time."""
    z, rate = x
    f0, f1, f2, f3 = cubics.lateral_force
    z, rate = exact_oscillation(h, z, rate, (-f0, -f1, -f2, -f3), p.mass, p.damping, p.stiffness, ops)
    return State(z, rate)


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables; ``margin_sdof`` as of `ship`."""
    free, free_rate, _ = driven(t, p.sway_amplitude, p.sway_period, p.sway_phase, p.ramp_time, ops)
    z, rate = x
    small = margin_small(z, p.sway_amplitude, p.sdof_tolerance, ops)
    speed, speed_rate = tow_speed(t, p, ops)
    return Outputs(free + z, free, speed, small, free_rate + rate, free_rate, speed_rate)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Constants of the oscillator."""
    return Calculated(p.mass, *natural(p.mass, p.damping, p.stiffness, ops))


SWAY_CRAFT = Model(
    "sway_craft",
    "Towing craft in sway: prescribed lateral motion, plus the response of its sway oscillator to the rope",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, derivatives=derivatives, advance=advance, outputs=outputs, calculated=calculated,
)  # fmt: skip
