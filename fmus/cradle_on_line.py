"""Unit `cradle_on_line`: the thesis's SDOF model, heave of the upper end in, pull out."""

from ..models.heave.cradle_on_line import CRADLE_ON_LINE
from .declare.unit import Unit

UNIT = Unit.of(
    CRADLE_ON_LINE,
    start={"stiffness": 1.0e4, "mass": 5000.0, "drag_area": 10.0, "weight_in_water": 2e4, "wave_speed": 900.0},
    inputs={"heave_top": (1.5, 1.3)},
    terminals={
        "top": {"force": "reaction", "displacement": "heave_top"},
    },
)
