"""How a ship in a sea looks at it: every ``update_interval`` an event at which the inputs are seen and held in modes.

Symbols and method: `ship_in_sea`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from ..heave import ship
from ..numeric.ops import NEVER, Ops, Value
from ..protocol.variables import input_variable
from . import waves
from .ship_parameters import Parameters
from .waves import GRAVITY

CALM = 0.1
"""Least height from which a period follows, m."""
TURN = 2.0 * math.pi
State = ship.State


class Modes(NamedTuple):
    """What was seen: whether there was a look yet; the time of the first look and the number of the last; the phase integrals
    P, C and D, rad, at the time ``anchor`` since which nothing changed but by one look; the sea that was left and the one
    that is approached."""

    begun: Value
    first_look: Value
    looks: Value
    anchor: Value
    peak_phase: Value
    doppler_cos: Value
    doppler_sin: Value
    old_height: Value
    old_frequency: Value
    old_direction: Value
    old_speed: Value
    new_height: Value
    new_frequency: Value
    new_direction: Value
    new_speed: Value


class Inputs(NamedTuple):
    """The line as in `ship`, and the sea, which only the scene can know: its start values may be meant, or forgotten."""

    reaction: ship.Reaction
    wave_height: Annotated[Value, input_variable("m", "Significant wave height", start=2.0, display="ft")]
    wave_period: Annotated[
        Value, input_variable("s", "Peak period; 0: that of a Pierson-Moskowitz sea of this height", unset="as for 0")
    ]
    wave_direction: Annotated[
        Value,
        input_variable(
            "rad", "Angle between the course and the waves' travel; pi head sea", start=math.pi, display="deg"
        ),
    ]
    speed: Annotated[Value, input_variable("m/s", "Speed of the ship", display="kn")]


def sea_of(u: Inputs, ops: Ops) -> tuple[Value, Value, Value, Value]:
    """Height, peak frequency, direction and speed that the inputs describe."""
    height = ops.maximum(u.wave_height, 0.0)
    given = u.wave_period > 0.0
    by_height = waves.steepest_frequency(ops.maximum(height, CALM), ops)
    frequency = ops.where(given, TURN / ops.where(given, u.wave_period, 1.0), by_height)
    return height, frequency, u.wave_direction, u.speed


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """At rest; the sea is looked at with the first inputs."""
    return State(0.0, 0.0), Modes(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def next_event_time(t: Value, m: Modes, p: Parameters, ops: Ops) -> Value:
    """The next look."""
    return ops.where(m.begun > 0.5, m.first_look + (m.looks + 1.0) * p.update_interval, NEVER)


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """A look that is due; at the start the sea is what the inputs say, however often they are set."""
    height, frequency, direction, speed = sea_of(u, ops)
    first = ops.where(m.begun > 0.5, ops.where(t > m.first_look, 0.0, 1.0), 1.0) > 0.5
    due = ops.where(m.begun > 0.5, ops.where(t >= next_event_time(t, m, p, ops), 1.0, 0.0), 0.0) > 0.5
    # nothing changed and nothing changes: the anchor stays, and no rounding is added
    resting = _differ(m, m.new_height, m.new_frequency, m.new_direction, m.new_speed, ops) < 0.5
    same = ops.where(resting, _differ(m, height, frequency, direction, speed, ops), 1.0) < 0.5
    look = m.first_look + (m.looks + 1.0) * p.update_interval
    left, half = look - m.anchor, 0.5 * p.update_interval
    c0, d0 = _doppler(m.old_frequency, m.old_direction, m.old_speed, ops)
    c1, d1 = _doppler(m.new_frequency, m.new_direction, m.new_speed, ops)

    def carried(total: Value, before: Value, after: Value) -> Value:
        return total + ops.where(resting, left * before, half * (before + after))

    def seen(held: Value, at_start: Value, moved: Value) -> Value:
        """After no look, the first one, one that finds something else."""
        return ops.where(first, at_start, ops.where(due, ops.where(same, held, moved), held))

    return x, Modes(
        1.0, ops.where(first, t, m.first_look), ops.where(first, 0.0, ops.where(due, m.looks + 1.0, m.looks)),
        seen(m.anchor, t, look),
        seen(m.peak_phase, 0.0, carried(m.peak_phase, m.old_frequency, m.new_frequency)),
        seen(m.doppler_cos, 0.0, carried(m.doppler_cos, c0, c1)),
        seen(m.doppler_sin, 0.0, carried(m.doppler_sin, d0, d1)),
        seen(m.old_height, height, m.new_height), seen(m.old_frequency, frequency, m.new_frequency),
        seen(m.old_direction, direction, m.new_direction), seen(m.old_speed, speed, m.new_speed),
        seen(m.new_height, height, height), seen(m.new_frequency, frequency, frequency),
        seen(m.new_direction, direction, direction), seen(m.new_speed, speed, speed),
    )  # fmt: skip


def _differ(m: Modes, height: Value, frequency: Value, direction: Value, speed: Value, ops: Ops) -> Value:
    """Whether this is another sea than the one that was left, 1 or 0."""
    off = ops.abs(height - m.old_height) + ops.abs(frequency - m.old_frequency)
    return ops.where(off + ops.abs(direction - m.old_direction) + ops.abs(speed - m.old_speed) > 0.0, 1.0, 0.0)


def _doppler(frequency: Value, direction: Value, speed: Value, ops: Ops) -> tuple[Value, Value]:
    """C' and D', rad/s."""
    scale = frequency * frequency * speed / GRAVITY
    return scale * ops.cos(direction), scale * ops.sin(direction)
