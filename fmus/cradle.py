"""Unit `cradle`: suspended body, line tension in, heave out, with docking."""

from ..models.heave import cradle
from .declare.unit import Unit, calculated, entry, local, margin, next_event_time, output, parameter, tunable

BODY = (
    parameter("mass", "kg", 1000.0, "Mass", display="lb", min=1e-9),
    tunable("added_mass", "kg", 0.0, "Added mass", display="lb", min=0.0),
    tunable("weight_in_water", "N", 0.0, "Weight in water", display="lbf", min=0.0),
    tunable("drag_area", "m2", 0.0, "Reference area of the drag", display="ft2", min=0.0),
    tunable("drag_coefficient", "1", 1.0, "Drag coefficient", min=0.0),
    parameter("water_density", "kg/m3", 1025.0, "Density of the water", display="slug/ft3", min=0.0),
    parameter("drag_length", "m", 1.0, "Length in the Reynolds number", display="ft", min=1e-9),
    parameter("kinematic_viscosity", "m2/s", 1.19e-6, "Kinematic viscosity of the water (sea water, 15 degC)", min=0.0),
    parameter("critical_reynolds", "1", 1e5, "Reynolds number above which the drag coefficient is constant", min=0.0),
    parameter("docking_time", "s", -1.0, "Time at which the submersible docks; negative: never"),
    parameter("submersible_mass", "kg", 0.0, "Mass of the submersible with its added mass", display="lb", min=0.0),
    parameter("submersible_weight_in_water", "N", 0.0, "Weight in water of the submersible", display="lbf"),
    parameter("docked_drag_area", "m2", 0.0, "Drag area once docked; 0: unchanged", display="ft2", min=0.0),
    parameter("soft_docking", "1", 0.0, "1: docking keeps the velocity, as in the thesis; 0: plastic capture", min=0.0,
              max=1.0),
    parameter("heave_start", "m", 0.0, "Heave at the start", display="ft"),
    parameter("velocity_start", "m/s", 0.0, "Velocity at the start", display="ft/s"),
)  # fmt: skip

SUBMERSIBLE = entry(
    "submersible_velocity", "m/s", 0.0, "Vertical velocity of the submersible when it docks, positive up",
    display="ft/s",
)  # fmt: skip
DOCKING = ("submersible_velocity",)
"""What acts without delay on all that follows from the velocity, at the moment of docking."""
MOTION = (
    output("heave", "m", "Heave from the static equilibrium, positive up", display="ft", nominal=1.0, rate=True),
    output("velocity", "m/s", "Heave velocity, positive up", display="ft/s", nominal=1.0, depends=DOCKING),
    local("docked", "1", "1 with the submersible aboard", "discrete"),
    next_event_time(),
)
REYNOLDS = margin(
    "drag_reynolds", "1 - b min(|v|, v_c)^2 / (0.1 W), v_c the speed at the critical Reynolds number", DOCKING
)

UNIT = Unit(
    name="cradle",
    description="Docking cradle on a line: heave with quadratic drag, capture of a submersible",
    model=cradle,
    parameters=BODY,
    calculated=(
        calculated("port_mass", "kg", "Virtual mass before docking", "tunable"),
        calculated("drag_factor", "kg/m", "Drag per squared velocity before docking", "tunable"),
    ),
    inputs=(entry("line_tension", "N", 0.0, "Tension of the line", display="lbf"), SUBMERSIBLE),
    outputs=(
        *MOTION,
        output("acceleration", "m/s2", "Heave acceleration, positive up", display="ft/s2",
               depends=("line_tension", *DOCKING)),
        REYNOLDS,
    ),
    start={"mass": 5000.0, "drag_area": 10.0, "weight_in_water": 2e4, "docking_time": 3.0, "submersible_mass": 8000.0},
    reference_inputs={"line_tension": (1.0e4, 0.9)},
)  # fmt: skip
