"""Unit `towed_body`: point mass with added masses and drag, cable force in, motion out."""

from ..models.cable import towed_body
from .declare.unit import Unit, calculated, entry, output, parameter, tunable

UNIT = Unit(
    name="towed_body",
    description="Towed body: motion from the steady tow under changes of cable force, drag and lift",
    model=towed_body,
    parameters=(
        parameter("mass", "kg", 900.0, "Mass", display="slug", min=1e-9),
        tunable("added_mass_surge", "kg", 256.0, "Added mass in surge", display="slug", min=0.0),
        tunable("added_mass_heave", "kg", 256.0, "Added mass in heave", display="slug", min=0.0),
        tunable("drag", "N", 1465.0, "Steady drag", display="lbf", min=0.0),
        parameter("tow_speed", "m/s", 3.0867, "Tow speed", display="kn", min=1e-9),
        parameter("quadratic_drag", "1", 1.0, "1: drag goes with speed squared; 0: constant", min=0.0, max=1.0),
    ),
    calculated=(calculated("port_mass", "kg", "Smaller virtual mass", "tunable"),),
    inputs=(
        entry("force_surge", "N", 0.0, "Change of the cable's force, forward", display="lbf"),
        entry("force_heave", "N", 0.0, "Change of the cable's force, up", display="lbf"),
        entry("drag_change", "N", 0.0, "Change of the drag, aft", display="lbf"),
        entry("lift_change", "N", 0.0, "Change of the lift, up", display="lbf"),
    ),
    outputs=(
        output("surge", "m", "Displacement from the steady tow, forward", display="ft", rate=True),
        output("heave", "m", "Displacement from the steady tow, up", display="ft", rate=True),
        output("velocity_surge", "m/s", "Velocity in the towing frame, forward", display="ft/s", rate=True),
        output("velocity_heave", "m/s", "Velocity, up", display="ft/s", rate=True),
    ),
    reference_inputs={"force_surge": (200.0, 1.1), "force_heave": (400.0, 0.8)},
)
