"""What the runs of a study say: a word a cell, limits of the height over the period, and the share of the time that is operable.

A criterion holds in a cell if the extreme that is not passed with the probability asked for (90 %) keeps to its limit; the cell
holds if all criteria do. It is **sure** if no limit lies inside a confidence interval. A cell counts as operable only if its
premises hold: no margin of a unit that decides was negative in any of its runs; a margin that is a criterion decides as one. What
is `invalid` or `not done` is told as a share of its own, never taken for either side.

    limit of Hs: the lowest height at which a criterion no longer holds, on straight lines between quantiles of two heights
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.checks.margins import PREMISES
from towage.checks.tow_names import SMALL
from towage.operability.cells import Cells
from towage.operability.extremes import FEWEST, Extreme, of_maxima
from towage.sweeps.criteria import Criterion
from towage.sweeps.table import Table

Array = NDArray[np.float64]
HOLDS, FAILS, INVALID, NOT_DONE = "holds", "fails", "invalid", "not done"
WORDS = (HOLDS, FAILS, INVALID, NOT_DONE)


@dataclass(frozen=True)
class Cell:
    """A heading, height and period (indices) with its ``share`` of the time at this heading. ``extremes``: one a criterion, none
    where runs are missing. ``margin``: the smallest that decides, with its name. ``reason``: of the word."""

    heading: int
    height: int
    period: int
    share: float
    word: str
    sure: bool
    reason: str
    extremes: tuple[Extreme, ...]
    margin: float
    margin_of: str


class Limit(NamedTuple):
    """Of a heading and a period: the largest significant height, m, up to which the cells hold; ``kind``: "crossing" of the
    ``criterion`` with this text, "below" the lowest height, "above" the highest one, or "premises": beyond, cells are invalid or
    not done."""

    heading: int
    period: int
    height: float
    kind: str
    criterion: str


class Uptime(NamedTuple):
    """Shares of the time: operable (``holds``), of which ``sure``; ``open``: cells that fail and would be operable
    at the other end of a confidence interval; ``invalid`` and ``not_done`` are counted on no side."""

    holds: float
    sure: float
    open: float
    invalid: float
    not_done: float

    @property
    def most(self) -> float:
        """Operable if every open cell were."""
        return self.holds + self.open


@dataclass(frozen=True)
class Outcome:
    """``cells`` of all headings, mirrors included, in the order of the diagram's columns."""

    plan: Cells
    criteria: tuple[Criterion, ...]
    probability: float
    cells: tuple[Cell, ...]

    @cached_property
    def by_place(self) -> dict[tuple[int, int, int], Cell]:
        """Cells by heading, height and period."""
        return {(c.heading, c.height, c.period): c for c in self.cells}

    def uptime(self, weights: Array, heading: int | None = None) -> Uptime:
        """With ``weights`` of the seas, shape (heights, periods), adding to 1, at one heading or at all."""
        shares, sums = self.plan.headings.shares, dict.fromkeys(("holds", "sure", "open", INVALID, NOT_DONE), 0.0)
        for cell in self.cells:
            if heading is not None and cell.heading != heading:
                continue
            weight = float(weights[cell.height, cell.period]) * (1.0 if heading is not None else shares[cell.heading])
            if cell.word in (INVALID, NOT_DONE):
                sums[cell.word] += weight
            elif cell.word == HOLDS:
                sums["holds"] += weight
                sums["sure"] += weight * cell.sure
            elif not cell.sure:
                sums["open"] += weight
        return Uptime(sums["holds"], sums["sure"], sums["open"], sums[INVALID], sums[NOT_DONE])

    @property
    def whole(self) -> Uptime:
        """Of the year and all headings."""
        return self.uptime(self.plan.scatter.share)

    def monthly(self) -> list[tuple[str, Uptime]]:
        """By month, where the diagram has any."""
        scatter = self.plan.scatter
        return [(name, self.uptime(w / w.sum())) for name, w in zip(scatter.months, scatter.weights) if name]

    def limits(self) -> list[Limit]:
        """Of every heading and period."""
        found = []
        for heading in range(len(self.plan.run)):
            for period in range(len(self.plan.peaks)):
                column = [c for c in self.cells if c.heading == heading and c.period == period]
                if column:
                    found.append(self._limit(sorted(column, key=lambda c: c.height)))
        return found

    def _limit(self, column: Sequence[Cell]) -> Limit:
        heights = self.plan.scatter.heights
        before: Cell | None = None
        for cell in column:
            place = (cell.heading, cell.period)
            last = float(heights[before.height]) if before else math.nan
            if cell.word in (INVALID, NOT_DONE):
                return Limit(*place, last, "premises", cell.reason)
            if cell.word == FAILS and before:
                height, which = min(self._crossing(before, cell, k) for k in range(len(self.criteria)))
                return Limit(*place, height, "crossing", self.criteria[which].text)
            if cell.word == FAILS:
                return Limit(*place, float(heights[cell.height]), "below", _worst(self.criteria, cell).text)
            before = cell
        return Limit(column[-1].heading, column[-1].period, float(heights[column[-1].height]), "above", "")

    def _crossing(self, lower: Cell, upper: Cell, k: int) -> tuple[float, int]:
        """Height at which criterion ``k`` stops to hold between two cells, infinite if it does not; and k."""
        one = self.criteria[k]
        a, b = (cell.extremes[k].quantile - one.limit for cell in (lower, upper))
        if one.holds(upper.extremes[k].quantile):
            return math.inf, k
        low, high = (float(self.plan.scatter.heights[cell.height]) for cell in (lower, upper))
        return low + (high - low) * (a / (a - b) if a != b else 0.0), k


def _worst(criteria: Sequence[Criterion], cell: Cell) -> Criterion:
    """The criterion that is passed with the largest probability."""
    passed = [extreme.exceedance for extreme in cell.extremes]
    return criteria[passed.index(max(passed))]


def outcome(
    plan: Cells, table: Table, criteria: Sequence[Criterion], probability: float, report_only: Sequence[str]
) -> Outcome:
    """From the table of all runs. ``report_only``: margins of the scene that are shown and do not decide."""
    named = {one.name for one in criteria}
    margins = {
        name: values for key, values in table.measures.items()
        if (name := key.removeprefix("margin:")) != key
        and name not in named and name not in report_only and not name.endswith(f".{SMALL}")
    }  # fmt: skip
    own = {
        tuple(place): _cell(plan, table, criteria, probability, margins, k)
        for k, place in enumerate(plan.places.tolist())
    }
    cells = []
    for heading, run in enumerate(plan.run):
        for (of, height, period), cell in own.items():
            if of == run:
                cells.append(Cell(heading, height, period, *list(vars(cell).values())[3:]))
    return Outcome(plan, tuple(criteria), probability, tuple(cells))


def _cell(
    plan: Cells, table: Table, criteria: Sequence[Criterion], probability: float, margins: Mapping[str, Array], k: int
) -> Cell:
    """Cell ``k`` of the plan."""
    heading, height, period = plan.places[k].tolist()
    runs = slice(k * plan.seeds, (k + 1) * plan.seeds)
    place = (heading, height, period, float(plan.scatter.share[height, period]))
    kept = [n for n in range(runs.start, runs.stop) if table.status[n] != "spared"]
    lost = [n for n in kept if table.status[n] != "done"]
    if lost or plan.seeds < FEWEST:
        said = f"{len(lost)} of {plan.seeds} runs were not done: {table.message[lost[0]]}" if lost else ""
        return Cell(*place, NOT_DONE, True, said or f"fewer than {FEWEST} seeds", (), math.nan, "")
    smallest = {name: float(values[kept].min()) for name, values in margins.items()}
    worst = min(smallest, key=lambda name: smallest[name], default="")
    margin = smallest.get(worst, math.nan)
    extremes = tuple(
        of_maxima(table.measures[one.measure(table.measures)][kept], one.limit, one.upper, probability)
        for one in criteria
    )
    doubts = [name for name, words in table.words.items() if name != PREMISES and INVALID in words[runs]]
    if margin < 0.0 or doubts:
        reason = f"{worst} = {margin:.3g}" if margin < 0.0 else f"{', '.join(doubts)} invalid in a run"
        return Cell(*place, INVALID, True, reason, extremes, margin, worst)
    failing = [not one.holds(extreme.quantile) for one, extreme in zip(criteria, extremes)]
    settled = [not any(map(one.holds, table.measures[one.measure(table.measures)][kept])) for one in criteria]
    ends = [all(one.holds(x) == one.holds(e.quantile) for x in (e.low, e.high)) for one, e in zip(criteria, extremes)]
    # sure to fail if one criterion is, by the interval or since all runs pass its limit (`early`); sure to hold if all are
    fails = [sure or all_pass for sure, all_pass, fail in zip(ends, settled, failing) if fail or all_pass]
    passed = [one.text for one, fail, all_pass in zip(criteria, failing, settled) if fail or all_pass]
    return Cell(
        *place,
        FAILS if passed else HOLDS,
        any(fails) if passed else all(ends),
        "; ".join(passed),
        extremes,
        margin,
        worst,
    )
