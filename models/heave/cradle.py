"""Docking cradle on a line: one degree of freedom in heave, quadratic drag, capture of a submersible.

    M y'' = T - W - b |y'| y' - c y',    b = rho S C_D / 2

| symbol | meaning | unit |
|---|---|---|
| y | heave from the static equilibrium, positive up | m |
| M | mass + added mass (+ submersible with its added mass, once docked) | kg |
| T | tension of the line, positive in tension | N |
| W | weight in water (+ that of the submersible, once docked) | N |
| b | drag per squared velocity | kg/m |
| c | ``linear_damping``: equivalent linear drag (`linear.equal_loss`) with b = 0, or damping beside the drag | N s/m |

Docking is a plastic capture: M2 v+ = M1 v- + (M2 - M1) v_sub, hydrodynamic masses included, position continuous; the
energy lost is M1 (M2 - M1)/(2 M2) (v- - v_sub)^2 >= 0. The source switches the mass and keeps the velocity
(``soft_docking``), which creates momentum unless the submersible moves with the cradle.

Assumptions: (1) vertical motion only; (2) constant C_D (`margin_drag_reynolds`); (3) constant added mass; (4) deep
below the surface.

Source: MIT thesis 1969, sections II and III and example 3 (docking); register row 19 for the capture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import NEGLIGIBLE, NEVER, Ops, Value
from ..protocol.model import Model, Requirement
from ..protocol.physical import GRAVITY, liquid, weight_below_gravity
from ..protocol.variables import (
    NextEvent,
    Rate,
    calculated_parameter,
    input_variable,
    local,
    margin,
    output,
    parameter,
    tunable,
)

REYNOLDS_SHARE = 0.1
"""Largest drag at uncertain C_D (below the critical Reynolds number) as a share of the weight carried."""


@dataclass(frozen=True)
class Parameters:
    """SI."""

    mass: Annotated[Value, parameter("kg", 1000.0, "Mass", display="lb", min=1e-9)]
    added_mass: Annotated[Value, tunable("kg", 0.0, "Added mass", display="lb", min=0.0)]
    weight_in_water: Annotated[Value, tunable("N", 0.0, "Weight in water", display="lbf", min=0.0)]
    drag_area: Annotated[Value, tunable("m2", 0.0, "Reference area of the drag", display="ft2", min=0.0)]
    drag_coefficient: Annotated[Value, tunable("1", 1.0, "Drag coefficient", min=0.0)]
    water_density: Annotated[Value, parameter("kg/m3", 1025.0, "Density of the water", display="slug/ft3", min=0.0)]
    drag_length: Annotated[Value, parameter("m", 1.0, "Length in the Reynolds number", display="ft", min=1e-9)]
    kinematic_viscosity: Annotated[
        Value, parameter("m2/s", 1.19e-6, "Kinematic viscosity of the water (sea water, 15 degC)", min=0.0)
    ]
    critical_reynolds: Annotated[
        Value, parameter("1", 1e5, "Reynolds number above which the drag coefficient is constant", min=0.0)
    ]
    docking_time: Annotated[Value, parameter("s", -1.0, "Time at which the submersible docks; negative: never")]
    submersible_mass: Annotated[
        Value, parameter("kg", 0.0, "Mass of the submersible with its added mass", display="lb", min=0.0)
    ]
    submersible_weight_in_water: Annotated[
        Value, parameter("N", 0.0, "Weight in water of the submersible", display="lbf")
    ]
    docked_drag_area: Annotated[
        Value, parameter("m2", 0.0, "Drag area once docked; 0: unchanged", display="ft2", min=0.0)
    ]
    soft_docking: Annotated[
        Value, parameter("1", 0.0, "1: docking keeps the velocity, as in the thesis; 0: plastic capture", min=0.0, max=1.0)
    ]
    heave_start: Annotated[Value, parameter("m", 0.0, "Heave at the start", display="ft")]
    velocity_start: Annotated[Value, parameter("m/s", 0.0, "Velocity at the start", display="ft/s")]
    linear_damping: Annotated[
        Value, tunable("N.s/m", 0.0, "Linear damping, as the equivalent of the quadratic drag", display="lbf.s/ft", min=0.0)
    ]


class State(NamedTuple):
    """Heave, m, and its rate, m/s: outputs both."""

    heave: Value
    velocity: Value


class Modes(NamedTuple):
    """``docked``: 1 with the submersible aboard."""

    docked: Value


Heave = Annotated[
    Value, output("m", "Heave from the static equilibrium, positive up", display="ft", nominal=1.0)
]
Velocity = Annotated[Value, output("m/s", "Heave velocity, positive up", display="ft/s", nominal=1.0)]
MarginDragReynolds = Annotated[
    Value, margin("1 - b min(|v|, v_c)^2 / (0.1 W), v_c the speed at the critical Reynolds number")
]
Docked = Annotated[Value, local("1", "1 with the submersible aboard", discrete=True)]
SubmersibleVelocity = Annotated[
    Value,
    input_variable(
        "m/s", "Vertical velocity of the submersible when it docks, positive up", display="ft/s",
        unset="the submersible hovers where it docks",
    ),
]  # fmt: skip


class Inputs(NamedTuple):
    """From the line, without whose pull the body falls, and from the submersible at docking."""

    line_tension: Annotated[Value, input_variable("N", "Tension of the line", display="lbf", needed=True)]
    submersible_velocity: SubmersibleVelocity


class Outputs(NamedTuple):
    """Motions, and the margin of the drag law."""

    heave: Heave
    velocity: Velocity
    acceleration: Annotated[Value, output("m/s2", "Heave acceleration, positive up", display="ft/s2")]
    margin_drag_reynolds: MarginDragReynolds
    heave_rate: Rate
    docked: Docked
    next_event_time: NextEvent


class Calculated(NamedTuple):
    """M and b before docking."""

    port_mass: Annotated[Value, calculated_parameter("kg", "Virtual mass before docking", tunable=True)]
    drag_factor: Annotated[
        Value, calculated_parameter("kg/m", "Drag per squared velocity before docking", tunable=True)
    ]


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
    drag = (drag_factor(docked, p, ops) * ops.abs(velocity) + p.linear_damping) * velocity
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


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """What docks has a mass; neither it nor the cradle weighs more in water than in air; no liquid is so dense."""
    text = "docking_time is set but submersible_mass is 0: give the mass that docks, or a negative docking_time"
    docks = p.docking_time >= 0.0
    possible, why = weight_below_gravity(
        p.submersible_weight_in_water, p.submersible_mass, p.water_density, "submersible_weight_in_water",
        "submersible_mass", ops,
    )  # fmt: skip
    return (
        (ops.where(docks, p.submersible_mass, 1.0), text),
        weight_below_gravity(p.weight_in_water, p.mass, p.water_density, "weight_in_water", "mass", ops),
        (ops.where(docks, possible, 1.0), why),
        liquid(p.water_density, ops),
    )


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """As given by the start parameters, without submersible."""
    return State(p.heave_start, p.velocity_start), Modes(0.0)


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x', m/s and m/s2."""
    return State(x.velocity, acceleration(x.velocity, m.docked, u.line_tension, p, ops))


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    y, v = x
    docked = m.docked
    a = acceleration(v, docked, u.line_tension, p, ops)
    return Outputs(y, v, a, margin_drag_reynolds(v, docked, p, ops), v, docked, next_event_time(t, m, p, ops))


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[Value, ...]:
    """The drag law has a kink where the velocity is zero."""
    return (x.velocity,)


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Docking, when due."""
    velocity, docked = capture(t, x.velocity, m.docked, u.submersible_velocity, p, ops)
    return State(x.heave, velocity), Modes(docked)


def next_event_time(t: Value, m: Modes, p: Parameters, ops: Ops) -> Value:
    """The docking time while it lies ahead, s."""
    return ops.where(p.docking_time >= 0.0, ops.where(m.docked > 0.5, NEVER, p.docking_time), NEVER)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Inertia at the port, and the drag factor."""
    return Calculated(virtual_mass(0.0, p), drag_factor(0.0, p, ops))


CRADLE = Model(
    "cradle",
    "Docking cradle on a line: heave with quadratic drag, capture of a submersible",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, derivatives=derivatives, outputs=outputs, indicators=indicators, transition=transition,
    next_event_time=next_event_time, calculated=calculated, requirements=requirements,
)  # fmt: skip
