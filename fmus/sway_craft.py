"""Unit `sway_craft`: towing craft with one degree of freedom, lateral force of the rope in, lateral motion out."""

from ..models.slender.sway_craft import SWAY_CRAFT
from .declare.unit import Unit

UNIT = Unit.of(
    SWAY_CRAFT,
    start={"mass": 2e4, "damping": 1e3, "ramp_time": 4.0, "speed_end": 3.0, "speed_change_time": 15.0},
    inputs={"lateral_force": (200.0, 0.9)},
    terminals={
        "tow": {"force": "lateral_force", "displacement": "lateral", "velocity_surge": "tow_speed"},
    },
)
