"""Cells that fail for certain before all of their runs are done.

If the extreme of a record stayed within a limit with the probability q that is asked for, or a larger one, all of n independent
records would pass the limit with a chance of at most (1 - q)^n. A cell whose first `FEWEST` runs all pass the limit of one
criterion is therefore settled: it fails, and the chance that this is wrong is at most (1 - q)^n a criterion, 1e-5 for 90 % and
five runs, whatever the distribution. Its other runs are spared; cells that hold, or nearly, get all of theirs. Nothing is
concluded from one cell to another, and nothing from the linear response.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from towage.operability.cells import Cells
from towage.operability.extremes import FEWEST
from towage.sweeps.criteria import Criterion
from towage.sweeps.row import Row

CHANCE = 1e-3
"""Of a wrong word, at most: where q is so small that the first runs do not settle as much, no run is spared."""


def first(plan: Cells) -> list[int]:
    """The first runs of all cells."""
    return [k * plan.seeds + n for k in range(len(plan.places)) for n in range(min(FEWEST, plan.seeds))]


def settled(plan: Cells, rows: Mapping[int, Row], criteria: Sequence[Criterion], probability: float) -> set[int]:
    """Runs that need not be done: those after the first ones in cells that fail for certain."""
    if (1.0 - probability) ** FEWEST > CHANCE:
        return set()
    spared: set[int] = set()
    for cell in range(len(plan.places)):
        begin = cell * plan.seeds
        begun = [rows[k] for k in range(begin, begin + FEWEST)]
        if all(row.status == "done" for row in begun) and any(
            not any(one.holds(row.measures[one.measure(row.measures)]) for row in begun) for one in criteria
        ):
            spared |= set(range(begin + FEWEST, begin + plan.seeds))
    return spared
