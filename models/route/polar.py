"""Polar diagrams: how fast a ship sails in which direction through waves of which height.

    velocity set {v : ((v.k + c)/a)^2 + (v.k')^2/b^2 <= 1},   a, b, c functions of the wave height H

| symbol | meaning | unit |
|---|---|---|
| k, k' | unit vector toward which the waves come FROM, and the one 90 degrees to its left | - |
| a, b | semi-axes of the ellipse along k and across it | m/s |
| c | displacement of its centre down-wave: a - c is the speed in head seas, a + c in following ones | m/s |
| V(theta) | speed at angle theta from k of a table; its convex hull is what a ship that may tack reaches | m/s |

Assumptions: (1) the ship keeps her power; (2) speed depends on height and direction only; (3) a table between two
heights is the linear mixture of their hulls. The default is valid up to 48 ft; its head speed vanishes at 50.2 ft,
beyond which the ship could be blown backwards and two speeds belong to a direction. It is held at 48 ft there, and the
share of a voyage above is reported.

Source: Minimal-time ship routing (1964), equation (1) and subroutine ABC, for a P2-S2-R2 ship after R. W. James (1957).
The constants are recovered from the print: a(0) = b(0) = 19.3 kn, c(0) = 0, and the half constants of the derivatives,
confirm every digit but the sixth decimal of 0.06647[9]3891, which moves c by less than 1e-4 kn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numeric.arrays import AnyArray
from ..numeric.ops import Ops, Value

"""Of floats or truth values."""
FOOT, KNOT = 0.3048, 1852.0 / 3600.0
JAMES_LIMIT = 48.0 * FOOT

Axes = tuple[Value, Value, Value, Value, Value, Value]
"""(a, b, c, da/dH, db/dH, dc/dH), m/s and 1/s."""


@dataclass(frozen=True)
class JamesPolar:
    """P2-S2-R2 (1957). ``limit``: height at which the curves are held, m."""

    limit: float = JAMES_LIMIT
    name: str = "P2-S2-R2 (1957)"

    def axes(self, height: Value, ops: Ops) -> Axes:
        """a, b, c and their derivatives at ``height``, m."""
        h = ops.minimum(ops.maximum(height, 0.0), self.limit) / FOOT
        moves = ops.where(height < self.limit, ops.where(height >= 0.0, KNOT / FOOT, 0.0), 0.0)
        r1 = ops.sqrt((0.0386356466 * h - 0.4924359727) * h + 2.099340872)
        r2 = ops.sqrt((0.0329376384 * h - 0.4398067919) * h + 1.778122940)
        r3 = ops.sqrt((0.0104418956 * h - 0.0664793891) * h + 0.3712046341)
        r4 = ops.sqrt((0.0130517910 * h - 0.193791634) * h + 0.8148863262)
        return (
            KNOT * (-0.120197666 * h + 20.748910236 - r1),
            KNOT * (-0.126879519 * h + 20.633462763 - r2),
            KNOT * (0.125424493 * h - 0.2934448925 - r3 + r4),
            moves * (-0.120197666 - (0.0386356466 * h - 0.24621798635) / r1),
            moves * (-0.126879519 - (0.0329376384 * h - 0.21990339595) / r2),
            moves
            * (0.125424493 - (0.0104418956 * h - 0.03323969455) / r3 + (0.0130517910 * h - 0.096895817) / r4),
        )

    def beyond(self, height: Value) -> Value:
        """Whether ``height`` is above the range of the curves."""
        return height > JAMES_LIMIT


@dataclass(frozen=True)
class ProportionalPolar:
    """Centred ellipse with semi-axes proportional to the field's value, which is then a speed, m/s, and no height."""

    along: float = 1.0
    across: float = 1.0
    name: str = "proportional"

    def axes(self, value: Value, ops: Ops) -> Axes:
        """a = ``along`` value, b = ``across`` value, c = 0."""
        zero = 0.0 * value
        return self.along * value, self.across * value, zero, self.along + zero, self.across + zero, zero

    def beyond(self, value: Value) -> Value:
        """Never."""
        return value != value


@dataclass(frozen=True)
class ConstantPolar:
    """The same speed, m/s, in every sea and direction."""

    speed: float
    name: str = "constant"

    def axes(self, height: Value, ops: Ops) -> Axes:
        """A circle."""
        zero = 0.0 * height
        return self.speed + zero, self.speed + zero, zero, zero, zero, zero

    def beyond(self, height: Value) -> Value:
        """Never."""
        return height != height


SmoothPolar = JamesPolar | ProportionalPolar | ConstantPolar


def follow_beam_head(polar: SmoothPolar, height: float, ops: Ops) -> tuple[float, float, float]:
    """Speeds in following, beam and head seas, m/s: a + c, b sqrt(1 - (c/a)^2), a - c."""
    a, b, c = polar.axes(height, ops)[:3]
    return a + c, b * math.sqrt(max(0.0, 1.0 - (c / a) ** 2)), a - c


class TablePolar:
    """Speeds of a table through their convex hull.

    ``heights`` (n,), m, ascending; ``angles`` (m,), rad, from 0 (head sea) ascending to at most pi, the other side is
    its mirror image; ``speeds`` (n, m), m/s. Between the angles speeds are linear. Raises ``ValueError``.
    """

    SAMPLES = 7200

    def __init__(
        self, heights: Sequence[float], angles: Sequence[float], speeds: Sequence[Sequence[float]], name: str = "table"
    ) -> None:
        self.name = name
        self.heights = np.asarray(heights, dtype=float)
        table = np.asarray(speeds, dtype=float)
        given = np.asarray(angles, dtype=float)
        if table.shape != (len(self.heights), len(given)) or len(given) < 2 or not len(self.heights):
            raise ValueError(f"speeds have shape {table.shape}, expected ({len(self.heights)}, {len(given)})")
        if not (np.all(np.diff(given) > 0.0) and given[0] >= 0.0 and given[-1] <= math.pi + 1e-9):
            raise ValueError("angles must ascend from 0 (head sea) to at most pi (following sea)")
        if np.any(np.diff(self.heights) <= 0.0):
            raise ValueError("heights must ascend")
        if not np.all(np.isfinite(table)) or np.any(table < 0.0):
            raise ValueError("speeds must be finite and not negative")
        theta = np.linspace(-math.pi, math.pi, self.SAMPLES, endpoint=False)
        self._theta = theta
        self._own = np.array([np.interp(np.abs(theta), given, row) for row in table])
        hulls = [_hull(theta, row) for row in self._own]
        self._hull = np.array([speed for speed, _ in hulls])
        self._chords = [chords for _, chords in hulls]

    def speed_along(self, height: AnyArray, theta: AnyArray) -> AnyArray:
        """Speed of the hull at ``theta`` from k, m/s, any shape."""
        return self._mix(self._hull, height, theta)

    def own_speed(self, height: AnyArray, theta: AnyArray) -> AnyArray:
        """Speed of the table itself, without tacking, m/s."""
        return self._mix(self._own, height, theta)

    def tack(self, height: float, theta: float) -> tuple[float, float] | None:
        """The two angles between which a ship tacks to make good ``theta``, or None where she sails it directly. At the
        tabulated height nearest to ``height``."""
        row = int(np.argmin(np.abs(self.heights - height)))
        wrapped = (theta + math.pi) % (2.0 * math.pi) - math.pi
        for low, high in self._chords[row]:
            if low < wrapped < high or low < wrapped + 2.0 * math.pi < high:
                return low, high
        return None

    def beyond(self, height: AnyArray) -> NDArray[np.bool_]:
        """Whether ``height`` is above the table, whose last row then holds."""
        return np.asarray(np.asarray(height) > self.heights[-1])

    def _mix(self, rows: AnyArray, height: AnyArray, theta: AnyArray) -> AnyArray:
        place = (np.asarray(theta) + math.pi) / (2.0 * math.pi) * self.SAMPLES
        cell = np.floor(place).astype(int)
        part = place - cell
        left, right = cell % self.SAMPLES, (cell + 1) % self.SAMPLES
        h = np.clip(height, self.heights[0], self.heights[-1])
        low = np.clip(np.searchsorted(self.heights, h, side="right") - 1, 0, max(0, len(self.heights) - 2))
        high = np.minimum(low + 1, len(self.heights) - 1)
        width = np.where(high > low, self.heights[high] - self.heights[low], 1.0)
        share = (h - self.heights[low]) / width
        below = (1.0 - part) * rows[low, left] + part * rows[low, right]
        above = (1.0 - part) * rows[high, left] + part * rows[high, right]
        return np.asarray((1.0 - share) * below + share * above)


def _hull(theta: AnyArray, speed: AnyArray) -> tuple[AnyArray, list[tuple[float, float]]]:
    """(speed of the convex hull at ``theta``, its chords as pairs of angles) of a star-shaped polar curve."""
    n = len(theta)
    if not speed.any():
        return speed.copy(), []
    x, y = speed * np.cos(theta), speed * np.sin(theta)
    order = sorted(range(n), key=lambda i: (x[i], y[i]))

    def half(indices: list[int]) -> list[int]:
        chain: list[int] = []
        for i in indices:
            while len(chain) > 1:
                o, a = chain[-2], chain[-1]
                if (x[a] - x[o]) * (y[i] - y[o]) - (y[a] - y[o]) * (x[i] - x[o]) > 0.0:
                    break
                chain.pop()
            chain.append(i)
        return chain

    corners = sorted(set(half(order) + half(order[::-1])))
    hull, chords = speed.copy(), []
    for i, j in zip(corners, [*corners[1:], corners[0] + n]):
        inner = np.arange(i + 1, j) % n
        if len(inner):
            ex, ey = x[j % n] - x[i], y[j % n] - y[i]
            across = np.cos(theta[inner]) * ey - np.sin(theta[inner]) * ex
            hull[inner] = (x[i] * ey - y[i] * ex) / across
            if len(inner) > 2 and np.any(hull[inner] > speed[inner] * (1.0 + 1e-6)):
                chords.append((float(theta[i]), float(theta[i] + (j - i) * (theta[1] - theta[0]))))
    return hull, chords


Polar = SmoothPolar | TablePolar
