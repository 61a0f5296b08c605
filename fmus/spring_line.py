"""Unit `spring_line`: elastic line, both ends' heave in, tension out."""

from ..models.heave import spring_line
from .declare.unit import FREEZE_BRANCHES, Unit, Variable, calculated, entry, local, margin, output, parameter, tunable

ELASTICITY = (
    tunable("stiffness", "N/m", 0.0, "Stiffness K; 0: axial_stiffness / length", display="lbf/ft", min=0.0),
    tunable("axial_stiffness", "N", 1e6, "Axial stiffness EA", display="lbf", min=0.0),
    parameter("length", "m", 30.0, "Length at rest", display="ft", min=0.0),
    parameter("breaking_load", "N", 0.0, "Breaking load; 0: not known", display="lbf", min=0.0),
    parameter("wave_speed", "m/s", 0.0, "Speed of longitudinal waves along the line; 0: not known", display="ft/s",
              min=0.0),
    FREEZE_BRANCHES,
)  # fmt: skip


def margins(depends: tuple[str, ...], rate_depends: tuple[str, ...] = ()) -> tuple[Variable, ...]:
    """Margins of a line; ``depends`` names the inputs that move its ends, ``rate_depends`` those that change only the
    speed of an end."""
    return (
        margin("taut", "min(1, K e / W), e the stretch and W the static tension; the line is slack below 0", depends),
        margin("breaking", "1 - (T - W)/(T_break - W)", depends),
        margin("propagation", "1 - (L/c) |dT/dt| / (0.4 W), L/c the travel time of a wave along the line",
               depends + rate_depends),
    )  # fmt: skip


BRANCH = (
    local("event_taut", "m", "Stretch beyond the unstretched length; the line is taut where it is positive"),
    local("event_taut_rate", "m/s", "Time derivative of event_taut"),
    local("taut", "1", "Branch in force: 1 taut, 0 slack", "discrete"),
)
ENDS = ("heave_top", "heave_bottom")

UNIT = Unit(
    name="spring_line",
    description="Elastic line between a ship and a suspended body, with slack",
    model=spring_line,
    parameters=(
        *ELASTICITY,
        tunable("static_tension", "N", 0.0, "Tension at rest: the weight in water carried", display="lbf", min=0.0),
    ),
    calculated=(
        calculated("port_stiffness", "N/m", "Stiffness seen at both ends", "tunable"),
        calculated("unstretched_length", "m", "Length before the static tension stretched the line", "tunable"),
    ),
    inputs=(
        entry("heave_top", "m", 0.0, "Heave of the upper end, positive up", display="ft"),
        entry("heave_bottom", "m", 0.0, "Heave of the lower end, positive up", display="ft"),
    ),
    outputs=(
        output("tension", "N", "Tension, never negative", display="lbf", depends=ENDS, rate=True),
        output("reaction", "N", "Excess of the pull over its static value, down on the upper end", display="lbf",
               depends=ENDS, rate=True),
        output("stretch", "m", "Stretch beyond the unstretched length", display="ft", depends=ENDS),
        *margins(ENDS),
        *BRANCH,
    ),
    start={"stiffness": 1.0e4, "static_tension": 2.0e4, "length": 30.0, "breaking_load": 2e5, "wave_speed": 900.0},
    reference_inputs={"heave_top": (1.0, 1.0), "heave_bottom": (2.5, 0.8)},
)  # fmt: skip
