"""Unit `ship`: heave of the ship, reaction of the line in."""

from ..models.heave.ship import SHIP
from .declare.unit import Unit

UNIT = Unit.of(
    SHIP,
    start={"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0},
    inputs={"reaction": (5.0e4, 0.9)},
    terminals={
        "line": {"force": "reaction", "displacement": "heave"},
    },
)
