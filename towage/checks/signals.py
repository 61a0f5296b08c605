"""Numbers of a motion that is known at times: its frequency, amplitude and peak, and whether it repeats."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PADDING = 8
"""The spectrum is taken of this many lengths of the record, so that the parabola through its peak is narrow."""
FEWEST = 16
"""Samples without which no frequency is told."""
MOST_PERIODS = 8
"""Subharmonics are looked for up to this order."""
REST = 1e-9
"""Standard deviation over the largest value of a signal that does not move but for rounding."""
LOWEST = 2 * PADDING
"""Place of two periods in the padded spectrum; a peak below it is no frequency."""


def dominant_frequency(time: Array, values: Array) -> float | None:
    """Angular frequency of the largest component, rad/s, by a least-squares refinement of the spectrum's peak; None
    for less than two periods or no motion."""
    n = len(time)
    if n < FEWEST or not np.ptp(values) > 0.0:
        return None
    step = (time[-1] - time[0]) / (n - 1)
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(n), PADDING * n))
    top = int(np.argmax(spectrum[1:])) + 1
    if top < LOWEST or top + 1 >= len(spectrum):
        return None
    left, middle, right = np.log(spectrum[top - 1 : top + 2] + 1e-300)
    bend = left - 2.0 * middle + right
    shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0  # no peak where the motion is too small to be squared
    return float(2.0 * math.pi * (top + shift) / (PADDING * n * step))


def component(time: Array, values: Array, omega: float) -> complex:
    """Complex amplitude A of Re(A exp(i omega t)) by least squares, over whole periods."""
    period = 2.0 * math.pi / omega
    periods = math.floor((time[-1] - time[0]) / period + 1e-9)
    keep = time >= time[-1] - periods * period
    t = time[keep]
    basis = np.column_stack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t)])
    c, s, _ = np.linalg.lstsq(basis, values[keep], rcond=None)[0]
    return complex(c, -s)


def repeats_after(time: Array, values: Array, omega: float | None, tolerance: float) -> int:
    """After how many periods of the driver (1 to `MOST_PERIODS`) a motion is the same again, within half the tolerance; 0
    if it is not: still ringing, irregular, chaotic. A motion without frequency, or too short to tell, counts as 1."""
    spread = float(np.std(values))
    if omega is None or not spread:
        return 1
    for n in range(1, MOST_PERIODS + 1):
        period = 2.0 * math.pi * n / omega
        late = time[time <= time[-1] - period]
        if len(late) < 8:
            return 1 if n == 1 else 0
        change = np.interp(late + period, time, values) - values[: len(late)]
        if math.sqrt(float(np.mean(change**2))) <= 0.5 * tolerance * spread:
            return n
    return 0


def irregular(time: Array, drive: Array, omega: float | None, tolerance: float) -> bool:
    """Whether what drives does not repeat, in the second half: one that fades in is regular afterwards."""
    late = len(time) // 2
    return not repeats_after(time[late:], drive[late:], omega, tolerance)


def relative_change(one: float, two: float) -> float:
    """one / two - 1; infinite where only ``one`` is not zero."""
    return one / two - 1.0 if two else share_of_nothing(one)


def share_of_nothing(value: float) -> float:
    """``value`` as a share of zero: infinite, but for zero itself."""
    return math.inf if value else 0.0


class Difference(NamedTuple):
    """A signal of a simpler model against that of the full one: ``amplitude``, half the swing, and ``peak`` above the mean,
    each simpler/full - 1; ``rms`` of the difference over the standard deviation of the full one. Infinite where only one of
    them moves, 0 where none does."""

    amplitude: float
    peak: float
    rms: float

    @property
    def worst(self) -> float:
        """The largest size."""
        return max(abs(self.amplitude), abs(self.peak), self.rms)


def difference(full: Array, simpler: Array) -> Difference:
    """Of two signals at the same times, shape (n,)."""
    if at_rest(full):
        same = at_rest(simpler) and abs(float(simpler.mean() - full.mean())) <= REST * float(np.max(np.abs(full), initial=0.0))
        return Difference(*(3 * [0.0 if same else math.inf]))
    amplitude = relative_change(peak(simpler) + peak(-simpler), peak(full) + peak(-full))
    above = relative_change(peak(simpler) - float(simpler.mean()), peak(full) - float(full.mean()))
    return Difference(amplitude, above, math.sqrt(float(np.mean((simpler - full) ** 2))) / float(full.std()))


def at_rest(values: Array) -> bool:
    """Whether a signal does not move but for rounding."""
    return float(np.std(values)) <= REST * float(np.max(np.abs(values), initial=0.0))


def peak(values: Array) -> float:
    """Largest value, refined by a parabola through the samples around it."""
    k = int(np.argmax(values))
    if 0 < k < len(values) - 1:
        a, b, c = (float(x) for x in values[k - 1 : k + 2])
        curvature = a - 2.0 * b + c
        if curvature < 0.0:
            return b - (a - c) ** 2 / (8.0 * curvature)
    return float(values[k])
