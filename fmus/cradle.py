"""Unit `cradle`: suspended body, line tension in, heave out, with docking."""

from ..models.heave.cradle import CRADLE
from .declare.unit import Unit

UNIT = Unit.of(
    CRADLE,
    start={"mass": 5000.0, "drag_area": 10.0, "weight_in_water": 2e4, "docking_time": 3.0, "submersible_mass": 8000.0},
    inputs={"line_tension": (1.0e4, 0.9)},
    terminals={
        "line": {"force": "line_tension", "displacement": "heave"},
    },
)
