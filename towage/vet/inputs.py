"""Trials of how a unit takes what it is given and gives what it is asked for: inputs, their derivatives, values, readings."""

from __future__ import annotations

import math

from towage.errors import RunError
from towage.master.trust import REPEATED
from towage.units.description import Variable
from towage.units.fmu import StepRefused, Unit
from towage.units.kinds import is_double
from towage.vet.bench import STEPS, Bench, Trial

NUDGE = 1e-3
"""Relative change of a start value that is read back."""
LARGE_STEP = 0.05
"""Difference between steps of one and of half the length beyond which a unit is not to be used at that step."""


def slopes(bench: Bench) -> list[Trial]:
    """Does it heed the derivatives of its inputs that it takes?"""
    if not (bench.description.can_interpolate_inputs and bench.inputs):
        return [Trial("slopes", "note", "takes no derivatives of inputs: they are held at their mean over a step")]
    told, held, ends = (_with_slopes(bench, slope, share) for slope, share in ((1.0, 0.0), (0.0, 0.0), (0.0, 1.0)))
    if held == ends:
        return [Trial("slopes", "note", "no output follows an input: not told")]
    if told == held:
        return [Trial("slopes", "fault", "takes derivatives of its inputs and does nothing with them")]
    return [Trial("slopes", "ok", "heeds the derivatives of its inputs")]


def _with_slopes(bench: Bench, slope: float, share: float) -> list[list[float]]:
    """Outputs after steps with inputs of ``share`` of the way over the step, that are told ``slope`` times their slopes."""
    rows = []
    with bench.unit(slopes=True) as unit:
        for k in range(STEPS):
            bench.excite(unit, (k + 1) * bench.step)
            ends = unit.input_buffer[:]
            bench.excite(unit, k * bench.step)
            for place in unit.inputs.values():
                change = ends[place.slot] - unit.input_buffer[place.slot]
                unit.input_buffer[place.slot] += share * change
                if place.orders:
                    unit.input_buffer[place.derivatives] = slope * change / bench.step
            try:
                rows.append(bench.row(unit, unit.advance(k * bench.step, bench.step)))
            except StepRefused:
                break
    return rows


def delay(bench: Bench) -> list[Trial]:
    """Does an input act in the step that it is set for?"""
    if not bench.inputs:
        return [Trial("delay", "note", "has no inputs")]
    runs = []
    for push in (0.0, 0.1):
        with bench.unit() as unit:
            rows = bench.run(unit, 3)
            for k in range(3, 6):
                bench.excite(unit, k * bench.step)
                for v in bench.inputs:
                    slot = unit.inputs[v.name].slot
                    unit.input_buffer[slot] = _inside(v, unit.input_buffer[slot], push)
                try:
                    rows.append(bench.row(unit, unit.advance(k * bench.step, bench.step)))
                except StepRefused:
                    break
            runs.append(rows[3:])
    smooth = [k for k, v in enumerate(bench.outputs) if v.variability == "continuous"]
    first = {k: next((n for n, (a, b) in enumerate(zip(*runs)) if a[k] != b[k]), None) for k in smooth}
    if late := [bench.outputs[k].name for k, n in first.items() if n]:
        return [Trial("delay", "warning", f"inputs reach {', '.join(late[:3])} a step late", len(late))]
    if all(n is None for n in first.values()):
        return [Trial("delay", "note", "no continuous output follows the inputs within three steps")]
    return [Trial("delay", "ok", "inputs act in the step that they are set for")]


def _inside(v: Variable, value: float, share: float) -> float:
    """The value changed by a share of its size, or of 1, to where its variable has room."""
    change = share * (abs(value) or 1.0)
    high = math.inf if v.max is None else v.max
    return value + change if value + change <= high else value - change


def reading(bench: Bench) -> list[Trial]:
    """Does a reading, in whatever order, or setting what is set already change what follows?"""
    with bench.unit() as unit:
        plain = bench.run(unit, STEPS)
    rows: list[list[float]] = []
    with bench.unit() as unit:
        for k in range(STEPS):
            rows += bench.run(unit, 1, k)
            time = (k + 1) * bench.step
            alone = [unit.constant(v.name) for v in reversed(bench.outputs)][::-1]
            for first, second, v in zip(rows[-1] if rows else (), alone, bench.outputs):
                if second is not None and first != second:
                    text = f"{v.name} is {first!r}, and {second!r} where it is read again alone"
                    return [Trial("reading", "fault", text, abs(first - second))]
            unit.set(time)
            unit.get(time)
    gap, name = bench.worst(plain, rows)
    if gap:
        return [Trial("reading", "fault", f"readings between steps, or inputs set again, change {name}", gap)]
    return [Trial("reading", "ok", "changes nothing, in any order")]


def start(bench: Bench) -> list[Trial]:
    """Are start values of parameters there when they are read back?"""
    numbers = [v for v in bench.description.variables if v.causality == "parameter" and is_double(v) and v.start is not None]
    if not numbers:
        return [Trial("start", "note", "has no parameters with start values that are numbers")]
    values = {v.name: _inside(v, float(v.start or 0.0), NUDGE) for v in numbers}
    try:
        with bench.unit(values=values) as unit:
            lost = [name for name, value in values.items() if not _reads(unit, name, value)]
    except RunError as error:
        return [Trial("start", "note", f"not told, with all parameters changed by {NUDGE:g} it fails: {error}")]
    if lost:
        return [Trial("start", "warning", f"reads something else than was set: {', '.join(lost[:3])}", len(lost))]
    return [Trial("start", "ok", f"{len(values)} parameters read what was set")]


def _reads(unit: Unit, name: str, value: float) -> bool:
    there = unit.constant(name)
    return there is None or abs(there - value) <= REPEATED * max(abs(value), abs(there))


def step_size(bench: Bench) -> list[Trial]:
    """How much do its outputs depend on the step, its inputs held?"""
    with bench.unit() as unit:
        bench.excite(unit, 7.0 * bench.step)
        whole = _steps(bench, unit, bench.step, 1)
    with bench.unit() as unit:
        bench.excite(unit, 7.0 * bench.step)
        half = _steps(bench, unit, 0.5 * bench.step, 2)
    gap, name = bench.worst(whole, half, smooth=True)
    if not whole or len(whole) != len(half):
        return [Trial("step size", "note", f"not told: it refuses steps of {0.5 * bench.step:g} s")]
    if not gap:
        return [Trial("step size", "ok", f"the same with steps of {bench.step:g} s and of half of it")]
    level = "warning" if gap > LARGE_STEP else "note"
    return [Trial("step size", level, f"{name} differs by {gap:.2g} between steps of {bench.step:g} s and of half of it", gap)]


def _steps(bench: Bench, unit: Unit, size: float, every: int) -> list[list[float]]:
    """Outputs after each ``every`` steps of ``size`` s, inputs as they are."""
    rows = []
    for k in range(STEPS * every):
        try:
            row = bench.row(unit, unit.advance(k * size, size))
        except StepRefused:
            break
        rows += [row] if k % every == every - 1 else []
    return rows
