"""Towed slender body in SI: its parameters, the dimensionless body they describe, and what is computed once from them.

| symbol | meaning | unit |
|---|---|---|
| M, m | mass of water displaced and of the body per length | kg/m |
| tau | L^2 sqrt((m + M)/EI) | s |
| u | sqrt(M/EI) U L | - |
| nu | mu_I/(sqrt(EI (m + M)) L^2), mu_I the ``structural_damping`` | - |
| eps cf, eps cd | slenderness L/D times the drag coefficients | - |

Assumptions and source: `slender_coefficients`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .ops import Value
from .slender_coefficients import THEORIES, Body
from .slender_modes import Matrices, matrices, roots, spectrum
from .slender_step import FAST, fast_mode_damping, propagator

Array = NDArray[np.float64]
MODES, MODE_ERROR, RIGID_ERROR = 5, 1e-4, 0.05
"""Modes and error that ``resolved_speed`` stands for."""
FLEXURE = 11.0
"""|s|, in 1/tau, half that of the first free-free mode: faster modes are flexure."""
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


class Plant:
    """What follows from the parameters: matrices, scales, rows of the outputs."""

    def __init__(self, p: Parameters) -> None:
        section = 0.25 * math.pi * p.diameter**2
        self.fluid = p.water_density * section
        self.mass = p.mass_per_length or self.fluid
        total = self.mass + self.fluid
        self.tau = float(p.length**2 * math.sqrt(total / p.bending_stiffness))
        self.speed = float(math.sqrt(p.bending_stiffness / self.fluid) / p.length)
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
def growth_rate(p: Parameters, speed: float) -> float:
    """Largest real part of the exponents slower than `FAST` at a tow speed in m/s, 1/s."""
    made = plant(p)
    s = roots(made.system, speed / made.speed)
    return float(np.max(s.real[np.abs(s) < FAST]) / made.tau)


@lru_cache(maxsize=32)
def step_matrices(p: Parameters, speed: float, h: float) -> tuple[Array, Array]:
    """`propagator` at a tow speed in m/s for a step of ``h``, s."""
    made = plant(p)
    return propagator(made.system, speed / made.speed, h / made.tau)


@lru_cache(maxsize=16)
def resolved_speed(p: Parameters) -> float:
    """Tow speed in m/s, on a grid of 0.5 in u up to 16, up to which the first five modes agree with those of six further
    functions; rigid: on a grid of 0.05, those of rope and yaw with the flexible body's."""
    made = plant(p)
    flexible = made.n > 2
    reference = matrices(made.body, made.n + 6 if flexible else 16)
    count, limit, grid = (MODES, MODE_ERROR, 0.5) if flexible else (4, RIGID_ERROR, 0.05)
    k = 0
    while (k + 1) * grid <= 16.0:
        u = (k + 1) * grid
        wanted = spectrum(reference, u, count)
        if not flexible:
            wanted = wanted[np.abs(wanted) < FLEXURE]
        found = roots(made.system, u)
        if any(np.min(np.abs(found - s)) > limit * abs(s) for s in wanted):
            break
        k += 1
    return float(max(k, 0.5) * grid * made.speed)
