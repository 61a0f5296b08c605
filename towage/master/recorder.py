"""What a run records: one row of doubles a communication point, kept in memory and in a journal, if one is wanted. The record
of the scene is read off them at its times (`towage.checks.track`); the journal marks the rows next to these times.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from towage.checks.track import SAME_TIME, Track, comparison_times
from towage.result.journal import Journal, texts_at
from towage.result.result import Event
from towage.units.log import Message

if TYPE_CHECKING:
    from towage.master.simulation import Settings
    from towage.master.system import System


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
        self._interval, self._held, self._rows = interval, frozenset(held), 0
        self.journal = journal

    def row(self, time: float, values: Sequence[Sequence[float]]) -> None:
        """Append a row; the journal marks the first one at or after a record time."""
        begin = len(self.data)
        self.data.append(time)
        for part in values:
            self.data.extend(part)
        if self.journal:
            recorded = not self._interval or time >= self._rows * self._interval - SAME_TIME * (1.0 + time)
            if recorded:
                self._count(time)
            self.journal.row(self.data[begin:].tobytes(), recorded)

    def _count(self, time: float) -> None:
        """The next record time is the first after ``time``, s."""
        if self._interval:
            self._rows = int(time / self._interval + SAME_TIME) + 1

    def go_on(self, rows: NDArray[np.float64]) -> None:
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
        return Track(*_columns(np.array(self.data), self.names), self._held)

    def columns(
        self, track: Track | None = None, records_end: bool = False
    ) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        """(times, columns by name) at the record times as far as the run came, out of ``track``, which is `track()`;
        ``records_end``: and where it ended."""
        track = track or self.track()
        if not self._interval or not len(track.time):
            return track.time, dict(track.columns)
        time, end = comparison_times(float(track.time[-1]), self._interval), float(track.time[-1])
        if records_end and end - time[-1] > SAME_TIME * (1.0 + end):
            time = np.append(time, end)
        return time, {name: track.at(name, time) for name in track.columns}

    def text_columns(self, times: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
        """The columns of texts at ``times``, s: each keeps its text until the next change."""
        return {name: column for name, changes in self.texts.items() if (column := texts_at(changes, times)) is not None}


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


def _columns(data: NDArray[np.float64], names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
