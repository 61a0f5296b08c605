"""The compiled code of an ensemble: made once for a text, kept in the cache, and called by several threads."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import platform
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.errors import TowageError
from towage.process.files import atomic_write
from towage.units.store import cache

if TYPE_CHECKING:
    from towage.fmus.native.ensemble.build import Text

Array = NDArray[np.float64]
DONE = 0
SHARE = 64
"""Members that a thread takes at a time."""


class Found(NamedTuple):
    """What the code says of each member: ``series`` (member, time, column), ``low`` and ``high`` (member, output), how it
    ended and at what time, s. ``steps`` that all of them tried, those of waiting lanes included."""

    series: Array
    low: Array
    high: Array
    status: NDArray[np.int64]
    when: Array
    steps: int


class Engine:
    """The code of one text. Raises `CompileError` where it cannot be compiled, `TowageError` where it cannot be kept."""

    def __init__(self, text: Text) -> None:
        self._width = len(text.observed)
        self._library = _library(text)

    def run(self, rows: Array, times: Array, columns: Sequence[int], accuracy: float, threads: int) -> Found:
        """All members, one a row of parameters and inputs, shared among threads: the code holds no lock of Python's.
        ``columns``: the outputs that are wanted as series."""
        rows, times = np.ascontiguousarray(rows), np.ascontiguousarray(times)
        n, chosen = len(rows), np.array(columns, np.int64)
        series = np.empty((n, len(times), len(columns)))
        low, high = np.empty((n, self._width)), np.empty((n, self._width))
        status, when = np.zeros(n, np.int64), np.zeros(n)

        def share(first: int) -> int:
            part = slice(first, min(n, first + SHARE))
            steps: int = self._library.run(
                part.stop - first, _at(rows[part]), len(times), _at(times), accuracy, len(columns), _at(chosen),
                _at(series[part]), _at(low[part]), _at(high[part]), _at(status[part]), _at(when[part]),
            )  # fmt: skip
            return steps

        with ThreadPoolExecutor(threads) as pool:
            steps = sum(pool.map(share, range(0, n, SHARE)))
        return Found(series, low, high, status, when, steps * self._library.lanes())


def _library(text: Text) -> ctypes.CDLL:
    """The compiled text, from the cache if it is there."""
    from towage.fmus.native.ensemble.build import FLAGS, SOURCES, library

    digest = hashlib.sha256("\0".join((text.text, *FLAGS, _machine())).encode())
    for path in sorted(SOURCES.iterdir()):
        digest.update(path.read_bytes())
    place = cache() / "ensemble" / f"{digest.hexdigest()[:24]}.so"
    if not place.is_file():
        built = library(text)
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            with atomic_write(place) as stream:
                stream.write(built)
        except OSError as error:
            raise TowageError(
                f"cannot write {place}: {error.strerror or error}; TOWAGE_CACHE names another place"
            ) from error
    return _loaded(place)


@functools.cache
def _loaded(place: Path) -> ctypes.CDLL:
    found = ctypes.CDLL(str(place))
    pointer, number, whole = ctypes.c_void_p, ctypes.c_double, ctypes.c_long
    found.run.argtypes = [whole, pointer, whole, pointer, number, whole, *[pointer] * 6]
    found.run.restype = found.lanes.restype = whole
    return found


def _machine() -> str:
    """What -march=native means here: the processor's flags where the system tells, else its name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    return next(
        (line for line in lines if line.startswith(("flags", "Features"))), platform.processor() or platform.machine()
    )


def _at(values: NDArray[np.float64] | NDArray[np.int64]) -> int:
    """Where an array is. A slice of rows of a contiguous array is contiguous."""
    return values.ctypes.data
