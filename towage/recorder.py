"""What a run records: one row of doubles a point, kept in memory and, if wanted, in a journal file that survives the
process."""

from __future__ import annotations

import json
import os
import time as clock
from array import array
from pathlib import Path
from typing import Sequence

import numpy as np
from numpy.typing import NDArray

FLUSH_SECONDS = 0.2


class Recorder:
    """Rows of (time, values of all units in order). ``names`` are the columns as unit.variable."""

    def __init__(self, names: Sequence[str], journal: Path | None = None) -> None:
        self.names = list(names)
        self.data = array("d")
        self._written = 0
        self._file = open(journal, "wb") if journal else None
        self._flushed = 0.0
        if self._file:
            self._file.write(json.dumps(self.names).encode() + b"\n")
            self._file.flush()

    def row(self, time: float, values: Sequence[Sequence[float]]) -> None:
        """Append a row."""
        data = self.data
        data.append(time)
        for part in values:
            data.extend(part)
        if self._file and clock.monotonic() - self._flushed > FLUSH_SECONDS:
            self.flush()

    def flush(self) -> None:
        """Bring the journal up to date."""
        if self._file:
            self._file.write(self.data[self._written :].tobytes())
            self._file.flush()
            self._written = len(self.data)
            self._flushed = clock.monotonic()

    def close(self) -> None:
        """Flush and close the journal."""
        if self._file:
            self.flush()
            os.fsync(self._file.fileno())
            self._file.close()
            self._file = None

    def columns(self) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        """(times, columns by name)."""
        return _columns(np.array(self.data), self.names)


def read_journal(path: Path) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """What a journal holds, whole rows only; nothing if it was never begun."""
    try:
        header, _, data = path.read_bytes().partition(b"\n")
        names = json.loads(header)
    except (OSError, ValueError):
        return np.empty(0), {}
    return _columns(np.frombuffer(data[: len(data) - len(data) % 8], dtype=np.float64), names)


def _columns(data: NDArray[np.float64], names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    width = len(names) + 1
    rows = data[: len(data) - len(data) % width].reshape(-1, width)
    return rows[:, 0].copy(), {name: rows[:, k + 1].copy() for k, name in enumerate(names)}
