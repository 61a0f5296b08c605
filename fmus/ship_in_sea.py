"""Unit `ship_in_sea`: the ship in an irregular sea that may change along a voyage, reaction of the line in."""

from ..models.sea.ship_in_sea import SHIP_IN_SEA
from .declare.unit import Unit

UNIT = Unit.of(
    SHIP_IN_SEA,
    start={"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0, "wave_height": 3.0, "speed": 5.0},
    inputs={"reaction": (5.0e4, 0.9)},
    terminals={
        "line": {"force": "reaction", "displacement": "heave"},
        "sea": {
            "wave_height": "wave_height",
            "wave_period": "wave_period",
            "wave_direction": "wave_direction",
            "speed": "speed",
        },
    },
)
