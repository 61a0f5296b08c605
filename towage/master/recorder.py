"""What a run records: one row of doubles a communication point, kept in memory, and those next to the record times in a
journal file, if wanted. The record of the scene is read off them at its times (`towage.checks.track`).

A row of the journal is handed to the operating system at once (2 us), so that the journal is complete up to the point
at which a process dies. Events go to a file beside it, one JSON object a line.
"""

from __future__ import annotations

import json
from array import array
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage.checks.track import SAME_TIME, Track, comparison_times
from towage.result.result import Event

EVENTS = ".events"
"""Suffix of the file with the events of a journal."""


class Recorder:
    """Rows of (time, values of all units in order). ``names`` are the columns as unit.variable, ``held`` those of them that
    change at events only. ``interval`` between record times, s; None: every row is recorded."""

    def __init__(
        self, names: Sequence[str], journal: Path | None = None, interval: float | None = None, held: Iterable[str] = ()
    ) -> None:
        self.names = list(names)
        self.data = array("d")
        self._interval, self._held, self._rows = interval, frozenset(held), 0
        self._file = open(journal, "wb", buffering=0) if journal else None  # noqa: SIM115
        self._events = journal.with_suffix(EVENTS) if journal else None
        if self._file:
            self._file.write(json.dumps(self.names).encode() + b"\n")

    def row(self, time: float, values: Sequence[Sequence[float]]) -> None:
        """Append a row; the first one at or after a record time goes to the journal too."""
        begin = len(self.data)
        self.data.append(time)
        for part in values:
            self.data.extend(part)
        if self._file and (not self._interval or time >= self._rows * self._interval - SAME_TIME * (1.0 + time)):
            if self._interval:
                self._rows = int(time / self._interval + SAME_TIME) + 1
            try:
                self._file.write(self.data[begin:])
            except OSError:  # a full disk costs the journal, not the run
                self.close()

    def event(self, event: Event) -> None:
        """Keep an event in the journal."""
        if self._events:
            with suppress(OSError), open(self._events, "a", encoding="ascii") as file:
                file.write(json.dumps(vars(event)) + "\n")

    def close(self) -> None:
        """Close the journal."""
        if self._file:
            self._file.close()
            self._file = None

    def track(self) -> Track:
        """All rows."""
        return Track(*_columns(np.array(self.data), self.names), self._held)

    def columns(self, track: Track | None = None) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        """(times, columns by name) at the record times as far as the run came, out of ``track``, which is `track()`."""
        track = track or self.track()
        if not self._interval or not len(track.time):
            return track.time, dict(track.columns)
        time = comparison_times(float(track.time[-1]), self._interval)
        return time, {name: track.at(name, time) for name in track.columns}


def read_journal(path: Path) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """What a journal holds, whole rows only; nothing if it was never begun."""
    try:
        header, _, data = path.read_bytes().partition(b"\n")
        names = json.loads(header)
    except (OSError, ValueError):
        return np.empty(0), {}
    return _columns(np.frombuffer(data[: len(data) - len(data) % 8], dtype=np.float64), names)


def read_events(path: Path) -> list[Event]:
    """The events of a journal, whole lines only."""
    try:
        lines = path.with_suffix(EVENTS).read_text("ascii").splitlines(keepends=True)
    except (OSError, ValueError):
        return []
    return [Event(**json.loads(line)) for line in lines if line.endswith("\n")]


def _columns(data: NDArray[np.float64], names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
