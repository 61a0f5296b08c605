"""The units of a scene wired together, and what a coupling scheme may do with them.

Every connection carries a signal: its value and rate at the communication point t (``value``, ``rate``), those found at
the end of the step being tried (``end_value``, ``end_rate``), and the cubic that its target is given over the step,
u(t + s) = a0 + a1 s + a2 s^2 + a3 s^3. A scheme is a sequence of `extrapolate`, `interpolate`, `hold` on signals and
`advance` on units (`schemes.py`). Units without direct feedthrough come first in ``order``, so that those with it see
both ends of their inputs: no delay is added where the equations have none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from towage.scene.resolve import ResolvedConnection, ResolvedScene, ResolvedUnit
from towage.units.archive import unpacked
from towage.units.fmu import Unit, UnitFactory
from towage.units.wiring import Input, Wanted

SAME_STEP = 1e-6
"""Relative difference below which two step lengths are one: k h is not exactly the time."""


@dataclass(slots=True)
class Signal:
    """One connection at work. ``rated``: its source reports the rate; ``backward``: its source comes after its target."""

    connection: ResolvedConnection
    source: int
    target: int
    input: Input
    slot: int
    rate_slot: int
    factor: float
    rated: bool
    value: float = 0.0
    rate: float = 0.0
    end_value: float = 0.0
    end_rate: float = 0.0
    old_value: float = 0.0
    scale: float = 0.0
    backward: bool = False
    polynomial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


class System:
    """The running units. FMUs are unpacked below ``extracted``. ``freeze``: ask units to hold their branches over a step,
    provided that all can go back to a step's start, which the search for events needs. ``held``: inputs are held over a
    step, so that neither rates nor events are read. ``make`` makes the units.

    Raises `FmuError` and `RunError` if a unit cannot be loaded or instantiated."""

    def __init__(
        self,
        scene: ResolvedScene,
        extracted: Path,
        freeze: bool = False,
        held: bool = False,
        make: UnitFactory = Unit,
    ) -> None:
        self.scene = scene
        self._freeze = freeze
        self.units: list[Unit] = []
        self.start_cpu = 0.0  # processor time of loading and initialisation, s
        self.old_step = 0.0
        self.saved_at = math.nan
        self.learned_now: list[tuple[Any, Any]] = []
        self.learned_step = 0.0
        try:
            for resolved in scene.units.values():
                directory = unpacked(resolved.path, extracted)
                self.units.append(make(resolved.name, resolved.description, directory, _wanted(resolved, scene, held)))
        except BaseException:
            self.close()
            raise
        number = {unit.name: i for i, unit in enumerate(self.units)}
        self.signals = [self._signal(c, number) for c in scene.connections]
        self.into: list[list[Signal]] = [[s for s in self.signals if s.target == i] for i in range(len(self.units))]
        self.out: list[list[Signal]] = [[s for s in self.signals if s.source == i] for i in range(len(self.units))]
        self.order = self._order()
        place = {unit: k for k, unit in enumerate(self.order)}
        for s in self.signals:
            s.backward = place[s.source] >= place[s.target]
        self.backward = [s for s in self.signals if s.backward]
        self.looped = self._looped()
        ours = ("python", "native")
        self.foreign = [i for i, unit in enumerate(self.units) if scene.units[unit.name].flavour not in ours]
        self.indicators = [
            (i, unit.slot[n], unit.slot.get(f"{n}_rate", -1), n.removeprefix("event_"))
            for i, unit in enumerate(self.units) for n in unit.outputs
            if n.startswith("event_") and not n.endswith("_rate")
        ]  # fmt: skip
        self.clocks = [
            (i, unit.slot["next_event_time"]) for i, unit in enumerate(self.units) if "next_event_time" in unit.slot
        ]

    def _signal(self, connection: ResolvedConnection, number: dict[str, int]) -> Signal:
        source, target = number[connection.source_unit], number[connection.target_unit]
        slots = self.units[source].slot
        rate = slots.get(f"{connection.source}_rate", -1)
        place = self.units[target].inputs[connection.target]
        return Signal(connection, source, target, place, slots[connection.source], rate, connection.factor, rate >= 0)

    def _order(self) -> list[int]:
        """Units in the order of evaluation: after every unit whose output goes straight through them."""
        hard = {i: {s.source for s in self.into[i] if s.input.feedthrough} for i in range(len(self.units))}
        order: list[int] = []
        left = list(range(len(self.units)))
        while left:
            missing = {i: len({s.source for s in self.into[i]} & set(left)) for i in left}
            free = [i for i in left if not hard[i] & set(left)] or left
            order.append(min(free, key=lambda i: (missing[i], i)))
            left.remove(order[-1])
        return order

    def _looped(self) -> list[int]:
        """Units, in order, whose inputs depend on a signal that runs backward in the order."""
        touched = {s.target for s in self.backward}
        for i in self.order:
            if any(s.source in touched for s in self.into[i]):
                touched.add(i)
        return [i for i in self.order if i in touched]

    # ---- start, communication points --------------------------------------------------------------------------------

    def start(self, start_time: float, stop_time: float) -> None:
        """Initialise all units and make the signals consistent at the start."""
        for unit in self.units:
            parameters = dict(self.scene.units[unit.name].parameters)
            if self._freeze and self.can_roll_back and "freeze_branches" in unit.variables:
                parameters.setdefault("freeze_branches", 1.0)
            unit.start(parameters, start_time, stop_time)
        for i in range(len(self.units)):
            self._read(i)
        self.accept(0.0)
        self.refresh(start_time)

    def refresh(self, time: float) -> None:
        """Limits from the right at a communication point: pass values and rates on, and read again. Branches change
        here. The history is of no use afterwards."""
        for i in self.order:
            if self.into[i]:
                for s in self.into[i]:
                    s.polynomial = (s.value, s.rate, 0.0, 0.0)
                self._write(i, 0.0)
                self.units[i].set(time)
                self.units[i].get(time)
                self._read(i)
                for s in self.out[i]:
                    s.value, s.rate = s.end_value, s.end_rate
        self.old_step = 0.0
        self.learned_now.clear()

    def learned(self, step: float) -> list[tuple[Any, Any]]:
        """What iterations at this step length told of the loop since the last event: (change of the residual, change of
        the ends found) of one to the next, oldest first. The caller adds to it."""
        if abs(step - self.learned_step) > SAME_STEP * step:
            self.learned_now.clear()
            self.learned_step = step
        return self.learned_now

    def accept(self, step: float) -> None:
        """The end of the step becomes the communication point."""
        for s in self.signals:
            s.old_value, s.value = s.value, s.end_value
            s.rate = s.end_rate if s.rated else (s.value - s.old_value) / step if step else 0.0
            s.scale = max(s.scale, abs(s.value))
        self.old_step = step

    def save(self, time: float) -> None:
        """Save the state of every unit."""
        self.saved_at = time
        for unit in self.units:
            unit.save(time)

    def restore(self, units: Sequence[int] | None = None) -> None:
        """Restore the saved state of some units (default: all)."""
        for i in range(len(self.units)) if units is None else units:
            self.units[i].restore(self.saved_at)

    @property
    def can_roll_back(self) -> bool:
        """Whether every unit can save and restore its state."""
        return all(unit.can_roll_back for unit in self.units)

    def close(self) -> None:
        """Free all units."""
        for unit in self.units:
            unit.close()

    # ---- signals ----------------------------------------------------------------------------------------------------

    def hold(self, s: Signal) -> None:
        """Zero-order hold of the value at the communication point."""
        s.polynomial = (s.value, 0.0, 0.0, 0.0)

    def extrapolate(self, s: Signal) -> None:
        """Quadratic through value, rate and the previous value; linear where there is no history."""
        h = self.old_step
        curvature = (s.old_value - s.value + s.rate * h) / (h * h) if s.rated and h else 0.0
        s.polynomial = (s.value, s.rate, curvature, 0.0)

    def interpolate(self, s: Signal, step: float) -> None:
        """Cubic Hermite between both ends; linear where there are no rates."""
        slope = (s.end_value - s.value) / step
        if s.rated:
            s.polynomial = (
                s.value,
                s.rate,
                (3.0 * slope - 2.0 * s.rate - s.end_rate) / step,
                (s.rate + s.end_rate - 2.0 * slope) / (step * step),
            )
        else:
            s.polynomial = (s.value, slope, 0.0, 0.0)

    # ---- units ------------------------------------------------------------------------------------------------------

    def advance(self, i: int, time: float, step: float) -> None:
        """Step one unit with the polynomials of its inputs, and read it."""
        self._write(i, step)
        self.units[i].advance(time, step)
        self._read(i)

    def _read(self, i: int) -> None:
        values = self.units[i].values
        for s in self.out[i]:
            s.end_value = values[s.slot] * s.factor
            if s.rated:
                s.end_rate = values[s.rate_slot] * s.factor

    def _write(self, i: int, step: float) -> None:
        unit = self.units[i]
        buffer = unit.input_buffer
        for s in self.into[i]:
            place = s.input
            a0, a1, a2, a3 = s.polynomial
            k, d = place.slot, place.derivatives
            if place.orders == 3:
                buffer[k], buffer[d], buffer[d + 1], buffer[d + 2] = a0, a1, 2.0 * a2, 6.0 * a3
            elif place.orders == 1:  # a straight line that ends where the signal does
                buffer[k], buffer[d] = a0, a1 + step * (a2 + step * a3)
            elif place.feedthrough:  # held over the step: what goes straight through should be right at its end
                buffer[k] = a0 + step * (a1 + step * (a2 + step * a3))
            else:  # and what is integrated should be right on average
                buffer[k] = a0 + step * (a1 / 2.0 + step * (a2 / 3.0 + step * a3 / 4.0))

    def next_event(self, time: float) -> float:
        """The earliest event time that a unit announces after ``time``."""
        ahead = [self.units[i].values[k] for i, k in self.clocks]
        return min((t for t in ahead if t > time + 1e-12 * (1.0 + abs(time))), default=float("inf"))


def _wanted(unit: ResolvedUnit, scene: ResolvedScene, held: bool) -> Wanted:
    """What the scene wants of a unit; where inputs are held, neither rates nor events."""
    connected = [c.target for c in scene.connections if c.target_unit == unit.name]
    sources = [c.source for c in scene.connections if c.source_unit == unit.name]
    names = sources + [v for u, v in (*scene.record, *scene.reads) if u == unit.name]
    names += [v.name for v in unit.description.variables if v.causality == "output" and v.name.startswith("margin_")]
    if not held:
        events = [v.name for v in unit.description.variables if v.name.startswith("event_")]
        names += [f"{n}_rate" for n in sources] + events + ["next_event_time"]
    known = {v.name for v in unit.description.variables if v.type == "Real"}
    return Wanted(connected, sources, [n for n in dict.fromkeys(names) if n in known], cubic=not held)
