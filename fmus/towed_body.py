"""Unit `towed_body`: point mass with added masses and drag, cable force in, motion out."""

from ..models.cable.towed_body import TOWED_BODY
from .declare.unit import Unit

UNIT = Unit.of(
    TOWED_BODY,
    inputs={"force_surge": (200.0, 1.1), "force_heave": (400.0, 0.8)},
    terminals={
        "cable": {
            "force_surge": "force_surge",
            "force_heave": "force_heave",
            "velocity_surge": "velocity_surge",
            "velocity_heave": "velocity_heave",
        },
        "flow": {"drag_change": "drag_change", "lift_change": "lift_change"},
    },
)
