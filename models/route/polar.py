"""Polar diagrams: how fast a ship sails in which direction through waves of which height.

    velocity set {v : ((v.k + c)/a)^2 + (v.k')^2/b^2 <= 1},   a, b, c functions of the wave height H

| symbol | meaning | unit |
|---|---|---|
| k, k' | unit vector toward which the waves come FROM, and the one 90 degrees to its left | - |
| a, b | semi-axes of the ellipse along k and across it | m/s |
| c | displacement of its centre down-wave: a - c is the speed in head seas, a + c in following ones | m/s |

Assumptions: (1) the ship keeps her power; (2) speed depends on height and direction only. Tables: `hulls`. The default is
valid up to 48 ft; its head speed vanishes at 50.2 ft, beyond which the ship could be blown backwards and two speeds belong to
a direction. It is held at 48 ft there, and the share of a voyage above is reported.

Source: Minimal-time ship routing (1964), equation (1) and subroutine ABC, for a P2-S2-R2 ship after R. W. James (1957).
The constants are recovered from the print: a(0) = b(0) = 19.3 kn, c(0) = 0, and the half constants of the derivatives,
confirm every digit but the sixth decimal of 0.06647[9]3891, which moves c by less than 1e-4 kn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..numeric.ops import Ops, Value
from .hulls import Tabled

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

    @property
    def steepest(self) -> float:
        """Bound of the change of the speed in any direction with the height, 1/s: |a'| or |b'|, and |c'|, each by its line and
        the roots of its leading terms, since the square root of a positive parabola is nowhere steeper than far out."""
        roots = math.sqrt(0.0386356466) + math.sqrt(0.0104418956) + math.sqrt(0.0130517910)
        return KNOT / FOOT * (0.120197666 + 0.125424493 + roots)

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

    @property
    def steepest(self) -> float:
        """0: the speed is proportional to the value, and largest where that is."""
        return 0.0

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

    @property
    def steepest(self) -> float:
        """0."""
        return 0.0

    def beyond(self, height: Value) -> Value:
        """Never."""
        return height != height


SmoothPolar = JamesPolar | ProportionalPolar | ConstantPolar


def follow_beam_head(polar: SmoothPolar, height: float, ops: Ops) -> tuple[float, float, float]:
    """Speeds in following, beam and head seas, m/s: a + c, b sqrt(1 - (c/a)^2), a - c."""
    a, b, c = polar.axes(height, ops)[:3]
    return a + c, b * math.sqrt(max(0.0, 1.0 - (c / a) ** 2)), a - c


Polar = SmoothPolar | Tabled
