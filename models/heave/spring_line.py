"""Elastic line between a ship and a suspended body: a massless linear spring that cannot push.

    T = max(0, K e),    e = W/K + x - y

| symbol | meaning | unit |
|---|---|---|
| T | tension, positive in tension | N |
| K | stiffness, ``stiffness`` or EA/L | N/m |
| e | stretch beyond the unstretched length; the line is taut where e > 0 | m |
| W | static tension: the weight in water it carries at rest | N |
| x, y | heave of the upper and the lower end from the static equilibrium, positive up | m |

With ``never_slack`` the line pushes too, T = K e: the spring of the linear theories.

Assumptions: (1) stretch proportional to load; (2) no mass, no drag of its own; (3) the travel time L/c of a wave along
it is short against the motion (`margin_propagation`); (4) no memory: taut again without impact.

Source: MIT thesis 1969, section II "spring force" (K = EA/L, parallel, series) and example 2 (slack: relaxed when
y - x exceeds W/K). The quasi-static line is the thesis's own argument: 100 ft at 3000 ft/s against periods of seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import NEGLIGIBLE, Ops, Value
from ..protocol.model import Model, Requirement
from ..protocol.variables import (
    FreezeBranches,
    Rate,
    calculated_parameter,
    input_variable,
    local,
    margin,
    output,
    parameter,
    tunable,
)

PROPAGATION_LIMIT = 0.4
"""Largest omega L/c for which (omega L/c)^2/3, the first term that kL cot kL neglects, stays near 5 %."""


@dataclass(frozen=True)
class Elasticity:
    """What makes the line a spring, SI."""

    stiffness: Annotated[Value, tunable("N/m", 0.0, "Stiffness K; 0: axial_stiffness / length", display="lbf/ft", min=0.0)]
    axial_stiffness: Annotated[Value, tunable("N", 1e6, "Axial stiffness EA", display="lbf", min=0.0)]
    length: Annotated[Value, parameter("m", 30.0, "Length at rest", display="ft", min=0.0)]
    breaking_load: Annotated[Value, parameter("N", 0.0, "Breaking load; 0: not known", display="lbf", min=0.0)]
    wave_speed: Annotated[
        Value,
        parameter("m/s", 0.0, "Speed of longitudinal waves along the line; 0: not known", display="ft/s", min=0.0),
    ]
    never_slack: Annotated[
        Value,
        parameter("1", 0.0, "1: the line pushes too, as in theories without slack; 0: it goes slack", min=0.0, max=1.0),
    ]
    freeze_branches: FreezeBranches


@dataclass(frozen=True)
class Parameters(Elasticity):
    """With the static tension."""

    static_tension: Annotated[
        Value, tunable("N", 0.0, "Tension at rest: the weight in water carried", display="lbf", min=0.0)
    ]


class State(NamedTuple):
    """A spring has no continuous state."""


class Modes(NamedTuple):
    """``taut``: 1 or 0, the branch in force."""

    taut: Value


class Inputs(NamedTuple):
    """Both ends, from the static equilibrium."""

    heave_top: Annotated[Value, input_variable("m", "Heave of the upper end, positive up", display="ft", needed=True)]
    heave_bottom: Annotated[
        Value, input_variable("m", "Heave of the lower end, positive up", display="ft", needed=True)
    ]


Tension = Annotated[Value, output("N", "Tension, negative only with never_slack", display="lbf")]
Reaction = Annotated[
    Value, output("N", "Excess of the pull over its static value, down on the upper end", display="lbf")
]
MarginTaut = Annotated[
    Value, margin("min(1, K e / W), e the stretch and W the static tension; the line is slack below 0")
]
MarginBreaking = Annotated[Value, margin("1 - (T - W)/(T_break - W)")]
MarginPropagation = Annotated[
    Value, margin("1 - (L/c) |dT/dt| / (0.4 W), L/c the travel time of a wave along the line")
]
EventTaut = Annotated[
    Value, local("m", "Stretch beyond the unstretched length, 1 if never slack; the line is taut where it is positive")
]
Taut = Annotated[Value, local("1", "Branch in force: 1 taut, 0 slack", discrete=True)]


class Outputs(NamedTuple):
    """Forces of the line, its branch and margins."""

    tension: Tension
    reaction: Reaction
    stretch: Annotated[Value, output("m", "Stretch beyond the unstretched length", display="ft")]
    margin_taut: MarginTaut
    margin_breaking: MarginBreaking
    margin_propagation: MarginPropagation
    tension_rate: Rate
    reaction_rate: Rate
    event_taut: EventTaut
    event_taut_rate: Rate
    taut: Taut


class Calculated(NamedTuple):
    """K, and ``length`` less the static stretch."""

    port_stiffness: Annotated[Value, calculated_parameter("N/m", "Stiffness seen at both ends", tunable=True)]
    unstretched_length: Annotated[
        Value, calculated_parameter("m", "Length before the static tension stretched the line", tunable=True)
    ]


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


def room(e: Value, p: Elasticity, ops: Ops) -> Value:
    """What must be positive for the line to be taut, m: the stretch, or 1 where it never goes slack."""
    return ops.where(p.never_slack > 0.5, 1.0, e)


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


def stiff(p: Elasticity, ops: Ops) -> Requirement:
    """A line needs its stiffness in one of two ways."""
    given = ops.maximum(p.stiffness, ops.minimum(p.axial_stiffness, p.length)) - NEGLIGIBLE
    text = "stiffness is 0 and so is axial_stiffness / length: give stiffness, or axial_stiffness and length"
    return given, text


def bears(static_tension: Value, breaking_load: Value, load: str, ops: Ops) -> Requirement:
    """A line that breaks above its static tension, N, if it is known to break; ``load`` is the parameter that gives it."""
    text = (
        f"{load}, which the line carries at rest, reaches breaking_load: take a stronger line, a lighter load, or 0 for a "
        "breaking_load that is not known"
    )
    return ops.where(breaking_load > 0.0, breaking_load - static_tension, 1.0), text


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """A stiffness, and a strength that bears what hangs on the line."""
    return stiff(p, ops), bears(p.static_tension, p.breaking_load, "static_tension", ops)


def initial(p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """Taut, at the static equilibrium."""
    return State(), Modes(1.0)


def outputs(t: Value, x: State, m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops) -> Outputs:
    """All observables; ``du`` are the rates of both ends, m/s."""
    k = stiffness(p, ops)
    e = stretch(u.heave_top, u.heave_bottom, p.static_tension, k)
    e_rate = du.heave_top - du.heave_bottom
    left = room(e, p, ops)
    branch = ops.where(p.freeze_branches > 0.5, m.taut, ops.where(left > 0.0, 1.0, 0.0))
    tension = pull(e, branch, k, ops.maximum(p.freeze_branches, p.never_slack), ops)
    rate = branch * k * e_rate
    taut, breaking, propagation = margins(tension, rate, e, k, p.static_tension, p, ops)
    return Outputs(
        tension, tension - p.static_tension, e, taut, breaking, propagation, rate, rate, left,
        ops.where(p.never_slack > 0.5, 0.0, e_rate), branch,
    )  # fmt: skip


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """The branch at a communication point: taut where the stretch is positive."""
    e = stretch(u.heave_top, u.heave_bottom, p.static_tension, stiffness(p, ops))
    return x, Modes(ops.where(room(e, p, ops) > 0.0, 1.0, 0.0))


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Stiffness seen at both ends, and the length before W stretched it (``length`` is measured at rest)."""
    k = stiffness(p, ops)
    return Calculated(k, p.length - p.static_tension / k)


SPRING_LINE = Model(
    "spring_line",
    "Elastic line between a ship and a suspended body, with slack",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, outputs=outputs, transition=transition, calculated=calculated, requirements=requirements,
)  # fmt: skip
