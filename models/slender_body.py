"""Towed slender body in lateral motion: flexible or rigid, behind a craft that may sway and change its speed.

    tau^2 M q'' + tau (nu K0 + u D1 + E) q' + (K0 + u^2 K2) q = u^2 f w(t),   y(x, t) = sum q_k(t) phi_k(x/L)

with the matrices of `slender_modes`, q in m, t in s, and the damping E of `slender_step`.

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

Source: thesis on the towed slender body; `slender_coefficients`, `slender_modes`, `slender_rigid` for equations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .ops import Ops, Value
from .slender_plant import Parameters, growth_rate, plant, problem, resolved_speed, step_matrices

__all__ = ["Parameters", "State", "advance", "calculated", "initial", "outputs", "problem"]

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


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """Straight, at ``lateral_start`` and turned by ``yaw_start``, moving along the tow. 2n states: displacements
    times their scale, then velocities in m/tau."""
    made = plant(p)
    q = np.zeros(made.n)
    q[0], q[1] = p.lateral_start, -p.yaw_start * p.length / math.sqrt(12.0)
    return tuple((made.system.scale * q).tolist()) + (0.0,) * made.n, Modes()


def advance(
    t: Value, h: Value, x: Sequence[Value], m: Modes, coefficients: Sequence[Sequence[Value]], p: Parameters, ops: Ops
) -> tuple[Value, ...]:
    """Step of ``h``, s: exact for a lateral motion that is a cubic of time, with the tow speed of mid-step. Raises
    ``ValueError`` for a negative speed."""
    (u0, u1, u2, u3), (w0, w1, w2, w3) = coefficients
    middle = u0 + 0.5 * h * (u1 + 0.5 * h * (u2 + 0.5 * h * u3))
    if min(u0, middle) < 0.0:
        raise ValueError(f"tow_speed = {min(u0, middle):g} m/s: expected no negative one, the body is towed nose first")
    f, g = step_matrices(p, middle, h)
    z = f @ np.array(x) + g @ np.array([w0, h * w1, 2.0 * h * h * w2, 6.0 * h**3 * w3])
    return tuple(z.tolist())


def outputs(t: Value, x: Sequence[Value], m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables. A negative speed, which `advance` refuses, counts as none here."""
    made = plant(p)
    speed, w = max(0.0, u[0]), u[1]
    speed_rate, w_rate = du
    z = np.array(x)
    n = made.n
    tip, tail, yaw = (made.points @ z[:n]).tolist()
    tip_rate, tail_rate, yaw_rate = (made.points @ (made.system.scale * z[n:]) / made.tau).tolist()
    tension, tension_rate = made.pull * speed * speed, 2.0 * made.pull * speed * speed_rate
    angle, angle_rate = (tip - w) / made.rope, (tip_rate - w_rate) / made.rope
    growth = growth_rate(p, speed)
    slope = max(abs(angle), float(np.abs(made.slopes @ z[:n]).max()))
    stability = min(1.0, -growth * p.length / (PER_LENGTH * speed)) if speed > 0.0 else 1.0
    return Outputs(
        tension, tension * angle, tip, tail, angle, yaw, growth, max(-1e9, stability),
        1.0 - slope / p.slope_limit,
        1.0 - abs(made.mass / made.fluid - 1.0) / p.buoyancy_limit,
        1.0 - speed / resolved_speed(p),
        tension_rate, tension_rate * angle + tension * angle_rate, tip_rate, tail_rate, yaw_rate,
    )  # fmt: skip


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Scales of the plant."""
    made = plant(p)
    length = p.length * float(made.system.mass[0, 0])
    return Calculated(made.tau, made.speed, resolved_speed(p), (made.mass + made.fluid) * length)
