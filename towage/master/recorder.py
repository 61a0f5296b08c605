"""What a run records: one row of doubles a communication point, kept in memory and in a journal, if one is wanted. The record
of the scene is read off them at its times (`towage.checks.track`); the journal marks the rows next to these times.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from towage.checks.track import SAME_TIME, Track, comparison_times
from towage.result.journal import Journal, Kept
from towage.result.result import Event


class Recorder:
    """Rows of (time, values of all units in order). ``names`` are the columns as unit.variable, ``held`` those of them that
    change at events only. ``interval`` between record times, s; None: every row is recorded."""

    def __init__(
        self, names: Sequence[str], journal: Journal | None = None, interval: float | None = None, held: Iterable[str] = ()
    ) -> None:
        self.names = list(names)
        self.data = array("d")
        self.interval, self.held, self._rows = interval, frozenset(held), 0
        self.journal = journal

    def row(self, time: float, values: Sequence[Sequence[float]]) -> None:
        """Append a row; the journal marks the first one at or after a record time."""
        begin = len(self.data)
        self.data.append(time)
        for part in values:
            self.data.extend(part)
        if self.journal:
            recorded = not self.interval or time >= self._rows * self.interval - SAME_TIME * (1.0 + time)
            if recorded:
                self._count(time)
            self.journal.row(self.data[begin:].tobytes(), recorded)

    def _count(self, time: float) -> None:
        """The next record time is the first after ``time``, s."""
        if self.interval:
            self._rows = int(time / self.interval + SAME_TIME) + 1

    def go_on(self, rows: NDArray[np.float64]) -> None:
        """Begin with the rows of an earlier part of the run, shape (n, 1 + names)."""
        self.data.frombytes(np.ascontiguousarray(rows).tobytes())
        if len(rows):
            self._count(float(rows[-1, 0]))

    def event(self, event: Event) -> None:
        """Keep an event in the journal."""
        if self.journal:
            self.journal.event(event)

    def close(self) -> None:
        """Close the journal."""
        if self.journal:
            self.journal.close()

    def track(self) -> Track:
        """All rows."""
        return Track(*_columns(np.array(self.data), self.names), self.held)

    def columns(self, track: Track | None = None) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        """(times, columns by name) at the record times as far as the run came, out of ``track``, which is `track()`."""
        return recorded(track or self.track(), self.interval)


def recorded(track: Track, interval: float | None) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """(times, columns by name) of a run at its record times, ``interval`` s apart, as far as it came."""
    if not interval or not len(track.time):
        return track.time, dict(track.columns)
    time = comparison_times(float(track.time[-1]), interval)
    return time, {name: track.at(name, time) for name in track.columns}


def record_of(kept: Kept) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """(times, columns by name) of the record that a journal holds."""
    return recorded(Track(*_columns(kept.rows.ravel(), kept.names), kept.held), kept.interval)


def _columns(data: NDArray[np.float64], names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
