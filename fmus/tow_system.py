"""Unit `tow_system`: tow cable and towed body, towpoint velocity in, force and body motion out (linear)."""

from ..models.cable.units import tow_system
from .declare.unit import Unit, Variable, calculated, entry, local, margin, output, parameter, per_second, tunable


def coefficients(name: str) -> tuple[Variable, ...]:
    """Parameters of one set of the ten-coefficient loading."""
    terms = {"a0": "1", "a1": "cos", "a2": "cos 2", "b1": "sin", "b2": "sin 2"}
    return tuple(
        tunable(f"{name}_{key}", "1", 0.0, f"Coefficient of {term} in the {name} load, loading_form 2")
        for key, term in terms.items()
    )


TOW = (
    parameter("quadrant", "1", 1.0, "1: a ship tows a deep body; 2: a submarine tows a float", min=1.0, max=2.0),
    tunable("tow_speed", "m/s", 3.0867, "Tow speed", display="kn"),
    tunable("water_density", "kg/m3", 1025.0, "Density of the water", display="slug/ft3"),
    tunable("cable_length", "m", 120.0, "Unstretched length", display="ft"),
    tunable("cable_mass", "kg/m", 0.83, "Mass per length", display="slug/ft"),
    tunable("cable_weight", "N/m", 6.36, "Weight in water per length", display="lbf/ft"),
    tunable("cable_thickness", "m", 0.015, "Thickness", display="in"),
    tunable("cable_drag_coefficient", "1", 1.2, "Drag coefficient of the cable across the flow"),
    parameter("loading_form", "1", 0.0, "0: Eames; 1: cross-flow; 2: ten coefficients", min=0.0, max=2.0),
    tunable("loading_friction", "1", 0.03, "Friction f of Eames, or pi Cdt/Cdn of the cross-flow form", min=0.0),
    *coefficients("normal"),
    *coefficients("tangential"),
    tunable("added_mass_coefficient", "1", 1.0, "Added mass over displaced mass; 1: bare and round", min=0.0),
    parameter("momentum_added_mass", "1", 0.0, "1: momentum form of the added mass; 0: Morison's", min=0.0, max=1.0),
    tunable("axial_stiffness", "N", 0.0, "Axial stiffness EA; 0: not known", display="lbf", min=0.0),
    tunable("body_mass", "kg", 900.0, "Mass of the body", display="slug", min=0.0),
    tunable("body_added_mass_surge", "kg", 256.0, "Added mass of the body in surge", display="slug", min=0.0),
    tunable("body_added_mass_heave", "kg", 256.0, "Added mass of the body in heave", display="slug", min=0.0),
    tunable("body_weight_in_water", "N", 6313.0, "Weight of the body in water", display="lbf"),
    tunable("body_lift", "N", 0.0, "Steady lift of the body", display="lbf"),
    tunable("body_drag", "N", 1465.0, "Steady drag of the body", display="lbf", min=0.0),
    parameter("body_quadratic_drag", "1", 1.0, "1: drag goes with speed squared; 0: constant", min=0.0, max=1.0),
    tunable("perturbation_limit", "1", 0.21,
            "Towpoint speed over tow speed at margin 0: 0.042, 0.21, 0.42 for 1, 5, 10 % error of the tension",
            min=1e-6),
)  # fmt: skip
CHOICE = (
    parameter("segments", "1", 0.0, "Number of segments; 0: as many as tolerance needs", min=0.0, max=400.0),
    parameter("tolerance", "1", 0.02, "Relative error of the gains up to band", min=1e-5, max=0.5),
    parameter("band", "rad/s", 2.0, "Highest angular frequency for which tolerance holds", min=1e-3, max=1e3),
    parameter("reduced", "1", 1.0, "1: reduce the number of states as tolerance allows; 0: keep all", min=0.0, max=1.0),
)
VELOCITY = (
    entry("velocity_surge", "m/s", 0.0, "Velocity of the towpoint in the towing frame, forward", display="ft/s"),
    entry("velocity_heave", "m/s", 0.0, "Velocity of the towpoint, up", display="ft/s"),
    entry("body_drag_change", "N", 0.0, "Change of the body's drag, aft", display="lbf"),
    entry("body_lift_change", "N", 0.0, "Change of the body's lift, up", display="lbf"),
)
NAMES = tuple(v.name for v in VELOCITY)


def reactions(depends: tuple[str, ...], rate: bool) -> tuple[Variable, ...]:
    """Forces on the towpoint."""
    return (
        output("reaction_surge", "N", "Excess of the cable's pull over its steady value, aft on the towpoint",
               display="lbf", depends=depends, rate=rate),
        output("reaction_heave", "N", "Excess of the cable's pull over its steady value, down on the towpoint",
               display="lbf", depends=depends, rate=rate),
        output("tension_top", "N", "Tension at the towpoint", display="lbf", depends=depends, rate=rate),
        output("tension_body", "N", "Tension at the body", display="lbf", depends=depends),
    )  # fmt: skip


BODY = (
    output("body_surge", "m", "Displacement of the body from the steady tow, forward", display="ft", rate=True),
    output("body_heave", "m", "Displacement of the body from the steady tow, up", display="ft", rate=True),
)


def body_velocity(depends: tuple[str, ...], rate: bool) -> tuple[Variable, ...]:
    """Velocity of the body."""
    return (
        output("body_velocity_surge", "m/s", "Velocity of the body in the towing frame, forward", display="ft/s",
               depends=depends, rate=rate),
        output("body_velocity_heave", "m/s", "Velocity of the body, up", display="ft/s", depends=depends, rate=rate),
    )  # fmt: skip


def linear_margins(depends: tuple[str, ...]) -> tuple[Variable, ...]:
    """Margins of the linear units."""
    return (
        margin("small_perturbation", "1 - v / (perturbation_limit c), v the speed of the towpoint", depends),
        margin("slack", "1 - max |T1| / T0 over the segments", depends),
        margin("flow", "1 - |V1| / V0 at the towpoint, V the flow along the cable", depends),
        margin("quadrant", "1 - share of the way to the stream's direction that a segment has turned", depends),
        margin("resolution", "1 - model_error / tolerance"),
    )


def remembered(inputs: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """The states that hold the second derivatives of ``inputs``."""
    return tuple(
        local(f"{v.name}_d2", per_second(v.unit, 2), f"Second derivative of {v.name} over the last step")
        for v in inputs
    )


CHOSEN = (
    calculated("steady_tension_top", "N", "Steady tension at the towpoint", "tunable", display="lbf"),
    calculated("steady_tension_body", "N", "Steady tension at the body", "tunable", display="lbf"),
    calculated("states", "1", "Number of states of the model"),
    calculated("segments_used", "1", "Number of segments behind it"),
    calculated(
        "model_error", "1", "Relative error of the gains up to band, of segments and reduction together", "tunable"
    ),
)

UNIT = Unit(
    name="tow_system",
    description="Tow cable and towed body, small perturbations from the steady tow",
    model=tow_system,
    parameters=(*TOW, parameter("extensible", "1", 0.0, "1: the cable stretches by axial_stiffness", min=0.0, max=1.0),
                *CHOICE),
    calculated=(
        calculated("port_mass", "kg", "Apparent mass in heave that the towpoint feels at once", "tunable"),
        calculated("apparent_mass_surge", "kg", "Apparent mass in surge", "tunable"),
        calculated("apparent_mass_coupling", "kg", "Apparent mass between surge and heave", "tunable"),
        calculated("apparent_mass_heave", "kg", "Apparent mass in heave", "tunable"),
        *CHOSEN[:2],
        calculated("steady_body_surge", "m", "Steady position of the body from the towpoint, forward", "tunable", display="ft"),
        calculated("steady_body_heave", "m", "Steady position of the body from the towpoint, up", "tunable", display="ft"),
        *CHOSEN[2:],
        calculated("inextensible_error", "1", "Relative error of leaving axial_stiffness out; 0: none or not known", "tunable"),
    ),
    inputs=VELOCITY,
    outputs=(
        *reactions(NAMES, True),
        *BODY,
        *body_velocity(NAMES, True),
        *linear_margins(NAMES),
        margin("inextensible", "1 - inextensible_error / tolerance"),
    ),
    states=(
        local("towpoint_surge", "m", "Displacement of the towpoint in the towing frame, forward", display="ft"),
        local("towpoint_heave", "m", "Displacement of the towpoint, up", display="ft"),
        *remembered(VELOCITY),
    ),
    start={"segments": 10.0, "tolerance": 0.2},
    reference_inputs={"velocity_heave": (0.4, 1.2), "velocity_surge": (0.2, 0.7)},
)  # fmt: skip
