"""Elastic line between a ship and a suspended body: a massless linear spring that cannot push.

    T = max(0, K e),    e = W/K + x - y

| symbol | meaning | unit |
|---|---|---|
| T | tension, positive in tension | N |
| K | stiffness, ``stiffness`` or EA/L | N/m |
| e | stretch beyond the unstretched length; the line is taut where e > 0 | m |
| W | static tension: the weight in water it carries at rest | N |
| x, y | heave of the upper and the lower end from the static equilibrium, positive up | m |

Assumptions: (1) stretch proportional to load; (2) no mass, no drag of its own; (3) the travel time L/c of a wave along
it is short against the motion (`margin_propagation`); (4) no memory: taut again without impact.

Source: MIT thesis 1969, section II "spring force" (K = EA/L, parallel, series) and example 2 (slack: relaxed when
y - x exceeds W/K). The quasi-static line is the thesis's own argument: 100 ft at 3000 ft/s against periods of seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .ops import NEGLIGIBLE, Ops, Value

PROPAGATION_LIMIT = 0.4
"""Largest omega L/c for which (omega L/c)^2/3, the first term that kL cot kL neglects, stays near 5 %."""


@dataclass(frozen=True)
class Elasticity:
    """SI. ``stiffness`` = 0: use ``axial_stiffness``/``length``; ``breaking_load`` or ``wave_speed`` = 0: not known."""

    stiffness: Value
    axial_stiffness: Value
    length: Value
    breaking_load: Value
    wave_speed: Value
    freeze_branches: Value


@dataclass(frozen=True)
class Parameters(Elasticity):
    """With the static tension W, N."""

    static_tension: Value


class State(NamedTuple):
    """A spring has no continuous state."""


class Modes(NamedTuple):
    """``taut``: 1 or 0, the branch in force."""

    taut: Value


class Inputs(NamedTuple):
    """Heave of both ends, m, positive up, zero at the static equilibrium."""

    heave_top: Value
    heave_bottom: Value


class Outputs(NamedTuple):
    """``reaction`` is the excess pull on whatever holds the upper end, ``tension`` - W, N."""

    tension: Value
    reaction: Value
    stretch: Value
    margin_taut: Value
    margin_breaking: Value
    margin_propagation: Value
    tension_rate: Value
    reaction_rate: Value
    event_taut: Value
    event_taut_rate: Value
    taut: Value


class Calculated(NamedTuple):
    """``port_stiffness``: K, N/m. ``unstretched_length``: ``length`` less the static stretch, m."""

    port_stiffness: Value
    unstretched_length: Value


def parallel(*stiffness: float) -> float:
    """Stiffness of elements side by side, N/m: the sum (thesis, section II)."""
    return sum(stiffness)


def series(*stiffness: float) -> float:
    """Stiffness of elements end to end, N/m: 1/K is the sum of 1/K_i (thesis, section II); none if one has none."""
    return 1.0 / sum(1.0 / k for k in stiffness) if all(k > 0.0 for k in stiffness) else 0.0


def stiffness(p: Elasticity, ops: Ops) -> Value:
    """K, N/m: as given, else EA/L."""
    length = ops.where(p.length > NEGLIGIBLE, p.length, 1.0)
    return ops.where(p.stiffness > NEGLIGIBLE, p.stiffness, p.axial_stiffness / length)


def stretch(heave_top: Value, heave_bottom: Value, static_tension: Value, k: Value) -> Value:
    """e = W/K + x - y, m; negative where the line is slack."""
    return static_tension / k + heave_top - heave_bottom


def pull(e: Value, taut: Value, k: Value, freeze_branches: Value, ops: Ops) -> Value:
    """Tension at stretch ``e``, N. With frozen branches the spring of a taut branch extends smoothly below zero,
    so that a master can find the zero of ``e``; otherwise the line never pushes."""
    return k * ops.where(freeze_branches > 0.5, taut * e, ops.maximum(e, 0.0))


def margins(
    tension: Value, tension_rate: Value, e: Value, k: Value, weight: Value, p: Elasticity, ops: Ops
) -> tuple[Value, Value, Value]:
    """(taut, breaking, propagation). W is the static tension.

    taut = min(1, K e/W): 0 at slack, negative beyond. breaking = 1 - (T - W)/(T_break - W), 1 where no breaking load is
    given. propagation = 1 - (L/c)|T'|/(0.4 W): the share of W by which the tension changes while a wave runs along the
    line, against its limit; for T = W + W sin(omega t) that is omega L/c < 0.4.
    """
    scale = ops.where(weight > NEGLIGIBLE, weight, 1.0)
    taut = ops.minimum(1.0, ops.where(weight > NEGLIGIBLE, k * e / scale, ops.where(e < 0.0, -1.0, 1.0)))
    reserve = ops.maximum(p.breaking_load - weight, 1e-9 * scale)
    breaking = ops.where(p.breaking_load > 0.0, 1.0 - ops.maximum(tension - weight, 0.0) / reserve, 1.0)
    known = p.wave_speed > NEGLIGIBLE
    travel_time = ops.where(known, p.length / ops.where(known, p.wave_speed, 1.0), 0.0)
    return taut, breaking, 1.0 - travel_time * ops.abs(tension_rate) / (PROPAGATION_LIMIT * scale)


def requirements(p: Elasticity, ops: Ops) -> tuple[tuple[Value, str], ...]:
    """A line needs its stiffness in one of two ways."""
    given = ops.maximum(p.stiffness, ops.minimum(p.axial_stiffness, p.length)) - NEGLIGIBLE
    text = "stiffness is 0 and so is axial_stiffness / length: give stiffness, or axial_stiffness and length"
    return ((given, text),)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Taut, at the static equilibrium."""
    return State(), Modes(1.0)


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables; ``du`` are the rates of both ends, m/s."""
    k = stiffness(p, ops)
    e = stretch(u[0], u[1], p.static_tension, k)
    e_rate = du[0] - du[1]
    branch = ops.where(p.freeze_branches > 0.5, m[0], ops.where(e > 0.0, 1.0, 0.0))
    tension = pull(e, branch, k, p.freeze_branches, ops)
    rate = branch * k * e_rate
    taut, breaking, propagation = margins(tension, rate, e, k, p.static_tension, p, ops)
    return Outputs(
        tension, tension - p.static_tension, e, taut, breaking, propagation, rate, rate, e, e_rate, branch
    )  # fmt: skip


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """The branch at a communication point: taut where the stretch is positive."""
    e = stretch(u[0], u[1], p.static_tension, stiffness(p, ops))
    return x, Modes(ops.where(e > 0.0, 1.0, 0.0))


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Stiffness seen at both ends, and the length before W stretched it (``length`` is measured at rest)."""
    k = stiffness(p, ops)
    return Calculated(k, p.length - p.static_tension / k)
