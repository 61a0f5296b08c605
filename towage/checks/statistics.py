"""Statistics of motions that do not repeat: irregular seas, and chaos, where two runs may differ by a whole amplitude at
every instant and still be the same motion.

Standard deviation and mean of the largest tenth of the crests, of motion and tension, in blocks of at least
``BLOCK_PERIODS`` periods. The logarithm of one-way over coupled is averaged over m blocks; its confidence interval (95 %) is
Student's, t s/sqrt(m). Runs in the same sea are paired block by block, so that what the sea itself varies cancels. The
interval assumes that blocks are independent and their logarithms normal: it is an estimate and no bound.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from towage.checks.check import Cell, Check, Part
from towage.result.records import Comparison, Item, Statistic, Word

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from towage.result.result import Result

    Array = NDArray[np.float64]

BLOCK_PERIODS = 10
"""Periods of the driver in a block, at least: ten crests have a largest tenth."""
FEWEST_BLOCKS, MOST_BLOCKS = 4, 20
SHARE = 0.1
"""The largest crests, of which the mean is taken."""


def statistics(time: Array, omega: float, signals: dict[str, tuple[Array, Array]]) -> dict[str, Statistic]:
    """Statistics of ``signals``, name to (one-way, coupled), shapes (n,) on ``time`` (s), for a dominant frequency ``omega``,
    rad/s. The half width is infinite for less than `FEWEST_BLOCKS` blocks."""
    periods = (time[-1] - time[0]) * omega / (2.0 * math.pi)
    blocks = min(MOST_BLOCKS, int(periods / BLOCK_PERIODS))
    compared = {}
    for name, (one, two) in signals.items():
        for kind, measure in (("standard deviation", spread), ("largest tenth", largest_tenth)):
            compared[f"{kind} of the {name}"] = _compared(measure, one, two, blocks)
    return compared


def spread(values: Array) -> float:
    """Standard deviation."""
    return float(values.std())


def largest_tenth(values: Array) -> float:
    """Mean of the largest tenth of the crests above the mean, at least one; zero without a crest."""
    import numpy as np

    v = values - values.mean()
    crests = np.sort(v[1:-1][(v[1:-1] >= v[:-2]) & (v[1:-1] > v[2:]) & (v[1:-1] > 0.0)])
    return float(crests[-math.ceil(SHARE * len(crests)) :].mean()) if len(crests) else 0.0


def _compared(measure: Callable[[Array], float], one: Array, two: Array, blocks: int) -> Statistic:
    """The statistic from the whole runs where blocks are too few, else from these."""
    import numpy as np

    from towage.checks.signals import relative_change

    whole = measure(one), measure(two)
    error = relative_change(*whole)
    if blocks < FEWEST_BLOCKS:
        return Statistic(error, math.inf)
    pairs = [(measure(a), measure(b)) for a, b in zip(np.array_split(one, blocks), np.array_split(two, blocks))]
    if not all(a > 0.0 and b > 0.0 for a, b in pairs):
        return Statistic(error, 0.0 if error == 0.0 else math.inf)
    logs = np.log([a / b for a, b in pairs])
    half = student(blocks - 1) * float(logs.std(ddof=1)) / math.sqrt(blocks)
    return Statistic(math.expm1(float(logs.mean())), math.expm1(half))


def student(freedom: int) -> float:
    """97.5 % point of Student's distribution."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.975))


def word_of(statistic: Statistic, tolerance: float) -> Word:
    """Valid or invalid where the whole interval lies on one side of the tolerance, else not judged."""
    size = abs(statistic.error)
    if size + statistic.half_width <= tolerance:
        return "valid"
    return "invalid" if size - statistic.half_width > tolerance else "not judged"


def deciding(c: Comparison) -> tuple[str, Statistic]:
    """The statistic that decides: of the gravest word, the farthest out."""
    order = ("valid", "not judged", "invalid")
    return max(
        c.statistics.items(),
        key=lambda item: (order.index(word_of(item[1], c.tolerance)), abs(item[1].error) + item[1].half_width),
    )


def item(result: Result) -> Item | None:
    """The word of the statistics, with the length that would do where they are too uncertain."""
    c = result.comparison
    if not c or not c.statistics:
        return None
    name, statistic = deciding(c)
    word = word_of(statistic, c.tolerance)
    chaos = "chaotic, a start 1e-9 apart drifts away: " if c.chaotic else ""
    interval = f"{100.0 * statistic.error:+.2g} % +- {100.0 * statistic.half_width:.2g} %"
    reason = f"{chaos}{name} of the one-way run against the coupled run, {interval}"
    remedy = "" if word == "valid" else _longer(statistic, c.tolerance, float(result.time[-1]))
    if word == "invalid":
        remedy = "model both ways"
    return Item(word, reason, abs(statistic.error) + statistic.half_width, c.tolerance, None, remedy, "statistics")


def _longer(statistic: Statistic, tolerance: float, length: float) -> str:
    """How long a run would tell, if the interval narrows with the root of the length."""
    room = abs(tolerance - abs(statistic.error))
    if not math.isfinite(statistic.half_width):
        return f"compare at least {FEWEST_BLOCKS * BLOCK_PERIODS} periods after settling"
    if not room or (factor := (statistic.half_width / room) ** 2) > 1000.0:
        return "no run of sensible length tells: the error lies at the tolerance"
    return f"run {length * max(factor - 1.0, 0.1):.3g} s longer"


def report(result: Result) -> list[Part]:
    """The statistics with their intervals."""
    c = result.comparison
    if not c or not c.statistics:
        return []
    rows = [
        (name, Cell(s.error, "%", True), Cell(s.half_width, "%"), word_of(s, c.tolerance)) for name, s in c.statistics.items()
    ]
    head = ("Statistic", "Error of the one-way run", "Half the 95 % interval", "Word")
    return [Part("Statistics of motions that do not repeat", head, tuple(rows))]


CHECK = Check(
    name="statistics",
    description="Do the statistics of motions agree that do not repeat?",
    item=item,
    report=report,
)
