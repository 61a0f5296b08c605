"""Unit `turning_ship`: a ship that turns, prescribed."""

from ..models.cable.turning_ship import TURNING_SHIP
from .declare.unit import Unit

UNIT = Unit.of(
    TURNING_SHIP,
    start={"speed": 3.0, "turn_radius": 20.0, "turn_start": 1.0, "ease_time": 3.0},
    terminals={
        "towpoint": {"velocity_surge": "velocity_surge", "velocity_sway": "velocity_sway"},
    },
)
