"""Wave fields given by formulas: what a ship meets at (x, y, t).

    H(x, y, t) = background + sum peak exp(-d^2/(2 sigma^2)),   d = |(x, y) - centre - velocity t|

A field answers `at` with a `Sea`: height H, the unit vector k toward which the waves come FROM, and the gradients of H
and of the angle K of k. Where k is not defined (the centre of a vortex) ``directed`` is False and the ship sails as
slowly as in her worst direction.

| symbol | meaning | unit |
|---|---|---|
| H | significant wave height | m |
| K | angle of k from +x | rad |
| u | surface current | m/s |

Directions of storms that swirl: k is along k0 + sum e [(-dy, dx)/sigma - k0], e = exp(-d^2/(2 sigma^2)), which vanishes
where they cancel.

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


Slope = tuple[AnyArray, AnyArray, AnyArray]
"""A value, its x and its y derivative."""


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


class Known(Protocol):
    """Where and how long something is known."""

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Whether there are data at these places."""

    @property
    def horizon(self) -> float:
        """Time of the last forecast, s; infinite for a formula. Later the field stays as it was then."""

    @property
    def detail(self) -> float:
        """Length within which it changes much, m; infinite where it changes evenly."""


class Field(Known, Protocol):
    """What the routes need of a field."""

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea at places of the plane, m, and times, s."""

    def period(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Peak period, s; 0 where it follows from the height."""

    def centres(self, t: float) -> tuple[tuple[float, float, float], ...]:
        """(x, y, size), m, of storms that are known as such at time ``t``, s: routes pass them on either side."""


class _Everywhere:
    def period(self, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Not known: 0."""
        return np.zeros_like(x)

    def centres(self, t: float) -> tuple[tuple[float, float, float], ...]:
        """None."""
        return ()

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Everywhere."""
        return np.ones_like(x, dtype=bool)

    @property
    def horizon(self) -> float:
        """No last forecast."""
        return math.inf

    @property
    def detail(self) -> float:
        """Even."""
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

    @property
    def detail(self) -> float:
        """sigma."""
        return self.sigma

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea."""
        return Storms(self.background, (self,), self.angle).at(x, y, t)

    def centres(self, t: float) -> tuple[tuple[float, float, float], ...]:
        """Its own."""
        return ((self.centre[0] + self.velocity[0] * t, self.centre[1] + self.velocity[1] * t, self.sigma),)


@dataclass(frozen=True)
class Storms(_Everywhere):
    """Several storms over one background: their peaks add, and so do the swirls. ``angle`` of k0, rad; background and angle
    of the storms themselves do not count."""

    background: float
    storms: tuple[StormField, ...]
    angle: float = 0.0

    @property
    def detail(self) -> float:
        """The least sigma."""
        return min(storm.sigma for storm in self.storms)

    def centres(self, t: float) -> tuple[tuple[float, float, float], ...]:
        """Of all storms."""
        return tuple(centre for storm in self.storms for centre in storm.centres(t))

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Sea:
        """The sea."""
        height, wx, wy = self.parts(x, y, t)
        if any(storm.swirl for storm in self.storms):
            return directed_sea(height, wx, wy)
        zero = np.zeros_like(wx[0])
        return Sea(*height, wx[0], wy[0], zero, zero, np.ones_like(zero, dtype=bool))

    def parts(self, x: AnyArray, y: AnyArray, t: AnyArray) -> tuple[Slope, Slope, Slope]:
        """Height and the components of a vector along k, each with its x and y derivatives."""
        zero = 0.0 * (x + y + t)
        height, hx, hy = self.background + zero, zero, zero
        k0x, k0y = math.cos(self.angle), math.sin(self.angle)
        wx, wx_x, wx_y, wy, wy_x, wy_y = k0x + zero, zero, zero, k0y + zero, zero, zero
        for storm in self.storms:
            dx = x - storm.centre[0] - storm.velocity[0] * t
            dy = y - storm.centre[1] - storm.velocity[1] * t
            inverse = 1.0 / storm.sigma**2
            e = np.exp(-0.5 * inverse * (dx * dx + dy * dy))
            ex, ey = -inverse * dx * e, -inverse * dy * e
            height, hx, hy = height + storm.peak * e, hx + storm.peak * ex, hy + storm.peak * ey
            if storm.swirl:
                s = 1.0 / storm.sigma
                wx, wy = wx - e * (k0x + dy * s), wy - e * (k0y - dx * s)
                wx_x, wx_y = wx_x - ex * (k0x + dy * s), wx_y - ey * (k0x + dy * s) - e * s
                wy_x, wy_y = wy_x - ex * (k0y - dx * s) + e * s, wy_y - ey * (k0y - dx * s)
        return (height, hx, hy), (wx, wx_x, wx_y), (wy, wy_x, wy_y)


def directed_sea(
    height: Slope, wx: Slope, wy: Slope
) -> Sea:
    """The sea from a height and a vector along k of any length, each with its x and y derivatives."""
    length = np.hypot(wx[0], wy[0])
    directed = length > UNDIRECTED
    safe = np.where(directed, length, 1.0)
    kx, ky = np.where(directed, wx[0] / safe, 1.0), np.where(directed, wy[0] / safe, 0.0)
    turn = np.where(directed, 1.0 / safe, 0.0)
    return Sea(*height, kx, ky, turn * (kx * wy[1] - ky * wx[1]), turn * (kx * wy[2] - ky * wx[2]), directed)


class Flow(NamedTuple):
    """A current: components along the axes of the plane, true speeds, m/s, and their derivatives per m of the plane."""

    u: AnyArray
    w: AnyArray
    u_x: AnyArray
    u_y: AnyArray
    w_x: AnyArray
    w_y: AnyArray


class Current(Known, Protocol):
    """What the routes need of a current."""

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Flow:
        """The current at places of the plane, m, and times, s."""


@dataclass(frozen=True)
class LinearCurrent(_Everywhere):
    """velocity + gradient (x, y): u = velocity[0] + gradient[0][0] x + gradient[0][1] y, w likewise; m/s and 1/s."""

    velocity: tuple[float, float] = (0.0, 0.0)
    gradient: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))

    def at(self, x: AnyArray, y: AnyArray, t: AnyArray) -> Flow:
        """The current."""
        (ux, uy), (wx, wy) = self.gradient
        zero = np.zeros_like(x)
        return Flow(
            self.velocity[0] + ux * x + uy * y, self.velocity[1] + wx * x + wy * y, zero + ux, zero + uy, zero + wx, zero + wy
        )

    @property
    def uniform(self) -> bool:
        """Whether it is the same everywhere."""
        return self.gradient == ((0.0, 0.0), (0.0, 0.0))
