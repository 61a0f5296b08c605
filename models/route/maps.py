"""Maps on which routes are computed: a flat one, and the polar stereographic plane of the source.

    plane velocity = m(r) times true velocity,   m = (Re^2 + r^2)/(2 Re R),   Re = R (1 + sin 60 deg)
    r = Re tan(colatitude/2),   x = r cos(longitude - reference),   y = r sin(longitude - reference)

| symbol | meaning | unit |
|---|---|---|
| R | radius of the earth | m |
| Re | distance of the equator from the pole on the plane, which is true to scale at 60 degrees | m |
| r | distance from the pole on the plane | m |

Both constants follow from one R. (The source prints 973.75 and 1043.6, and programs 1043.638743 mesh units, which do
not belong to one R: geodesic times come out wrong by 1.7e-5.) A southern plane is the mirror image of a northern one:
the sign of latitude and of y changes, so that angles still run from x to y.

Assumptions: a sphere. Directions are stored as plane vectors: compass directions are singular at the pole.

Source: Minimal-time ship routing (1964), section on the map and equation (23).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..numeric.ops import Value

EARTH_RADIUS = 6371.2e3
"""The source's mesh of 381 km with its other constants gives this radius, m."""


@dataclass(frozen=True)
class FlatMap:
    """A plane with true scale; x east, y north, m."""

    def scale(self, x: Value, y: Value) -> tuple[Value, Value, Value]:
        """m and its derivatives with respect to x and y."""
        zero = 0.0 * x
        return 1.0 + zero, zero, zero

    def distance(self, start: tuple[float, float], end: tuple[float, float]) -> float:
        """Shortest true distance between two points of the plane, m."""
        return math.dist(start, end)

    def geodesic(self, start: tuple[float, float], end: tuple[float, float], n: int) -> list[tuple[float, float]]:
        """n + 1 equidistant points of the shortest way."""
        return [
            (start[0] + (end[0] - start[0]) * i / n, start[1] + (end[1] - start[1]) * i / n) for i in range(n + 1)
        ]


@dataclass(frozen=True)
class StereographicMap:
    """``reference``: longitude of the x axis, rad; ``south``: the plane about the south pole."""

    radius: float = EARTH_RADIUS
    reference: float = 0.0
    south: bool = False

    @property
    def equator(self) -> float:
        """Re, m."""
        return self.radius * (1.0 + math.sin(math.radians(60.0)))

    def scale(self, x: Value, y: Value) -> tuple[Value, Value, Value]:
        """m and its derivatives with respect to x and y."""
        twice = 2.0 * self.equator * self.radius
        return (self.equator**2 + x * x + y * y) / twice, 2.0 * x / twice, 2.0 * y / twice

    def to_plane(self, latitude: Value, longitude: Value) -> tuple[Value, Value]:
        """x, y, m, of a place, rad."""
        sign = -1.0 if self.south else 1.0
        r = self.equator * np.tan(0.25 * math.pi - 0.5 * sign * latitude)
        angle = longitude - self.reference
        return r * np.cos(angle), sign * r * np.sin(angle)

    def to_geographic(self, x: Value, y: Value) -> tuple[Value, Value]:
        """Latitude and longitude in -pi ... pi, rad."""
        sign = -1.0 if self.south else 1.0
        latitude = sign * (0.5 * math.pi - 2.0 * np.arctan(np.hypot(x, y) / self.equator))
        longitude = np.arctan2(sign * y, x) + self.reference
        return latitude, np.arctan2(np.sin(longitude), np.cos(longitude))

    def direction(self, x: Value, y: Value, bearing: Value) -> Value:
        """Plane angle from +x of a compass ``bearing`` (rad, clockwise from north) at a place of the plane."""
        outward = np.arctan2(y, x)
        return outward - bearing if self.south else outward + math.pi - bearing

    def bearing(self, x: Value, y: Value, direction: Value) -> Value:
        """Compass bearing, 0 ... 2 pi, of a plane ``direction``; the inverse of `direction`."""
        outward = np.arctan2(y, x)
        raw = outward - direction if self.south else outward + math.pi - direction
        return np.mod(raw, 2.0 * math.pi)

    def distance(self, start: tuple[float, float], end: tuple[float, float]) -> float:
        """Length of the great circle, m, from the chord, so that short ways keep their digits."""
        a, b = self._unit(*start), self._unit(*end)
        return 2.0 * self.radius * math.asin(min(1.0, 0.5 * math.dist(a, b)))

    def geodesic(self, start: tuple[float, float], end: tuple[float, float], n: int) -> list[tuple[float, float]]:
        """n + 1 equidistant points of the great circle."""
        a, b = self._unit(*start), self._unit(*end)
        angle = self.distance(start, end) / self.radius
        points = []
        for i in range(n + 1):
            f = i / n
            if math.sin(angle) < 1e-12:
                p = [(1.0 - f) * u + f * v for u, v in zip(a, b)]
            else:
                p = [(math.sin((1.0 - f) * angle) * u + math.sin(f * angle) * v) / math.sin(angle) for u, v in zip(a, b)]
            points.append((self.equator * p[0] / (1.0 + p[2]), self.equator * p[1] / (1.0 + p[2])))
        return points

    def _unit(self, x: float, y: float) -> tuple[float, float, float]:
        """The place as a unit vector whose third axis goes through the plane's pole."""
        u, v = x / self.equator, y / self.equator
        size = 1.0 + u * u + v * v
        return 2.0 * u / size, 2.0 * v / size, (2.0 - size) / size


RouteMap = FlatMap | StereographicMap
