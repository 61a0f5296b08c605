"""Docking cradle on a line: one degree of freedom in heave, quadratic drag, capture of a submersible.

    M y'' = T - W - b |y'| y',    b = rho S C_D / 2

| symbol | meaning | unit |
|---|---|---|
| y | heave from the static equilibrium, positive up | m |
| M | mass + added mass (+ submersible with its added mass, once docked) | kg |
| T | tension of the line, positive in tension | N |
| W | weight in water (+ that of the submersible, once docked) | N |
| b | drag per squared velocity | kg/m |

Docking is a plastic capture: M2 v+ = M1 v- + (M2 - M1) v_sub, hydrodynamic masses included, position continuous; the
energy lost is M1 (M2 - M1)/(2 M2) (v- - v_sub)^2 >= 0. The source switches the mass and keeps the velocity
(``soft_docking``), which creates momentum unless the submersible moves with the cradle.

Assumptions: (1) vertical motion only; (2) constant C_D (`margin_drag_reynolds`); (3) constant added mass; (4) deep
below the surface.

Source: MIT thesis 1969, sections II and III and example 3 (docking); register row 19 for the capture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .ops import NEGLIGIBLE, NEVER, Ops, Value

GRAVITY = 9.80665
REYNOLDS_SHARE = 0.1
"""Largest drag at uncertain C_D (below the critical Reynolds number) as a share of the weight carried."""


@dataclass(frozen=True)
class Parameters:
    """SI. ``docking_time`` < 0: never. ``docked_drag_area`` = 0: unchanged by docking."""

    mass: Value
    added_mass: Value
    weight_in_water: Value
    drag_area: Value
    drag_coefficient: Value
    water_density: Value
    drag_length: Value
    kinematic_viscosity: Value
    critical_reynolds: Value
    docking_time: Value
    submersible_mass: Value
    submersible_weight_in_water: Value
    docked_drag_area: Value
    soft_docking: Value
    heave_start: Value
    velocity_start: Value


class State(NamedTuple):
    """Heave, m, and its rate, m/s."""

    heave: Value
    velocity: Value


class Modes(NamedTuple):
    """``docked``: 1 with the submersible aboard."""

    docked: Value


class Inputs(NamedTuple):
    """Tension of the line, N, and vertical velocity of the submersible at docking, m/s, positive up."""

    line_tension: Value
    submersible_velocity: Value


class Outputs(NamedTuple):
    """Motions, m, m/s, m/s2, and the margin of the drag law."""

    heave: Value
    velocity: Value
    acceleration: Value
    margin_drag_reynolds: Value
    heave_rate: Value
    docked: Value
    next_event_time: Value


class Calculated(NamedTuple):
    """``port_mass``: M before docking, kg. ``drag_factor``: b before docking, kg/m."""

    port_mass: Value
    drag_factor: Value


def virtual_mass(docked: Value, p: Parameters) -> Value:
    """M, kg."""
    return p.mass + p.added_mass + docked * p.submersible_mass


def weight(docked: Value, p: Parameters) -> Value:
    """W, N."""
    return p.weight_in_water + docked * p.submersible_weight_in_water


def drag_factor(docked: Value, p: Parameters, ops: Ops) -> Value:
    """b = rho S C_D / 2, kg/m."""
    area = ops.where(docked * p.docked_drag_area > 0.0, p.docked_drag_area, p.drag_area)
    return 0.5 * p.water_density * p.drag_coefficient * area


def acceleration(velocity: Value, docked: Value, tension: Value, p: Parameters, ops: Ops) -> Value:
    """y'', m/s2."""
    drag = drag_factor(docked, p, ops) * ops.abs(velocity) * velocity
    return (tension - weight(docked, p) - drag) / virtual_mass(docked, p)


def capture(t: Value, velocity: Value, docked: Value, v_sub: Value, p: Parameters, ops: Ops) -> tuple[Value, Value]:
    """(velocity, docked) after a docking that is due at or before ``t``; unchanged otherwise."""
    due = ops.where(p.docking_time >= 0.0, ops.where(t >= p.docking_time, 1.0 - docked, 0.0), 0.0)
    before = p.mass + p.added_mass
    after = before + p.submersible_mass
    plastic = (before * velocity + p.submersible_mass * v_sub) / after
    return (
        ops.where(due * (1.0 - p.soft_docking) > 0.5, plastic, velocity),
        ops.where(due > 0.5, 1.0, docked),
    )


def margin_drag_reynolds(velocity: Value, docked: Value, p: Parameters, ops: Ops) -> Value:
    """1 - b min(|v|, v_c)^2 / (0.1 W), v_c = Re_c nu / d: below v_c the drag coefficient is not constant, and the drag
    there must stay under a tenth of the weight carried (of M g for a weightless body)."""
    v_c = p.critical_reynolds * p.kinematic_viscosity / p.drag_length
    slow = ops.minimum(ops.abs(velocity), v_c)
    load = weight(docked, p)
    load = ops.where(load > NEGLIGIBLE, load, virtual_mass(docked, p) * GRAVITY)
    return 1.0 - drag_factor(docked, p, ops) * slow * slow / (REYNOLDS_SHARE * load)


def requirements(p: Parameters, ops: Ops) -> tuple[tuple[Value, str], ...]:
    """What docks has a mass."""
    text = "docking_time is set but submersible_mass is 0: give the mass that docks, or a negative docking_time"
    return ((ops.where(p.docking_time >= 0.0, p.submersible_mass, 1.0), text),)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """As given by the start parameters, without submersible."""
    return State(p.heave_start, p.velocity_start), Modes(0.0)


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x', m/s and m/s2."""
    return State(x[1], acceleration(x[1], m[0], u[0], p, ops))


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    y, v = x
    docked = m[0]
    a = acceleration(v, docked, u[0], p, ops)
    margin = margin_drag_reynolds(v, docked, p, ops)
    return Outputs(y, v, a, margin, v, docked, next_event_time(t, m, p, ops))


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[Value, ...]:
    """The drag law has a kink where the velocity is zero."""
    return (x[1],)


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Docking, when due."""
    velocity, docked = capture(t, x[1], m[0], u[1], p, ops)
    return State(x[0], velocity), Modes(docked)


def next_event_time(t: Value, m: Modes, p: Parameters, ops: Ops) -> Value:
    """The docking time while it lies ahead, s."""
    return ops.where(p.docking_time >= 0.0, ops.where(m[0] > 0.5, NEVER, p.docking_time), NEVER)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Inertia at the port, and the drag factor."""
    return Calculated(virtual_mass(0.0, p), drag_factor(0.0, p, ops))
