"""Unit `tow_cable_nonlinear`: tow cable and towed body without linearisation; ports as `tow_system`."""

from ..models.cable.units import tow_nonlinear
from .declare.unit import Unit, calculated, margin, output, parameter
from .tow_system import BODY, CHOSEN, NAMES, TOW, VELOCITY, body_velocity, reactions

UNIT = Unit(
    name="tow_cable_nonlinear",
    description="Tow cable and towed body, elastic lumped masses, large motions and slack",
    model=tow_nonlinear,
    parameters=(
        *TOW,
        parameter("segments", "1", 20.0, "Number of segments", min=1.0, max=400.0),
        parameter("internal_step", "s", 0.05, "Largest implicit step", min=1e-6),
    ),
    calculated=(calculated("port_mass", "kg", "Mass of half the last segment, in heave", "tunable"), *CHOSEN[:2]),
    inputs=VELOCITY,
    outputs=(
        *reactions(NAMES[:2], False),
        output("tension_least", "N", "Least tension of the segments", display="lbf"),
        *BODY,
        *body_velocity((), False),
        margin("slack", "least tension over steady tension of a segment, at most 1"),
        margin("quadrant", "least angle to the stream's direction over its steady value, at most 1"),
    ),
    start={"axial_stiffness": 4e6, "segments": 6.0},
    reference_inputs={"velocity_heave": (1.0, 1.2), "velocity_surge": (0.5, 0.7)},
    not_native="its implicit steps are divided and iterated as the numbers demand, which a trace cannot follow",
)
