"""Towed slender body in lateral motion: flexible or rigid, behind a craft that may sway and change its speed.

    tau^2 M q'' + tau (nu K0 + u D1 + E) q' + (K0 + u^2 K2) q = u^2 f w(t),   y(x, t) = sum q_k(t) phi_k(x/L)

with the matrices of `slender_galerkin`, q in m, t in s, and the damping E of `slender_step`. The functions are those of a
linear model in ``docs/native.md``, core input w, schedule u.

| symbol | meaning | unit |
|---|---|---|
| y | lateral displacement, positive to port; x forward along the tow, z up | m |
| U, w | ``tow_speed``, ``craft_lateral`` | m/s, m |
| T | rope tension M U^2 P/2 | N |
| alpha | ``rope_angle`` = (tip - w)/rope length, positive with the tip to port of the craft | rad |
| F | ``lateral_force`` of the rope on the craft, T alpha, positive to port; along the tow the rope pulls it back by T | N |
| psi | ``yaw_angle`` = (y nose - y tail)/L, positive with the nose to port | rad |
| g | ``growth_rate``: largest real part of the exponents at the present speed, slower than `slender_step.FAST` | 1/s |

``flexible`` = 0 holds the body rigid: two shape functions, two pairs of states. The step is exact for a constant speed
and a cubic w; `slender_step` tells about a changing speed and ``fast_mode_damping``.

Assumptions: those of `slender_coefficients`; the speed may change slowly (forces of dU/dt are left out); the craft is a
source of constant speed, so that energy is not conserved and a host must not expect it.

| margin | 1 minus, or formula |
|---|---|
| stability | min(1, -10 g L/U): 1 where every disturbance decays by 1/e within ten lengths, and at U = 0 |
| small_slope | largest slope of rope and body over ``slope_limit`` |
| neutral_buoyancy | abs(m/M - 1) over ``buoyancy_limit`` |
| resolution | U over ``resolved_speed``, up to which the first five modes are right to 1e-4, rigid to 5 % |

Source: thesis on the towed slender body; `slender_coefficients`, `slender_galerkin`, `slender_rigid` for equations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from .linear_unit import remembered
from .ops import NEGLIGIBLE, Ops, Value
from .slender_plant import SlenderUnit, plant
from .slender_plant import constants as constants_of
from .slender_setup import Constants, Parameters, Size, requirements, setup, size_of, study

__all__ = ["STRUCTURE", "Parameters", "Size", "requirements", "setup", "study"]

STRUCTURE = Size._fields
PER_LENGTH = 0.1
"""Decay per body length at which the stability margin is 1."""


class State(NamedTuple):
    """Blocks of the state, n components each, one after the other: kappa q (q where kappa < 1), m; q', m/tau. Only their
    names: n is a parameter, so the state itself is a plain tuple."""

    displacements: Value
    velocities: Value


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Tow speed, m/s; lateral position of the craft, m, positive to port."""

    tow_speed: Value
    craft_lateral: Value


class Outputs(NamedTuple):
    """As in the table of this module; ``tip`` and ``tail`` are lateral positions of the nose's tip and the body's end, m."""

    tension: Value
    lateral_force: Value
    tip: Value
    tail: Value
    rope_angle: Value
    yaw_angle: Value
    growth_rate: Value
    margin_stability: Value
    margin_small_slope: Value
    margin_neutral_buoyancy: Value
    margin_resolution: Value
    tension_rate: Value
    lateral_force_rate: Value
    tip_rate: Value
    tail_rate: Value
    yaw_angle_rate: Value


class Calculated(NamedTuple):
    """tau, s; speed of u = 1, m/s; speed up to which the modes are resolved, m/s; mass with the water it drags, kg."""

    time_scale: Value
    speed_scale: Value
    resolved_speed: Value
    towed_mass: Value


def start(p: Parameters, constants: Constants, ops: Ops) -> tuple[tuple[Value, ...], tuple[()]]:
    """Straight, at ``lateral_start`` and turned by ``yaw_start``, moving along the tow: (z, no own states)."""
    rest = (0.0,) * (2 * size_of(p).functions - 2)
    return (p.lateral_start, -p.yaw_start * p.length / math.sqrt(12.0), *rest), ()


def schedule(u: Sequence[Value], p: Parameters, constants: Constants, ops: Ops) -> Value:
    """The tow speed u, dimensionless. A negative one, with which no step is made, counts as none."""
    return ops.maximum(0.0, u[0]) / constants.speed_scale


def drive(
    own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value]]:
    """The polynomial of the one core input, the craft's lateral position."""
    return (cubics[1],)


def own_after(
    h: Value, own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Constants, ops: Ops
) -> tuple[()]:
    """No own states."""
    return ()


def own_rates(
    own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Constants, ops: Ops
) -> tuple[()]:
    """No own states."""
    return ()


def core(
    own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Constants, ops: Ops
) -> tuple[tuple[Value], tuple[Value], tuple[Value]]:
    """(w, w', 0): y contains no w', so w'' is not asked for."""
    return (u[1],), (du[1],), (0.0,)


def observe(
    t: Value, own: Sequence[Value], y: Sequence[Value], y_rate: Sequence[Value], u: Sequence[Value],
    du: Sequence[Value], growth: Value, p: Parameters, constants: Constants, ops: Ops,
) -> tuple[Outputs, tuple[()]]:  # fmt: skip
    """All observables, from the rows of `slender_setup`; a negative speed as in `schedule`."""
    speed, w = ops.maximum(0.0, u[0]), u[1]
    speed_rate, w_rate = du
    tip, tail, yaw = y[0], y[1], y[2]
    tip_rate, tail_rate, yaw_rate = y_rate[0], y_rate[1], y_rate[2]
    tension, tension_rate = constants.pull * speed * speed, 2.0 * constants.pull * speed * speed_rate
    angle, angle_rate = (tip - w) / p.rope_length, (tip_rate - w_rate) / p.rope_length
    slope = ops.abs(angle)
    for each in y[3:]:
        slope = ops.maximum(slope, ops.abs(each))
    moves = speed > NEGLIGIBLE
    decay = ops.where(moves, -growth * p.length / (PER_LENGTH * ops.where(moves, speed, 1.0)), 1.0)
    found = Outputs(
        tension, tension * angle, tip, tail, angle, yaw, growth, ops.maximum(-1e9, ops.minimum(1.0, decay)),
        1.0 - slope / p.slope_limit,
        1.0 - ops.abs(constants.mass_share - 1.0) / p.buoyancy_limit,
        1.0 - speed / (constants.resolved * constants.speed_scale),
        tension_rate, tension_rate * angle + tension * angle_rate, tip_rate, tail_rate, yaw_rate,
    )  # fmt: skip
    return found, ()


def describe(p: Parameters, constants: Constants, ops: Ops) -> Calculated:
    """Scales of the plant."""
    c = constants
    return Calculated(c.time_scale, c.speed_scale, c.resolved * c.speed_scale, c.towed_mass)


@remembered
def ready(p: Parameters) -> SlenderUnit:
    """The unit of a set of parameters. Raises ``ValueError`` where there is none."""
    found = constants_of(p)
    return SlenderUnit(
        plant(p).setup._replace(constants=found), p, drive, own_after, core, observe, rates=3, schedule=schedule,
        growth_below=found.fast,
    )  # fmt: skip


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """`start`: 2n states, displacements times their scale, then velocities in m/tau."""
    return start(p, ready(p).constants, ops)[0], Modes()


def advance(
    t: Value, h: Value, x: Sequence[Value], m: Modes, coefficients: Sequence[Sequence[Value]], p: Parameters, ops: Ops
) -> tuple[Value, ...]:
    """Step of ``h``, s: exact for a lateral motion that is a cubic of time, with the tow speed of mid-step. Raises
    ``ValueError`` for a negative speed."""
    u0, u1, u2, u3 = coefficients[0]
    least = min(u0, u0 + 0.5 * h * (u1 + 0.5 * h * (u2 + 0.5 * h * u3)))
    if least < 0.0:
        raise ValueError(f"tow_speed = {least:g} m/s: expected no negative one, the body is towed nose first")
    return ready(p).advance(h, x, coefficients)


def outputs(t: Value, x: Sequence[Value], m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """`observe`."""
    found: Outputs = ready(p).outputs(t, x, u, du)[0]
    return found


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """`describe`."""
    return describe(p, ready(p).constants, ops)
