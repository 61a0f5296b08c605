"""Unit `voyage`: a computed route as a table; position, course and sea along it out."""

from ..models.route.voyage import VOYAGE
from .declare.unit import Unit

UNIT = Unit.of(
    VOYAGE,
    start={"duration": 10.0, "wave_height_12": 4.0, "speed_12": 4.0},
    terminals={
        "sea": {
            "wave_height": "wave_height",
            "wave_period": "wave_period",
            "wave_direction": "wave_direction",
            "speed": "speed",
        },
    },
)
