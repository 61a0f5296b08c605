"""Cradle and its line as one unit, motion of the upper end in, pull of the line out: the thesis's own SDOF model.

    M y'' + b |y'| y' + K (y - x) = 0  while taut,    M y'' + b |y'| y' = -W  while slack

Symbols, assumptions and docking as in `cradle` and `spring_line`, whose functions this module joins. Slack and taut
are located inside a step, unless ``freeze_branches`` leaves that to the master. The static tension is the cradle's
weight in water. This split is the one for a stiff line: no interface loop runs through the fast mode sqrt(K/M).

Source: MIT thesis 1969, the equation of motion of section II, and example 2 (slack).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..numeric.ops import Ops, Value
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
    """Heave of the upper end, m, and velocity of the submersible at docking, m/s, both positive up."""

    heave_top: Value
    submersible_velocity: Value


class Outputs(NamedTuple):
    """Those of both parts."""

    heave: Value
    velocity: Value
    tension: Value
    reaction: Value
    margin_taut: Value
    margin_breaking: Value
    margin_propagation: Value
    margin_drag_reynolds: Value
    heave_rate: Value
    tension_rate: Value
    reaction_rate: Value
    event_taut: Value
    event_taut_rate: Value
    taut: Value
    docked: Value
    next_event_time: Value


class Calculated(NamedTuple):
    """K, N/m; M and b before docking, kg and kg/m; sqrt(K/M), rad/s."""

    port_stiffness: Value
    virtual_mass: Value
    drag_factor: Value
    natural_frequency: Value


def _line(y: Value, u: Inputs, taut: Value, p: Parameters, ops: Ops) -> tuple[Value, Value]:
    """(tension, N; stretch, m)."""
    k = spring_line.stiffness(p, ops)
    e = spring_line.stretch(u[0], y, p.weight_in_water, k)
    return spring_line.pull(e, taut, k, 1.0, ops), e


def requirements(p: Parameters, ops: Ops) -> tuple[tuple[Value, str], ...]:
    """Those of both parts."""
    return spring_line.requirements(p, ops) + cradle.requirements(p, ops)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """As given by the start parameters, taut."""
    return State(p.heave_start, p.velocity_start), Modes(1.0, 0.0)


def derivatives(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> State:
    """x', m/s and m/s2, on the branch in force."""
    tension, _ = _line(x[0], u, m[0], p, ops)
    return State(x[1], cradle.acceleration(x[1], m[1], tension, p, ops))


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables."""
    y, v = x
    k = spring_line.stiffness(p, ops)
    tension, e = _line(y, u, m[0], p, ops)
    tension = ops.where(p.freeze_branches > 0.5, tension, ops.maximum(tension, 0.0))
    e_rate = du[0] - v
    rate = m[0] * k * e_rate
    taut, breaking, propagation = spring_line.margins(tension, rate, e, k, p.weight_in_water, p, ops)
    return Outputs(
        y, v, tension, tension - p.weight_in_water, taut, breaking, propagation,
        cradle.margin_drag_reynolds(v, m[1], p, ops), v, rate, rate, e, e_rate, m[0], m[1],
        next_event_time(t, m, p, ops),
    )  # fmt: skip


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[Value, ...]:
    """Drag reversal and, unless frozen, the stretch of the line."""
    _, e = _line(x[0], u, m[0], p, ops)
    return x[1], ops.where(p.freeze_branches > 0.5, 1.0, e)


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Branch of the line, and docking when due."""
    _, e = _line(x[0], u, m[0], p, ops)
    velocity, docked = cradle.capture(t, x[1], m[1], u[1], p, ops)
    return State(x[0], velocity), Modes(ops.where(e > 0.0, 1.0, 0.0), docked)


def next_event_time(t: Value, m: Modes, p: Parameters, ops: Ops) -> Value:
    """The docking time while it lies ahead, s."""
    return cradle.next_event_time(t, cradle.Modes(m[1]), p, ops)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Constants of the unit."""
    k = spring_line.stiffness(p, ops)
    mass, b = cradle.calculated(p, ops)
    return Calculated(k, mass, b, ops.sqrt(k / mass))
