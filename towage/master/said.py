"""What a run has to say of its units beside the checks: who ended it, what was taken on trust, what units said."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from towage.master.simulation import Run, Settings
from towage.master.system import System
from towage.result.records import Finding
from towage.units.log import STATUS, Message

GRAVE = STATUS[2:]


def listen(system: System, write: Callable[[Message], None], kept: Sequence[Message] | None = None) -> None:
    """Have what the units say written, what they said before first. ``kept``: what was written before a run that goes on, which
    takes the place of what they said at this start."""
    for unit in system.units:
        if kept is not None:
            unit.instance.log.take_up([message for message in kept if message.unit == unit.name])
        unit.instance.log.follow(lambda: system.now(), write, past=kept is None)


def messages(system: System) -> list[Message]:
    """What the units said, in order of time."""
    every = [message for unit in system.units for message in unit.instance.log.messages]
    return sorted(every, key=lambda message: -math.inf if message.time is None else message.time)


def after(system: System, settings: Settings, run: Run) -> list[Finding]:
    """The findings, whether the run came to its end or failed."""
    findings = []
    if run.ended_by and run.time < settings.stop_time:
        message = f"{run.ended_by}: the unit ended the run at t = {run.time:.9g} s, before {settings.stop_time:g} s"
        findings.append(Finding("end", "info", run.time, settings.stop_time, message))
    for name, noise in system.noise.items():
        message = f"{name} differs by {noise:.2g} of its size where a step is repeated, which this run bears"
        findings.append(Finding("noise", "info", noise, system.floor, message))
    for name in sorted(system.late_units):
        message = (
            f"outputs of {name} do not follow its inputs when they are set between steps: where they depend on inputs without "
            "delay, what is recorded of them is late by up to half a step"
        )
        remedy = "take a shorter step, or connect the output; `towage vet` tells whether they depend"
        findings.append(Finding("late outputs", "warning", None, None, message, remedy))
    findings += system.found.values()
    apart = [unit.lacks for unit in system.units if unit.lacks is not None]
    if lacks := dict.fromkeys(word for words in apart for word in words):
        message = f"units in processes of their own that the system does not keep from {'; '.join(lacks)}"
        findings.append(Finding("isolation", "warning", None, None, message, "take Linux 6.12 or newer, with both enabled"))
    elif apart:
        message = "a process a unit: it writes in its folder alone, has no network, and reaches no other process"
        findings.append(Finding("isolation", "info", None, None, message))
    for unit in system.units:
        log = unit.instance.log
        if log.warnings:
            about = (m.text for m in log.messages if m.status == STATUS[1] and m.time == log.warned_at)
            first = f": {text}" if (text := next(about, "")) else ""
            at = "at the start" if log.warned_at is None else f"at t = {log.warned_at:.9g} s"
            message = f"{log.warnings} calls of {unit.name} ended with a warning, first {at}{first}"
            remedy = "something may be wrong, as the standard has it: read the log, or ask the maker of the unit"
            findings.append(Finding("warnings", "warning", float(log.warnings), None, message, remedy))
        grave = [message for message in log.messages if message.status in GRAVE]
        if grave:
            more = f", {log.lost} more were not kept" if log.lost else ""
            message = f"{unit.name} logged {len(log.messages)} messages{more}; first error: {grave[0].line()}"
            findings.append(Finding("messages", "warning", float(len(grave)), None, message))
    return findings
