"""One coupled run: communication points, step control, events, record.

Communication points lie on multiples of the step (t = k h, never accumulated) or where the error control puts them, on
announced event times and on located zeros of event indicators; what is recorded moves none. An event step ends just beyond its
zero; there all units are brought to their limits from the right and the history of the signals is dropped. A unit that takes
steps of one size only keeps all points on the grid. A unit that ends the simulation by itself ends the run, as well done.
"""

from __future__ import annotations

import math
import time as clock
from array import array
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

from towage.errors import RunError
from towage.master.bonds import BondEnergy, accounts
from towage.master.events import crossing, happened, indications, locate
from towage.master.points import changed, look_after
from towage.master.recorder import Recorder
from towage.master.schemes import Scheme
from towage.master.system import System
from towage.master.trust import allowed, repeat
from towage.master.watch import Watch
from towage.result.result import Event
from towage.units.fmu import StepRefused

MERGE = 1e-6
"""A remainder shorter than this share of a step is merged with it."""
LEAST_STEP = 16
"""Units in the last place of the time that a step has at least."""
REPORT_INTERVAL = 0.1
"""Least time between two reports of progress, s of the clock on the wall."""


@dataclass
class Settings:
    """How to couple. Either ``step`` (s) or ``tolerance`` (relative error per step). ``max_step`` bounds the latter.
    ``on_grid``: units that take steps of one size only. ``ended``: a unit ended the run at ``stop_time``."""

    scheme: Scheme
    step: float | None
    tolerance: float | None
    max_step: float
    events: bool
    record_interval: float
    stop_time: float
    on_grid: tuple[str, ...] = ()
    ended: bool = False

    @property
    def records_end(self) -> bool:
        """Whether the end is recorded, wherever it lies: it is not where the scene has it."""
        return bool(self.ended or self.on_grid)


@dataclass
class Run:
    """What is known of a run beside its record: events, accepted steps (s), the energy accounts of its bonds, repeated
    steps, events that were searched for; processor time and time passed (s), the time reached (s), and the unit that ended
    the run before its stop time, with what it said."""

    events: list[Event] = field(default_factory=list)
    steps: array[float] = field(default_factory=lambda: array("d"))
    bonds: list[BondEnergy] = field(default_factory=list)
    rejected: int = 0
    located: int = 0
    cpu: float = 0.0
    wall: float = 0.0
    time: float = 0.0
    ended_by: str = ""


class _Over(Exception):
    """The run is over at the communication point, before its stop time."""


def simulate(
    system: System,
    settings: Settings,
    recorder: Recorder,
    report: Callable[[float], None] | None = None,
    begin_at: Callable[[Simulation], None] | None = None,
    look: Callable[[Simulation], None] | None = None,
) -> Run:
    """Run a started system from 0, or from where ``begin_at`` brings it, to the stop time. ``report`` hears the time reached
    now and then; ``look`` is given the simulation as often, before a step (`towage.master.checkpoint`).

    Raises `RunError`; what was recorded until then is in ``recorder``, and the run so far in its ``run`` attribute.
    """
    simulation = Simulation(system, settings, recorder)
    run = simulation.run
    begin, begin_cpu = clock.perf_counter(), clock.process_time()
    try:
        if begin_at:
            begin_at(simulation)
        with suppress(_Over):
            simulation.to_the_end(report, look)
    except RunError as error:
        error.run = run  # type: ignore[attr-defined]
        raise
    finally:
        run.wall, run.cpu = clock.perf_counter() - begin, clock.process_time() - begin_cpu
    return run


class Simulation:
    """A run on its way: where it stands, and one communication step after the other.

    ``done`` counts the steps of a fixed grid. ``control`` is the step that the error control
    wants, s. ``before`` holds the event indicators at the communication point where zeros are searched for.
    """

    def __init__(self, system: System, settings: Settings, recorder: Recorder) -> None:
        self.system = system
        self.recorder = recorder
        self.watch = Watch(system) if system.foreign else None
        self.cares, self.texts = bool(system.foreign or system.discrete or system.texts), bool(recorder.texts)
        self.run = Run(bonds=accounts(system))
        system.now = lambda: self.run.time
        self.stop, self.tolerance = settings.stop_time, settings.tolerance
        self.max_step = settings.max_step
        scheme = settings.scheme
        self.scheme_step = scheme.step
        can_roll_back = system.can_roll_back
        self.on_grid = settings.on_grid
        searches = settings.events and not scheme.holds and not self.on_grid
        self.searches = searches and can_roll_back and bool(system.indicators)
        self.clocks = not scheme.holds and bool(system.clocks or system.eventful)
        self.keeps = can_roll_back and (self.searches or self.tolerance is not None or scheme.goes_back)
        self.saves = self.keeps or (scheme.goes_back and bool(system.repeated))
        self.grid = settings.step if settings.step is not None else settings.max_step
        self.control = self.max_step if self.tolerance is None else min(self.max_step, 1e-3 * self.stop)
        self.time, self.done = 0.0, 0
        self.before = indications(system) if self.searches else []
        self.limit = system.floor = allowed(settings.tolerance) if system.foreign else 0.0
        for i in system.eventful:
            system.units[i].instance.locates = self.keeps and not self.on_grid
        if self.on_grid:
            self.stop = max(1, math.floor(self.stop / self.grid + MERGE)) * self.grid

    def to_the_end(
        self, report: Callable[[float], None] | None, look: Callable[[Simulation], None] | None = None
    ) -> None:
        """Step until the stop time."""
        if not self.recorder.data:
            self.record(0.0)
        next_report = 0.0
        while True:
            if report and clock.monotonic() > next_report:
                report(self.time)
                if look:
                    look(self)
                next_report = clock.monotonic() + REPORT_INTERVAL
            if self.time >= self.stop:
                return
            self.step()

    def step(self) -> None:
        """One communication step, or one that the error control refuses."""
        system, time = self.system, self.time
        target, announced = self.target()
        step = target - time
        if self.saves:
            system.save(time)
        estimate, step = self.attempt(time, step)
        if self.saves and len(self.run.steps).bit_count() < 2:  # steps 0, 1, 2, 4, 8, ...
            repeat(system, time, step, self.limit)
        if self.tolerance is not None and not self.accepts(estimate, step):
            system.restore()
            self.run.rejected += 1
            return
        crossed = crossing(self.before, indications(system), step) if self.searches else 0.0
        if crossed:
            self.run.located += 1
            step = locate(system, self.before, time, step, crossed, self.again)
        self.advance(target if step == target - time else time + step, step, bool(crossed), announced)

    def target(self) -> tuple[float, float]:
        """(where the step should end: on the grid or where the error control wants it, or sooner if the stop or an announced
        event is due; the time of that event, infinite if there is none by then)."""
        time, grid = self.time, self.grid
        target = (self.done + 1) * grid if self.tolerance is None else time + self.control
        if self.on_grid:
            announced = self.system.next_event(time) if self.clocks else math.inf
            return target, announced if announced <= target else math.inf
        if self.stop < target + MERGE * grid:
            target = self.stop
        if self.clocks:
            announced = self.system.next_event(time)
            if announced < target + MERGE * (target - time):
                return announced, announced
        return target, math.inf

    def attempt(self, time: float, step: float) -> tuple[float, float]:
        """Try the step, and shorter ones if a unit refuses: (error estimate, step that was done)."""
        while True:
            try:
                return self.scheme_step(self.system, time, step), step
            except StepRefused as refusal:
                least = LEAST_STEP * math.ulp(max(abs(time), self.stop))
                if refusal.ends:
                    step = self.last_step(refusal, time, step)
                    if len(self.system.units) == 1:  # it stands there already
                        self.system.units[0].get(time + step)
                        self.system.read(0)
                        return 0.0, step
                else:
                    step = self.shorter(refusal, time, step)
                if step < least:
                    tried = f"last tried {2 * step:g} s"
                    raise RunError(f"no step is short enough for a unit ({tried}): {refusal}", time=time) from None
                self.system.restore()
                self.run.rejected += 1

    def last_step(self, refusal: StepRefused, time: float, step: float) -> float:
        """The step to where a unit ended the simulation, which becomes the stop time. Raises `_Over` where the others cannot be
        brought there: the run then ends at the communication point."""
        self.run.ended_by = str(refusal)
        reached = refusal.reached
        alone = len(self.system.units) == 1
        if reached is None or not time < reached < time + step or self.on_grid or not (self.keeps or alone):
            raise _Over
        self.stop = reached
        return reached - time

    def shorter(self, refusal: StepRefused, time: float, step: float) -> float:
        """The step to try after a refusal. Raises `RunError` where there is none."""
        if refusal.event is not None:
            return refusal.event - time
        if self.on_grid:
            names = ", ".join(self.on_grid)
            raise RunError(f"a unit refused the step of {step:g} s ({refusal}), and {names} takes steps of one size only: "
                           "try a shorter coupling.step", time=time) from None  # fmt: skip
        if not self.keeps:
            raise RunError(f"a unit refused the step of {step:g} s ({refusal}) and not all units can go back "
                           "for a shorter one: try a shorter step", time=time) from None  # fmt: skip
        for unit in self.system.units:
            unit.instance.log.mark()
        return 0.5 * step

    def again(self, step: float) -> float:
        """Repeat the step from its start with another length; returns the length that was done."""
        self.system.restore()
        self.run.rejected += 1
        return self.attempt(self.time, step)[1]

    def accepts(self, estimate: float, step: float) -> bool:
        """Whether the error control accepts the step; sets what it wants next."""
        assert self.tolerance is not None
        factor = 0.8 * (self.tolerance / max(estimate, 1e-300)) ** 0.25
        if estimate > self.tolerance and self.keeps and step > 1e-12 * self.stop:
            self.control = step * max(0.2, factor)
            return False
        grown = min(self.max_step, step * min(2.0, factor))
        # a step cut short says nothing against longer ones
        self.control = max(self.control, grown) if step < self.control else grown
        return True

    def advance(self, end: float, step: float, crossed: bool, announced: float) -> None:
        """Make the end of the step the communication point: energy, events, record."""
        system, run = self.system, self.run
        for bond in run.bonds:
            bond.add(step)
        if self.watch:
            self.watch.before(end, step)
        system.accept(step)
        run.time = end
        if self.cares:
            look_after(system, end)
        left = [unit.values for unit in system.units]
        event = crossed or end >= announced
        if event:
            for one in happened(system, end, self.before, announced if end >= announced else None):
                run.events.append(one)
                self.recorder.event(one)
        if (self.cares and changed(system, end)) or event:
            self.recorder.row(end, left)  # the limits from the left
            system.refresh(end)
        if self.searches:
            self.before = indications(system)
        self.time = end
        run.steps.append(step)
        if self.watch:
            self.watch.after(end, len(run.steps).bit_count() < 2)
        if self.cares and (enders := [name for name, at in system.endings if abs(at - end) <= MERGE * step]):
            run.ended_by, self.stop = enders[0], end
        if self.tolerance is None and end >= (self.done + 1) * self.grid - MERGE * self.grid:
            self.done += 1
        self.record(end)

    def record(self, time: float) -> None:
        """Append the values of all units."""
        units = self.system.units
        self.recorder.row(time, [unit.values for unit in units])
        if self.texts:
            self.recorder.words(time, {unit.name: unit.wiring.others.words for unit in units})
