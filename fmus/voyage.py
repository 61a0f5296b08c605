"""Unit `voyage`: a computed route as a table; position, course and sea along it out."""

from ..models.route import voyage
from .declare.unit import Unit, margin, output, parameter

COLUMNS = {
    "x": ("m", "nmi", "Position on the route's plane, x"),
    "y": ("m", "nmi", "Position on the route's plane, y"),
    "heading": ("rad", "deg", "Heading, clockwise from north"),
    "speed": ("m/s", "kn", "Speed of the ship"),
    "wave_height": ("m", "ft", "Significant wave height"),
    "wave_period": ("s", None, "Peak period; 0: that of a Pierson-Moskowitz sea of this height"),
    "wave_direction": ("rad", "deg", "Angle between the course and the waves' travel; pi head sea"),
}
EXAMPLE = {"speed": 5.0, "wave_height": 3.0, "wave_direction": 3.141592653589793}

UNIT = Unit(
    name="voyage",
    description="Voyage along a computed route: position, heading, speed and the sea met, from a table",
    model=voyage,
    parameters=(
        parameter("duration", "s", 3600.0, "Duration of the voyage", display="h", min=1e-3),
        parameter("pace", "1", 1.0, "Seconds of the voyage that pass in a second", min=0.0),
        parameter("horizon", "s", 0.0, "Time of the last forecast; 0: none", display="h", min=0.0),
        *(
            parameter(f"{column}_{k}", unit, EXAMPLE.get(column, 0.0),
                      f"{text}, at {k}/{voyage.POINTS - 1} of the duration", display=display)
            for column, (unit, display, text) in COLUMNS.items()
            for k in range(voyage.POINTS)
        ),
    ),
    inputs=(),
    outputs=(
        *(output(column, unit, text, display=display, rate=True) for column, (unit, display, text) in COLUMNS.items()),
        output("progress", "1", "Share of the voyage done"),
        margin("forecast", "1 - voyage time / horizon; 1 without a horizon"),
    ),
    start={"duration": 10.0, "wave_height_12": 4.0, "speed_12": 4.0},
    reference_inputs={},
)  # fmt: skip
