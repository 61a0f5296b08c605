"""How far a line without mass is from an elastic bar of the wire's mass, under one motion of its top: the numbers of `wire`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from towage.models.heave.elastic_bar import Path

    Array = NDArray[np.float64]

ROOM = 1.1
"""Bound over the error that is computed, to which `GROWS` times that error is added: harmonics of the drag and the frequencies
beside the one at which the bar is exact count the more, the more the wire does."""
GROWS = 0.5
PARTS = 0.1
"""omega h, h the step of the integration, for the load on its line."""
MOST_STEPS = 200_000
ENERGY = 0.98
"""The bar is exact at the frequency below which this share of the energy of the top's acceleration lies."""
LOBE = 3.0
"""Half the width of a single frequency in the spectrum, in lines: two of Hann's window, and its place between lines."""


@dataclass(frozen=True)
class Cost:
    """Relative errors of the spring against the bar, ``time`` of the largest difference in tension, s, omega L/c, and the share
    of the waves of earlier ``snaps``."""

    motion: float
    tension: float
    time: float
    angle: float
    snaps: float = 0.0

    @property
    def error(self) -> float:
        """The bound without the waves of earlier snaps."""
        return bound_of(max(self.motion, self.tension))

    @property
    def bound(self) -> float:
        """The bound."""
        return bound_of(max(self.motion, self.tension) + self.snaps)


def bound_of(error: float) -> float:
    """What an error may be that was computed."""
    return float(error * (ROOM + GROWS * error))


@dataclass(frozen=True)
class Line:
    """A line of the scene: ``top``, the output that moves its upper end; ``heave``, that of the load, empty if it is not
    known; masses of the load during the run, kg; drag factor, kg/m; K, N/m; m L, kg, or 0; its length, m; W, N; start (m,
    m/s); damping ratio of the wire's first mode."""

    name: str
    top: str
    heave: str
    masses: tuple[float, ...]
    drag: float
    stiffness: float
    wire: float
    length: float
    weight: float
    start: tuple[float, float]
    damping: float = 0.0


def cost_of(
    line: Line, mass: float, wire: float, times: Array, motion: Array, settle: float, statistical: bool
) -> tuple[Cost, Array]:
    """The errors for a load of ``mass``, kg, and the heave of the load on the massless spring, m, at ``times``, s, equally
    spaced, under the ``motion`` of the top, m."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    from towage.models.heave import elastic_bar

    if len(times) < 4 or not np.ptp(motion) + abs(line.start[0]) + abs(line.start[1]) > 0.0:
        return Cost(0.0, 0.0, 0.0, 0.0), np.full(len(times), line.start[0])
    settled = times >= settle
    omega = frequency(times[settled], motion[settled])
    theta = elastic_bar.angle(omega, line.stiffness, wire)
    between = float(times[1] - times[0])
    fastest = max(omega, math.sqrt(line.stiffness / mass))
    parts = max(1, min(math.ceil(between * fastest / PARTS), MOST_STEPS // len(times)))
    h = between / parts
    spline = CubicSpline(times, motion)
    halves = times[0] + 0.5 * h * np.arange(2 * parts * (len(times) - 1) + 1)
    top, acceleration = spline(halves).tolist(), spline(halves, 2).tolist()
    first = parts * int(np.argmax(settled))

    def path(m: float) -> Path:
        lift = elastic_bar.Lift(line.stiffness, m, mass, line.drag, line.weight, omega)
        decay = line.damping * 0.5 * math.pi * math.sqrt(line.stiffness / m) if m else 0.0
        return elastic_bar.follow(lift, h, top, acceleration, line.start, first, decay)

    spring = path(0.0)
    heave = np.array(spring.load[::parts])
    if theta >= 0.5 * math.pi:
        return Cost(math.inf, math.inf, float(times[-1]), theta), heave
    bar = path(wire)
    impact, ringing = (v * math.sqrt(line.stiffness * wire) for v in (bar.impact, bar.ringing))
    own = np.array(spring.low)[first:]
    tension = snap = snaps = time = 0.0
    for values in (bar.top, bar.low):
        true = np.array(values)[first:]
        peak = float(true.max()) - line.weight
        snap, snaps = share(impact, peak), max(snaps, share(ringing - impact, peak))
        tension = max(tension, snap + apart(own, true, line.weight, statistical))
        time = float(times[0]) + h * (first + int(np.argmax(np.abs(own - true))))
    motions = snap + apart(np.array(spring.load)[first:], np.array(bar.load)[first:], None, statistical)
    return Cost(motions, tension, time, theta, snaps), heave


def apart(spring: Array, bar: Array, mean: float | None, statistical: bool) -> float:
    """The largest of the errors of the spring: of the swing, or of the peak above ``mean`` where it is given, and rms of the
    difference over the standard deviation; ``statistical``, for motions that do not repeat: of the standard deviation and of the
    mean of the largest tenth of the values. Zero for signals at rest."""
    import numpy as np

    from towage.checks.signals import relative_change

    spread = float(bar.std())
    if max(spread, float(spring.std())) <= 1e-12 * max(float(np.abs(bar).max()), float(np.abs(spring).max())):
        return 0.0
    if statistical:
        high = [float(np.sort(values - values.mean())[-max(1, len(values) // 10) :].mean()) for values in (spring, bar)]
        return max(abs(relative_change(float(spring.std()), spread)), abs(relative_change(*high)))
    size = (float(np.ptp(spring)), float(np.ptp(bar))) if mean is None else (spring.max() - mean, bar.max() - mean)
    return max(abs(relative_change(*size)), share(float(np.sqrt(np.mean((spring - bar) ** 2))), spread))


def share(value: float, whole: float) -> float:
    """value / whole; infinite where only ``value`` is not zero."""
    return value / whole if whole > 0.0 else math.inf if value else 0.0


def frequency(times: Array, motion: Array) -> float:
    """Frequency at which the bar is taken, rad/s: that of the motion where it has one alone, else that below which `ENERGY`
    of the energy of its acceleration lies; 0 for too few samples."""
    import numpy as np

    from towage.checks.signals import FEWEST, dominant_frequency

    if len(times) < FEWEST:
        return 0.0
    omega = 2.0 * math.pi * np.fft.rfftfreq(len(times), float(times[1] - times[0]))
    power = np.cumsum((omega**2 * np.abs(np.fft.rfft((motion - motion.mean()) * np.hanning(len(times))))) ** 2)
    if not power[-1] > 0.0:
        return 0.0
    high = float(omega[int(np.searchsorted(power, ENERGY * power[-1]))])
    single = dominant_frequency(times, motion)
    return single if single and high - single <= LOBE * omega[1] else high
