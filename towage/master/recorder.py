"""What a run records: one row of doubles a communication point, kept in memory and in a journal, if one is wanted."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from towage.checks.track import Track
from towage.result.journal import Journal
from towage.result.result import Event


class Recorder:
    """Rows of (time, values of all units in order). ``names`` are the columns as unit.variable; ``recorded`` tells of
    every row whether the scene records it, else it serves comparisons alone."""

    def __init__(self, names: Sequence[str], journal: Journal | None = None) -> None:
        self.names = list(names)
        self.data = array("d")
        self.recorded = array("b")
        self.journal = journal

    def row(self, time: float, values: Sequence[Sequence[float]], recorded: bool = True) -> None:
        """Append a row."""
        begin = len(self.data)
        self.recorded.append(recorded)
        self.data.append(time)
        for part in values:
            self.data.extend(part)
        if self.journal:
            self.journal.row(self.data[begin:].tobytes(), recorded)

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
        return Track(*_columns(np.array(self.data), self.names))

    def columns(self, track: Track | None = None) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        """(times, columns by name) of the rows that the scene records, out of ``track``, which is `track()`."""
        time, columns = track or self.track()
        kept = np.array(self.recorded, dtype=bool)
        if kept.all():
            return time, dict(columns)
        return time[kept], {name: values[kept] for name, values in columns.items()}


def _columns(data: NDArray[np.float64], names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
