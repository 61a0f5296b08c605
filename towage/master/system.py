"""The units of a scene wired together, and what a coupling scheme may do with them.

Every connection carries a signal: its value and rate at the communication point t (``value``, ``rate``), those found at
the end of the step being tried (``end_value``, ``end_rate``), and the cubic that its target is given over the step,
u(t + s) = a0 + a1 s + a2 s^2 + a3 s^3. A discrete signal is held over the step, its change is an event. A scheme is a
sequence of `extrapolate`, `interpolate`, `hold` on signals and `advance` on units (`schemes.py`). Units without direct
feedthrough come first in ``order``, so that those with it see both ends of their inputs: no delay is added where the
equations have none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from towage.master.initial import initialise
from towage.master.signals import Signal, TextSignal, evaluation_order, looped, signal, wanted
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene, ResolvedUnit
from towage.units.archive import unpacked
from towage.units.conventions import CLOCK, FREEZE, has, indicators
from towage.units.copies import own_library
from towage.units.doubt import Doubts
from towage.units.fmu import Unit, UnitFactory

ROUNDING = 1e-12
"""Share of a signal's largest value by which rounding may change it."""
OURS = ("python", "native")
"""Flavours of towage's own units."""
SAME_STEP = 1e-6
"""Relative difference below which two step lengths are one: k h is not exactly the time."""


class System:
    """The running units. FMUs are unpacked below ``extracted``. ``freeze``: ask units to hold their branches over a step,
    provided that all can go back to a step's start, which the search for events needs. ``held``: inputs are held over a
    step, so that neither rates nor events are read. ``make`` makes the units. ``distrusted``: units that are not to go back,
    and why.

    Raises `FmuError` and `RunError` if a unit cannot be loaded or instantiated."""

    def __init__(
        self,
        scene: ResolvedScene,
        extracted: Path,
        freeze: bool = False,
        held: bool = False,
        make: UnitFactory = Unit,
        distrusted: Mapping[str, str] | None = None,
    ) -> None:
        self.scene = scene
        self.distrusted = dict(distrusted or {})
        self.doubts: Doubts = {}
        self.now: Callable[[], float | None] = lambda: None
        self.noise: dict[str, float] = {}
        self.found: dict[tuple[str, str], Finding] = {}
        self.scales: dict[int, list[float]] = {}
        self.floor = 0.0
        self.late_units: set[str] = set()
        self.endings: list[tuple[str, float]] = []
        self._freeze = freeze
        self.units: list[Unit] = []
        self.start_cpu = 0.0  # processor time of loading and initialisation, s
        self.old_step = 0.0
        self.saved_at = math.nan
        self.learned_now: list[tuple[Any, Any]] = []
        self.learned_step = 0.0
        self._libraries = ExitStack()
        try:
            for resolved in scene.units.values():
                self._make(resolved, make, extracted, held)
        except BaseException:
            self.close()
            raise
        number = {unit.name: i for i, unit in enumerate(self.units)}
        self._wire(number)
        self._known(held)

    def _make(self, resolved: ResolvedUnit, make: UnitFactory, extracted: Path, held: bool) -> None:
        directory = unpacked(resolved.path, extracted)
        if resolved.flavour not in OURS:
            directory = self._libraries.enter_context(own_library(directory))
        unit = make(resolved.name, resolved.description, directory, wanted(resolved, self.scene, held))
        self.units.append(unit)
        unit.can_roll_back = unit.can_roll_back and unit.name not in self.distrusted
        unit.instance.log.follow(lambda: self.now())
        unit.endings = self.endings

    def _wire(self, number: Mapping[str, int]) -> None:
        """The signals between units, whose places are in ``number``, and the order of evaluation."""
        scene = self.scene
        numeric = [c for c in scene.connections if c.target in self.units[number[c.target_unit]].inputs]
        self.signals = [signal(c, self.units, number) for c in numeric]
        self.texts = [
            TextSignal(number[c.source_unit], c.source, number[c.target_unit], c.target)
            for c in scene.connections if c not in numeric
        ]  # fmt: skip
        self.discrete = [s for s in self.signals if s.discrete]
        self._changed: dict[int, list[Signal]] = {}
        for s in self.signals:
            if s.offset or s.table:
                self._changed.setdefault(s.source, []).append(s)
        self.unknown = [s for s in self.signals if s.unknown]
        self.into: list[list[Signal]] = [[s for s in self.signals if s.target == i] for i in range(len(self.units))]
        self.out: list[list[Signal]] = [[s for s in self.signals if s.source == i] for i in range(len(self.units))]
        stuck = {i for i, unit in enumerate(self.units) if not unit.can_roll_back}
        self.order = evaluation_order(self.into, stuck)
        place = {unit: k for k, unit in enumerate(self.order)}
        for s in self.signals:
            s.backward = place[s.source] >= place[s.target]
        self.backward = [s for s in self.signals if s.backward]
        self.looped = looped(self.order, self.backward, self.into)
        self.repeated = [i for i in self.looped if i not in stuck]

    def _known(self, held: bool) -> None:
        """What the master has to look after in these units."""
        scene = self.scene
        self.foreign = [i for i, unit in enumerate(self.units) if scene.units[unit.name].flavour not in OURS]
        self.eventful = [i for i, unit in enumerate(self.units) if unit.description.event_mode]
        late = {s.target for s in self.signals if s.input.late and not s.input.orders}
        self.late = [] if held else sorted(late)
        self.indicators = [
            (i, unit.slot[n], unit.slot.get(f"{n}_rate", -1), n.removeprefix("event_"))
            for i, unit in enumerate(self.units) for n in indicators(unit.description)
            if n in unit.slot and not n.endswith("_rate")
        ]  # fmt: skip
        self.clocks = [(i, u.slot[CLOCK]) for i, u in enumerate(self.units) if CLOCK in u.slot and has(u.description, CLOCK)]

    # ---- start, communication points --------------------------------------------------------------------------------

    def start(self, start_time: float, stop_time: float, tolerance: float | None = None) -> None:
        """Initialise all units and make the signals consistent at the start. ``tolerance``: relative, for what units solve
        themselves; None: that of their default experiment."""
        for unit in self.units:
            parameters = dict(self.scene.units[unit.name].parameters)
            if self._freeze and self.can_roll_back and has(unit.description, FREEZE):
                parameters.setdefault(FREEZE, 1.0)
            own = unit.description.default_experiment.tolerance
            unit.enter(parameters, (start_time, stop_time), own if tolerance is None else tolerance)
        initialise(self, start_time)
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
                self.read(i)
                for s in self.out[i]:
                    s.value, s.rate = s.end_value, s.end_rate
        self.old_step = 0.0
        self.learned_now.clear()

    def pass_texts(self) -> None:
        """Pass texts on, which are held between communication points."""
        for text in self.texts:
            words = self.units[text.source].wiring.others.words
            self.units[text.target].wiring.others.words[text.input] = words[text.output]

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
        for s in self.discrete:
            s.rate = 0.0
        if self.unknown and step:
            for s in self.unknown:
                s.unknown = False
            self.unknown.clear()
        self.old_step = step

    def save(self, time: float) -> None:
        """Save the state of every unit that goes back."""
        self.saved_at = time
        for unit in self.units:
            if unit.can_roll_back:
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
        self._libraries.close()

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
            if s.unknown:
                s.rate = 2.0 * slope - s.end_rate
            s.polynomial = (
                s.value,
                s.rate,
                (3.0 * slope - 2.0 * s.rate - s.end_rate) / step,
                (s.rate + s.end_rate - 2.0 * slope) / (step * step),
            )
        else:
            s.polynomial = (s.value, 0.0 if s.discrete else slope, 0.0, 0.0)

    # ---- units ------------------------------------------------------------------------------------------------------

    def advance(self, i: int, time: float, step: float) -> None:
        """Step one unit with the polynomials of its inputs, and read it."""
        self._write(i, step)
        self.units[i].advance(time, step)
        self.read(i)

    def read(self, i: int) -> None:
        """Take the ends of the signals that a unit sends from its values."""
        values = self.units[i].values
        for s in self.out[i]:
            s.end_value = values[s.slot] * s.factor
            if s.rated:
                s.end_rate = values[s.rate_slot] * s.rate_factor
        if i in self._changed:
            for s in self._changed[i]:
                s.end_value = s.table.get(s.end_value, s.end_value) + s.offset

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
            elif s.at_end:  # held over the step: what goes straight through should be right at its end
                buffer[k] = a0 + step * (a1 + step * (a2 + step * a3))
            else:  # and what is integrated should be right on average
                buffer[k] = a0 + step * (a1 / 2.0 + step * (a2 / 3.0 + step * a3 / 4.0))

    def next_event(self, time: float) -> float:
        """The earliest event time that a unit announces after ``time``."""
        ahead = [self.units[i].values[k] for i, k in self.clocks] + [self.units[i].instance.next_event for i in self.eventful]
        return min((t for t in ahead if t > time + 1e-12 * (1.0 + abs(time))), default=float("inf"))
