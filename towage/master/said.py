"""What a run has to say of its units beside the checks: who ended it, what was taken on trust, what units said."""

from __future__ import annotations

from towage.master.simulation import Run, Settings
from towage.master.system import System
from towage.result.records import Finding
from towage.units.log import STATUS

GRAVE = STATUS[2:]


def after(system: System, settings: Settings, run: Run) -> list[Finding]:
    """The findings, whether the run came to its end or failed."""
    findings = []
    if run.ended_by:
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
    for unit in system.units:
        log = unit.instance.log
        grave = [message for message in log.messages if message.status in GRAVE]
        if grave:
            more = f", {log.lost} more were not kept" if log.lost else ""
            message = f"{unit.name} logged {len(log.messages)} messages{more}; first error: {grave[0].line()}"
            findings.append(Finding("messages", "warning", float(len(grave)), None, message))
    return findings
