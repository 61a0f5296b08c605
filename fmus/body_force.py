"""Unit `body_force`: oscillating drag and lift of a towed body."""

from ..models.cable import body_force
from .declare.unit import Unit, entry, output, parameter

UNIT = Unit(
    name="body_force",
    description="Oscillating drag and lift of a towed body, prescribed",
    model=body_force,
    parameters=(
        parameter("drag_amplitude", "N", 0.0, "Amplitude of the drag", display="lbf"),
        parameter("drag_phase", "rad", 0.0, "Phase of the drag: a sin(2 pi t / period + phase)", display="deg"),
        parameter("lift_amplitude", "N", 0.0, "Amplitude of the lift", display="lbf"),
        parameter("lift_phase", "rad", 0.0, "Phase of the lift: a sin(2 pi t / period + phase)", display="deg"),
        parameter("period", "s", 8.0, "Period of both", min=1e-9),
        parameter("ramp_time", "s", 0.0, "Duration of a smooth start; 0: none", min=0.0),
    ),
    inputs=(entry("offset_lift", "N", 0.0, "Lift on top of the prescribed one", display="lbf"),),
    outputs=(
        output("drag_change", "N", "Change of the body's drag, aft", display="lbf", rate=True),
        output("lift_change", "N", "Change of the body's lift, up", display="lbf", depends=("offset_lift",), rate=True),
    ),
    start={"drag_amplitude": 200.0, "lift_amplitude": 400.0, "ramp_time": 4.0},
    reference_inputs={"offset_lift": (50.0, 0.9)},
)
