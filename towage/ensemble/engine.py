"""The compiled code of an ensemble: made once for a text, kept in the cache, and called by several threads."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import platform
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.errors import TowageError
from towage.files import atomic_write
from towage.units.store import cache

if TYPE_CHECKING:
    from towage.fmus.native.ensemble.build import Text

Array = NDArray[np.float64]
DONE = 0
SHARE = 64
"""Members that a thread takes at a time."""


class Computed(NamedTuple):
    """What the code says of each member: ``series``, shape (members, times, columns); ``low`` and ``high``, shape (members,
    outputs), extremes over the times; ``status``, DONE or how it ended, and ``when``, s. ``steps``: how many all members
    tried, those of waiting lanes included."""

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

    def run(self, rows: Array, times: Array, columns: Sequence[int], accuracy: float, threads: int) -> Computed:
        """Run all members: ``rows``, shape (members, parameters and inputs), SI, over ``times``, shape (n,), s, rising.

        ``columns``: positions of the outputs that are wanted as series. ``accuracy``: relative error of a step. The members
        are shared among ``threads``, since the code does not hold Python's lock."""
        rows, times = np.ascontiguousarray(rows), np.ascontiguousarray(times)
        n, chosen = len(rows), np.array(columns, np.int64)
        series = np.empty((n, len(times), len(columns)))
        low, high = np.empty((n, self._width)), np.empty((n, self._width))
        status, when = np.zeros(n, np.int64), np.zeros(n)

        def share(first: int) -> int:
            """Some members, from ``first`` on; the steps that they tried."""
            part = slice(first, min(n, first + SHARE))
            steps: int = self._library.run(
                part.stop - first, _at(rows[part]), len(times), _at(times), accuracy, len(columns), _at(chosen),
                _at(series[part]), _at(low[part]), _at(high[part]), _at(status[part]), _at(when[part]),
            )  # fmt: skip
            if steps < 0:
                raise TowageError("there is no memory for the members of an ensemble: ask for fewer threads")
            return steps

        with ThreadPoolExecutor(threads) as pool:
            steps = sum(pool.map(share, range(0, n, SHARE)))
        return Computed(series, low, high, status, when, steps * self._library.lanes())


def _library(text: Text) -> ctypes.CDLL:
    """The compiled text, from the cache if it is there."""
    from towage.fmus.native.compiler import compiler, host
    from towage.fmus.native.ensemble.build import FLAGS, library, sources_of
    from towage.fmus.native.kernels import kernels_source

    command = compiler(host())
    digest = hashlib.sha256("\0".join((text.text, *FLAGS, *command, _version(*command), _machine())).encode())
    for path in sources_of(text):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    digest.update(kernels_source(text.traced.kernels).encode())
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
    library = ctypes.CDLL(str(place))
    pointer, number, whole = ctypes.c_void_p, ctypes.c_double, ctypes.c_long
    library.run.argtypes = [whole, pointer, whole, pointer, number, whole, *[pointer] * 6]
    library.run.restype = library.lanes.restype = whole
    return library


@functools.cache
def _version(*command: str) -> str:
    """What the compiler says of its version."""
    asked = subprocess.run([*command, "--version"], capture_output=True, text=True, timeout=60, check=False)
    return asked.stdout


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
