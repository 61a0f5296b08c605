"""Towed slender body in SI: its parameters, the dimensionless body they describe, and its matrices.

    z' = (A0 + u A1 + u^2 A2) z + u^2 B2 w,   y = C z,   z = (scale q, tau q') in m, t in s

| symbol | meaning | unit |
|---|---|---|
| M, m | mass of water displaced and of the body per length | kg/m |
| tau | L^2 sqrt((m + M)/EI) | s |
| u | sqrt(M/EI) U L | - |
| nu | mu_I/(sqrt(EI (m + M)) L^2), mu_I the ``structural_damping`` | - |
| eps cf, eps cd | slenderness L/D times the drag coefficients | - |
| y | positions of tip and tail, m; yaw angle; slopes at `STATIONS` | m, rad |

q and scale as in `galerkin`. Assumptions and source: `coefficients`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from ..numeric.matrix_ops import MatrixOps
from ..numeric.ops import FLOATS, NEVER, Ops, Value
from ..protocol.model import Requirement, refusal_of
from ..protocol.physical import liquid, solid_cylinder
from ..protocol.state_space import Resolution, Setup, Study
from ..protocol.variables import parameter
from . import coefficients as slender_coefficients
from .coefficients import THEORIES, Body, Numbers, ends, where_met
from .damping import FAST, fast_mode_damping
from .galerkin import Matrices, galerkin

FLEXURE = 11.0
"""|s|, in 1/tau, half that of the first free-free mode: faster modes are flexure."""
STATIONS = np.cos(np.linspace(math.pi, 0.0, 25)) / 2.0
"""Points at which the slope is watched, denser towards the ends."""
FEWEST, MOST, RIGID = 4, 24, 2
"""Shape functions that a flexible body may have, and those of a rigid one."""


@dataclass(frozen=True)
class Parameters:
    """SI."""

    length: Annotated[Value, parameter("m", 10.0, "Length of the body without its ends", display="ft", min=1e-9)]
    diameter: Annotated[Value, parameter("m", 0.25, "Diameter", display="ft", min=1e-9)]
    bending_stiffness: Annotated[Value, parameter("N.m2", 2830.0, "Bending stiffness EI", min=1e-9)]
    structural_damping: Annotated[
        Value, parameter("N.m2.s", 0.0, "Kelvin-Voigt damping: moment per rate of curvature", min=0.0)
    ]
    mass_per_length: Annotated[
        Value, parameter("kg/m", 0.0, "Mass per length; 0: that of the water displaced", display="lb/ft", min=0.0)
    ]
    water_density: Annotated[Value, parameter("kg/m3", 1025.0, "Density of the water", display="slug/ft3", min=1e-9)]
    end_length: Annotated[
        Value,
        parameter("m", 0.15, "Length of the half-ellipsoidal nose, and tail, more than half a diameter", display="ft", min=1e-12),
    ]
    tail_length: Annotated[
        Value,
        parameter("m", 0.0, "Length of the tail's half ellipsoid before it is cut; 0: that of the nose, end_length", display="ft",
                  min=0.0),
    ]  # fmt: skip
    tail_cut: Annotated[
        Value,
        parameter("1", 1.0, "Share of the tail's length that is kept: 1 full, towards 0 a flat base", min=1e-9, max=1.0),
    ]
    rope_length: Annotated[Value, parameter("m", 10.0, "Length of the tow rope", display="ft", min=1e-9)]
    friction_coefficient: Annotated[
        Value, parameter("1", 0.025, "Friction coefficient cf on rho U^2 pi D/2 per length", min=0.0)
    ]
    normal_drag_coefficient: Annotated[
        Value, parameter("1", 0.0, "Coefficient cd of the linear normal drag beyond friction", min=0.0)
    ]
    theory: Annotated[
        Value,
        parameter("1", 0.0, "0: present, as published; 1: corrected nose terms; 2: modified old", min=0.0, max=2.0),
    ]
    nose_factor: Annotated[Value, parameter("1", 1.0, "f1 of the old theory")]
    tail_factor: Annotated[Value, parameter("1", 1.0, "f2 of the old theory")]
    nose_drag: Annotated[Value, parameter("1", 0.0, "c1 of the old theory")]
    flexible: Annotated[Value, parameter("1", 1.0, "1: flexible; 0: rigid, two pairs of states", min=0.0, max=1.0)]
    shape_functions: Annotated[
        Value, parameter("1", 14.0, "Legendre functions of the flexible body; twice as many states", min=4.0, max=24.0)
    ]
    fast_mode_damping: Annotated[
        Value,
        parameter("1", 0.02, "Damping ratio of the modes beyond the resolution, which would grow", min=0.0, max=1.0),
    ]
    lateral_start: Annotated[
        Value, parameter("m", 0.0, "Lateral position at the start, positive to port", display="ft")
    ]
    yaw_start: Annotated[Value, parameter("rad", 0.0, "Yaw angle at the start, nose to port positive", display="deg")]
    slope_limit: Annotated[
        Value, parameter("rad", 0.2, "Slope up to which the small-slope theory is trusted", display="deg", min=1e-9)
    ]
    buoyancy_limit: Annotated[
        Value, parameter("1", 0.1, "Share by which the mass may differ from that of the water displaced", min=1e-9)
    ]


class Size(NamedTuple):
    """The parameters that fix the number of states."""

    flexible: float
    shape_functions: float

    @property
    def functions(self) -> int:
        """Shape functions: half the number of states."""
        return round(self.shape_functions) if self.flexible > 0.5 else RIGID

    @property
    def damped(self) -> bool:
        """Whether fast modes are damped as the parameters say."""
        return True


class Undamped(Size):
    """Never damped: what a resolution is judged by, so that the damping's own error counts."""

    @property
    def damped(self) -> bool:
        """No."""
        return False


class Constants(NamedTuple):
    """tau, s; speed of u = 1, m/s; T/U^2, N s2/m2; mass with the water it drags across, and along the tow, kg; m/M; `FAST`
    and `FLEXURE` in 1/s; the u up to which the modes are resolved, which is found after the rest."""

    time_scale: Value
    speed_scale: Value
    pull: Value
    towed_mass: Value
    axial_mass: Value
    mass_share: Value
    fast: Value
    flexure: Value
    resolved: Value


def size_of(p: Parameters) -> Size:
    """The structure that the parameters ask for."""
    return Size(p.flexible, p.shape_functions)


def resolution(size: Size) -> Resolution:
    """Resolved are the first five modes to 1e-4, judged by six further functions, on a grid of 0.5 in u up to 16; rigid:
    those of rope and yaw to 5 %, judged by a flexible body, on a grid of 0.05."""
    flexible = size.functions > RIGID
    finer = Undamped(1.0, size.functions + 6.0 if flexible else 16.0)
    modes, error, grid, below = (5, 1e-4, 0.5, None) if flexible else (4, 0.05, 0.05, "flexure")
    return Resolution(finer, modes, error, grid, 16.0, "resolved", below)


def study(size: Size) -> Study:
    """What is found out at the start: resolution and growth."""
    return Study(resolution=resolution(size), growth_below="fast")


def masses(p: Parameters, ops: Ops) -> tuple[Value, Value]:
    """(M, m), kg/m."""
    fluid = p.water_density * 0.25 * math.pi * p.diameter**2
    return fluid, ops.where(p.mass_per_length == 0.0, fluid, p.mass_per_length)


def dimensionless(p: Parameters, ops: Ops) -> Numbers:
    """The body's numbers."""
    fluid, mass = masses(p, ops)
    slenderness = p.length / p.diameter
    return Numbers(
        end_length=p.end_length / p.length, rope_length=p.rope_length / p.length, tail_cut=p.tail_cut,
        slenderness=slenderness, friction=slenderness * p.friction_coefficient,
        normal_drag=slenderness * p.normal_drag_coefficient, mass_ratio=fluid / (mass + fluid),
        damping=p.structural_damping / (ops.sqrt(p.bending_stiffness * (mass + fluid)) * p.length**2),
        theory=p.theory, nose_factor=p.nose_factor, tail_factor=p.tail_factor, nose_drag=p.nose_drag,
        tail_length=p.tail_length / p.length,
    )  # fmt: skip


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """What a body needs: numbers in SI first, then what `coefficients.requirements` asks, and a taut rope."""
    positive = ("length", "diameter", "bending_stiffness", "water_density", "rope_length")
    held = {}
    own: list[Requirement] = []
    for name in positive:
        value = getattr(p, name)
        fits = ops.where(value < NEVER, value, -1.0)
        held[name] = ops.where(fits > 0.0, value, 1.0)
        own.append((fits, f"{name}: expected a positive, finite number"))
    mass = p.mass_per_length
    fits = ops.where(mass >= 0.0, ops.where(mass < NEVER, 1.0, 0.0), 0.0)
    held["mass_per_length"] = ops.where(fits > 0.0, mass, 1.0)
    own += [
        (fits, "mass_per_length: expected a finite number that is not negative"),
        (sum(ops.where(p.flexible == k, 1.0, 0.0) for k in (0, 1)), "flexible: expected 0 (rigid) or 1 (flexible)"),
        (sum(ops.where(p.shape_functions == k, 1.0, 0.0) for k in range(FEWEST, MOST + 1)),
         f"shape_functions: expected a whole number from {FEWEST} to {MOST}"),
    ]  # fmt: skip
    own += [
        liquid(p.water_density, ops),
        solid_cylinder(p.mass_per_length, p.diameter, "mass_per_length", "diameter", ops),
    ]
    numbers = dimensionless(replace(p, **held), ops)
    own += slender_coefficients.requirements(numbers, ops)
    tension = ends(where_met(own, numbers, ops), ops).tension
    return (*own, (tension, "rope tension: expected a positive one, with some drag"))


def refusal(p: Parameters) -> str:
    """Why no body has these parameters; empty if one has."""
    return refusal_of(requirements(p, FLOATS))


def body(p: Parameters) -> Body:
    """The dimensionless body. Raises ``ValueError`` with the reason where there is none."""
    if reason := refusal(p):
        raise ValueError(reason)
    numbers = dimensionless(p, FLOATS)
    return Body(**(numbers._asdict() | {"theory": THEORIES[int(p.theory)]}))


def system_of(p: Parameters, size: Size, matrices: MatrixOps) -> Matrices:
    """The Galerkin matrices, with the damping of fast modes."""
    plain = galerkin(dimensionless(p, matrices.scalars), size.functions, matrices)
    if not size.damped:
        return plain
    return replace(plain, extra=fast_mode_damping(plain, p.fast_mode_damping, matrices))


def axial_mass(p: Parameters, ops: Ops) -> Value:
    """Mass that a change of the tow speed accelerates, kg: body, ends, and the added mass along the tow, that of the spheroids
    whose halves the ends are (k1 of H. Lamb, Hydrodynamics, 6th ed., section 114: the cylinder between them adds none)."""
    fluid, mass = masses(p, ops)
    numbers = dimensionless(p, ops)
    its_ends = ends(numbers, ops)
    volume = its_ends.nose.i2 + its_ends.tail.i2
    added = its_ends.shape.k1 * its_ends.nose.i2 + its_ends.tail_shape.k1 * its_ends.tail.i2
    return p.length * (mass * (1.0 + volume) + fluid * added)


def setup(p: Parameters, size: Size, matrices: MatrixOps) -> Setup:
    """The matrices in s and m, and the constants."""
    return assemble(p, system_of(p, size, matrices), matrices)


def assemble(p: Parameters, system: Matrices, matrices: MatrixOps) -> Setup:
    """`setup` from the matrices of `system_of`."""
    ops = matrices.scalars
    fluid, mass = masses(p, ops)
    tau = p.length**2 * ops.sqrt((mass + fluid) / p.bending_stiffness)
    form = system.state_space(matrices)
    zero = matrices.zeros(2 * system.n, 1)
    per_scale = np.diag(1.0 / system.scale)
    value, slope = (matrices.constant(rows @ per_scale) for rows in system.rows(np.array([-0.5, 0.5])))
    slopes = matrices.constant(system.rows(STATIONS)[1] @ per_scale)
    rows = matrices.vstack([
        value[:1, :] - p.end_length / p.length * slope[:1, :], value[1:, :], (value[:1, :] - value[1:, :]) / p.length,
        slopes / p.length,
    ])  # fmt: skip
    moved = (mass + fluid) * p.length * system.mass[0, 0]
    constants = Constants(
        time_scale=tau, speed_scale=ops.sqrt(p.bending_stiffness / fluid) / p.length,
        pull=0.5 * fluid * system.tension, towed_mass=moved, axial_mass=axial_mass(p, ops),
        mass_share=mass / fluid, fast=FAST / tau, flexure=FLEXURE / tau, resolved=0.0,
    )  # fmt: skip
    count = rows.shape[0]
    return Setup(
        a=tuple(a / tau for a in form.a), b=(zero, zero, form.b / tau),
        c=matrices.hstack([rows, matrices.zeros(count, system.n)]), d=matrices.zeros(count, 1),
        e=matrices.zeros(count, 1), constants=constants,
    )  # fmt: skip
