"""The trials of an FMU, each a function of the bench that says what it found."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from towage.errors import RunError
from towage.master.trust import FIXED, REPEATED
from towage.units.conventions import guessed, rate_of
from towage.units.fmu import StepRefused
from towage.vet import inputs, process
from towage.vet.bench import STEPS, Bench, Trial

RATE = 0.05
"""Relative error of a rate over a step that passes: the rest is the curvature of the signal."""


def runs(bench: Bench) -> list[Trial]:
    """Does it initialise and step? Does it end by itself?"""
    with bench.unit() as unit:
        for k in range(10 * STEPS):
            bench.excite(unit, k * bench.step)
            try:
                unit.advance(k * bench.step, bench.step)
            except StepRefused as refusal:
                if refusal.ends:
                    return [_end(refusal, k, bench.step)]
                return [Trial("runs", "warning", f"refuses step {k} of {bench.step:g} s: {refusal}")]
            if unit.endings:
                return [Trial("runs", "note", f"ends by itself at {unit.endings[0][1]:g} s")]
    return [Trial("runs", "ok", f"initialises and does {10 * STEPS} steps of {bench.step:g} s")]


def _end(refusal: StepRefused, done: int, step: float) -> Trial:
    reached = refusal.reached
    if reached is not None and not done * step <= reached * (1.0 + 1e-9) <= (done + 1 + 1e-9) * step:
        span = f"{done * step:g} to {(done + 1) * step:g} s"
        text = f"ends by itself in the step from {span}, and says that it came to {reached:g} s"
        return Trial("runs", "warning", text, reached)
    return Trial("runs", "note", f"ends by itself after {done} steps, at {reached} s")


def flag(bench: Bench) -> list[Trial]:
    """Does a step commit where noSetFMUStatePriorToCurrentPoint is false?"""
    with bench.unit() as unit:
        usual = bench.run(unit, STEPS)
    with bench.unit() as unit:
        do_step = unit.instance.do_step
        unit.instance.do_step = lambda component, time, size, flag: do_step(component, time, size, 0)
        unit.advance = unit._stepper()
        other = bench.run(unit, STEPS)
    gap, name = bench.worst(usual, other)
    if gap > REPEATED or len(usual) != len(other):
        text = f"a step counts only where noSetFMUStatePriorToCurrentPoint is true ({name} differs), as the master sets it"
        return [Trial("flag", "note", text, gap)]
    return [Trial("flag", "ok", "steps do not depend on noSetFMUStatePriorToCurrentPoint")]


def determinism(bench: Bench) -> list[Trial]:
    """Do two instances, one after the other and side by side, do the same?"""
    with bench.unit() as unit:
        first = bench.run(unit, STEPS)
    with bench.unit() as unit:
        second = bench.run(unit, STEPS)
    gap, name = bench.worst(first, second)
    found = [Trial("determinism", "ok", "two runs give the same bits")]
    if gap:
        found = [Trial("determinism", "warning" if gap < FIXED else "fault", f"two runs differ, most in {name}", gap)]
    if bench.description.once_per_process:
        return [*found, Trial("two instances", "note", "only one a process, as its description says")]
    try:
        with bench.unit("one") as one, bench.unit("two") as two:
            sides = [bench.run(one, 1, k) + bench.run(two, 1, k) for k in range(STEPS)]
    except RunError as error:
        return [*found, Trial("two instances", "fault", f"there is no second one beside the first: {error}")]
    gap, name = bench.worst([row[0] for row in sides if row], first)
    if gap > REPEATED:
        return [*found, Trial("two instances", "fault", f"disturb one another, most in {name}: run one a process", gap)]
    return [*found, Trial("two instances", "ok", "do not disturb one another")]


def rollback(bench: Bench) -> list[Trial]:
    """What noise has a repeated step, and is the state complete?"""
    if not bench.description.can_get_set_state:
        return [Trial("rollback", "note", "cannot save and restore its state: only schemes that never go back")]
    noise, which = 0.0, ""
    with bench.unit() as unit:
        for k in range(STEPS):
            unit.save(k * bench.step)
            first = bench.run(unit, 1, k)
            unit.restore(k * bench.step)
            second = bench.run(unit, 1, k)
            gap, name = bench.worst(first, second)
            noise, which = max((noise, which), (gap, name))
    with bench.unit() as unit:
        bench.run(unit, 5)
        unit.save(5 * bench.step)
        first = bench.run(unit, STEPS, 5)
        unit.restore(5 * bench.step)
        second = bench.run(unit, STEPS, 5)
    lost, name = bench.worst(first, second)
    level = "ok" if noise <= REPEATED else "note" if noise <= FIXED else "warning"
    text = f"a repeated step differs by {noise:.2g} of {which}" if which else "a repeated step is the same to the last bit"
    found = [Trial("noise", level, text + (": it is not taken back" if noise > FIXED else ""), noise)]
    complete = lost <= max(REPEATED, 10.0 * STEPS * noise if noise <= FIXED else REPEATED)
    text = "complete" if complete else f"{STEPS} steps from a saved state differ by {lost:.2g} of {name}: it is not complete"
    return [*found, Trial("state", "ok" if complete else "warning", text, lost), *_serialised(bench)]


def _serialised(bench: Bench) -> list[Trial]:
    """Is a state that is written down all of it? Another instance goes on from there."""
    if not bench.description.can_serialize_state:
        return []
    with bench.unit() as unit:
        bench.run(unit, 5)
        data = unit.frozen(5 * bench.step)
        first = bench.run(unit, STEPS, 5)
    with bench.unit() as unit:
        unit.thaw(data, 5 * bench.step)
        second = bench.run(unit, STEPS, 5)
    lost, name = bench.worst(first, second)
    text = "another instance goes on from a state that was written down"
    if lost > REPEATED or len(first) != len(second):
        return [Trial("serialisation", "fault", f"{text}, and differs by {lost:.2g} of {name}: it is not complete", lost)]
    return [Trial("serialisation", "ok", text, lost)]


def feedthrough(bench: Bench) -> list[Trial]:
    """Which outputs follow an input that is set between two steps, and does the description say so?"""
    hidden, lazy = [], []
    with bench.unit() as unit:
        bench.run(unit, 3)
        before = bench.row(unit, unit.get(0.0))
        for v in bench.inputs:
            slot = unit.inputs[v.name].slot
            kept = unit.input_buffer[slot]
            unit.input_buffer[slot] = kept + 0.01 * (abs(kept) or 1.0)
            unit.set(0.0)
            after = bench.row(unit, unit.get(0.0))
            for output, a, b in zip(bench.outputs, before, after):
                declared = bench.description.dependencies.get(output.name)
                if a != b and declared is not None and v.name not in declared:
                    hidden.append(f"{v.name} -> {output.name}")
                if a == b and declared and v.name in declared:
                    lazy.append(f"{v.name} -> {output.name}")
            unit.input_buffer[slot] = kept
            unit.set(0.0)
    found = [Trial("feedthrough", "ok", "is as declared")]
    if hidden:
        found = [Trial("feedthrough", "fault", f"not declared: {', '.join(hidden[:3])}; loops are not seen", len(hidden))]
    elif lazy:
        found = [Trial("feedthrough", "note", f"declared and not seen when inputs are set: {', '.join(lazy[:3])}", len(lazy))]
    if any(d is None for d in bench.description.dependencies.values()):
        found.append(Trial("dependencies", "note", "not declared: every output counts as depending on every input"))
    return found


def rates(bench: Bench) -> list[Trial]:
    """Are what its names call rates the time derivatives?"""
    names = {v.name: rate for v in bench.outputs if (rate := rate_of(bench.description, v.name))}
    places = {v.name: k for k, v in enumerate(bench.outputs)}
    if not names:
        return [Trial("rates", "note", "tells none: differences take their place")]
    wrong = []
    with bench.unit() as unit:
        rows = bench.run(unit, STEPS)
    for name, (told, factor) in names.items():
        if told not in places:
            continue
        y, r = [row[places[name]] for row in rows], [factor * row[places[told]] for row in rows]
        slopes = [(b - a) / bench.step for a, b in pairwise(y)]
        means = [0.5 * (a + b) for a, b in pairwise(r)]
        size = max(map(abs, (*slopes, *means)), default=0.0)
        if size and max(abs(a - b) for a, b in zip(slopes, means)) > RATE * size:
            wrong.append(f"{told} is not the time derivative of {name}")
    said = guessed(bench.description)
    if wrong:
        return [Trial("rates", "fault", "; ".join(wrong[:3]), len(wrong))]
    return [Trial("rates", "ok", "; ".join(said[:3]) or "are the time derivatives")]


TRIALS: dict[str, Callable[[Bench], list[Trial]]] = {
    "runs": runs, "flag": flag, "determinism": determinism, "rollback": rollback, "feedthrough": feedthrough,
    "rates": rates, "slopes": inputs.slopes, "delay": inputs.delay, "reading": inputs.reading, "start": inputs.start,
    "step size": inputs.step_size, "environment": process.environment, "leaks": process.leaks, "threads": process.threads,
}  # fmt: skip


def tried(name: str, path: Path) -> list[Trial]:
    """What one trial found of an FMU; a failure of the unit is what it found."""
    try:
        return TRIALS[name](Bench(path))
    except RunError as error:
        return [Trial("runs" if name == "runs" else f"{name} trial", "fault" if name == "runs" else "warning", f"fails: {error}")]
