"""What the master looks at in units of other makes on the way of a run, beside what it asks of them (`towage.master.trust`).

A value that is set has to be there when it is read back. Two readings of a unit that was not stepped agree. The rate that a unit
tells is the slope of what it tells; where it is not, in most of the steps in which something moves, the run begins again without
its rates. And no signal leaves the bounds that its variable declares, beyond which a unit may clip, or compute nonsense.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from towage.errors import RunError
from towage.result.records import Finding
from towage.units.doubt import Doubt

if TYPE_CHECKING:
    from towage.master.signals import Signal
    from towage.master.system import System

READ_BACK = 1e-12
"""Relative difference of a value from the one that was set, which is rounding: some keep single precision not."""
SLOPE = 0.25
"""Difference of a mean rate from a slope, over the larger of them, that curvature does not explain: at a quarter of a radian a
step the two differ by half a percent, at one and a half radians by a fifth."""
FEWEST = 8
"""Steps with motion before a rate is judged."""
MOVES = 1e-6
"""Share of the largest slope below which a signal stands still."""
NUDGE = 1e-3
"""Relative change of an input that shows what follows it."""
OUTSIDE = 1e-9
"""Share of a bound by which rounding may pass it."""


class Bound(NamedTuple):
    """A variable with bounds: its unit, the name, its place among the outputs or None for an input, the bounds."""

    unit: int
    name: str
    slot: int | None
    low: float
    high: float


class Rated:
    """A signal that is judged: ``odd`` of ``steps`` with motion have a rate that is not its slope; ``largest`` slope."""

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self.steps = self.odd = 0
        self.largest = 0.0

    def look(self, step: float) -> bool:
        """Whether the rate is none, after the step before it is accepted."""
        s = self.signal
        if s.unknown:
            return False
        slope, mean = (s.end_value - s.value) / step, 0.5 * (s.rate + s.end_rate)
        size = max(abs(slope), abs(mean))
        self.largest = max(self.largest, size)
        if size > MOVES * self.largest:
            self.steps += 1
            self.odd += abs(slope - mean) > SLOPE * size
        return self.steps >= FEWEST and 2 * self.odd > self.steps


class Watch:
    """Watches the units of other makes of a system that is started."""

    def __init__(self, system: System) -> None:
        self.system = system
        foreign = set(system.foreign)
        self._rated = [Rated(s) for s in system.signals if s.rated and s.source in foreign]
        self._bounds = list(_bounds(system))
        self._set()
        for i in system.foreign:
            if system.units[i].can_roll_back:
                self._feedthrough(i)

    def before(self, time: float, step: float) -> None:
        """Look at the ends of the signals before they are accepted. Raises `Doubt` of a rate."""
        for rated in self._rated:
            if rated.look(step):
                s = rated.signal
                why = f"what it tells as the rate of {s.connection.source} is not its time derivative"
                found = f"at t = {time:g} s: {s.end_rate:g} told, {(s.end_value - s.value) / step:g} found"
                raise Doubt(
                    f"{why} ({found}). Take scheme 'auto', which does without", "rates", why, s.connection.source_unit,
                    s.connection.source, time,
                )  # fmt: skip

    def after(self, time: float, reread: bool) -> None:
        """Look at the values of a communication point; ``reread``: read every unit again."""
        for bound in self._bounds:
            unit = self.system.units[bound.unit]
            value = unit.values[bound.slot] if bound.slot is not None else unit.input_buffer[unit.inputs[bound.name].slot]
            margin = OUTSIDE * max(abs(value), 1.0)
            if not bound.low - margin <= value <= bound.high + margin:
                what = "is given" if bound.slot is None else "becomes"
                self._note(
                    "bounds", unit.name, bound.name, value,
                    f"{unit.name}.{bound.name} {what} {value:g} at t = {time:g} s, outside the {bound.low:g} to {bound.high:g} "
                    "that its unit declares: what the unit does there is not known",
                    "keep it inside, or ask the maker of the unit",
                )  # fmt: skip
        if reread:
            self._read_again(time)

    def _read_again(self, time: float) -> None:
        for i in self.system.foreign:
            unit = self.system.units[i]
            first = unit.values
            if (second := unit.get(time)) == first:
                continue
            name, a, b = next(each for each in zip(unit.outputs, first, second) if each[1] != each[2])
            unit.values = first
            self._note(
                "reading", unit.name, "", abs(a - b),
                f"{unit.name}.{name} is {a!r} and, read again at once at t = {time:g} s, {b!r}: its outputs change by being read",
                "do not rely on them; ask the maker of the unit",
            )  # fmt: skip

    def _set(self) -> None:
        """Read back what was set."""
        for i in self.system.foreign:
            unit = self.system.units[i]
            for name, value in self.system.scene.units[unit.name].parameters.items():
                if unit.variables[name].causality != "parameter" or not isinstance(value, float):
                    continue
                try:
                    there = unit.constant(name)
                except RunError:  # it need not be readable
                    continue
                if there is not None and abs(there - value) > READ_BACK * max(abs(value), abs(there)):
                    self._note(
                        "start values", unit.name, name, there,
                        f"{unit.name}.{name} was set to {value:g} and reads {there:g}: the unit does not take it",
                        "look in the documentation of the unit how it is set",
                    )  # fmt: skip

    def _feedthrough(self, i: int) -> None:
        """See at the start whether an output follows an input that it is not declared to follow; the unit goes back then."""
        unit, declared = self.system.units[i], self.system.units[i].description.dependencies
        for s in self.system.into[i]:
            hidden = [n for n in unit.outputs if (d := declared.get(n)) is not None and s.input.name not in d]
            if s.discrete or not hidden:
                continue
            first, slot = unit.values, s.input.slot
            kept = unit.input_buffer[slot]
            unit.save(0.0)
            try:
                unit.input_buffer[slot] = kept + NUDGE * (abs(kept) or 1.0)
                unit.set(0.0)
                second = unit.get(0.0)
            except RunError:  # no place to go to
                second = first
            unit.input_buffer[slot], unit.values = kept, first
            unit.restore(0.0)
            if follow := [n for n in hidden if first[unit.slot[n]] != second[unit.slot[n]]]:
                self._note(
                    "feedthrough", unit.name, s.input.name, float(len(follow)),
                    f"{unit.name}.{follow[0]} follows {s.input.name} without delay, and its description declares that it does "
                    "not: loops through it are not seen, and what it sends is up to a step late",
                    "vet the unit (towage vet), which lets runs take it as it is",
                )  # fmt: skip

    def _note(self, kind: str, unit: str, name: str, value: float, message: str, remedy: str) -> None:
        self.system.found.setdefault((unit, f"{kind} {name}"), Finding(kind, "warning", value, None, message, remedy))


def _bounds(system: System) -> Iterator[Bound]:
    """The variables of units of other makes that have bounds: outputs, and inputs that are connected."""
    for i in system.foreign:
        unit = system.units[i]
        connected = {s.input.name for s in system.into[i]}
        for name, v in unit.variables.items():
            low, high = -math.inf if v.min is None else v.min, math.inf if v.max is None else v.max
            if (name in unit.slot or name in connected) and (low > -math.inf or high < math.inf):
                yield Bound(i, name, unit.slot.get(name), low, high)
