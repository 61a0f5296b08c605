"""Inputs that may have been forgotten: neither connected nor set, and their unit does not say what that means.

One that its unit needs is refused when the scene is resolved (`towage.scene.inputs`), so that it never comes this far; the
connections that a one-way run leaves out are meant to be.
"""

from __future__ import annotations

from towage.checks.check import Check, Start
from towage.result.records import Finding
from towage.scene.inputs import unset_text


def before(start: Start) -> list[Finding]:
    """One warning that lists them all."""
    forgotten = start.scene.forgotten
    return [Finding("inputs", "warning", None, None, unset_text(forgotten))] if forgotten else []


CHECK = Check(
    name="inputs",
    description="Is every input connected, set, or meant to be open?",
    before=before,
    refuses=True,
)
