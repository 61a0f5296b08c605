"""Places of the global search: a lattice from start to end, and rings around forbidden areas that find the passages between
them.

A ring around a disc is a polygon with the disc inside, close enough to pass a gap of which three rings would fill the width; a
ring around a polygon stands off its corners by as much. Places of rings and of gaps reach all places within ``radius`` meshes.

Assumptions: a passage narrower than `NARROWEST` of the distance is closed; grids of cells (land) have no rings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..numeric.arrays import AnyArray
from .areas import Area, Disc, Polygon

NARROWEST = 1e-4
MOST = 180
"""Places of a ring."""


@dataclass(frozen=True)
class Nodes:
    """``x``, ``y`` (n,), m: the lattice of ``rows`` and ``columns`` first, then the others. ``offsets`` (k, 2): legs of the
    lattice. ``near``: other places within reach of every place, and of the others lattice places too."""

    x: AnyArray
    y: AnyArray
    rows: int
    columns: int
    offsets: AnyArray
    source: int
    target: int
    near: dict[int, AnyArray]

    def ahead(self, node: int) -> AnyArray:
        """Places that legs lead to."""
        other = self.near.get(node, np.zeros(0, dtype=int))
        if node >= self.rows * self.columns:
            return other
        row, column = divmod(node, self.columns)
        at = self.offsets + np.array([row, column])
        at = at[(at[:, 0] >= 0) & (at[:, 0] < self.rows) & (at[:, 1] >= 0) & (at[:, 1] < self.columns)]
        return np.concatenate([at[:, 0] * self.columns + at[:, 1], other])


def lattice(
    start: tuple[float, float], end: tuple[float, float], areas: Sequence[Area], cells: int, radius: int, width: float,
    behind: float,
) -> Nodes:
    """``cells`` meshes from start to end, ``width`` D to either side and ``behind`` D beyond both ends."""
    distance = math.dist(start, end)
    mesh = distance / cells
    ex, ey = (end[0] - start[0]) / distance, (end[1] - start[1]) / distance
    back, side = math.ceil(behind * cells), math.ceil(width * cells)
    rows, columns = cells + 2 * back + 1, 2 * side + 1
    offsets = np.array([
        (i, j) for i in range(-radius, radius + 1) for j in range(-radius, radius + 1) if math.gcd(i, j) == 1
    ])  # fmt: skip
    i, j = np.meshgrid(np.arange(rows) - back, np.arange(columns) - side, indexing="ij")
    x = (start[0] + mesh * (i * ex - j * ey)).ravel()
    y = (start[1] + mesh * (i * ey + j * ex)).ravel()
    source, target = back * columns + side, (back + cells) * columns + side
    x[target], y[target] = end
    others = around(areas, mesh, NARROWEST * distance)
    near: dict[int, AnyArray] = {}
    if len(others):
        from scipy.spatial import cKDTree

        base = len(x)
        places = np.vstack([np.column_stack([x, y]), others])
        tree = cKDTree(others)
        reach = radius * mesh
        for node, found in enumerate(tree.query_ball_point(places, reach)):
            if found:
                near[node] = base + np.array(found)
        whole = cKDTree(places[:base])
        for k, found in enumerate(whole.query_ball_point(others, reach)):
            near[base + k] = np.concatenate([near[base + k], np.array(found, dtype=int)])
        x, y = places.T
    return Nodes(x, y, rows, columns, offsets, source, target, near)


def around(areas: Sequence[Area], mesh: float, narrowest: float) -> AnyArray:
    """Places (n, 2) beside areas, and in the middle of gaps that the mesh may miss."""
    solid = [area for area in areas if isinstance(area, (Disc, Polygon))]
    places: list[AnyArray] = [np.zeros((0, 2))]
    for k, area in enumerate(solid):
        least = mesh
        for n, other in enumerate(solid):
            if n != k:
                gap, middle = _gap(area, other)
                if narrowest < gap < 2.0 * mesh:
                    least = min(least, gap)
                    if n > k:
                        places.append(middle[None])
        places.append(_ring(area, min(0.25 * least, 0.125 * mesh)))
    return np.concatenate(places)


def _ring(area: Disc | Polygon, off: float) -> AnyArray:
    """Places around an area, at most ``off`` away, whose neighbours see each other."""
    if isinstance(area, Disc):
        half = math.acos(area.radius / (area.radius + off))
        n = int(np.clip(math.ceil(math.pi / half), 8, MOST))
        angle = 2.0 * math.pi * np.arange(n) / n
        r = area.radius / math.cos(math.pi / n) * (1.0 + 1e-9)
        return np.column_stack([area.x + r * np.cos(angle), area.y + r * np.sin(angle)])
    corners = area.corners
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    turn = np.sign(np.sum(corners[:, 0] * np.roll(corners[:, 1], -1) - corners[:, 1] * np.roll(corners[:, 0], -1)))
    normals = [turn * np.column_stack([e[:, 1], -e[:, 0]]) / np.hypot(*e.T)[:, None] for e in (before, after)]
    middle = normals[0] + normals[1]
    size = np.maximum(np.hypot(*middle.T), 0.1)[:, None]
    return np.asarray(corners + off * 2.0 * middle / size**2)


def _gap(one: Disc | Polygon, two: Disc | Polygon) -> tuple[float, AnyArray]:
    """(width, middle) of the gap between two areas."""
    best, middle = math.inf, np.zeros(2)
    for a, b in ((one, two), (two, one)):
        for p in _outline(a):
            q = _nearest(b, p)
            d = float(np.hypot(*(q - p)))
            ra = a.radius if isinstance(a, Disc) else 0.0
            rb = b.radius if isinstance(b, Disc) else 0.0
            if d - ra - rb < best and d > 0.0:
                best = d - ra - rb
                middle = p + (q - p) / d * (ra + 0.5 * best)
    return best, middle


def _outline(area: Disc | Polygon) -> AnyArray:
    """Corners, or the centre of a disc."""
    return np.array([[area.x, area.y]]) if isinstance(area, Disc) else area.corners


def _nearest(area: Disc | Polygon, p: AnyArray) -> AnyArray:
    """The nearest place on the edges of a polygon, or the centre of a disc."""
    if isinstance(area, Disc):
        return np.array([area.x, area.y])
    a = area.corners
    e = np.roll(a, -1, axis=0) - a
    s = np.clip(np.sum((p - a) * e, axis=1) / np.maximum(np.sum(e * e, axis=1), 1e-300), 0.0, 1.0)
    at = a + s[:, None] * e
    return np.asarray(at[np.argmin(np.hypot(*(at - p).T))])
