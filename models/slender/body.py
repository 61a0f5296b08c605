"""Towed slender body in lateral motion: flexible or rigid, behind a craft that may sway and change its speed.

    tau^2 M q'' + tau (nu K0 + u D1 + E) q' + (K0 + u^2 K2) q = u^2 f w(t),   y(x, t) = sum q_k(t) phi_k(x/L)

with the matrices of `galerkin`, q in m, t in s, and the damping E of `damping`. The functions are those of a
linear model in ``docs/native.md``, core input w, schedule u.

| symbol | meaning | unit |
|---|---|---|
| y | lateral displacement, positive to port; x forward along the tow, z up | m |
| U, w | ``tow_speed``, ``craft_lateral`` | m/s, m |
| T | rope tension M U^2 P/2 + m_x dU/dt, never negative: a rope cannot push | N |
| m_x | mass of the body with its added mass along the tow | kg |
| alpha | ``rope_angle`` = (tip - w)/rope length, positive with the tip to port of the craft | rad |
| F | ``lateral_force`` of the rope on the craft, T alpha, positive to port; along the tow the rope pulls it back by T | N |
| psi | ``yaw_angle`` = (y nose - y tail)/L, positive with the nose to port | rad |
| g | ``growth_rate``: largest real part of the exponents at the present speed, slower than `damping.FAST` | 1/s |

``flexible`` = 0 holds the body rigid: two shape functions, two pairs of states. The step is exact for a constant speed
and a cubic w; `damping` tells about a changing speed and ``fast_mode_damping``.

Assumptions: those of `coefficients`; the speed changes slowly: dU/dt is in the rope's tension and its force on the craft, but
not in the equation of the lateral motion, whose rope pulls with the drag alone (`margin_speed_change`; where the body overtakes
its rope, the rope is slack and the equation means nothing); the craft is a source of speed, so that energy is not conserved
and a host must not expect it.

| margin | 1 minus, or formula |
|---|---|
| stability | min(1, -10 g L/U): 1 where every disturbance decays by 1/e within ten lengths, and at U = 0 |
| small_slope | largest slope of rope and body over ``slope_limit`` |
| neutral_buoyancy | abs(m/M - 1) over ``buoyancy_limit`` |
| speed_change | 4 m_x abs(dU/dt)/(M U^2 P/2), which bounds the error of a stable lateral motion, over 5 % |
| resolution | U over ``resolved_speed``, up to which the first five modes are right to 1e-4, rigid to 5 % |

Source: thesis on the towed slender body; `coefficients`, `galerkin`, `rigid` for equations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from ..numeric.ops import NEGLIGIBLE, Ops, Value
from ..protocol.linear_model import LinearModel, NoOwn
from ..protocol.state_space import Setup
from ..protocol.variables import Rate, calculated_parameter, error_margin, input_variable, margin, output
from .damping import propagator
from .prepared import prepare as prepared
from .prepared import resolved_constants
from .setup import Constants, Parameters, Size, requirements, setup, size_of, study

PER_LENGTH = 0.1
"""Decay per body length at which the stability margin is 1."""
CHANGE_LIMIT = 0.05
"""Error of the lateral motion, relative to its largest value, up to which a change of speed is slow."""
FELT = 4.0
"""That error over the share m_x dU/dt has of the rope's pull, at most: 0.1 to 3.2 on 150 random ramps of bodies that are stable
(``tests/models/test_slender_speed_change.py``: with the forces of dU/dt on rope, body and ends against without)."""
LEAST = -1e9
"""Margins are finite."""


class Inputs(NamedTuple):
    """What the craft does. A body that is not towed has no theory; a craft that is not given holds its course, or was
    forgotten."""

    tow_speed: Annotated[Value, input_variable("m/s", "Tow speed", display="kn", min=0.0, needed=True)]
    craft_lateral: Annotated[
        Value, input_variable("m", "Lateral position of the towing craft, positive to port", display="ft")
    ]


class Outputs(NamedTuple):
    """As in the table of this module."""

    tension: Annotated[Value, output("N", "Tension of the rope", display="lbf")]
    lateral_force: Annotated[
        Value, output("N", "Lateral force of the rope on the craft, positive to port", display="lbf")
    ]
    tip: Annotated[Value, output("m", "Lateral position of the nose's tip, positive to port", display="ft")]
    tail: Annotated[Value, output("m", "Lateral position of the tail, positive to port", display="ft")]
    rope_angle: Annotated[
        Value, output("rad", "Angle of the rope, positive with the tip to port of the craft", display="deg")
    ]
    yaw_angle: Annotated[
        Value, output("rad", "Mean slope of the body, positive with the nose to port", display="deg")
    ]
    growth_rate: Annotated[Value, output("1/s", "Largest real part of the modes at the present speed")]
    margin_stability: Annotated[Value, margin("min(1, -10 g L/U), g the growth rate; 1 at U = 0")]
    margin_small_slope: Annotated[Value, margin("1 - largest slope of rope and body / slope_limit")]
    margin_neutral_buoyancy: Annotated[
        Value, margin("1 - |m/M - 1| / buoyancy_limit, M the mass of the water displaced")
    ]
    margin_resolution: Annotated[Value, margin("1 - U / resolved_speed")]
    margin_speed_change: Annotated[
        Value,
        error_margin(
            "of the lateral motion, which leaves the forces of dU/dt out; the rope is slack where the body overtakes it",
            100.0 * CHANGE_LIMIT, "change the speed more slowly",
        ),
    ]  # fmt: skip
    tension_rate: Rate
    lateral_force_rate: Rate
    tip_rate: Rate
    tail_rate: Rate
    yaw_angle_rate: Rate


class Calculated(NamedTuple):
    """Scales of the body."""

    time_scale: Annotated[Value, calculated_parameter("s", "tau = L^2 sqrt((m + M)/EI)")]
    speed_scale: Annotated[
        Value, calculated_parameter("m/s", "Tow speed at which u = sqrt(M/EI) U L is 1", display="kn")
    ]
    resolved_speed: Annotated[
        Value,
        calculated_parameter(
            "m/s", "Tow speed up to which the first modes are met to 1e-4, rigid: 5 %", display="kn"
        ),
    ]
    towed_mass: Annotated[Value, calculated_parameter("kg", "Mass with the lateral added mass", display="lb")]
    axial_mass: Annotated[Value, calculated_parameter("kg", "Mass with the added mass along the tow", display="lb")]


def start(p: Parameters, constants: Constants, ops: Ops) -> tuple[tuple[Value, ...], tuple[()]]:
    """Straight, at ``lateral_start`` and turned by ``yaw_start``, moving along the tow: (z, no own states)."""
    rest = (0.0,) * (2 * size_of(p).functions - 2)
    return (p.lateral_start, -p.yaw_start * p.length / math.sqrt(12.0), *rest), ()


def schedule(u: Inputs, p: Parameters, constants: Constants, ops: Ops) -> Value:
    """The tow speed u, dimensionless. A negative one, with which no step is made, counts as none."""
    return ops.maximum(0.0, u.tow_speed) / constants.speed_scale


def drive(own: NoOwn, cubics: Inputs, p: Parameters, constants: Constants, ops: Ops) -> tuple[Sequence[Value]]:
    """The polynomial of the one core input, the craft's lateral position."""
    return (cubics.craft_lateral,)


def core(
    own: NoOwn, u: Inputs, du: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[tuple[Value], tuple[Value], tuple[Value]]:
    """(w, w', 0): y contains no w', so w'' is not asked for."""
    return (u.craft_lateral,), (du.craft_lateral,), (0.0,)


def observe(
    t: Value, own: NoOwn, y: Sequence[Value], y_rate: Sequence[Value], u: Inputs, du: Inputs, growth: Value,
    p: Parameters, constants: Constants, ops: Ops,
) -> tuple[Outputs, tuple[()]]:  # fmt: skip
    """All observables, from the rows of `setup`; a negative speed as in `schedule`."""
    speed, w = ops.maximum(0.0, u.tow_speed), u.craft_lateral
    speed_rate, w_rate = du
    tip, tail, yaw, *slopes = y
    tip_rate, tail_rate, yaw_rate, *_ = y_rate
    drag, inertia = constants.pull * speed * speed, constants.axial_mass * speed_rate
    taut = drag + inertia > 0.0
    tension = ops.maximum(0.0, drag + inertia)
    tension_rate = ops.where(taut, 2.0 * constants.pull * speed * speed_rate, 0.0)  # U'' is not known here
    angle, angle_rate = (tip - w) / p.rope_length, (tip_rate - w_rate) / p.rope_length
    slope = ops.abs(angle)
    for each in slopes:
        slope = ops.maximum(slope, ops.abs(each))
    moves = speed > NEGLIGIBLE
    pulled = drag > NEGLIGIBLE
    left_out = ops.abs(inertia) / ops.where(pulled, drag, 1.0)
    left_out = ops.where(pulled, left_out, ops.where(ops.abs(inertia) > 0.0, -LEAST, 0.0))
    decay = ops.where(moves, -growth * p.length / (PER_LENGTH * ops.where(moves, speed, 1.0)), 1.0)
    return Outputs(
        tension, tension * angle, tip, tail, angle, yaw, growth, ops.maximum(LEAST, ops.minimum(1.0, decay)),
        1.0 - slope / p.slope_limit,
        1.0 - ops.abs(constants.mass_share - 1.0) / p.buoyancy_limit,
        1.0 - speed / (constants.resolved * constants.speed_scale),
        ops.maximum(LEAST, 1.0 - FELT * left_out / CHANGE_LIMIT),
        tension_rate, tension_rate * angle + tension * angle_rate, tip_rate, tail_rate, yaw_rate,
    ), ()  # fmt: skip


def describe(p: Parameters, constants: Constants, ops: Ops) -> Calculated:
    """Scales of the body."""
    c = constants
    return Calculated(c.time_scale, c.speed_scale, c.resolved * c.speed_scale, c.towed_mass, c.axial_mass)


def prepare(p: Parameters) -> Setup:
    """The matrices and constants, of numbers. Raises ``ValueError`` where there is no body."""
    return prepared(p).setup._replace(constants=resolved_constants(p))


def check_step(h: float, cubics: Inputs) -> None:
    """Raises ``ValueError`` for a step of ``h``, s, with a negative speed at its start or in its middle."""
    u0, u1, u2, u3 = cubics.tow_speed
    least = min(u0, u0 + 0.5 * h * (u1 + 0.5 * h * (u2 + 0.5 * h * u3)))
    if least < 0.0:
        raise ValueError(f"tow_speed = {least:g} m/s: expected no negative one, the body is towed nose first")


LINEAR = LinearModel(
    "slender_body",
    "Towed slender body with tapered ends in lateral motion, flexible or rigid",
    Parameters, Inputs, Outputs, Calculated, Size,
    setup=setup, prepare=prepare, drive=drive, core=core, observe=observe, describe=describe, start=start,
    schedule=schedule, study=study, requirements=requirements, check_step=check_step, operator=propagator, rates=3,
)  # fmt: skip
SLENDER_BODY = LINEAR.as_model()
