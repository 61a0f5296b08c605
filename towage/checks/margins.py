"""What the units say of their own validity: the worst value of every ``margin_*`` at the solver's own points, recorded or not,
and when.

A margin that bounds an error is 1 - error/limit; its unit says so in the variable's description, by `ERROR`, and other
checks add such margins to the result themselves. The card then shows the error.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from towage.checks.check import Cell, Check, Finished, Part
from towage.checks.verdict import GRAVITY
from towage.result.records import Finding, Item, Margin, Word
from towage.units.conventions import has

if TYPE_CHECKING:
    from towage.result.result import Result


PREMISES = "premises"
"""The item on the assumptions of the models."""
ERROR = re.compile(r"1 - error / (\d+(?:\.\d+)?) %.*?(?:; remedy: (.*))?$")
"""The limit and the remedy in the description of a margin that bounds an error
(`towage.models.protocol.variables.error_margin`)."""
ROUGH = "a rough sign"
"""In the description of a margin that is no bound: it decides only where a check has found the error."""


def after(run: Finished) -> list[Finding]:
    """Adds what units say to the result's ``margins``, but where a check has found the error behind one."""
    import numpy as np

    result, shown = run.result, run.scene.scene.checks.report_only
    known = {margin.variable for margin in result.margins}
    for name, values in run.track.columns.items():
        unit, _, variable = name.partition(".")
        stated = variable.startswith("margin_") and has(run.scene.units[unit].description, variable)
        if stated and len(values) and name not in known:
            k = int(np.argmin(values))
            told = run.scene.units[unit].description.by_name()[variable].description
            margin = Margin(name, float(values[k]), float(run.track.time[k]), name not in shown)
            result.margins.append(rough(margin) if ROUGH in told else with_error(margin, told))
    return []


def rough(margin: Margin) -> Margin:
    """The margin, of which neither sign says that the model is right or wrong."""
    reason = f"{margin.variable} is a rough sign, and no check has found the error behind it"
    return replace(margin, word="not judged", reason=reason, remedy="run the unit in a scene of its own")


def with_error(margin: Margin, description: str) -> Margin:
    """The margin with error, limit and remedy, where its variable's description names the error that it bounds."""
    found = ERROR.search(description)
    if not found:
        return margin
    limit = 0.01 * float(found[1])
    return replace(margin, error=(1.0 - margin.worst) * limit, limit=limit, remedy=found[2] or "")


def item_of(margins: Sequence[Margin]) -> Item | None:
    """What margins say to the verdict: the gravest of those that decide, the smallest of equals; None if none decides."""
    deciding = [margin for margin in margins if margin.decides]
    return said(min(deciding, key=lambda margin: (GRAVITY.index(said(margin).word), margin.worst))) if deciding else None


def said(margin: Margin) -> Item:
    """What one margin says: by the error behind it, where that is known, else invalid where it is negative."""
    m = margin
    if m.word:
        return Item(m.word, m.reason, m.error, m.limit, m.time, m.remedy, PREMISES)
    word: Word = "invalid" if m.worst < 0.0 else "valid"
    if m.error is not None and m.limit is not None:
        percent = f"{100.0 * m.error:.3g} %, limit {100.0 * m.limit:.3g} %"
        at = f"{m.variable} at t = {m.time:.4g} s: error up to {percent}"
        return Item(word, at, m.error, m.limit, m.time, m.remedy, PREMISES)
    reason = f"{m.variable} is negative at t = {m.time:.4g} s" if m.worst < 0.0 else f"smallest margin is {m.variable}"
    return Item(word, reason, m.worst, 0.0, m.time, name=PREMISES)


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
