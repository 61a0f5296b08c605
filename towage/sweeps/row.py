"""What a sweep keeps of a run: a word, a verdict and numbers that do not depend on when or where it was run.

Names of the numbers: ``sdof:rms`` and the other measures of the comparison with the one-way run, ``item:<name>`` (the number
that decided of each item of the card), ``statistics:<name>`` (error of a statistic) and ``interval:<name>`` (half the width of
its confidence interval), ``margin:<variable>``
(smallest value) and ``worst_margin``, ``min:<variable>``, ``max:<variable>``, ``events:<unit>.<name>`` (how many),
``coupling_error`` (the largest), ``attractor`` (periods after which the motion repeats, `attractor`).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from towage.result.result import Result
from towage.scene.resolve import ResolvedScene
from towage.sweeps.attractor import repeats_after

Status = Literal["done", "failed", "refused", "crashed", "hung", "defect", "spared"]
_COMPARISON = ("rms", "tension_rms", "amplitude", "phase", "peak_tension", "indicator", "bound", "estimate")


@dataclass(frozen=True)
class Row:
    """One run. ``status``: done; failed (a unit said so, or a value was not finite); refused (the values do not fit the
    scene or the checks before the run); crashed or hung with its process; defect (of towage); spared (a study that
    did without it). ``measures``: numbers
    by the names above, in the units of their variables. ``words``: those of the card's items, by their names. ``note``: the
    stack or what was printed, for a reader; it goes to the journal only, because two crashes of one run need not print the
    same."""

    index: int
    status: Status
    verdict: str = "not judged"
    message: str = ""
    measures: dict[str, float] = field(default_factory=dict)
    note: str = ""
    words: dict[str, str] = field(default_factory=dict)


def row(index: int, result: Result, resolved: ResolvedScene, since: float = 0.0) -> Row:
    """The row of a run that came to its end. ``since``: s, before which no extremes are taken of what is recorded."""
    if result.status == "failed":
        return Row(index, "failed", message=result.message)
    words: dict[str, str] = {item.name: item.word for item in result.verdict.items}
    return Row(
        index, "done", result.verdict.word, result.verdict.reason, _measures(result, resolved, since), words=words
    )


def _measures(result: Result, resolved: ResolvedScene, since: float) -> dict[str, float]:
    measures: dict[str, float | None] = {}
    if result.comparison:
        measures |= {f"sdof:{name}": vars(result.comparison)[name] for name in _COMPARISON}
        told = result.comparison.statistics
        measures |= {f"statistics:{name}": statistic.error for name, statistic in told.items()}
        measures |= {f"interval:{name}": statistic.half_width for name, statistic in told.items()}
    measures |= {f"item:{item.name}": item.number for item in result.verdict.items}
    if worst := result.worst_margin():
        measures["worst_margin"] = worst.worst
    measures |= {f"margin:{margin.variable}": margin.worst for margin in result.margins}
    margins = {margin.variable for margin in result.margins}
    kept = result.time >= since
    for name, values in ((name, column[kept]) for name, column in result.columns.items()):
        if name in margins and since > 0.0 and np.isfinite(values).any():
            measures[f"margin:{name}"] = float(np.nanmin(values))
        if name not in margins and np.isfinite(values).any():
            measures[f"min:{name}"], measures[f"max:{name}"] = float(np.nanmin(values)), float(np.nanmax(values))
    measures |= {f"events:{name}": float(n) for name, n in Counter(f"{e.unit}.{e.name}" for e in result.events).items()}
    if error := result.worst_coupling_error():
        measures["coupling_error"] = error[1]
    measures["attractor"] = _attractor(result, resolved)
    return {name: float(value) for name, value in measures.items() if value is not None}


def _attractor(result: Result, resolved: ResolvedScene) -> float | None:
    """Periods after which the motion of the SDOF check repeats; None where the scene has no such check, or its driver no
    parameter ``heave_period``."""
    check = resolved.scene.checks.get("sdof")
    if not check or check.motion not in result.columns:
        return None
    driver = resolved.units[check.driver.partition(".")[0]]
    variable = driver.description.by_name().get("heave_period")
    period = driver.parameters.get("heave_period", variable.start if variable else None)
    if not isinstance(period, float) or period <= 0.0:
        return None
    return repeats_after(result.time, result[check.motion], period)
