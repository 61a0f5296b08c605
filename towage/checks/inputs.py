"""Inputs that may have been forgotten: neither connected nor set, and their unit does not say what that means.

One that its unit needs is refused when the scene is resolved (`towage.scene.inputs`), so that it never comes this far; the
connections that a one-way run leaves out are meant to be.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from towage.checks.check import Check, Start
from towage.checks.verdict import INPUTS
from towage.result.records import Finding, Item
from towage.scene.inputs import unset_text

if TYPE_CHECKING:
    from towage.result.result import Result


def before(start: Start) -> list[Finding]:
    """One warning that lists them all."""
    forgotten = start.scene.forgotten
    if not forgotten:
        return []
    remedy = "; ".join(start.scene.remedies)
    return [Finding(INPUTS, "warning", float(len(forgotten)), 0.0, unset_text(forgotten), remedy)]


def item(result: Result) -> Item:
    """Marginal where an input may have been forgotten: the run is right for a value that nobody chose."""
    finding = next((finding for finding in result.checks if finding.name == INPUTS), None)
    if finding is None:
        return Item("valid", "every input is connected, set, or meant to be open", None, None, name=INPUTS)
    return Item("marginal", finding.message, finding.value, finding.limit, None, finding.remedy, INPUTS)


CHECK = Check(
    name="inputs",
    description="Is every input connected, set, or meant to be open?",
    before=before,
    refuses=True,
    item=item,
)
