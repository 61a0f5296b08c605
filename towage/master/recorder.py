"""What a run records: one row of doubles a communication point, kept in memory and in a journal, if one is wanted. The record
of the scene is read off them at its times (`towage.checks.track`); the journal marks the rows next to these times.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.checks.track import SAME_TIME, Track, comparison_times
from towage.errors import FileError
from towage.result.journal import Journal, Kept
from towage.result.result import Event
from towage.units.log import Message

if TYPE_CHECKING:
    from towage.master.simulation import Settings
    from towage.master.system import System

Array = NDArray[np.float64]


class Recorder:
    """Rows of (time, values of all units in order). ``names`` are the columns as unit.variable, ``held`` those of them that
    change at events only. ``interval`` between record times, s; None: every row is recorded. ``texts`` are columns of texts,
    of which changes are kept."""

    def __init__(
        self,
        names: Sequence[str],
        journal: Journal | None = None,
        interval: float | None = None,
        held: Iterable[str] = (),
        texts: Sequence[str] = (),
    ) -> None:
        self.names = list(names)
        self.texts: dict[str, list[tuple[float, str]]] = {name: [] for name in texts}
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

    def go_on(self, rows: Array) -> None:
        """Begin with the rows of an earlier part of the run, shape (n, 1 + names)."""
        self.data.frombytes(np.ascontiguousarray(rows).tobytes())
        if len(rows):
            self._count(float(rows[-1, 0]))

    def words(self, time: float, units: Mapping[str, Mapping[str, str | bytes]]) -> None:
        """The texts at a communication point, by unit and variable."""
        for name, changes in self.texts.items():
            unit, _, variable = name.partition(".")
            value = units[unit][variable]
            text = value.hex() if isinstance(value, bytes) else value
            if not changes or changes[-1][1] != text:
                changes.append((time, text))
                if self.journal:
                    self.journal.text(time, name, text)

    def event(self, event: Event) -> None:
        """Keep an event in the journal."""
        if self.journal:
            self.journal.event(event)

    def message(self, message: Message) -> None:
        """Keep what a unit said in the journal."""
        if self.journal:
            self.journal.message(message)

    def close(self) -> None:
        """Close the journal."""
        if self.journal:
            self.journal.close()

    def track(self) -> Track:
        """All rows."""
        return Track(*_columns(np.array(self.data), self.names), self.held)

    def columns(self, track: Track | None = None, records_end: bool = False) -> tuple[Array, dict[str, Array]]:
        """(times, columns by name) at the record times as far as the run came, out of ``track``, which is `track()`;
        ``records_end``: and where it ended."""
        return recorded(track or self.track(), self.interval, records_end)

    def text_columns(self, times: Array) -> dict[str, NDArray[Any]]:
        """The columns of texts at ``times``, s: each keeps its text until the next change."""
        return texts_at(self.texts, times)


def recorded(track: Track, interval: float | None, records_end: bool = False) -> tuple[Array, dict[str, Array]]:
    """(times, columns by name) of a run at its record times, ``interval`` s apart, as far as it came; ``records_end``: and
    where it ended."""
    if not interval or not len(track.time):
        return track.time, dict(track.columns)
    end = float(track.time[-1])
    time = comparison_times(end, interval)
    if records_end and end - time[-1] > SAME_TIME * (1.0 + end):
        time = np.append(time, end)
    return time, {name: track.at(name, time) for name in track.columns}


def record_of(kept: Kept) -> tuple[Array, dict[str, Array]]:
    """(times, columns by name) of the record that a journal holds. Raises `FileError` for one that no memory holds."""
    end = float(np.max(kept.rows[:, 0], initial=0.0))
    wanted = 8.0 * (1 + len(kept.names)) * end / (kept.interval or math.inf)
    if not wanted <= reading.memory():
        raise FileError(f"a journal up to t = {end:g} s with a record every {kept.interval:g} s is none of a run")
    return recorded(Track(*_columns(kept.rows.ravel(), kept.names), kept.held), kept.interval)


def texts_at(texts: Mapping[str, Sequence[tuple[float, str]]], times: Array) -> dict[str, NDArray[Any]]:
    """The columns of ``texts`` at ``times``, s; of each column, from when (s) it has which text."""
    columns = {}
    for name, changes in texts.items():
        if changes:
            begins = np.array([time for time, _ in changes])
            at = np.searchsorted(begins, times + SAME_TIME * (1.0 + np.abs(times)), side="right") - 1
            columns[name] = np.array([text for _, text in changes])[np.maximum(at, 0)]
    return columns


def recorder_of(system: System, settings: Settings) -> Recorder:
    """A recorder of all that the units of a system are read for."""
    names = [f"{unit.name}.{output}" for unit in system.units for output in unit.outputs]
    held = [
        f"{unit.name}.{output}" for unit in system.units for output in unit.outputs
        if (variable := unit.variables.get(output)) and (variable.type != "Real" or variable.variability == "discrete")
    ]  # fmt: skip
    recorded = {f"{unit}.{name}" for unit, name in system.scene.record}
    words = [f"{unit.name}.{name}" for unit in system.units for name in unit.wiring.others.words]
    return Recorder(names, None, settings.record_interval, held, [name for name in words if name in recorded])


def _columns(data: Array, names: list[str]) -> tuple[Array, dict[str, Array]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
