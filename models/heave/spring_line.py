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

Assumptions: (1) stretch proportional to load; (2) no mass, no drag of its own, so that a wave runs along it in no time;
(3) no memory: taut again without impact. What (2) and (3) cost follows from the mass of the wire with the load and the
motion, which no line knows: the check `wire` of the master says it, after `elastic_bar`; it alone reads ``wire_damping``,
whose default is assumed. The line's own weight counts
against its breaking load only; it does not change the motion about the equilibrium.

Source: MIT thesis 1969, section II "spring force" (K = EA/L, parallel, series) and example 2 (slack: relaxed when
y - x exceeds W/K). The line without waves is the thesis's own argument: 100 ft at 3000 ft/s against periods of seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ..numeric.ops import NEGLIGIBLE, Ops, Value
from ..protocol.model import Model, Requirement
from ..protocol.physical import GRAVITY, ROUNDING, holds
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


@dataclass(frozen=True)
class Elasticity:
    """What makes the line a spring, SI."""

    stiffness: Annotated[Value, tunable("N/m", 0.0, "Stiffness K; 0: axial_stiffness / length", display="lbf/ft", min=0.0)]
    axial_stiffness: Annotated[Value, tunable("N", 1e6, "Axial stiffness EA", display="lbf", min=0.0)]
    length: Annotated[Value, parameter("m", 30.0, "Length at rest", display="ft", min=0.0)]
    breaking_load: Annotated[Value, parameter("N", 0.0, "Breaking load; 0: not known", display="lbf", min=0.0)]
    mass_per_length: Annotated[
        Value, parameter("kg/m", 0.0, "Mass per length of the line; 0: from wave_speed", display="lb/ft", min=0.0)
    ]
    weight_per_length: Annotated[
        Value,
        parameter("N/m", 0.0, "Weight in water per length; 0: as in air, the most it can be", display="lbf/ft", min=0.0),
    ]
    wave_speed: Annotated[
        Value,
        parameter(
            "m/s", 0.0, "Speed of waves along the line, which gives its mass; 0: not known", display="ft/s", min=0.0
        ),
    ]
    wire_damping: Annotated[
        Value,
        parameter("1", 0.01, "Damping ratio of the line's own first mode, by which waves of a snap die out; ropes have more",
                  min=0.0, max=1.0),
    ]  # fmt: skip
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
MarginBreaking = Annotated[
    Value, margin("1 - (T - W)/(T_break - W - w L), w L the line's own weight, which hangs on its upper end")
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
    tension_rate: Rate
    reaction_rate: Rate
    event_taut: EventTaut
    event_taut_rate: Rate
    taut: Taut


WireMass = Annotated[Value, calculated_parameter("kg", "Mass of the line; 0: not known", tunable=True)]


class Calculated(NamedTuple):
    """K, ``length`` less the static stretch, m L."""

    port_stiffness: Annotated[Value, calculated_parameter("N/m", "Stiffness seen at both ends", tunable=True)]
    unstretched_length: Annotated[
        Value, calculated_parameter("m", "Length before the static tension stretched the line", tunable=True)
    ]
    wire_mass: WireMass


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


def wire_mass(p: Elasticity, ops: Ops) -> Value:
    """m L, kg: from ``mass_per_length``, else K (L/c)^2, since EA = K L and c^2 = EA/m; 0 where neither is known."""
    known = p.wave_speed > NEGLIGIBLE
    travel_time = ops.where(known, p.length / ops.where(known, p.wave_speed, 1.0), 0.0)
    given = p.mass_per_length * p.length
    return ops.where(p.mass_per_length > 0.0, given, stiffness(p, ops) * travel_time * travel_time)


def room(e: Value, p: Elasticity, ops: Ops) -> Value:
    """What must be positive for the line to be taut, m: the stretch, or 1 where it never goes slack."""
    return ops.where(p.never_slack > 0.5, 1.0, e)


def own_weight(p: Elasticity, ops: Ops) -> Value:
    """w L, N, which hangs on the upper end: as given, else as in air, which no water makes more."""
    return ops.where(p.weight_per_length > 0.0, p.weight_per_length * p.length, wire_mass(p, ops) * GRAVITY)


def margins(tension: Value, e: Value, k: Value, weight: Value, p: Elasticity, ops: Ops) -> tuple[Value, Value]:
    """(taut, breaking). W is the static tension.

    taut = min(1, K e/W): 0 at slack, negative beyond. breaking = 1 - (T - W)/(T_break - W - w L), 1 where no breaking load
    is given.
    """
    scale = ops.where(weight > NEGLIGIBLE, weight, 1.0)
    taut = ops.minimum(1.0, ops.where(weight > NEGLIGIBLE, k * e / scale, ops.where(e < 0.0, -1.0, 1.0)))
    reserve = ops.maximum(p.breaking_load - weight - own_weight(p, ops), 1e-9 * scale)
    breaking = ops.where(p.breaking_load > 0.0, 1.0 - ops.maximum(tension - weight, 0.0) / reserve, 1.0)
    return taut, breaking


def stiff(p: Elasticity, ops: Ops) -> Requirement:
    """A line needs its stiffness in one of two ways."""
    given = ops.maximum(p.stiffness, ops.minimum(p.axial_stiffness, p.length)) - NEGLIGIBLE
    text = "stiffness is 0 and so is axial_stiffness / length: give stiffness, or axial_stiffness and length"
    return given, text


def bears(static_tension: Value, p: Elasticity, load: str, ops: Ops) -> Requirement:
    """A line that breaks above its static tension, N, and its own weight, if it is known to break; ``load`` is the parameter
    that gives the tension."""
    text = (
        f"{load}, which the line carries at rest, with the line's own weight (weight_per_length; without it that in air) "
        "reaches breaking_load: take a stronger line, a lighter load, or 0 for a breaking_load that is not known"
    )
    hangs = static_tension + own_weight(p, ops)
    return ops.where(p.breaking_load > 0.0, p.breaking_load - hangs, 1.0), text


def wire(p: Elasticity, ops: Ops) -> tuple[Requirement, ...]:
    """The mass of the line is given once, and it weighs no more in water than in air."""
    once = "mass_per_length and wave_speed are both given, but m c^2 = K L: give one of them and 0 for the other"
    light = (
        "weight_per_length is above g times the mass per length (mass_per_length, or K L / wave_speed^2), the weight in air: "
        "in water a line weighs less by its buoyancy (units of measure?)"
    )
    mass = wire_mass(p, ops)
    possible = holds(p.weight_per_length * p.length <= mass * GRAVITY * (1.0 + ROUNDING), ops)
    both = ops.minimum(p.mass_per_length, p.wave_speed) > 0.0
    return (ops.where(both, 0.0, 1.0), once), (ops.where(mass > 0.0, possible, 1.0), light)


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """A stiffness, one mass, and a strength that bears what hangs on the line."""
    return stiff(p, ops), *wire(p, ops), bears(p.static_tension, p, "static_tension", ops)


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
    taut, breaking = margins(tension, e, k, p.static_tension, p, ops)
    return Outputs(
        tension, tension - p.static_tension, e, taut, breaking, rate, rate, left,
        ops.where(p.never_slack > 0.5, 0.0, e_rate), branch,
    )  # fmt: skip


def indicators(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[Value]:
    """The stretch, or 1 where the line never goes slack."""
    return (room(stretch(u.heave_top, u.heave_bottom, p.static_tension, stiffness(p, ops)), p, ops),)


def transition(t: Value, x: State, m: Modes, u: Inputs, p: Parameters, ops: Ops) -> tuple[State, Modes]:
    """The branch at a communication point: taut where the stretch is positive."""
    e = stretch(u.heave_top, u.heave_bottom, p.static_tension, stiffness(p, ops))
    return x, Modes(ops.where(room(e, p, ops) > 0.0, 1.0, 0.0))


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Stiffness seen at both ends, the length before W stretched it (``length`` is measured at rest), and the mass."""
    k = stiffness(p, ops)
    return Calculated(k, p.length - p.static_tension / k, wire_mass(p, ops))


SPRING_LINE = Model(
    "spring_line",
    "Elastic line between a ship and a suspended body, with slack",
    Parameters, State, Modes, Inputs, Outputs, Calculated,
    initial=initial, outputs=outputs, indicators=indicators, transition=transition, calculated=calculated,
    requirements=requirements,
)  # fmt: skip
