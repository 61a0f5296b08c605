"""Cradle and its line as one unit, motion of the upper end in, pull of the line out: the thesis's own SDOF model.

    M y'' + b |y'| y' + K (y - x) = 0  while taut,    M y'' + b |y'| y' = -W  while slack

Symbols, assumptions and docking as in `cradle` and `spring_line`, whose functions this module joins. Slack and taut
are located inside a step, unless ``freeze_branches`` leaves that to the master. The static tension is the cradle's
weight in water. This split is the one for a stiff line: no interface loop runs through the fast mode sqrt(K/M).

Source: MIT thesis 1969, the equation of motion of section II, and example 2 (slack).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import Ops, Value
from ..protocol.model import Model, Requirement
from ..protocol.variables import NextEvent, Rate, calculated_parameter, input_variable
from . import cradle, spring_line


@dataclass(frozen=True)
class Parameters(cradle.Parameters, spring_line.Elasticity):
    """Those of both parts; the static tension is the cradle's weight in water."""


class State(NamedTuple):
    """Heave of the cradle, m, and its rate, m/s."""

    heave: Value
    velocity: Value


class Modes(NamedTuple):
    """Branch of the line, and whether the submersible is aboard."""

    taut: Value
    docked: Value


class Inputs(NamedTuple):
    """From the ship, without which the line hangs from a fixed point, and from the submersible at docking."""

    heave_top: Annotated[Value, input_variable("m", "Heave of the upper end, positive up", display="ft", needed=True)]
    submersible_velocity: cradle.SubmersibleVelocity


class Outputs(NamedTuple):
    """Those of both parts."""

    heave: cradle.Heave
    velocity: cradle.Velocity
    tension: spring_line.Tension
    reaction: spring_line.Reaction
    margin_taut: spring_line.MarginTaut
    margin_breaking: spring_line.MarginBreaking
    margin_drag_reynolds: cradle.MarginDragReynolds
    heave_rate: Rate
    tension_rate: Rate
    reaction_rate: Rate
    event_taut: spring_line.EventTaut
    event_taut_rate: Rate
    taut: spring_line.Taut
    docked: cradle.Docked
    next_event_time: NextEvent


class Calculated(NamedTuple):
    """K; M and b before docking; sqrt(K/M); m L."""

    port_stiffness: Annotated[Value, calculated_parameter("N/m", "Stiffness seen at the upper end", tunable=True)]
    virtual_mass: Annotated[Value, calculated_parameter("kg", "Virtual mass before docking", tunable=True)]
    drag_factor: Annotated[
        Value, calculated_parameter("kg/m", "Drag per squared velocity before docking", tunable=True)
    ]
    natural_frequency: Annotated[Value, calculated_parameter("rad/s", "sqrt(K/M) before docking", tunable=True)]
    wire_mass: spring_line.WireMass


def _line(y: Value, u: Inputs, taut: Value, p: Parameters, ops: Ops) -> tuple[Value, Value]:
    """(tension, N; stretch, m)."""
    k = spring_line.stiffness(p, ops)
    e = spring_line.stretch(u.heave_top, y, p.weight_in_water, k)
    return spring_line.pull(e, taut, k, 1.0, ops), e


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """Those of both parts."""
    bears = spring_line.bears(p.weight_in_water, p, "weight_in_water", ops)
    return spring_line.stiff(p, ops), *spring_line.wire(p, ops), bears, *cradle.requirements(p, ops)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """As given by the start parameters, taut."""
    return State(p.heave_start, p.velocity_start), Modes(1.0, 0.0)


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x', m/s and m/s2, on the branch in force."""
    tension, _ = _line(x.heave, u, m.taut, p, ops)
    return State(x.velocity, cradle.acceleration(x.velocity, m.docked, tension, p, ops))


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    y, v = x
    k = spring_line.stiffness(p, ops)
    tension, e = _line(y, u, m.taut, p, ops)
    smooth = ops.maximum(p.freeze_branches, p.never_slack)
    tension = ops.where(smooth > 0.5, tension, ops.maximum(tension, 0.0))
    e_rate = du.heave_top - v
    rate = m.taut * k * e_rate
    taut, breaking = spring_line.margins(tension, e, k, p.weight_in_water, p, ops)
    return Outputs(
        y, v, tension, tension - p.weight_in_water, taut, breaking,
        cradle.margin_drag_reynolds(v, m.docked, p, ops), v, rate, rate, spring_line.room(e, p, ops),
        ops.where(p.never_slack > 0.5, 0.0, e_rate), m.taut, m.docked, next_event_time(t, m, p, ops),
    )  # fmt: skip


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[Value, ...]:
    """Drag reversal and, unless frozen, the stretch of the line."""
    _, e = _line(x.heave, u, m.taut, p, ops)
    return x.velocity, ops.where(p.freeze_branches > 0.5, 1.0, spring_line.room(e, p, ops))


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Branch of the line, and docking when due."""
    _, e = _line(x.heave, u, m.taut, p, ops)
    velocity, docked = cradle.capture(t, x.velocity, m.docked, u.submersible_velocity, p, ops)
    return State(x.heave, velocity), Modes(ops.where(spring_line.room(e, p, ops) > 0.0, 1.0, 0.0), docked)


def next_event_time(t: Value, m: Modes, p: Parameters, ops: Ops) -> Value:
    """The docking time while it lies ahead, s."""
    return cradle.next_event_time(t, cradle.Modes(m.docked), p, ops)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Constants of the unit."""
    k = spring_line.stiffness(p, ops)
    mass, b = cradle.calculated(p, ops)
    return Calculated(k, mass, b, ops.sqrt(k / mass), spring_line.wire_mass(p, ops))


CRADLE_ON_LINE = Model(
    "cradle_on_line",
    "Docking cradle and its elastic line in one: motion of the upper end in, pull of the line out",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, derivatives=derivatives, outputs=outputs, indicators=indicators, transition=transition,
    next_event_time=next_event_time, calculated=calculated, requirements=requirements,
)  # fmt: skip
