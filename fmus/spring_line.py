"""Unit `spring_line`: elastic line, both ends' heave in, tension out."""

from ..models.heave.spring_line import SPRING_LINE
from .declare.unit import Unit

UNIT = Unit.of(
    SPRING_LINE,
    start={"stiffness": 1.0e4, "static_tension": 2.0e4, "length": 30.0, "breaking_load": 2e5, "wave_speed": 900.0},
    inputs={"heave_top": (1.0, 1.0), "heave_bottom": (2.5, 0.8)},
    terminals={
        "top": {"force": "reaction", "displacement": "heave_top"},
        "bottom": {"force": "tension", "displacement": "heave_bottom"},
    },
)
