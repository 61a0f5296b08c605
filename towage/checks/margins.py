"""What the units say of their own validity: the worst value of every recorded ``margin_*`` and when.

A margin that bounds an error is 1 - error/limit; its unit says so in the variable's description, by `ERROR`, and other
checks add such margins to the result themselves. The card then shows the error.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from towage.checks.check import Cell, Check, Finished, Part
from towage.result.records import Finding, Item, Margin, Word

if TYPE_CHECKING:
    from towage.result.result import Result


PREMISES = "premises"
"""The item on the assumptions of the models."""
ERROR = re.compile(r"1 - error / (\d+(?:\.\d+)?) %.*?(?:; remedy: (.*))?$")
"""The limit and the remedy in the description of a margin that bounds an error
(`towage.models.protocol.variables.error_margin`)."""


def after(run: Finished) -> list[Finding]:
    """Sets the result's ``margins``."""
    import numpy as np

    result, shown = run.result, run.scene.scene.checks.report_only
    for name, values in result.columns.items():
        unit, variable = name.split(".", 1)
        if variable.startswith("margin_") and len(values):
            k = int(np.argmin(values))
            told = run.scene.units[unit].description.by_name()[variable].description
            bound = error_of(float(values[k]), told)
            result.margins.append(Margin(name, float(values[k]), float(result.time[k]), name not in shown, *bound))
    return []


def error_of(worst: float, description: str) -> tuple[float | None, float | None, str]:
    """(error, limit, both relative; remedy) of a margin's smallest value, by its variable's description."""
    found = ERROR.search(description)
    if not found:
        return None, None, ""
    limit = 0.01 * float(found[1])
    return (1.0 - worst) * limit, limit, found[2] or ""


def item_of(margins: Sequence[Margin]) -> Item | None:
    """What margins say to the verdict: invalid where one that decides is negative; None if none decides."""
    worst = min((margin for margin in margins if margin.decides), key=lambda margin: margin.worst, default=None)
    if worst is None:
        return None
    if worst.error is not None and worst.limit is not None:
        percent = f"{100.0 * worst.error:.3g} %, limit {100.0 * worst.limit:.3g} %"
        at = f"{worst.variable} at t = {worst.time:.4g} s: error up to {percent}"
        word: Word = "invalid" if worst.worst < 0.0 else "valid"
        return Item(word, at, worst.error, worst.limit, worst.time, worst.remedy, PREMISES)
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
