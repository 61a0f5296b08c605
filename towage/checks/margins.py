"""What the units say of their own validity: the worst value of every recorded ``margin_*`` and when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from towage.checks.check import Cell, Check, Finished, Part
from towage.result.records import Finding, Item, Margin
from towage.units.conventions import has

if TYPE_CHECKING:
    from towage.result.result import Result


PREMISES = "premises"
"""The item on the assumptions of the models."""


def after(run: Finished) -> list[Finding]:
    """Sets the result's ``margins``."""
    import numpy as np

    result, shown = run.result, run.scene.scene.checks.report_only
    for name, values in result.columns.items():
        unit, _, variable = name.partition(".")
        if variable.startswith("margin_") and has(run.scene.units[unit].description, variable) and len(values):
            k = int(np.argmin(values))
            result.margins.append(Margin(name, float(values[k]), float(result.time[k]), name not in shown))
    return []


def item_of(margins: Sequence[Margin]) -> Item | None:
    """What margins say to the verdict: invalid where one that decides is negative; None if none decides."""
    worst = min((margin for margin in margins if margin.decides), key=lambda margin: margin.worst, default=None)
    if worst is None:
        return None
    if worst.worst < 0.0:
        reason = f"{worst.variable} is negative at t = {worst.time:.4g} s"
        return Item("invalid", reason, worst.worst, 0.0, worst.time, name=PREMISES)
    return Item("valid", f"smallest margin is {worst.variable}", worst.worst, 0.0, worst.time, name=PREMISES)


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
