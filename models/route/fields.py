"""Wave fields given by formulas: what a ship meets at (x, y, t).

    H(x, y, t) = background + peak exp(-d^2/(2 sigma^2)),   d = |(x, y) - centre - velocity t|

A field answers `at` with a `Sea`: height H, the unit vector k toward which the waves come FROM, and the gradients of H
and of the angle K of k. Where k is not defined (the centre of a vortex) ``directed`` is False and the ship sails as
slowly as in her worst direction.

| symbol | meaning | unit |
|---|---|---|
| H | significant wave height | m |
| K | angle of k from +x | rad |
| u | surface current | m/s |

Directions of a storm that swirls: k is along (1 - e) k0 + e (-dy, dx)/sigma, e = exp(-d^2/(2 sigma^2)), which vanishes
where the two cancel.

Assumptions: (1) the waves move with the storm and do not disperse; (2) one direction at a place.

Source: test problems P1 to P10 of the project's specification; Minimal-time ship routing (1964) for the meaning of K.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ..numeric.arrays import AnyArray

UNDIRECTED = 1e-9
"""Length of the mean direction vector below which there is no direction."""


class Sea(NamedTuple):
    """Arrays of one shape; gradients per m of the plane."""

    height: AnyArray
    height_x: AnyArray
    height_y: AnyArray
    kx: AnyArray
    ky: AnyArray
    angle_x: AnyArray
    angle_y: AnyArray
    directed: AnyArray


class Field(Protocol):
    """What the routes need of a field."""

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea at places of the plane, m, and times, s."""

    def period(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Peak period, s; 0 where it follows from the height."""

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Whether there are data at these places."""

    @property
    def horizon(self) -> float:
        """Time of the last forecast, s; infinite for a formula. Later the field stays as it was then."""


class _Everywhere:
    def period(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Not known: 0."""
        return np.zeros_like(x)

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Everywhere."""
        return np.ones_like(x, dtype=bool)

    @property
    def horizon(self) -> float:
        """No last forecast."""
        return math.inf


@dataclass(frozen=True)
class UniformField(_Everywhere):
    """The same everywhere and always; ``height`` m (0: calm), ``angle`` K, rad."""

    height: float = 0.0
    angle: float = 0.0

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea."""
        zero = np.zeros_like(x)
        directed = np.ones_like(x, dtype=bool)
        return Sea(zero + self.height, zero, zero, zero + math.cos(self.angle), zero + math.sin(self.angle), zero, zero,
                   directed)  # fmt: skip


@dataclass(frozen=True)
class LinearField(_Everywhere):
    """value + gradient (x, y): for a `ProportionalPolar` the value is a speed, m/s."""

    value: float
    gradient: tuple[float, float]
    angle: float = 0.0

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea."""
        zero = np.zeros_like(x)
        gx, gy = self.gradient
        return Sea(self.value + gx * x + gy * y, zero + gx, zero + gy, zero + math.cos(self.angle),
                   zero + math.sin(self.angle), zero, zero, np.ones_like(x, dtype=bool))  # fmt: skip


@dataclass(frozen=True)
class StormField(_Everywhere):
    """A Gaussian storm; lengths m, ``velocity`` m/s, ``angle`` of k0, rad."""

    background: float
    peak: float
    centre: tuple[float, float]
    sigma: float
    velocity: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0
    swirl: bool = False

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea."""
        dx = x - self.centre[0] - self.velocity[0] * t
        dy = y - self.centre[1] - self.velocity[1] * t
        inverse = 1.0 / self.sigma**2
        e = np.exp(-0.5 * inverse * (dx * dx + dy * dy))
        ex, ey = -inverse * dx * e, -inverse * dy * e
        height, hx, hy = self.background + self.peak * e, self.peak * ex, self.peak * ey
        k0x, k0y = math.cos(self.angle), math.sin(self.angle)
        zero = np.zeros_like(e)
        if not self.swirl:
            return Sea(height, hx, hy, zero + k0x, zero + k0y, zero, zero, np.ones_like(e, dtype=bool))
        s = 1.0 / self.sigma
        wx, wy = (1.0 - e) * k0x - e * dy * s, (1.0 - e) * k0y + e * dx * s
        wx_x, wx_y = -ex * (k0x + dy * s), -ey * (k0x + dy * s) - e * s
        wy_x, wy_y = -ex * (k0y - dx * s) + e * s, -ey * (k0y - dx * s)
        return directed_sea((height, hx, hy), (wx, wx_x, wx_y), (wy, wy_x, wy_y))


def directed_sea(
    height: tuple[AnyArray, AnyArray, AnyArray], wx: tuple[AnyArray, AnyArray, AnyArray], wy: tuple[AnyArray, AnyArray, AnyArray]
) -> Sea:
    """The sea from a height and a vector along k of any length, each with its x and y derivatives."""
    length = np.hypot(wx[0], wy[0])
    directed = length > UNDIRECTED
    safe = np.where(directed, length, 1.0)
    kx, ky = np.where(directed, wx[0] / safe, 1.0), np.where(directed, wy[0] / safe, 0.0)
    turn = np.where(directed, 1.0 / safe, 0.0)
    return Sea(*height, kx, ky, turn * (kx * wy[1] - ky * wx[1]), turn * (kx * wy[2] - ky * wx[2]), directed)


@dataclass(frozen=True)
class ShearCurrent:
    """u = (rate_x y, rate_y x): constant gradients; 1/s."""

    rate_x: float = 0.0
    rate_y: float = 0.0

    def at(self, x: AnyArray, y: AnyArray) -> tuple[AnyArray, AnyArray]:
        """u, m/s."""
        return self.rate_x * y, self.rate_y * x
