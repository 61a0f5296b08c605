"""Unit `wire`: the nonlinear wire, from hanging at rest to towing in a turn."""

from ..models.cable.units.wire import WIRE
from .declare.unit import Unit

UNIT = Unit.of(
    WIRE,
    start={"in_space": 1.0, "elements": 2.0, "degree": 4.0, "velocity_tolerance": 0.01},
    inputs={"velocity_heave": (1.0, 1.2), "velocity_surge": (0.5, 0.7)},
    terminals={
        "top": {
            "force_surge": "reaction_surge",
            "force_sway": "reaction_sway",
            "force_heave": "reaction_heave",
            "velocity_surge": "velocity_surge",
            "velocity_sway": "velocity_sway",
            "velocity_heave": "velocity_heave",
        },
        "body": {
            "force_surge": "lower_force_surge",
            "force_sway": "lower_force_sway",
            "force_heave": "lower_force_heave",
            "velocity_surge": "lower_velocity_surge",
            "velocity_sway": "lower_velocity_sway",
            "velocity_heave": "lower_velocity_heave",
        },
    },
)
