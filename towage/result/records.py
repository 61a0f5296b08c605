"""What is said of a run: events, findings of checks, margins, the comparison and the verdict. Nothing heavy is imported."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Word = Literal["valid", "marginal", "invalid", "not judged"]


@dataclass(frozen=True)
class Event:
    """A change of branch at ``time``, s: ``name`` as in ``event_<name>``; ``direction`` is the sign after the zero
    crossing (+1 rising, -1 falling), 0 for an event in time."""

    time: float
    unit: str
    name: str
    direction: int


@dataclass(frozen=True)
class Finding:
    """What a check found before or after a run; ``value`` and ``limit`` where there are any, in the unit that ``message``
    names; ``remedy``: what can be done about it. A run with a finding of level "refused" is not begun."""

    name: str
    level: Literal["ok", "warning", "refused", "info"]
    value: float | None
    limit: float | None
    message: str
    remedy: str = ""


@dataclass(frozen=True)
class Margin:
    """Smallest value of a margin and when, s; 1 at rest, 0 at the limit of validity. ``decides``: it can make a run
    invalid, otherwise it is shown only. A margin that bounds an error is 1 - error/limit: ``error`` and ``limit`` are
    relative, None of others; ``remedy``: what can be done where it is negative. A check may give it a ``word`` with its
    ``reason``; else the sign of ``worst`` tells."""

    variable: str
    worst: float
    time: float
    decides: bool
    word: Word | Literal[""] = ""
    reason: str = ""
    error: float | None = None
    limit: float | None = None
    remedy: str = ""


@dataclass(frozen=True)
class Comparison:
    """The coupled run against the one-way run, which is the assumption of a single degree of freedom.

    ``amplitude``, ``peak_tension``: relative change. ``phase``: change, rad. ``rms`` of the difference over rms of the
    one-way motion. ``indicator`` eps, ``bound`` eps/(1 - eps) and the closed form ``estimate`` eps* need no
    coupled run. ``eigenvector`` and ``frequency_shift`` are the thesis's own indicators, which pass wrongly.
    ``tension_rms``: as rms, of the tension. ``periods``: the one-way motion repeats after so many periods of its driver, 0
    if it does not. ``chaotic``: two one-way runs that begin 1e-9 apart drift away from one another; amplitude, peak tension
    and both rms then decide nothing. ``statistics``: quantity to its `Statistic`, where motions do not repeat.
    """

    tolerance: float
    amplitude: float
    phase: float
    peak_tension: float
    rms: float
    indicator: float | None
    bound: float | None
    estimate: float | None
    eigenvector: float | None
    frequency_shift: float | None
    word: str
    tension_rms: float = 0.0
    periods: int = 0
    chaotic: bool = False
    statistics: dict[str, Statistic] = field(default_factory=dict)


@dataclass(frozen=True)
class Statistic:
    """Error of a statistic of the one-way run, relative or of a share, and half the width of its confidence interval;
    ``number``: the statistic itself in the coupled run, SI, None where it is not known."""

    error: float
    half_width: float
    number: float | None = None


@dataclass(frozen=True)
class Item:
    """What one check says to the verdict: its word, why, the number that decided with its limit, and where they are known
    the time of that number (s) and what can be done about it. An item that does not ``decide`` is shown only."""

    word: Word
    reason: str
    number: float | None
    limit: float | None
    time: float | None = None
    remedy: str = ""
    name: str = ""
    decides: bool = True


@dataclass(frozen=True)
class Verdict:
    """The judgement on a run: the gravest of its ``items``, with the number that decided, its limit, its time (s) and the
    remedy, where there are any."""

    word: Word
    reason: str
    number: float | None
    limit: float | None
    time: float | None = None
    remedy: str = ""
    items: tuple[Item, ...] = ()


NOT_JUDGED = Verdict("not judged", "", None, None)
"""Before a run is judged."""
