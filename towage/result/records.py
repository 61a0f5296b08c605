"""What is said of a run: events, findings of checks, margins, the comparison and the verdict. Nothing heavy is imported."""

from __future__ import annotations

from dataclasses import dataclass
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
    names. A run with a finding of level "refused" is not begun."""

    name: str
    level: Literal["ok", "warning", "refused", "info"]
    value: float | None
    limit: float | None
    message: str


@dataclass(frozen=True)
class Margin:
    """Smallest value of a margin and when, s; 1 at rest, 0 at the limit of validity. ``decides``: it can make a run
    invalid, otherwise it is shown only."""

    variable: str
    worst: float
    time: float
    decides: bool


@dataclass(frozen=True)
class Comparison:
    """The coupled run against the one-way run, which is the assumption of a single degree of freedom.

    ``amplitude``, ``peak_tension``: relative change. ``phase``: change, rad. ``rms`` of the difference over rms of the
    one-way motion. ``indicator`` eps = |D2/D1|, ``bound`` eps/(1 - eps) and the closed form ``estimate`` eps* need no
    coupled run. ``eigenvector`` and ``frequency_shift`` are the thesis's own indicators, which pass wrongly.
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


@dataclass(frozen=True)
class Verdict:
    """The judgement on a run, with the number that decided and its limit."""

    word: Word
    reason: str
    number: float | None
    limit: float | None


NOT_JUDGED = Verdict("not judged", "", None, None)
"""Before a run is judged."""
