"""What the units say of their own validity: the worst value of every recorded ``margin_*`` and when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from towage.checks.check import Cell, Check, Finished, Part
from towage.checks.verdict import GRAVITY
from towage.result.records import Finding, Item, Margin

if TYPE_CHECKING:
    from towage.result.result import Result


PREMISES = "premises"
"""The item on the assumptions of the models."""


def after(run: Finished) -> list[Finding]:
    """Adds what units say to the result's ``margins``, but where a check has found the error behind one."""
    import numpy as np

    result, shown = run.result, run.scene.scene.checks.report_only
    known = {margin.variable for margin in result.margins}
    for name, values in result.columns.items():
        if name.split(".", 1)[1].startswith("margin_") and len(values) and name not in known:
            k = int(np.argmin(values))
            result.margins.append(Margin(name, float(values[k]), float(result.time[k]), name not in shown))
    return []


def item_of(margins: Sequence[Margin]) -> Item | None:
    """What margins say to the verdict: the gravest of those that decide, the smallest of equals; None if none decides."""
    deciding = [margin for margin in margins if margin.decides]
    return said(min(deciding, key=lambda margin: (GRAVITY.index(said(margin).word), margin.worst))) if deciding else None


def said(margin: Margin) -> Item:
    """What one margin says: by the error behind it, where a check knows that, else invalid where it is negative."""
    m = margin
    if m.word:
        return Item(m.word, m.reason, m.error, m.limit, m.time, m.remedy, PREMISES)
    if m.worst < 0.0:
        return Item("invalid", f"{m.variable} is negative at t = {m.time:.4g} s", m.worst, 0.0, m.time, name=PREMISES)
    return Item("valid", f"smallest margin is {m.variable}", m.worst, 0.0, m.time, name=PREMISES)


def report(result: Result) -> list[Part]:
    """The smallest value of each margin, those that decide first."""
    if not result.margins:
        return []
    ordered = sorted(result.margins, key=lambda margin: (not margin.decides, margin.worst))
    rows = [(m.variable, Cell(m.worst), Cell(m.time, "s"), "decides" if m.decides else "report only") for m in ordered]
    return [Part("Margins", ("Margin", "Worst", "At", "Use"), tuple(rows))]


CHECK = Check(
    name="margins",
    description="Do the units stay inside the assumptions of their models?",
    after=after,
    item=lambda result: item_of(result.margins),
    report=report,
)
