"""After how many periods of the sea the motion at the end of a run repeats: 1, a subharmonic 2, 3, ..., or not at all.

    d_n = max |z(t) - z(t - n T)| over the last `COMPARED` periods,    period n: the smallest n with d_n <= tol (max z - min z)

A motion that does not repeat is chaotic or has not settled yet: a record cannot tell these apart, the Lyapunov exponent
can (`models.orbits.attractors`). A run that is too short says nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
COMPARED = 8
"""Periods compared: as many as the longest subharmonic looked for, so that each of its cycles is seen."""
LONGEST = 8
"""As in `models.orbits.attractors`."""
TOLERANCE = 0.01
"""Of the peak-to-peak motion: above the error of the spline through 40 samples a period (1e-5), below what separates the
cycles of the subharmonics in the reference cases (tens of percent)."""
PHASES = 32
"""Times in a period at which cycles are compared."""
APERIODIC = 0.0
"""Repeats after no number of periods up to `LONGEST`."""


def repeats_after(time: Array, values: Array, period: float) -> float | None:
    """Periods (each ``period`` s) after which ``values`` on ``time`` (s, ascending) repeat at the end of the record;
    `APERIODIC` if after none; None where the record has fewer than COMPARED + 1 periods, or gaps.

    Only as many periods back are looked at as the record holds."""
    from scipy.interpolate import CubicSpline  # heavy, and not wanted by every sweep

    longest = min(LONGEST, int((time[-1] - time[0]) / period * (1.0 + 1e-9)) - COMPARED) if len(time) > 1 else 0
    if longest < 1 or not np.isfinite(values).all():
        return None
    apart = np.concatenate(([True], np.diff(time) > 0.0))  # an event may leave two samples at one time
    curve = CubicSpline(time[apart], values[apart])
    at = time[-1] - np.arange(COMPARED * PHASES) * (period / PHASES)
    last = curve(at)
    size = float(np.ptp(last))
    for n in range(1, longest + 1):
        if float(np.max(np.abs(last - curve(at - n * period)))) <= TOLERANCE * size:
            return float(n)
    return APERIODIC if longest == LONGEST else None
