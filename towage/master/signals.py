"""The connections of a scene at work, and what they make a scene want of its units."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from towage.scene.resolve import ResolvedConnection, ResolvedScene, ResolvedUnit
from towage.units.conventions import CLOCK, has, indicators, rate_of
from towage.units.fmu import Unit
from towage.units.wiring import Input, Wanted


@dataclass(slots=True)
class Signal:
    """One connection at work: target = factor * source + offset, or what ``table`` has for it. ``rated``: its source reports the
    rate, which ``unknown`` is before the first step where a function tells it; ``backward``: its source comes after its
    target; ``discrete``: held over a step; ``at_end``: held at its end, because what goes straight through the target is right
    there."""

    connection: ResolvedConnection
    source: int
    target: int
    input: Input
    slot: int
    rate_slot: int
    factor: float
    offset: float
    rate_factor: float
    rated: bool
    unknown: bool
    discrete: bool
    at_end: bool
    value: float = 0.0
    rate: float = 0.0
    end_value: float = 0.0
    end_rate: float = 0.0
    old_value: float = 0.0
    scale: float = 0.0
    backward: bool = False
    table: dict[float, float] = field(default_factory=dict)
    polynomial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


class TextSignal(NamedTuple):
    """A connection that carries a text, by the places of its units and the names of their variables."""

    source: int
    output: str
    target: int
    input: str


def signal(connection: ResolvedConnection, units: Sequence[Unit], number: Mapping[str, int]) -> Signal:
    """The signal of a connection between ``units``, whose places are in ``number``."""
    source, target = number[connection.source_unit], number[connection.target_unit]
    unit = units[source]
    factor, variable = connection.factor, unit.variables[connection.source]
    by_function = f"{connection.source}_rate" in unit.outputs[slice(*unit.wiring.by_function)]
    named = rate_of(unit.description, connection.source)
    name, scale = (f"{connection.source}_rate", 1.0) if by_function else named or ("", 1.0)
    rate = unit.slot.get(name, -1)
    discrete = variable.type != "Real" or variable.variability in ("discrete", "fixed", "tunable", "constant")
    place = units[target].inputs[connection.target]
    unknown = by_function and not unit.description.conventions
    return Signal(
        connection, source, target, place, unit.slot[connection.source], rate, factor, connection.offset, factor * scale,
        rate >= 0 and not discrete, unknown, discrete, place.feedthrough, table=dict(connection.values),
    )  # fmt: skip


def wanted(unit: ResolvedUnit, scene: ResolvedScene, held: bool) -> Wanted:
    """What the scene wants of a unit; where inputs are held, neither rates nor events."""
    description = unit.description
    connected = [c.target for c in scene.connections if c.target_unit == unit.name]
    sources = [c.source for c in scene.connections if c.source_unit == unit.name]
    names = sources + [v for u, v in (*scene.record, *scene.reads) if u == unit.name]
    outputs = (v.name for v in description.variables if v.causality == "output")
    names += [name for name in outputs if name.startswith("margin_") and has(description, name)]
    if not held:
        rates = [rate[0] for n in sources if (rate := rate_of(description, n))]
        names += rates + indicators(description) + ([CLOCK] if has(description, CLOCK) else [])
    return Wanted(connected, sources, list(dict.fromkeys(names)), cubic=not held)


def evaluation_order(into: Sequence[Sequence[Signal]], stuck: Collection[int] = ()) -> list[int]:
    """Units in the order of evaluation: after every unit whose output goes straight through them. ``into``: the signals into
    each unit. Those that are ``stuck``, which make a step once, come late: what they are given is then found already."""
    hard = {i: {s.source for s in signals if s.input.feedthrough} for i, signals in enumerate(into)}
    order: list[int] = []
    left = list(range(len(into)))
    while left:
        missing = {i: len({s.source for s in into[i]} & set(left)) for i in left}
        free = [i for i in left if not hard[i] & set(left)] or left
        order.append(min(free, key=lambda i: (i in stuck, missing[i], i)))
        left.remove(order[-1])
    return order


def looped(order: Sequence[int], backward: Sequence[Signal], into: Sequence[Sequence[Signal]]) -> list[int]:
    """Units, in order, whose inputs depend on a signal that runs backward in the order."""
    touched = {s.target for s in backward}
    for i in order:
        if any(s.source in touched for s in into[i]):
            touched.add(i)
    return [i for i in order if i in touched]
