"""Unit `body_force`: oscillating drag and lift of a towed body."""

from ..models.cable.body_force import BODY_FORCE
from .declare.unit import Unit

UNIT = Unit.of(
    BODY_FORCE,
    start={"drag_amplitude": 200.0, "lift_amplitude": 400.0, "ramp_time": 4.0},
    inputs={"offset_lift": (50.0, 0.9)},
    terminals={
        "body": {"drag_change": "drag_change", "lift_change": "lift_change"},
    },
)
