"""Unit `tow_system`: tow cable and towed body, towpoint velocity in, force and body motion out (linear)."""

from ..models.cable.units.tow_system import TOW_SYSTEM
from .declare.unit import Unit

UNIT = Unit.of(
    TOW_SYSTEM,
    start={"segments": 10.0, "tolerance": 0.2},
    inputs={"velocity_heave": (0.4, 1.2), "velocity_surge": (0.2, 0.7)},
)
