"""What the master takes on trust of units of other makes, said before the run: descriptions that break the standard, units of
measure that nobody defines, and names that are read as conventions because their unit of measure fits; and what was filled in or
not understood of a system of another format."""

from __future__ import annotations

from typing import TYPE_CHECKING

from towage.checks.check import Check, Start, told
from towage.result.records import Finding
from towage.units.conventions import guessed

if TYPE_CHECKING:
    from towage.result.result import Result


def before(start: Start) -> list[Finding]:
    """A warning for each thing that was taken although something is wrong with it, a note for each convention."""
    findings = [Finding("system", note.level, None, None, note.text) for note in start.scene.scene.notes]
    findings += [Finding("units", "warning", None, None, text) for text in start.scene.warnings]
    for name, unit in start.scene.units.items():
        if said := guessed(unit.description):
            findings.append(Finding("units", "info", None, None, f"{name}: {'; '.join(said)}"))
    return findings


TOLD = (
    "end", "grid", "noise", "fallback", "late outputs", "start values", "reading", "feedthrough", "bounds", "warnings",
    "messages",
)  # fmt: skip
"""Findings of the run that its summary repeats."""
MOST = 5
"""Warnings about a system of another format that the summary repeats."""


def summary(result: Result) -> list[tuple[str, str]]:
    """What a reader of the verdict has to know of the units."""
    warnings = [f.message for f in result.checks if f.name == "system" and f.level == "warning"]
    if len(warnings) > MOST:
        warnings[MOST:] = [f"and {len(warnings) - MOST} more warnings, which the report lists"]
    return [*(("system", text) for text in warnings), *(line for name in TOLD for line in told(result, name))]


CHECK = Check(
    name="units",
    description="What is taken on trust of units of other makes?",
    before=before,
    refuses=True,
    summary=summary,
)
