"""Statistics of motions that do not repeat: irregular seas, and chaos, where two runs may differ by a whole amplitude at
every instant and still be the same motion.

Standard deviation and mean of the largest tenth of the crests, of motion and tension, in blocks of at least
``BLOCK_PERIODS`` periods. The logarithm of one-way over coupled is averaged over m blocks; its confidence interval is
Student's, t s/sqrt(m). Runs in the same sea are paired block by block, so that what the sea itself varies cancels. Where the
line goes slack, so do the share of time that it is, and the times a period that it comes to be: rare ones have no ratio, so
that their differences are taken, a share of time or of the periods. The intervals hold together with 95 %: each with
1 - 5 %/`JUDGED` (Bonferroni), for the worst of them decides. They assume that blocks are independent and their values normal,
and are estimates and no bounds.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from towage.checks.check import Cell, Check, Part, Start, System
from towage.result.records import Finding, Item, Statistic, Word

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from towage.result.result import Result

    Array = NDArray[np.float64]

NAME = "length for statistics"
BLOCK_PERIODS = 10
"""Periods of the driver in a block, at least: ten crests have a largest tenth."""
FEWEST_BLOCKS, MOST_BLOCKS = 4, 20
JUDGED = 6
"""Statistics whose intervals have to hold together."""
MINUTE = 60.0
"""s."""
SLACK = 1e-9
"""Tension, over the mean one, of a slack line."""
SHARE = 0.1
"""The largest crests, of which the mean is taken."""


def before(start: Start) -> list[Finding]:
    """How long a run has to be for statistics, and whether this one is: an irregular sea has no other judgement of its own, and
    a regular one needs it in chaos."""
    section, stop = start.scene.scene.checks.get("sdof"), start.scene.scene.stop_time
    if section is None:
        return []
    regular, period = wave(start.system, section.driver)
    periods = FEWEST_BLOCKS * BLOCK_PERIODS
    asks = "in chaos alone, statistics judge" if regular else "statistics judge an irregular sea"
    message = f"{asks}, and take at least {periods} periods of the driver after settling"
    if period is None:
        return [Finding(NAME, "info", None, None, f"{message}; how long one is, the driver does not tell before the run")]
    needed = section.settle + periods * period
    message = f"{message}: a stop_time of {needed:.4g} s; it is {stop:.4g} s"
    if stop >= needed:
        return [Finding(NAME, "ok", stop, needed, message)]
    return [Finding(NAME, "info" if regular else "warning", stop, needed, message, f"stop_time >= {needed:.4g} s")]


def wave(system: System, driver: str) -> tuple[bool, float | None]:
    """Whether the driver is one wave, and its period (of the peak, for a sea), s, None if its unit does not tell."""
    from towage.models.sea.waves import peak_frequency

    unit = next(unit for unit in system.units if unit.name == driver.partition(".")[0])
    if period := unit.constant("heave_period"):
        return True, period
    height, period = unit.constant("wave_height") or 0.0, unit.constant("wave_period") or 0.0
    if period > 0.0 or height > 0.0:
        return False, 2.0 * math.pi / peak_frequency(height, period)
    return False, None


def statistics(
    time: Array, omega: float, signals: dict[str, tuple[Array, Array]], judged: int = JUDGED
) -> dict[str, Statistic]:
    """Statistics of ``signals``, name to (one-way, coupled), shapes (n,) on ``time`` (s), for a dominant frequency ``omega``,
    rad/s; ``judged``: how many intervals have to hold together. The half width is infinite for less than `FEWEST_BLOCKS`
    blocks."""
    blocks = _blocks(time, omega)
    compared = {}
    for name, (one, two) in signals.items():
        for kind, measure in (("standard deviation", spread), ("largest tenth", largest_tenth)):
            compared[f"{kind} of the {name}"] = _compared(measure, one, two, blocks, judged)
    return compared


def slack_statistics(time: Array, omega: float, one: Array, two: Array, judged: int = JUDGED) -> dict[str, Statistic]:
    """Of the tensions of one-way and coupled run, as `statistics`; nothing where neither goes slack. The number of each
    statistic is that of the coupled run: share of time, events a minute."""
    import numpy as np

    limp1, limp2 = (tension <= SLACK * abs(float(tension.mean())) for tension in (one, two))
    if not (limp1.any() or limp2.any()):
        return {}
    blocks, period = _blocks(time, omega), 2.0 * math.pi / omega
    samples = period / float(time[1] - time[0])

    def onsets(side: NDArray[np.bool_]) -> Array:
        """Times a period that the line comes to be slack, sample by sample."""
        begun: Array = samples * np.append(0.0, ~side[:-1] & side[1:])
        return begun

    return {
        "share of time slack": _difference(limp1.astype(float), limp2.astype(float), blocks, 1.0, judged),
        "times slack a period": _difference(onsets(limp1), onsets(limp2), blocks, MINUTE / period, judged),
    }


def _blocks(time: Array, omega: float) -> int:
    """How many blocks a run is cut into."""
    return min(MOST_BLOCKS, int((time[-1] - time[0]) * omega / (2.0 * math.pi) / BLOCK_PERIODS))


def _difference(one: Array, two: Array, blocks: int, scale: float, judged: int) -> Statistic:
    """The statistic of a difference of means, ``scale`` times that of the coupled run as its number."""
    import numpy as np

    error, number = float(one.mean() - two.mean()), scale * float(two.mean())
    if blocks < FEWEST_BLOCKS:
        return Statistic(error, math.inf, number)
    apart = np.array([float(part.mean()) for part in np.array_split(one - two, blocks)])
    return Statistic(error, student(blocks - 1, judged) * float(apart.std(ddof=1)) / math.sqrt(blocks), number)


def spread(values: Array) -> float:
    """Standard deviation."""
    return float(values.std())


def largest_tenth(values: Array) -> float:
    """Mean of the largest tenth of the crests above the mean, at least one; zero without a crest."""
    import numpy as np

    v = values - values.mean()
    crests = np.sort(v[1:-1][(v[1:-1] >= v[:-2]) & (v[1:-1] > v[2:]) & (v[1:-1] > 0.0)])
    return float(crests[-math.ceil(SHARE * len(crests)) :].mean()) if len(crests) else 0.0


def _compared(measure: Callable[[Array], float], one: Array, two: Array, blocks: int, judged: int) -> Statistic:
    """The statistic from the whole runs where blocks are too few, else from these."""
    import numpy as np

    from towage.checks.signals import relative_change

    whole = measure(one), measure(two)
    error = relative_change(*whole)
    if blocks < FEWEST_BLOCKS:
        return Statistic(error, math.inf, whole[1])
    pairs = [(measure(a), measure(b)) for a, b in zip(np.array_split(one, blocks), np.array_split(two, blocks))]
    if not all(a > 0.0 and b > 0.0 for a, b in pairs):
        return Statistic(error, 0.0 if error == 0.0 else math.inf, whole[1])
    logs = np.log([a / b for a, b in pairs])
    half = student(blocks - 1, judged) * float(logs.std(ddof=1)) / math.sqrt(blocks)
    return Statistic(math.expm1(float(logs.mean())), math.expm1(half), whole[1])


def student(freedom: int, judged: int) -> float:
    """Point of Student's distribution beyond which, on both sides, 5 %/``judged`` lie."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 1.0 - 0.025 / judged))


def word_of(statistic: Statistic, tolerance: float) -> Word:
    """Valid or invalid where the whole interval lies on one side of the tolerance, else not judged."""
    size = abs(statistic.error)
    if size + statistic.half_width <= tolerance:
        return "valid"
    return "invalid" if size - statistic.half_width > tolerance else "not judged"


def deciding(statistics: Mapping[str, Statistic], tolerance: float) -> tuple[str, Statistic]:
    """The statistic that decides: of the gravest word, the farthest out."""
    order = ("valid", "not judged", "invalid")
    return max(
        statistics.items(),
        key=lambda item: (order.index(word_of(item[1], tolerance)), abs(item[1].error) + item[1].half_width),
    )


def item(result: Result) -> Item | None:
    """The word of the statistics, with the length that would do where they are too uncertain."""
    c = result.comparison
    if not c or not c.statistics:
        return None
    name, statistic = deciding(c.statistics, c.tolerance)
    word = word_of(statistic, c.tolerance)
    chaos = "chaotic, a start 1e-9 apart drifts away: " if c.chaotic else ""
    interval = f"{100.0 * statistic.error:+.2g} % +- {100.0 * statistic.half_width:.2g} %"
    reason = f"{chaos}{name} of the one-way run against the coupled run, {interval}"
    remedy = "" if word == "valid" else longer(statistic, c.tolerance, float(result.time[-1]))
    if word == "invalid":
        remedy = "model both ways"
    return Item(word, reason, abs(statistic.error) + statistic.half_width, c.tolerance, None, remedy, "statistics")


def longer(statistic: Statistic, tolerance: float, length: float) -> str:
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
        (name, Cell(s.number), Cell(s.error, "%", True), Cell(s.half_width, "%"), word_of(s, c.tolerance))
        for name, s in c.statistics.items()
    ]
    head = ("Statistic", "Coupled run, SI", "Error of the one-way run", "Half the interval", "Word")
    note = (
        "The intervals hold together with 95 %. Of slack the number is the share of time and the events a minute, and the error "
        "the difference of shares, of time and of the periods."
    )
    return [Part("Statistics of motions that do not repeat", head, tuple(rows), note=note)]


CHECK = Check(
    name="statistics",
    description="Do the statistics of motions agree that do not repeat?",
    before=before,
    item=item,
    report=report,
)
