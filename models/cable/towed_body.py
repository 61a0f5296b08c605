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
from typing import Annotated, NamedTuple

from ..numeric.ops import Ops, Value
from ..protocol.model import Model
from ..protocol.variables import Rate, calculated_parameter, input_variable, output, parameter, tunable


@dataclass(frozen=True)
class Parameters:
    """SI."""

    mass: Annotated[Value, parameter("kg", 900.0, "Mass", display="slug", min=1e-9)]
    added_mass_surge: Annotated[Value, tunable("kg", 256.0, "Added mass in surge", display="slug", min=0.0)]
    added_mass_heave: Annotated[Value, tunable("kg", 256.0, "Added mass in heave", display="slug", min=0.0)]
    drag: Annotated[Value, tunable("N", 1465.0, "Steady drag", display="lbf", min=0.0)]
    tow_speed: Annotated[Value, parameter("m/s", 3.0867, "Tow speed", display="kn", min=1e-9)]
    quadratic_drag: Annotated[
        Value, parameter("1", 1.0, "1: drag goes with speed squared; 0: constant", min=0.0, max=1.0)
    ]


class State(NamedTuple):
    """Displacements, m, and velocities, m/s, in the towing frame: outputs all."""

    surge: Value
    heave: Value
    velocity_surge: Value
    velocity_heave: Value


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """Changes of force; without those of the cable the body stays where it is."""

    force_surge: Annotated[
        Value, input_variable("N", "Change of the cable's force, forward", display="lbf", needed=True)
    ]
    force_heave: Annotated[Value, input_variable("N", "Change of the cable's force, up", display="lbf", needed=True)]
    drag_change: Annotated[
        Value, input_variable("N", "Change of the drag, aft", display="lbf", unset="no force but the cable's")
    ]
    lift_change: Annotated[
        Value, input_variable("N", "Change of the lift, up", display="lbf", unset="no force but the cable's")
    ]


class Outputs(NamedTuple):
    """Motion from the steady tow."""

    surge: Annotated[Value, output("m", "Displacement from the steady tow, forward", display="ft")]
    heave: Annotated[Value, output("m", "Displacement from the steady tow, up", display="ft")]
    velocity_surge: Annotated[Value, output("m/s", "Velocity in the towing frame, forward", display="ft/s")]
    velocity_heave: Annotated[Value, output("m/s", "Velocity, up", display="ft/s")]
    surge_rate: Rate
    heave_rate: Rate
    velocity_surge_rate: Rate
    velocity_heave_rate: Rate


class Calculated(NamedTuple):
    """What the cable feels."""

    port_mass: Annotated[Value, calculated_parameter("kg", "Smaller virtual mass", tunable=True)]


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """The steady tow."""
    return State(0.0, 0.0, 0.0, 0.0), Modes()


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x'."""
    vx, vy = p.tow_speed + x.velocity_surge, x.velocity_heave
    size = ops.sqrt(vx * vx + vy * vy)
    quadratic = ops.where(p.quadratic_drag > 0.5, p.drag / (p.tow_speed * p.tow_speed), 0.0)
    drag_x = quadratic * (size * vx - p.tow_speed * p.tow_speed)
    drag_y = quadratic * size * vy
    return State(
        x.velocity_surge,
        x.velocity_heave,
        (u.force_surge - u.drag_change - drag_x) / (p.mass + p.added_mass_surge),
        (u.force_heave + u.lift_change - drag_y) / (p.mass + p.added_mass_heave),
    )


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[()]:
    """No branches."""
    return ()


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    surge, heave, velocity_surge, velocity_heave = x
    _, _, rate_surge, rate_heave = derivatives(t, x, m, u, p, ops)
    return Outputs(
        surge, heave, velocity_surge, velocity_heave, velocity_surge, velocity_heave, rate_surge, rate_heave
    )


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Mass seen by the cable."""
    return Calculated(p.mass + ops.minimum(p.added_mass_surge, p.added_mass_heave))


TOWED_BODY = Model(
    "towed_body",
    "Towed body: motion from the steady tow under changes of cable force, drag and lift",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, derivatives=derivatives, indicators=indicators, outputs=outputs, calculated=calculated,
)  # fmt: skip
