"""The solver's own points of a run: every communication point, whatever the scene records.

Comparisons are made on them, and the record is read off them, so that ``record.interval`` changes nothing but what is kept.
Between two points a signal is the cubic of both values and both rates, where the unit tells its rate (``<output>_rate``), else
slopes of parabolas through three points. At an event the time stands twice, with the limits from the left and from the
right, and no cubic reaches over it; an output that changes at events only keeps its value until the next point.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FEWEST = 2000
"""Times of a comparison under error control, at least."""
SAME_TIME = 1e-9
"""Times closer than this, relative to 1 s + their size, are one: k h is not exactly the time."""


class Track(NamedTuple):
    """``time`` of every communication point, s, not decreasing, shape (n,); ``columns``: every observed output, shape (n,);
    ``held``: those that change at events only."""

    time: Array
    columns: Mapping[str, Array]
    held: frozenset[str] = frozenset()

    def at(self, name: str, times: Array) -> Array:
        """The output ``name`` at ``times`` (s, within the run), shape of ``times``; at an event the limit from the right."""
        time, values = self.time, self.columns[name]
        if len(time) < 2:
            return np.interp(times, time, values)
        right = np.searchsorted(time, times + SAME_TIME * (1.0 + np.abs(times)), side="right")
        right = np.clip(right, 1, len(time) - 1)
        left = right - 1
        size, near = time[right] - time[left], SAME_TIME * (1.0 + np.abs(times))
        b = (times - time[left]) / np.where(size > 0.0, size, 1.0)
        b = np.where(np.abs(times - time[left]) <= near, 0.0, b)
        b = np.where((time[right] - times <= near) | (size == 0.0), 1.0, b)
        if name in self.held:
            known: Array = np.where(b < 1.0, values[left], values[right])
            return known
        rates = self.columns.get(f"{name}_rate")
        slopes = _slopes(time, values) if rates is None else rates
        a = 1.0 - b
        smooth: Array = (
            a * a * (1.0 + 2.0 * b) * values[left] + b * b * (1.0 + 2.0 * a) * values[right]
            + size * a * b * (a * slopes[left] - b * slopes[right])
        )  # fmt: skip
        return smooth


def _slopes(time: Array, values: Array) -> Array:
    """Slopes of the parabolas through each point and its neighbours, one-sided beside an event, shape (n,)."""
    steps = np.diff(time)
    there = steps > 0.0
    secants = np.where(there, np.diff(values) / np.where(there, steps, 1.0), 0.0)
    before, after = np.append(0.0, np.where(there, steps, 0.0)), np.append(np.where(there, steps, 0.0), 0.0)
    to, off = np.append(0.0, secants), np.append(secants, 0.0)
    inner = (before > 0.0) & (after > 0.0)
    whole = before + after
    slopes: Array = np.where(inner, (after * to + before * off) / np.where(inner, whole, 1.0), to + off)
    begins, ends = ~inner & (after > 0.0), ~inner & (before > 0.0)
    begins[:-1] &= inner[1:]
    ends[1:] &= inner[:-1]
    begins[-1] = ends[0] = False
    first, last = np.flatnonzero(begins), np.flatnonzero(ends)
    edges = 2.0 * off[first] - slopes[first + 1], 2.0 * to[last] - slopes[last - 1]
    slopes[first], slopes[last] = edges
    return slopes


def comparison_times(stop: float, step: float | None, points: int = 0) -> Array:
    """Times from 0 to ``stop``, s, at which runs are compared, equally spaced: multiples of the communication ``step``; under
    error control (``step`` None) as many as the run has ``points``, and at least `FEWEST`."""
    size = stop / max(FEWEST, points) if step is None else step
    times: Array = size * np.arange(int(stop / size * (1.0 + 1e-12) + 1e-6) + 1, dtype=np.float64)
    return times
