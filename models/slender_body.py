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
| resolution | U over ``resolved_speed``, up to which the first five modes of the converged body are met to 1e-4 (rigid: the four of the rope and of yaw to 5 %) |

Source: thesis on the towed slender body; `slender_coefficients`, `slender_modes`, `slender_rigid` for equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple, Sequence

import numpy as np
from numpy.typing import NDArray

from .ops import Ops, Value
from .slender_coefficients import THEORIES, Body
from .slender_modes import Matrices, matrices, roots, spectrum
from .slender_step import FAST, fast_mode_damping, propagator

Array = NDArray[np.float64]
PER_LENGTH = 0.1
"""Decay per body length at which the stability margin is 1."""
MODES, MODE_ERROR, RIGID_ERROR = 5, 1e-4, 0.05
"""Modes and error that ``resolved_speed`` stands for."""
STATIONS = np.cos(np.linspace(math.pi, 0.0, 25)) / 2.0
"""Points at which the slope is watched, denser towards the ends."""


@dataclass(frozen=True)
class Parameters:
    """SI. ``theory``: 0 present, 1 corrected, 2 modified_old (with the three factors). ``mass_per_length`` = 0: neutrally
    buoyant."""

    length: Value
    diameter: Value
    bending_stiffness: Value
    structural_damping: Value
    mass_per_length: Value
    water_density: Value
    end_length: Value
    tail_cut: Value
    rope_length: Value
    friction_coefficient: Value
    normal_drag_coefficient: Value
    theory: Value
    nose_factor: Value
    tail_factor: Value
    nose_drag: Value
    flexible: Value
    shape_functions: Value
    fast_mode_damping: Value
    lateral_start: Value
    yaw_start: Value
    slope_limit: Value
    buoyancy_limit: Value


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


class Plant:
    """What follows from the parameters: matrices, scales, rows of the outputs."""

    def __init__(self, p: Parameters) -> None:
        section = 0.25 * math.pi * p.diameter**2
        self.fluid = p.water_density * section
        self.mass = p.mass_per_length or self.fluid
        total = self.mass + self.fluid
        self.tau = p.length**2 * math.sqrt(total / p.bending_stiffness)
        self.speed = math.sqrt(p.bending_stiffness / self.fluid) / p.length
        self.body = body(p)
        self.n = round(p.shape_functions) if p.flexible > 0.5 else 2
        plain = matrices(self.body, self.n)
        self.system: Matrices = replace(plain, extra=fast_mode_damping(plain, p.fast_mode_damping))
        self.rope = p.rope_length
        self.pull = 0.5 * self.fluid * self.body.tension
        value, slope = self.system.rows(np.array([-0.5, 0.5]))
        lam = self.body.end_length
        scale = self.system.scale
        self.points = np.array([value[0] - lam * slope[0], value[1], (value[0] - value[1]) / p.length]) / scale
        self.slopes = self.system.rows(STATIONS)[1] / scale / p.length


def body(p: Parameters) -> Body:
    """The dimensionless body. Raises ``ValueError`` with the reason where there is none."""
    for name in ("length", "diameter", "bending_stiffness", "water_density", "rope_length"):
        if not getattr(p, name) > 0.0:
            raise ValueError(f"{name} = {getattr(p, name):g}: expected a positive number")
    if p.theory not in (0.0, 1.0, 2.0):
        raise ValueError(f"theory = {p.theory:g}: expected 0 (present), 1 (corrected) or 2 (modified_old)")
    if p.flexible not in (0.0, 1.0):
        raise ValueError(f"flexible = {p.flexible:g}: expected 0 (rigid) or 1 (flexible)")
    if not 4 <= p.shape_functions <= 24 or p.shape_functions != round(p.shape_functions):
        raise ValueError(f"shape_functions = {p.shape_functions:g}: expected a whole number from 4 to 24")
    fluid = p.water_density * 0.25 * math.pi * p.diameter**2
    total = (p.mass_per_length or fluid) + fluid
    slenderness = p.length / p.diameter
    return Body(
        end_length=p.end_length / p.length, rope_length=p.rope_length / p.length, tail_cut=p.tail_cut,
        slenderness=slenderness, friction=slenderness * p.friction_coefficient,
        normal_drag=slenderness * p.normal_drag_coefficient, mass_ratio=fluid / total,
        damping=p.structural_damping / (math.sqrt(p.bending_stiffness * total) * p.length**2),
        theory=THEORIES[int(p.theory)], nose_factor=p.nose_factor, tail_factor=p.tail_factor, nose_drag=p.nose_drag,
    )  # fmt: skip


def problem(p: Parameters) -> str | None:
    """Why no body has these parameters, None if one has."""
    try:
        tension = body(p).tension
    except ValueError as error:
        return str(error)
    return None if tension > 0.0 else f"rope tension {tension:g} rho U^2 S/2: expected a positive one, with some drag"


@lru_cache(maxsize=16)
def plant(p: Parameters) -> Plant:
    """The plant of a set of parameters, remembered."""
    return Plant(p)


@lru_cache(maxsize=256)
def _growth(p: Parameters, speed: float) -> float:
    made = plant(p)
    s = roots(made.system, speed / made.speed)
    return float(np.max(s.real[np.abs(s) < FAST])) / made.tau


@lru_cache(maxsize=32)
def _propagator(p: Parameters, speed: float, h: float) -> tuple[Array, Array]:
    made = plant(p)
    return propagator(made.system, speed / made.speed, h / made.tau)


@lru_cache(maxsize=16)
def resolved_speed(p: Parameters) -> float:
    """m/s, on a grid of half a unit of u from 0.5 to 16."""
    made = plant(p)
    flexible = made.n > 2
    reference = matrices(made.body, made.n + 6 if flexible else 16)
    count, limit = (MODES, MODE_ERROR) if flexible else (4, RIGID_ERROR)
    u = 0.0
    while u < 16.0:
        wanted = spectrum(reference, u + 0.5, count)
        if not flexible:
            wanted = wanted[np.abs(wanted) < 0.5 * 22.37]  # beyond half the first free-free frequency it is flexure
        found = roots(made.system, u + 0.5)
        if any(np.min(np.abs(found - s)) > limit * abs(s) for s in wanted):
            break
        u += 0.5
    return max(u, 0.25) * made.speed


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
    f, g = _propagator(p, middle, h)
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
    growth = _growth(p, speed)
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
