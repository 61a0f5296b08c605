"""Towed body: a point mass with added masses and drag, pulled by a cable.

    (m + m_s) x'' = F_x - dD - (D_B/c^2) (|V| V_x - c^2),   (m + m_h) y'' = F_y + dL - (D_B/c^2) |V| V_y
    V = (c + x', y') with quadratic drag; without it D_B is constant and its bracket vanishes

| symbol | meaning | unit |
|---|---|---|
| x, y | displacement from the steady tow, forward and up | m |
| F | change of the cable's force on the body, forward and up | N |
| dD, dL | change of drag (aft) and lift (up), inputs | N |
| m, m_s, m_h | mass, added masses in surge and heave | kg |
| D_B, c | steady drag, tow speed | N, m/s |

Weight, steady lift, drag and tension balance and do not appear. Assumptions: (1) a point: no pitch; (2) added masses
along the axes of the frame.

Source: small-perturbation report on towed cables, Equations [9] [10]; the quadratic drag is ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..numeric.ops import Ops, Value


@dataclass(frozen=True)
class Parameters:
    """SI."""

    mass: Value
    added_mass_surge: Value
    added_mass_heave: Value
    drag: Value
    tow_speed: Value
    quadratic_drag: Value


class State(NamedTuple):
    """Displacements, m, and velocities, m/s, in the towing frame."""

    surge: Value
    heave: Value
    velocity_surge: Value
    velocity_heave: Value


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Changes of force, N."""

    force_surge: Value
    force_heave: Value
    drag_change: Value
    lift_change: Value


class Outputs(NamedTuple):
    """Motion from the steady tow."""

    surge: Value
    heave: Value
    velocity_surge: Value
    velocity_heave: Value
    surge_rate: Value
    heave_rate: Value
    velocity_surge_rate: Value
    velocity_heave_rate: Value


class Calculated(NamedTuple):
    """Smaller of the two virtual masses, kg."""

    port_mass: Value


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """The steady tow."""
    return State(0.0, 0.0, 0.0, 0.0), Modes()


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x'."""
    vx, vy = p.tow_speed + x[2], x[3]
    size = ops.sqrt(vx * vx + vy * vy)
    quadratic = ops.where(p.quadratic_drag > 0.5, p.drag / (p.tow_speed * p.tow_speed), 0.0)
    drag_x = quadratic * (size * vx - p.tow_speed * p.tow_speed)
    drag_y = quadratic * size * vy
    return State(
        x[2],
        x[3],
        (u[0] - u[2] - drag_x) / (p.mass + p.added_mass_surge),
        (u[1] + u[3] - drag_y) / (p.mass + p.added_mass_heave),
    )


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[()]:
    """No branches."""
    return ()


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    rate = derivatives(t, x, m, u, p, ops)
    return Outputs(x[0], x[1], x[2], x[3], x[2], x[3], rate[2], rate[3])


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Mass seen by the cable."""
    return Calculated(p.mass + ops.minimum(p.added_mass_surge, p.added_mass_heave))
