"""Ports of the unit ``wire``: inputs, outputs, calculated parameters."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from ...numeric.ops import Value
from ...protocol.variables import Quantity, Rate, calculated_parameter, error_margin, input_variable, margin, output
from .ports import SteadyTensionBody, SteadyTensionTop

VELOCITIES = ("velocity_surge", "velocity_sway", "velocity_heave", "payout_speed")
FORCES = ("body_force_surge", "body_force_sway", "body_force_heave")
LOWER = ("lower_velocity_surge", "lower_velocity_sway", "lower_velocity_heave")
ALL = (*VELOCITIES, *FORCES, *LOWER)
STATIONS = 5
"""Places between body and towpoint that show the shape."""
AT_BODY = (*FORCES, *LOWER)
LEAST_ROOM = 1e-9
"""Steady room to the breaking load, N, where there is none."""
BENDING_LIMIT, MOST_BENDING = 0.05, 10.0
"""Error of the tension by bending at which `margin_bending` is 0, and the largest that is told (a slack wire has any)."""
REYNOLDS_LIMIT, VISCOSITY = 2e5, 1.2e-6
"""Reynolds number at which the drag of a smooth cylinder begins to fall; kinematic viscosity of sea water at 13 deg C, m2/s."""


class Modes(NamedTuple):
    """No branches."""


def _force(direction: str) -> Quantity:
    return input_variable("N", f"Force on the body, {direction}", unset="no force but weight, drag and the wire's")


def _lower(direction: str) -> Quantity:
    return input_variable(
        "m/s", f"Velocity of the wire's lower end in the towing frame, {direction}; with body_port = 1",
        unset="the body on board, or with body_port = 1 a lower end that does not move so",
    )  # fmt: skip


class Inputs(NamedTuple):
    """Velocity of the towpoint in the towing frame, winch speed, forces on the body, velocity of a body of its own."""

    velocity_surge: Annotated[
        Value,
        input_variable(
            "m/s", "Velocity of the towpoint in the towing frame, forward", unset="the towpoint does not surge"
        ),
    ]
    velocity_sway: Annotated[Value, input_variable("m/s", "Velocity of the towpoint, to port", unset="no sway")]
    velocity_heave: Annotated[Value, input_variable("m/s", "Velocity of the towpoint, up")]
    payout_speed: Annotated[
        Value, input_variable("m/s", "Speed at which wire is paid out at the top; hauling: negative", unset="the winch is held")
    ]
    body_force_surge: Annotated[Value, _force("forward")]
    body_force_sway: Annotated[Value, _force("to port")]
    body_force_heave: Annotated[Value, _force("up")]
    lower_velocity_surge: Annotated[Value, _lower("forward")]
    lower_velocity_sway: Annotated[Value, _lower("to port")]
    lower_velocity_heave: Annotated[Value, _lower("up")]


def _lower_force(direction: str) -> Quantity:
    return output(
        "N", f"Excess of the wire's force on the body over its steady value, {direction}; 0 with the body on board",
        also=(*LOWER, *VELOCITIES),
    )  # fmt: skip


def _body_velocity(direction: str) -> Quantity:
    return output("m/s", f"Velocity of the body in the towing frame, {direction}", also=LOWER)


def _shape(k: int, what: str) -> Quantity:
    return output("m", f"Shape, {k}/{STATIONS + 1} of the length from the body up: {what}")


class Outputs(NamedTuple):
    """Forces, tensions, angles, places; ``*_rate`` of what other units take."""

    reaction_surge: Annotated[
        Value, output("N", "Excess of the wire's pull over its steady value, aft on the towpoint", also=VELOCITIES)
    ]
    reaction_sway: Annotated[
        Value, output("N", "Excess of the wire's pull over its steady value, to starboard on the towpoint", also=VELOCITIES)
    ]
    reaction_heave: Annotated[
        Value, output("N", "Excess of the wire's pull over its steady value, down on the towpoint", also=VELOCITIES)
    ]
    tension_top: Annotated[Value, output("N", "Tension at the towpoint", also=VELOCITIES)]
    tension_body: Annotated[Value, output("N", "Tension at the body", also=AT_BODY)]
    tension_least: Annotated[Value, output("N", "Least tension in the wire", also=ALL)]
    tension_most: Annotated[Value, output("N", "Largest tension in the wire", also=ALL)]
    angle_top: Annotated[
        Value, output("rad", "Angle of the wire at the towpoint below the horizontal", display="deg", also=VELOCITIES)
    ]
    depth: Annotated[Value, output("m", "Depth of the body below the towpoint's mean height")]
    layback: Annotated[Value, output("m", "Distance of the body behind the towpoint")]
    offset: Annotated[Value, output("m", "Distance of the body to port of the towpoint")]
    shape1_layback: Annotated[Value, _shape(1, "distance behind the towpoint")]
    shape1_offset: Annotated[Value, _shape(1, "distance to port of the towpoint")]
    shape1_depth: Annotated[Value, _shape(1, "depth below the towpoint's mean height")]
    shape2_layback: Annotated[Value, _shape(2, "distance behind the towpoint")]
    shape2_offset: Annotated[Value, _shape(2, "distance to port of the towpoint")]
    shape2_depth: Annotated[Value, _shape(2, "depth below the towpoint's mean height")]
    shape3_layback: Annotated[Value, _shape(3, "distance behind the towpoint")]
    shape3_offset: Annotated[Value, _shape(3, "distance to port of the towpoint")]
    shape3_depth: Annotated[Value, _shape(3, "depth below the towpoint's mean height")]
    shape4_layback: Annotated[Value, _shape(4, "distance behind the towpoint")]
    shape4_offset: Annotated[Value, _shape(4, "distance to port of the towpoint")]
    shape4_depth: Annotated[Value, _shape(4, "depth below the towpoint's mean height")]
    shape5_layback: Annotated[Value, _shape(5, "distance behind the towpoint")]
    shape5_offset: Annotated[Value, _shape(5, "distance to port of the towpoint")]
    shape5_depth: Annotated[Value, _shape(5, "depth below the towpoint's mean height")]
    body_surge: Annotated[Value, output("m", "Displacement of the body from the steady tow, forward")]
    body_sway: Annotated[Value, output("m", "Displacement of the body from the steady tow, to port")]
    body_heave: Annotated[Value, output("m", "Displacement of the body from the steady tow, up")]
    body_velocity_surge: Annotated[Value, _body_velocity("forward")]
    body_velocity_sway: Annotated[Value, _body_velocity("to port")]
    body_velocity_heave: Annotated[Value, _body_velocity("up")]
    lower_force_surge: Annotated[Value, _lower_force("forward")]
    lower_force_sway: Annotated[Value, _lower_force("to port")]
    lower_force_heave: Annotated[Value, _lower_force("up")]
    length: Annotated[Value, output("m", "Unstretched length of wire and tail")]
    margin_slack: Annotated[Value, margin("least tension over its steady value, at most 1", also=ALL)]
    margin_breaking: Annotated[
        Value, margin("(breaking load - largest tension) over its steady value; 1 where no breaking load is given", also=ALL)
    ]
    margin_resolution: Annotated[Value, margin("1 - error of the present shape by the elements / tolerance")]
    margin_bending: Annotated[
        Value,
        error_margin(
            "of the tension, by bending that the model leaves out: largest EI curvature^2/T where EI is given",
            100.0 * BENDING_LIMIT, "smaller motions, or more tension at the end that hangs loose",
            also=ALL,
        ),
    ]  # fmt: skip
    margin_surface: Annotated[
        Value,
        margin("depth of the body below the surface over its steady value, at most 1: the model has no surface; 1 where the "
               "steady body is above surface_height"),
    ]  # fmt: skip
    margin_drag: Annotated[
        Value,
        margin(f"1 - largest Reynolds number of the flow across the wire / {REYNOLDS_LIMIT:g}, where the drag coefficient of "
               "a smooth cylinder begins to fall", also=ALL),
    ]  # fmt: skip
    body_surge_rate: Rate
    body_sway_rate: Rate
    body_heave_rate: Rate


class Calculated(NamedTuple):
    """Of the steady tow and its elements."""

    port_mass: Annotated[Value, calculated_parameter("kg", "Mass of the wire at the towpoint's node")]
    steady_tension_top: SteadyTensionTop
    steady_tension_body: SteadyTensionBody
    steady_depth: Annotated[Value, calculated_parameter("m", "Steady depth of the body")]
    elements_used: Annotated[Value, calculated_parameter("1", "Number of elements")]
    mesh_error: Annotated[Value, calculated_parameter("1", "Error of the steady shape by the elements over the length")]
