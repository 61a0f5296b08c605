"""Unit `tow_cable_nonlinear`: tow cable and towed body without linearisation; ports as `tow_system`."""

from ..models.cable.units.tow_nonlinear import TOW_CABLE_NONLINEAR
from .declare.unit import Unit

UNIT = Unit.of(
    TOW_CABLE_NONLINEAR,
    start={"axial_stiffness": 4e6, "segments": 6.0},
    inputs={"velocity_heave": (1.0, 1.2), "velocity_surge": (0.5, 0.7)},
    terminals={
        "top": {
            "force_surge": "reaction_surge",
            "force_heave": "reaction_heave",
            "velocity_surge": "velocity_surge",
            "velocity_heave": "velocity_heave",
        },
        "flow": {"drag_change": "body_drag_change", "lift_change": "body_lift_change"},
    },
)
