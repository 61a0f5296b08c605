"""Unit `tow_cable`: elastic tow cable alone, velocities of both ends in, forces on both ends out (linear)."""

from ..models.cable.units import tow_cable
from .declare.unit import Unit, calculated, entry, output
from .tow_system import CHOICE, CHOSEN, TOW, linear_margins, reactions, remembered

INPUTS = tuple(
    entry(f"{end}_velocity_{axis}", "m/s", 0.0, f"Velocity of the {end} end in the towing frame, {way}", display="ft/s")
    for end in ("top", "body") for axis, way in (("surge", "forward"), ("heave", "up"))
)  # fmt: skip
NAMES = tuple(v.name for v in INPUTS)

UNIT = Unit(
    name="tow_cable",
    description="Elastic tow cable between two units, small perturbations from the steady tow",
    model=tow_cable,
    parameters=(*TOW, *CHOICE),
    calculated=(
        calculated("port_stiffness", "N/m", "Largest force on the body at once per displacement of it", "tunable"),
        *CHOSEN,
    ),
    inputs=INPUTS,
    outputs=(
        *reactions(NAMES, True),
        output("body_force_surge", "N", "Change of the pull on the body, forward", display="lbf", depends=NAMES, rate=True),
        output("body_force_heave", "N", "Change of the pull on the body, up", display="lbf", depends=NAMES, rate=True),
        output("offset_surge", "m", "Displacement of the body relative to the towpoint, forward", display="ft"),
        output("offset_heave", "m", "Displacement of the body relative to the towpoint, up", display="ft"),
        *linear_margins(NAMES),
    ),
    states=remembered(INPUTS),
    start={"axial_stiffness": 4e6, "segments": 10.0, "tolerance": 0.2},
    reference_inputs={"top_velocity_heave": (0.4, 1.2), "body_velocity_heave": (0.3, 1.2)},
)  # fmt: skip
