"""What the towing units show in common: inputs at the towpoint, forces, motions and margins."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from ...numeric.ops import Value
from ...protocol.variables import (
    EVERY_INPUT,
    Quantity,
    calculated_parameter,
    input_variable,
    margin,
    output,
    per_second,
    state,
)


class TowpointInputs(NamedTuple):
    """Velocity of the towpoint, whose heave may be none (in a submarine) or was forgotten, and forces on the body."""

    velocity_surge: Annotated[
        Value,
        input_variable(
            "m/s", "Velocity of the towpoint in the towing frame, forward", display="ft/s",
            unset="the towpoint does not surge",
        ),
    ]  # fmt: skip
    velocity_heave: Annotated[Value, input_variable("m/s", "Velocity of the towpoint, up", display="ft/s")]
    body_drag_change: Annotated[
        Value, input_variable("N", "Change of the body's drag, aft", display="lbf", unset="no force but the tow's own")
    ]
    body_lift_change: Annotated[
        Value, input_variable("N", "Change of the body's lift, up", display="lbf", unset="no force but the tow's own")
    ]


# A reduced model answers through every row of its D: `also` says so of what is a force or follows from one.
REACTION_SURGE = output(
    "N", "Excess of the cable's pull over its steady value, aft on the towpoint", display="lbf", also=EVERY_INPUT
)
REACTION_HEAVE = output(
    "N", "Excess of the cable's pull over its steady value, down on the towpoint", display="lbf", also=EVERY_INPUT
)
TENSION_TOP = output("N", "Tension at the towpoint", display="lbf", also=EVERY_INPUT)
TENSION_BODY = output("N", "Tension at the body", display="lbf", also=EVERY_INPUT)
BODY_VELOCITY_SURGE = output(
    "m/s", "Velocity of the body in the towing frame, forward", display="ft/s", also=EVERY_INPUT
)
BODY_VELOCITY_HEAVE = output("m/s", "Velocity of the body, up", display="ft/s", also=EVERY_INPUT)

BODY_SURGE = output("m", "Displacement of the body from the steady tow, forward", display="ft")
BODY_HEAVE = output("m", "Displacement of the body from the steady tow, up", display="ft")
BodySurge = Annotated[Value, BODY_SURGE]
BodyHeave = Annotated[Value, BODY_HEAVE]
MarginSmallPerturbation = Annotated[
    Value, margin("a rough sign, no bound: 1 - v / (perturbation_limit c), v the speed of the towpoint", also=EVERY_INPUT)
]
MarginSlack = Annotated[Value, margin("1 - max |T1| / T0 over the segments", also=EVERY_INPUT)]
MarginQuadrant = Annotated[
    Value, margin("1 - share of the way to the stream's direction that a segment has turned", also=EVERY_INPUT)
]
MarginResolution = Annotated[Value, margin("1 - model_error / tolerance")]

SteadyTensionTop = Annotated[
    Value, calculated_parameter("N", "Steady tension at the towpoint", display="lbf", tunable=True)
]
SteadyTensionBody = Annotated[
    Value, calculated_parameter("N", "Steady tension at the body", display="lbf", tunable=True)
]
States = Annotated[Value, calculated_parameter("1", "Number of states of the model")]
SegmentsUsed = Annotated[Value, calculated_parameter("1", "Number of segments behind it")]
ModelError = Annotated[
    Value,
    calculated_parameter(
        "1", "Relative error of the gains up to band, of segments and reduction together", tunable=True
    ),
]


def second_derivative(of: str, unit: str) -> Quantity:
    """The own state that remembers u'' of the input ``of``, in ``unit``."""
    return state(per_second(unit, 2), f"Second derivative of {of} over the last step")
