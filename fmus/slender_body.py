"""Unit `slender_body`: towed slender body, tow speed and lateral motion of the craft in, force on the craft out."""

from ..models.slender.body import SLENDER_BODY
from .declare.unit import Unit

UNIT = Unit.of(
    SLENDER_BODY,
    start={"tow_speed": 2.7, "yaw_start": 0.01},
    inputs={"craft_lateral": (0.1, 0.5)},
    terminals={
        "craft": {"force": "lateral_force", "displacement": "craft_lateral", "velocity_surge": "tow_speed"},
    },
)
