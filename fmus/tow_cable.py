"""Unit `tow_cable`: elastic tow cable alone, velocities of both ends in, forces on both ends out (linear)."""

from ..models.cable.units.tow_cable import TOW_CABLE
from .declare.unit import Unit

UNIT = Unit.of(
    TOW_CABLE,
    start={"axial_stiffness": 4e6, "segments": 10.0, "tolerance": 0.2},
    inputs={"top_velocity_heave": (0.4, 1.2), "body_velocity_heave": (0.3, 1.2)},
    terminals={
        "top": {
            "force_surge": "reaction_surge",
            "force_heave": "reaction_heave",
            "velocity_surge": "top_velocity_surge",
            "velocity_heave": "top_velocity_heave",
        },
        "body": {
            "force_surge": "body_force_surge",
            "force_heave": "body_force_heave",
            "velocity_surge": "body_velocity_surge",
            "velocity_heave": "body_velocity_heave",
        },
    },
)
