"""Unit `cradle_on_line`: the thesis's SDOF model, heave of the upper end in, pull out."""

from ..models.heave import cradle_on_line
from .cradle import BODY, DOCKING, MOTION, REYNOLDS, SUBMERSIBLE
from .declare.unit import Unit, calculated, entry, output
from .spring_line import BRANCH, ELASTICITY, margins

TOP = ("heave_top",)

UNIT = Unit(
    name="cradle_on_line",
    description="Docking cradle and its elastic line in one: motion of the upper end in, pull of the line out",
    model=cradle_on_line,
    parameters=ELASTICITY + BODY,
    calculated=(
        calculated("port_stiffness", "N/m", "Stiffness seen at the upper end", "tunable"),
        calculated("virtual_mass", "kg", "Virtual mass before docking", "tunable"),
        calculated("drag_factor", "kg/m", "Drag per squared velocity before docking", "tunable"),
        calculated("natural_frequency", "rad/s", "sqrt(K/M) before docking", "tunable"),
    ),
    inputs=(entry("heave_top", "m", 0.0, "Heave of the upper end, positive up", display="ft"), SUBMERSIBLE),
    outputs=(
        *MOTION,
        output("tension", "N", "Tension, never negative", display="lbf", depends=TOP, rate=True),
        output("reaction", "N", "Excess of the pull over its static value, down on the upper end", display="lbf",
               depends=TOP, rate=True),
        *margins(TOP, DOCKING),
        *BRANCH,
        REYNOLDS,
    ),
    start={"stiffness": 1.0e4, "mass": 5000.0, "drag_area": 10.0, "weight_in_water": 2e4},
    reference_inputs={"heave_top": (1.5, 1.3)},
)  # fmt: skip
