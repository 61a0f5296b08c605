"""Unit `tow_cable`: elastic tow cable alone, velocities of both ends in, forces on both ends out (linear)."""

from ..models.cable.units.tow_cable import TOW_CABLE
from .declare.unit import Unit

UNIT = Unit.of(
    TOW_CABLE,
    start={"axial_stiffness": 4e6, "segments": 10.0, "tolerance": 0.2},
    inputs={"top_velocity_heave": (0.4, 1.2), "body_velocity_heave": (0.3, 1.2)},
)
