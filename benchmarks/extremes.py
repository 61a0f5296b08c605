"""Fitted maxima of some records against 1000 hours of one sea: `python benchmarks/extremes.py [HOURS]`.

Scene `cage_300m` in one sea, head seas, 3 h a record, by an ensemble. All records together tell the quantile of the largest value
of 3 h, from their order alone; each twenty of them are fitted as `towage operability` does, and the share of the fits whose
confidence interval holds that quantile is counted. The heave of the point has a linear response, so that Rayleigh's maxima
(`towage/operability/screening.py`) stand beside it.
"""

from __future__ import annotations

import math
import sys
from typing import NamedTuple

import numpy as np
from scipy.stats import binom

from towage.operability import ensembles
from towage.operability.cells import Cells, cells, headings
from towage.operability.extremes import CONFIDENCE, of_maxima
from towage.operability.scatter import parsed
from towage.operability.screening import screened
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.sweeps.criteria import Criterion
from towage.units.store import locator

HEIGHT, PERIOD = 3.5, 9.0
"""The line nearly goes slack in this sea: quadratic drag decides the peaks."""
LENGTH, TRANSIENT, GROUP, PROBABILITY = 10800.0, 200.0, 20, 0.9
LOOKED_AT = (
    Criterion("ship.heave", True, 5.0, "m"), Criterion("line.tension", True, 310e3, "N"),
    Criterion("line.margin_taut", False, -0.1, "1"), Criterion("cage.velocity", True, 4.2, "m/s"),
)  # fmt: skip
"""Limits that some of the records pass, and not all."""


class Told(NamedTuple):
    """Of one criterion: the quantile by all records, with its binomial interval; mean of the fits, how many of ``groups``
    intervals hold it; the share of all records that pass the limit, and how many intervals hold that; the linear response's
    quantile."""

    name: str
    quantile: float
    low: float
    high: float
    fitted: float
    holding: int
    passed: float
    holding_passed: int
    groups: int
    linear: float


def plan(records: int) -> tuple[Scene, Cells]:
    """The scene, and one cell with so many seeds."""
    scene = Scene.load("cage_300m").setting({"stop_time": LENGTH + TRANSIENT}, "benchmark")
    resolved = described(scene, locator())
    diagram = parsed(f"Hs [m] \\ Tp [s], {PERIOD}\n{HEIGHT}, 1\n")
    return scene, cells(resolved, diagram, headings(["180"]), records, 1, LENGTH)


def told(hours: float, workers: int = 2) -> list[Told]:
    """What the records say."""
    records = GROUP * math.ceil(hours * 3600.0 / LENGTH / GROUP)
    scene, one = plan(records)
    ensemble = ensembles.ensemble_of(scene, one, [c.name for c in LOOKED_AT])
    times = ensembles.times_of(LENGTH, TRANSIENT, ensembles.interval(scene, one))
    rows = [row for batch in ensembles.rows(ensemble, range(records), times, workers) for row in batch or ()]
    rows.sort(key=lambda row: row.index)
    assert all(row.status == "done" for row in rows)
    linear = screened(described(scene, locator()), one, LOOKED_AT, PROBABILITY).outcome
    assert linear
    return [
        _told(
            c, np.array([row.measures[c.measure(row.measures)] for row in rows]), linear.cells[0].extremes[k].quantile
        )
        for k, c in enumerate(LOOKED_AT)
    ]


def _told(one: Criterion, values: np.ndarray, linear: float) -> Told:
    sign = 1.0 if one.upper else -1.0
    ordered, n = np.sort(sign * values), len(values)
    at = [int(binom.ppf(p, n, PROBABILITY)) for p in (0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE)]
    quantile = float(np.quantile(ordered, PROBABILITY))
    low, high = sorted((sign * float(ordered[at[0] - 1]), sign * float(ordered[min(at[1], n - 1)])))
    fits = [of_maxima(group, one.limit, one.upper, PROBABILITY) for group in values.reshape(-1, GROUP)]
    passed = float(np.mean(ordered > sign * one.limit))
    return Told(
        one.name, sign * quantile, low, high, float(np.mean([f.quantile for f in fits])),
        sum(f.low <= sign * quantile <= f.high for f in fits), passed, sum(f.least <= passed <= f.most for f in fits),
        len(fits), linear,
    )  # fmt: skip


def main() -> None:
    """Prints the table."""
    hours = float(sys.argv[1]) if len(sys.argv) > 1 else 1000.0
    print(
        "| | quantile 0.9 of all | its interval | mean of the fits | intervals that hold it | passes | hold that | linear |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for t in told(hours):
        print(
            f"| `{t.name}` | {t.quantile:.5g} | {t.low:.5g} to {t.high:.5g} | {t.fitted:.5g} | {t.holding} of {t.groups} | "
            f"{100.0 * t.passed:.3g} % | {t.holding_passed} of {t.groups} | {t.linear:.5g} |"
        )


if __name__ == "__main__":
    main()
