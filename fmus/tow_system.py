"""Unit `tow_system`: tow cable and towed body, towpoint velocity in, force and body motion out (linear)."""

from ..models.cable.units.tow_system import TOW_SYSTEM
from .declare.unit import Unit

UNIT = Unit.of(
    TOW_SYSTEM,
    start={"segments": 10.0, "tolerance": 0.2},
    inputs={"velocity_heave": (0.4, 1.2), "velocity_surge": (0.2, 0.7)},
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
