"""What a run records: one row of doubles a communication point, kept in memory, and those that the scene records in a
journal file, if wanted.

A row of the journal is handed to the operating system at once (2 us), so that the journal is complete up to the point
at which a process dies. Events go to a file beside it, one JSON object a line.
"""

from __future__ import annotations

import json
from array import array
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from towage.checks.track import Track
from towage.result.result import Event
from towage.units.log import Message

if TYPE_CHECKING:
    from towage.master.system import System

EVENTS = ".events"
"""Suffix of the file with the events of a journal."""
LOG = ".log"
"""Suffix of the file with what its units said."""


class Recorder:
    """Rows of (time, values of all units in order). ``names`` are the columns as unit.variable; ``recorded`` tells of
    every row whether the scene records it, else it serves comparisons alone. ``texts`` are columns of texts, of which changes
    are kept."""

    def __init__(self, names: Sequence[str], journal: Path | None = None, texts: Sequence[str] = ()) -> None:
        self.names = list(names)
        self.texts: dict[str, list[tuple[int, str]]] = {name: [] for name in texts}
        self.data = array("d")
        self.recorded = array("b")
        self._file = open(journal, "wb", buffering=0) if journal else None  # noqa: SIM115
        self._events = journal.with_suffix(EVENTS) if journal else None
        self._log = journal.with_suffix(LOG) if journal else None
        if self._file:
            self._file.write(json.dumps(self.names).encode() + b"\n")

    def row(self, time: float, values: Sequence[Sequence[float]], recorded: bool = True) -> None:
        """Append a row."""
        begin = len(self.data)
        self.recorded.append(recorded)
        self.data.append(time)
        for part in values:
            self.data.extend(part)
        if self._file and recorded:
            try:
                self._file.write(self.data[begin:])
            except OSError:  # a full disk costs the journal, not the run
                self.close()

    def words(self, units: Mapping[str, Mapping[str, str | bytes]]) -> None:
        """The texts of the row that was appended last, by unit and variable."""
        for name, changes in self.texts.items():
            unit, _, variable = name.partition(".")
            value = units[unit][variable]
            text = value.hex() if isinstance(value, bytes) else value
            if not changes or changes[-1][1] != text:
                changes.append((len(self.recorded) - 1, text))

    def event(self, event: Event) -> None:
        """Keep an event in the journal."""
        _append(self._events, vars(event))

    def message(self, message: Message) -> None:
        """Keep what a unit said in the journal."""
        _append(self._log, message._asdict())

    def close(self) -> None:
        """Close the journal."""
        if self._file:
            self._file.close()
            self._file = None

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


    def text_columns(self) -> dict[str, NDArray[Any]]:
        """The columns of texts at the rows that the scene records."""
        kept = np.flatnonzero(np.array(self.recorded, dtype=bool))
        made = {}
        for name, changes in self.texts.items():
            if changes:
                at = np.searchsorted([row for row, _ in changes], kept, side="right") - 1
                made[name] = np.array([text for _, text in changes])[at]
        return made


def recorder_of(system: System, journal: Path | None = None) -> Recorder:
    """A recorder of all that the units of a system are read for."""
    names = [f"{unit.name}.{output}" for unit in system.units for output in unit.outputs]
    recorded = {f"{unit}.{name}" for unit, name in system.scene.record}
    words = [f"{unit.name}.{name}" for unit in system.units for name in unit.wiring.others.words]
    return Recorder(names, journal, [name for name in words if name in recorded])


def _append(path: Path | None, record: Mapping[str, Any]) -> None:
    """One JSON object as a line of a file beside the journal, if there is one."""
    if path:
        with suppress(OSError), open(path, "a", encoding="ascii") as file:
            file.write(json.dumps(record) + "\n")


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
    return [Event(**record) for record in _records(path.with_suffix(EVENTS))]


def read_messages(path: Path) -> list[Message]:
    """What the units of a journal's run said, whole lines only."""
    return [Message(**record) for record in _records(path.with_suffix(LOG))]


def _records(path: Path) -> list[dict[str, Any]]:
    try:
        lines = path.read_text("ascii").splitlines(keepends=True)
    except (OSError, ValueError):
        return []
    return [json.loads(line) for line in lines if line.endswith("\n")]


def _columns(data: NDArray[np.float64], names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
