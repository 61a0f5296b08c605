"""The solver's own points of a run: every communication point, whatever the scene records.

Comparisons are made on them, so that ``record.interval`` changes no word. Between two points a signal is a cubic spline; at
a point it is the value itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FEWEST = 2000
"""Times of a comparison under error control, at least."""


class Track(NamedTuple):
    """``time`` of every communication point, s, increasing, shape (n,); ``columns``: every observed output, shape (n,)."""

    time: Array
    columns: Mapping[str, Array]

    def at(self, name: str, times: Array) -> Array:
        """The output ``name`` at ``times`` (s, within the run), shape of ``times``."""
        time, values = self.time, self.columns[name]
        if len(time) < 3:
            return np.interp(times, time, values)
        right = np.clip(np.searchsorted(time, times), 1, len(time) - 1)
        left = right - 1
        known: Array = np.where(times == time[right], values[right], values[left])
        between = (times != time[left]) & (times != time[right])
        if not between.any():
            return known
        from scipy.interpolate import CubicSpline

        known[between] = CubicSpline(time, values)(np.minimum(times[between], time[-1]))
        return known


def comparison_times(stop: float, step: float | None, interval: float) -> Array:
    """Times from 0 to ``stop``, s, at which runs are compared, equally spaced: multiples of the communication ``step``, or
    of a shorter record ``interval``, which cuts the step; under error control (``step`` None) the record times, or
    `FEWEST` where these are fewer."""
    if step is None:
        interval = min(interval, stop / FEWEST)
    size = interval if step is None else min(step, interval)
    times: Array = size * np.arange(int(stop / size * (1.0 + 1e-12) + 1e-6) + 1, dtype=np.float64)
    return times
