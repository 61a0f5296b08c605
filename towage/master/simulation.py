"""One coupled run: communication points, step control, events, record.

Communication points lie on multiples of the step (t = k h, never accumulated) or where the error control puts them, on
every record time, on announced event times and on located zeros of event indicators. An event step ends just beyond its
zero; there all units are brought to their limits from the right and the history of the signals is dropped.
"""

from __future__ import annotations

import math
import time as clock
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field

from towage.errors import RunError
from towage.master.recorder import Recorder
from towage.master.schemes import Scheme
from towage.master.system import System
from towage.result.result import Event
from towage.units.fmu import StepRefused
from towage.units.trust import repeat

LANDING = 1e-10
"""An event is located to this share of the step: 1e-10 of a step costs no accuracy and stays clear of rounding."""
MERGE = 1e-6
"""A remainder shorter than this share of a step is merged with it."""
MAX_HALVINGS = 40


@dataclass
class Settings:
    """How to couple. Either ``step`` (s) or ``tolerance`` (relative error per step). ``max_step`` bounds the latter."""

    scheme: Scheme
    step: float | None
    tolerance: float | None
    max_step: float
    events: bool
    record_interval: float
    stop_time: float


@dataclass
class Bond:
    """Two connections, one each way, whose product is a power: force and the rate of a displacement."""

    name: str
    force: int
    motion: int
    residual: float = 0.0
    throughput: float = 0.0


@dataclass
class Run:
    """Counts and findings of a run."""

    events: list[Event] = field(default_factory=list)
    steps: array[float] = field(default_factory=lambda: array("d"))
    bonds: list[Bond] = field(default_factory=list)
    rejected: int = 0
    located: int = 0
    cpu: float = 0.0
    wall: float = 0.0
    time: float = 0.0


def simulate(
    system: System, settings: Settings, recorder: Recorder, report: Callable[[float], None] | None = None
) -> Run:
    """Run a started system from 0 to the stop time. ``report`` hears the time reached now and then.

    Raises `RunError`; what was recorded until then is in ``recorder``, and the run so far in its ``run`` attribute.
    """
    run = Run(bonds=_bonds(system))
    begin, begin_cpu = clock.perf_counter(), clock.process_time()
    try:
        _loop(system, settings, recorder, run, report)
    except RunError as error:
        error.run = run  # type: ignore[attr-defined]
        raise
    finally:
        run.wall, run.cpu = clock.perf_counter() - begin, clock.process_time() - begin_cpu
    return run


def _loop(
    system: System, settings: Settings, recorder: Recorder, run: Run, report: Callable[[float], None] | None
) -> None:
    scheme = settings.scheme
    units = system.units
    smooth = not scheme.holds
    locate = settings.events and smooth and system.can_roll_back and bool(system.indicators)
    clocks = smooth and bool(system.clocks)
    keep = system.can_roll_back and (locate or settings.tolerance is not None or scheme.goes_back)
    stop, tolerance = settings.stop_time, settings.tolerance
    grid = settings.step if settings.step is not None else settings.max_step
    control = settings.max_step if tolerance is None else min(settings.max_step, 1e-3 * stop)
    time, k, records, next_report = 0.0, 0, 0, 0.0
    recorder.row(0.0, [u.values for u in units])
    before = _indications(system)
    while True:
        if report and clock.monotonic() > next_report:
            report(time)
            next_report = clock.monotonic() + 0.1
        if time >= stop:
            return
        # where to: the end of the step, or sooner if something is due
        target = (k + 1) * grid if tolerance is None else time + control
        record_time = (records + 1) * settings.record_interval
        for due in (record_time, stop):
            if due < target + MERGE * grid:
                target = due
        announced = system.next_event(time) if clocks else float("inf")
        at_clock = announced < target + MERGE * (target - time)
        if at_clock:
            target = announced
        step = target - time
        if keep:
            system.save(time)
        estimate, step = _attempt(system, scheme, time, step, keep, run)
        if keep and len(run.steps).bit_count() < 2:  # steps 0, 1, 2, 4, 8, ...
            repeat(system, time, step)
        if tolerance is not None:
            factor = 0.8 * (tolerance / max(estimate, 1e-300)) ** 0.25
            if estimate > tolerance and keep and step > 1e-12 * stop:
                control = step * max(0.2, factor)
                system.restore()
                run.rejected += 1
                continue
            grown = min(settings.max_step, step * min(2.0, factor))
            control = max(control, grown) if step < control else grown  # a step cut short says nothing against longer
        crossed = locate and _crossing(system, before, step)
        if crossed:
            step = _locate(system, scheme, time, step, crossed, before, run)
        end = target if step == target - time else time + step
        _bookkeep(system, run, step)
        system.accept(step)
        if crossed or (at_clock and end >= announced):
            _note(system, run, recorder, end, before, at_clock and end >= announced)
            system.refresh(end)
        time = end
        before = _indications(system) if locate else []
        run.time = time
        run.steps.append(step)
        if tolerance is None and time >= (k + 1) * grid - MERGE * grid:
            k += 1
        if time >= record_time - MERGE * grid:
            recorder.row(time, [u.values for u in units])
            records += 1


def _attempt(system: System, scheme: Scheme, time: float, step: float, keep: bool, run: Run) -> tuple[float, float]:
    """Try the step, and shorter ones if a unit refuses: (error estimate, step that was done)."""
    for _ in range(MAX_HALVINGS):
        try:
            return scheme.step(system, time, step), step
        except StepRefused as refusal:
            if not keep:
                raise RunError(f"a unit refused the step of {step:g} s ({refusal}) and not all units can go back "
                               "for a shorter one: try a shorter step", time=time) from None  # fmt: skip
            last = refusal
            system.restore()
            run.rejected += 1
            step *= 0.5
    raise RunError(f"no step is short enough for a unit (last tried {2 * step:g} s): {last}", time=time)


def _indications(system: System) -> list[tuple[float, float]]:
    """(value, rate) of every event indicator; the rate is 0 where it is not known."""
    return [
        (values[slot], values[rate] if rate >= 0 else 0.0)
        for values, slot, rate in ((system.units[i].values, slot, rate) for i, slot, rate, _ in system.indicators)
    ]


def _crossing(system: System, before: list[tuple[float, float]], step: float) -> float:
    """0 if no indicator changes sign in the step; else a length at or before which one has changed: the step, or the
    extremum of the cubic Hermite interpolant of an indicator that only dips through zero and comes back."""
    for (g0, r0), (g1, r1) in zip(before, _indications(system)):
        if (g0 > 0.0) != (g1 > 0.0):
            return step
        if g0 * r0 < 0.0 < g0 * r1:
            slope = (g1 - g0) / step
            a2, a3 = (3.0 * slope - 2.0 * r0 - r1) / step, (r0 + r1 - 2.0 * slope) / (step * step)
            root = math.sqrt(max(0.0, a2 * a2 - 3.0 * a3 * r0))
            s = -r0 / (a2 + math.copysign(root, a2)) if a2 else math.sqrt(max(0.0, -r0 / (3.0 * a3))) if a3 else 0.0
            if 0.0 < s < step and (g0 + s * (r0 + s * (a2 + s * a3)) > 0.0) != (g0 > 0.0):
                return s
    return 0.0


def _locate(
    system: System,
    scheme: Scheme,
    time: float,
    tried: float,
    high: float,
    before: list[tuple[float, float]],
    run: Run,
) -> float:
    """End the step just beyond the first zero of an indicator; the system is left there. ``high`` is a length by which
    one has changed. Secant steps inside a bracket (Illinois rule), each a full step of the scheme with frozen branches.
    """

    def first_change() -> int:
        """The indicator that changes first, -1 if none changes."""
        shares = {
            k: abs(a) / (abs(a) + abs(b) + 1e-300)
            for k, ((a, _), (b, _)) in enumerate(zip(before, _indications(system))) if (a > 0.0) != (b > 0.0)
        }  # fmt: skip
        return min(shares, key=shares.__getitem__) if shares else -1

    run.located += 1
    if high != tried:
        _again(system, scheme, time, high, run)
    which = first_change()
    if which < 0:  # the interpolant dipped through zero, the indicator itself does not
        return _again(system, scheme, time, tried, run) if high != tried else tried
    low, last, done = 0.0, 0, high
    g_low, g_high = before[which][0], _indications(system)[which][0]
    width = max(LANDING * tried, 8e-16 * abs(time))
    for _ in range(60):
        if high - low <= width:
            break
        h = high - g_high * (high - low) / (g_high - g_low) + 0.3 * width
        h = min(max(h, low + 0.5 * width), high - 0.5 * width)
        done = _again(system, scheme, time, h, run)
        changed = first_change()
        if changed < 0:
            low, g_low = h, _indications(system)[which][0]
            g_high *= 0.5 if last < 0 else 1.0
            last = -1
        elif changed != which:  # another indicator changes before this one
            which, low, high, last = changed, 0.0, h, 0
            g_low, g_high = before[which][0], _indications(system)[which][0]
        else:
            high, g_high = h, _indications(system)[which][0]
            g_low *= 0.5 if last > 0 else 1.0
            last = 1
    return high if done == high else _again(system, scheme, time, high, run)


def _again(system: System, scheme: Scheme, time: float, step: float, run: Run) -> float:
    system.restore()
    run.rejected += 1
    _, done = _attempt(system, scheme, time, step, True, run)
    return done


def _note(
    system: System, run: Run, recorder: Recorder, time: float, before: list[tuple[float, float]], at_clock: bool
) -> None:
    """Write events into the record."""
    known = len(run.events)
    for (g0, _), (g1, _), (i, _, _, name) in zip(before, _indications(system), system.indicators):
        if (g0 > 0.0) != (g1 > 0.0):
            run.events.append(Event(time, system.units[i].name, name, 1 if g1 > 0.0 else -1))
    if at_clock:
        for i, slot in system.clocks:
            if abs(system.units[i].values[slot] - time) <= 1e-9 * (1.0 + time):
                run.events.append(Event(time, system.units[i].name, "time event", 0))
    for event in run.events[known:]:
        recorder.event(event)


def _bonds(system: System) -> list[Bond]:
    """Pairs of connections between two units that carry a force one way and a displacement the other."""
    unit_of = [system.units[s.source].variables[s.connection.source].unit for s in system.signals]
    bonds = []
    for a, force in enumerate(system.signals):
        for b, motion in enumerate(system.signals):
            if (
                (force.source, force.target) == (motion.target, motion.source)
                and (unit_of[a], unit_of[b]) == ("N", "m") and motion.rated
            ):  # fmt: skip
                bonds.append(Bond(f"{system.units[force.source].name} - {system.units[force.target].name}", a, b))
    return bonds


def _bookkeep(system: System, run: Run, step: float) -> None:
    """Energy that the coupling made or lost at each bond: half the gap of the force at the end of the step, times the
    motion; against the work that went through."""
    signals = system.signals
    for bond in run.bonds:
        f, y = signals[bond.force], signals[bond.motion]
        a0, a1, a2, a3 = f.polynomial
        gap = a0 + step * (a1 + step * (a2 + step * a3)) - f.end_value
        way = abs(y.end_rate) * step
        bond.residual += 0.5 * abs(gap) * way
        bond.throughput += abs(f.end_value) * way
