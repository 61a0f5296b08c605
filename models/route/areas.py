"""Forbidden areas of the plane: discs, polygons and cells of a grid, and whether a leg touches one.

A leg is a straight segment of the plane. A leg along the edge of an area is allowed: discs and polygons are smaller by 1e-9 of
their size where they are asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numeric.arrays import AnyArray

Mask = NDArray[np.bool_]
EDGE = 1e-9
"""Width of an edge over the size of its area."""


@dataclass(frozen=True)
class Disc:
    """Centre and radius, m."""

    x: float
    y: float
    radius: float
    name: str = "disc"

    def contains(self, x: AnyArray, y: AnyArray) -> Mask:
        """Whether places lie inside."""
        return np.hypot(x - self.x, y - self.y) < self.radius * (1.0 - EDGE)

    def blocks(self, x0: AnyArray, y0: AnyArray, x1: AnyArray, y1: AnyArray) -> Mask:
        """Whether legs pass through, arrays of one shape."""
        dx, dy = x1 - x0, y1 - y0
        length2 = np.maximum(dx * dx + dy * dy, 1e-300)
        s = np.clip(((self.x - x0) * dx + (self.y - y0) * dy) / length2, 0.0, 1.0)
        return self.contains(x0 + s * dx, y0 + s * dy)


class Polygon:
    """A closed polygon of n >= 3 corners (n, 2), m, of either sense. Raises ``ValueError``."""

    def __init__(self, corners: Sequence[Sequence[float]], name: str = "polygon") -> None:
        self.corners = np.asarray(corners, dtype=float)
        self.name = name
        if self.corners.ndim != 2 or self.corners.shape[1] != 2 or len(self.corners) < 3:
            raise ValueError(f"a polygon has shape {self.corners.shape}, expected (n, 2) with n >= 3")
        if not np.all(np.isfinite(self.corners)):
            raise ValueError("the corners of a polygon must be finite")
        self._next = np.roll(self.corners, -1, axis=0)
        self._edge = EDGE * float(np.max(np.ptp(self.corners, axis=0)))

    def contains(self, x: AnyArray, y: AnyArray) -> Mask:
        """Whether places lie inside (even-odd rule) and not on an edge."""
        x, y = np.asarray(x)[..., None], np.asarray(y)[..., None]
        (ax, ay), (bx, by) = self.corners.T, self._next.T
        dx, dy = bx - ax, by - ay
        across = (ay > y) != (by > y)
        at = ax + (y - ay) * dx / np.where(by == ay, 1.0, dy)
        s = np.clip(((x - ax) * dx + (y - ay) * dy) / np.maximum(dx * dx + dy * dy, 1e-300), 0.0, 1.0)
        near = np.min(np.hypot(x - ax - s * dx, y - ay - s * dy), axis=-1)
        return np.asarray((np.sum(across & (x < at), axis=-1) % 2 == 1) & (near > self._edge))

    def blocks(self, x0: AnyArray, y0: AnyArray, x1: AnyArray, y1: AnyArray) -> Mask:
        """Whether legs cross an edge or lie inside."""
        px, py, qx, qy = (np.asarray(v)[..., None] for v in (x0, y0, x1, y1))
        (ax, ay), (bx, by) = self.corners.T, self._next.T

        def side(ox: AnyArray, oy: AnyArray, ux: AnyArray, uy: AnyArray, vx: AnyArray, vy: AnyArray) -> AnyArray:
            return np.asarray((ux - ox) * (vy - oy) - (uy - oy) * (vx - ox))

        d1, d2 = side(ax, ay, bx, by, px, py), side(ax, ay, bx, by, qx, qy)
        d3, d4 = side(px, py, qx, qy, ax, ay), side(px, py, qx, qy, bx, by)
        crossed = np.any((d1 * d2 < 0.0) & (d3 * d4 < 0.0), axis=-1)
        middle = self.contains(0.5 * (np.asarray(x0) + x1), 0.5 * (np.asarray(y0) + y1))
        return np.asarray(crossed | middle | self.contains(np.asarray(x1), np.asarray(y1)))


class Cells:
    """Places whose nearest node of a regular grid is marked: land, or where there are no data. ``mask`` (ny, nx), the
    first node at (``x0``, ``y0``), mesh ``dx``, ``dy``, m. Legs are sampled at every half mesh."""

    def __init__(self, x0: float, y0: float, dx: float, dy: float, mask: Mask, name: str = "land") -> None:
        self.x0, self.y0, self.dx, self.dy, self.mask, self.name = x0, y0, dx, dy, np.asarray(mask, dtype=bool), name

    def contains(self, x: AnyArray, y: AnyArray) -> Mask:
        """Whether places lie on marked cells; beyond the grid that of its edge."""
        ny, nx = self.mask.shape
        i = np.clip(np.rint((np.asarray(x) - self.x0) / self.dx), 0, nx - 1).astype(int)
        j = np.clip(np.rint((np.asarray(y) - self.y0) / self.dy), 0, ny - 1).astype(int)
        return np.asarray(self.mask[j, i])

    def blocks(self, x0: AnyArray, y0: AnyArray, x1: AnyArray, y1: AnyArray) -> Mask:
        """Whether legs pass over marked cells."""
        if not self.mask.any():
            return np.zeros(np.broadcast(x0, y0, x1, y1).shape, dtype=bool)
        longest = float(np.max(np.hypot(x1 - x0, y1 - y0), initial=0.0))
        n = max(2, int(np.ceil(2.0 * longest / min(self.dx, self.dy))))
        crossed = np.zeros(np.broadcast(x0, y0, x1, y1).shape, dtype=bool)
        for k in range(1, n + 1):
            crossed |= self.contains(x0 + (x1 - x0) * (k / n), y0 + (y1 - y0) * (k / n))
        return crossed


Area = Disc | Polygon | Cells


def blocked(areas: Sequence[Area], x0: AnyArray, y0: AnyArray, x1: AnyArray, y1: AnyArray) -> Mask:
    """Whether any area is in the way."""
    blocking = np.zeros(np.broadcast(x0, y0, x1, y1).shape, dtype=bool)
    for area in areas:
        blocking |= area.blocks(x0, y0, x1, y1)
    return blocking


def containing(areas: Sequence[Area], x: float, y: float) -> Area | None:
    """The first area that a place lies in."""
    return next((a for a in areas if bool(a.contains(np.array([x]), np.array([y]))[0])), None)
