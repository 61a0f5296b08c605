"""A ship that turns: velocity of its towpoint in the frame that goes on as the ship did before, a prescribed motion.

    psi(t) = (U/R) (I(t - t0) - I(t - t0 - angle R/U)),   v = U (cos psi - 1, sin psi)

| symbol | meaning | unit |
|---|---|---|
| psi | heading, positive to port | rad |
| U, R | speed along the course, radius of the turn (negative: to starboard) | m/s, m |
| t0, angle | begin of the turn; what the ship turns by | s, rad |
| I | integral of the ramp s^3 (10 - 15 s + 6 s^2), s = t/``ease_time`` within [0, 1], by which turning sets in and dies out | s |
| v | velocity forward and to port in the frame of the old course | m/s |

Assumptions: (1) the speed along the course stays; (2) no drift, no heel.

Source: kinematics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import Ops, Value
from ..numeric.ramp import ramp, ramp_integral
from ..protocol.model import AnyModel, Model, Requirement
from ..protocol.variables import Rate, output, parameter


@dataclass(frozen=True)
class Parameters:
    """The course, SI."""

    speed: Annotated[Value, parameter("m/s", 3.0, "Speed along the course", display="kn", min=1e-3)]
    turn_radius: Annotated[Value, parameter("m", 300.0, "Radius of the turn, to port; to starboard: negative")]
    turn_angle: Annotated[Value, parameter("rad", 3.141592653589793, "What the ship turns by", display="deg", min=0.0)]
    turn_start: Annotated[Value, parameter("s", 10.0, "Begin of the turn", min=0.0)]
    ease_time: Annotated[Value, parameter("s", 10.0, "In which the rate of turning sets in and dies out", min=1e-3)]


class State(NamedTuple):
    """None: the motion follows from the time."""


class Modes(NamedTuple):
    """No branches."""


class Inputs(NamedTuple):
    """None."""


class Outputs(NamedTuple):
    """Heading, velocity, and their rates."""

    heading: Annotated[Value, output("rad", "Heading against the old course, to port", display="deg")]
    velocity_surge: Annotated[Value, output("m/s", "Velocity in the frame of the old course, forward")]
    velocity_sway: Annotated[Value, output("m/s", "Velocity in the frame of the old course, to port")]
    heading_rate: Rate
    velocity_surge_rate: Rate
    velocity_sway_rate: Rate


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """What the parameters must fulfil."""
    return (
        (ops.abs(p.turn_radius), "turn_radius: expected a radius, not 0"),
        (
            p.turn_angle * ops.abs(p.turn_radius) / p.speed - p.ease_time + 1e-9,
            "ease_time: expected at most the time of the turn, turn_angle turn_radius / speed",
        ),
    )


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """No states."""
    return State(), Modes()


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """The motion and its rates."""

    def eased(since: Value) -> tuple[Value, Value]:
        """(I, its rate) so long after a begin."""
        late = ops.maximum(0.0, since - p.ease_time)
        return ramp_integral(since, p.ease_time, ops) + late, ramp(since, p.ease_time, ops)[0]

    turning = p.speed / p.turn_radius
    (begun, begun_rate), (ended, ended_rate) = (
        eased(t - p.turn_start - after) for after in (0.0, p.turn_angle / ops.abs(turning))
    )
    heading, rate = turning * (begun - ended), turning * (begun_rate - ended_rate)
    cosine, sine = p.speed * ops.cos(heading), p.speed * ops.sin(heading)
    return Outputs(heading, cosine - p.speed, sine, rate, -sine * rate, cosine * rate)


TURNING_SHIP: AnyModel = Model(
    "turning_ship", "Ship that turns, prescribed: velocity of its towpoint in the frame of the old course",
    Parameters, State, Modes, Inputs, Outputs, initial=initial, outputs=outputs, requirements=requirements,
)  # fmt: skip
