"""Polar diagrams given by tables, through their convex hulls: what a ship that may tack makes good.

    hull of {V(theta) (cos theta, sin theta)} and the origin,   V between the angles of the table linear

| symbol | meaning | unit |
|---|---|---|
| V(theta) | speed at angle theta from where the waves or the true wind come from | m/s |
| ends | what lies below the first and above the last angle: "no-go", no speed (a sailing boat, who tacks there), or "held" | - |
| level | wave height, m, or speed of the true wind, m/s: a row of the table | |

Assumptions: (1) speed depends on level and angle only; (2) between two levels the set of velocities is the linear mixture of
their hulls; (3) beyond the levels of the table the nearest row holds, and the share of a voyage there is told; (4) where there
is no direction (the centre of a vortex) the ship sails as against the sea. Waves beside the wind slow the ship by a factor,
V(W, theta) f(H, theta - delta), whose hulls are made for `TURNS` angles delta between wind and waves.

Source: the convex hull of a set of velocities is what fast changes between them make good (relaxed controls; L. C. Young,
Lectures on the Calculus of Variations, 1969).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..numeric.arrays import AnyArray
from .fields import Sea

Ends = Literal["held", "no-go"]
SAMPLES, TURNS = 7200, 48
"""Directions of a hull, and angles between wind and waves; 720 directions where there are both."""
TACKS = 1e-4
"""Share by which the hull must exceed the table where a ship tacks."""


class Table:
    """Rows of values over levels (n,), ascending, and angles (m,), rad, from 0 ascending to at most pi; the other side is the
    mirror image. Raises ``ValueError``."""

    def __init__(
        self, levels: Sequence[float], angles: Sequence[float], values: Sequence[Sequence[float]], ends: Ends = "held", *,
        level: str = "heights", value: str = "speeds",
    ) -> None:
        self.levels, self.angles = np.asarray(levels, dtype=float), np.asarray(angles, dtype=float)
        self.values = np.asarray(values, dtype=float) if len({len(row) for row in values}) == 1 else np.zeros((0, 0))
        self.ends = ends
        given = self.angles
        if self.values.shape != (len(self.levels), len(given)) or len(given) < 2 or not len(self.levels):
            shape = self.values.shape if self.values.size else [len(row) for row in values]
            raise ValueError(f"{value} have shape {shape}, expected ({len(self.levels)}, {len(given)})")
        if not (np.all(np.diff(given) > 0.0) and given[0] >= 0.0 and given[-1] <= math.pi + 1e-9):
            raise ValueError("angles must ascend from 0 (head sea) to at most pi (following sea)")
        if np.any(np.diff(self.levels) <= 0.0):
            raise ValueError(f"{level} must ascend")
        if not np.all(np.isfinite(self.values)) or np.any(self.values < 0.0):
            raise ValueError(f"{value} must be finite and not negative")

    @property
    def open_ends(self) -> tuple[float, float]:
        """Width of the angles below the first and above the last, rad."""
        return float(self.angles[0]), float(max(0.0, math.pi - self.angles[-1]))

    def at(self, theta: AnyArray) -> AnyArray:
        """Rows (n, k) at angles ``theta`` (k,), rad."""
        away = np.abs((np.asarray(theta) + math.pi) % (2.0 * math.pi) - math.pi)
        rows = np.array([np.interp(away, self.angles, row) for row in self.values])
        if self.ends == "no-go":
            rows[:, (away < self.angles[0] - 1e-9) | (away > self.angles[-1] + 1e-9)] = 0.0
        return rows

    def directions(self, count: int) -> AnyArray:
        """``count`` equal steps around and the angles of the table, ascending from -pi."""
        own = np.concatenate([self.angles, -self.angles])
        return np.unique(np.concatenate([circle(count), own[np.abs(own) < math.pi]]))

    def cell(self, level: AnyArray) -> tuple[NDArray[np.intp], NDArray[np.intp], AnyArray]:
        """(row below, row above, share of the one above) of a level, held beyond the ends."""
        v = np.clip(level, self.levels[0], self.levels[-1])
        low = np.clip(np.searchsorted(self.levels, v, side="right") - 1, 0, max(0, len(self.levels) - 2))
        high = np.minimum(low + 1, len(self.levels) - 1)
        width = np.where(high > low, self.levels[high] - self.levels[low], 1.0)
        return low, high, np.asarray((v - self.levels[low]) / width)

    def beyond(self, level: AnyArray) -> NDArray[np.bool_]:
        """Whether a level is above the table, whose last row then holds."""
        return np.asarray(np.asarray(level) > self.levels[-1])


def circle(count: int) -> AnyArray:
    """``count`` angles from -pi, at equal distances."""
    return np.linspace(-math.pi, math.pi, count, endpoint=False)


def hull(theta: AnyArray, speed: AnyArray, wanted: AnyArray) -> tuple[AnyArray, AnyArray]:
    """(radius at ``wanted``, angles of the corners) of the convex hull of a polar curve and the origin; ``theta`` ascending in
    -pi ... pi. 0 in directions in which the hull does not lie."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.column_stack([speed * np.cos(theta), speed * np.sin(theta)])
    try:
        corner = ConvexHull(np.vstack([points, [0.0, 0.0]])).vertices
    except QhullError:  # all on a line
        return np.interp(wanted, theta, speed, period=2.0 * math.pi), theta[speed > 0.0]
    corner = np.sort(corner[corner < len(theta)])
    corner = corner[speed[corner] > 0.0]
    a = theta[corner]
    place = np.searchsorted(a, wanted, side="right") - 1
    i, j = corner[place % len(a)], corner[(place + 1) % len(a)]
    open_side = np.mod(theta[j] - theta[i], 2.0 * math.pi) >= math.pi - 1e-12
    (xi, yi), (xj, yj) = points[i].T, points[j].T
    across = np.cos(wanted) * (yj - yi) - np.sin(wanted) * (xj - xi)
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = (xi * yj - yi * xj) / across
    on = np.isclose(wanted, theta[i], atol=1e-12)
    return np.where(on, speed[i], np.where(open_side, 0.0, radius)), a


def around(rows: AnyArray, index: tuple[AnyArray, ...], theta: AnyArray) -> AnyArray:
    """Rows (..., count) over a whole `circle`, at ``index`` of the first axes and angles ``theta``, linear between."""
    count = rows.shape[-1]
    place = (np.asarray(theta) + math.pi) / (2.0 * math.pi) * count
    cell = np.floor(place).astype(int)
    part = place - cell
    return np.asarray((1.0 - part) * rows[(*index, cell % count)] + part * rows[(*index, (cell + 1) % count)])


class TablePolar:
    """Speeds, m/s, over wave heights, m (``over`` "waves"), or speeds of the true wind, m/s (``over`` "wind"). Raises
    ``ValueError``."""

    def __init__(
        self, heights: Sequence[float], angles: Sequence[float], speeds: Sequence[Sequence[float]], name: str = "table",
        ends: Ends = "held", over: Literal["waves", "wind"] = "waves",
    ) -> None:
        self.name, self.over = name, over
        self.table = Table(heights, angles, speeds, ends, level="heights" if over == "waves" else "winds")
        theta, around_ = self.table.directions(SAMPLES), circle(SAMPLES)
        self._own = self.table.at(around_)
        hulls = [hull(theta, row, around_) for row in self.table.at(theta)]
        self._hull = np.array([radius for radius, _ in hulls])
        self._corners = [corners for _, corners in hulls]

    @property
    def needs_wind(self) -> bool:
        """Whether the wind must be known."""
        return self.over == "wind"

    @property
    def needs_waves(self) -> bool:
        """Whether the waves must be known."""
        return self.over == "waves"

    def speed_along(self, level: AnyArray, theta: AnyArray) -> AnyArray:
        """Speed of the hull at ``theta`` from where waves or wind come from, m/s, any shape."""
        return self._mix(self._hull, level, theta)

    def own_speed(self, level: AnyArray, theta: AnyArray) -> AnyArray:
        """Speed of the table itself, without tacking, m/s."""
        return self._mix(self._own, level, theta)

    def tack(self, level: float, theta: float) -> tuple[float, float] | None:
        """The two angles between which a ship tacks to make good ``theta``, or None where she sails it directly. At the
        tabulated level nearest to ``level``."""
        row = int(np.argmin(np.abs(self.table.levels - level)))
        at = np.array([self.table.levels[row]]), np.array([theta])
        if not self.speed_along(*at)[0] > (1.0 + TACKS) * self.own_speed(*at)[0]:
            return None
        corners, turn = self._corners[row], 2.0 * math.pi
        wrapped = (theta + math.pi) % turn - math.pi
        above = int(np.searchsorted(corners, wrapped, side="right"))
        low = corners[above - 1] - (turn if above == 0 else 0.0)
        return float(low), float(corners[above % len(corners)] + (turn if above == len(corners) else 0.0))

    def beyond(self, level: AnyArray) -> NDArray[np.bool_]:
        """Whether ``level`` is above the table, whose last row then holds."""
        return self.table.beyond(level)

    def sail(self, sea: Sea, wind: Sea | None, px: AnyArray, py: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """(speed of the hull along the unit vector p, that of the table itself, whether the level is above the table)."""
        given = wind if self.over == "wind" else sea
        assert given is not None
        theta = _from(given, px, py)
        return self.speed_along(given.height, theta), self.own_speed(given.height, theta), self.beyond(given.height)

    def _mix(self, rows: AnyArray, level: AnyArray, theta: AnyArray) -> AnyArray:
        low, high, share = self.table.cell(level)
        return np.asarray((1.0 - share) * around(rows, (low,), theta) + share * around(rows, (high,), theta))


class WindWavePolar:
    """Speeds, m/s, over the true wind, times factors over the waves. ``wind``: speeds over winds, m/s; ``waves``: factors over
    heights, m."""

    over = "wind"
    needs_wind = needs_waves = True

    def __init__(self, wind: Table, waves: Table, name: str = "wind and waves", samples: int = SAMPLES // 10) -> None:
        self.name, self.wind, self.waves = name, wind, waves
        theta, even = wind.directions(samples), circle(samples)
        shape = (len(wind.levels), len(waves.levels), TURNS, samples)
        self._own, self._hull = np.empty(shape), np.empty(shape)
        speeds, own = wind.at(theta), wind.at(even)
        for turn in range(TURNS):
            delta = 2.0 * math.pi * turn / TURNS
            slowed, here = waves.at(theta - delta), waves.at(even - delta)
            for h in range(shape[1]):
                self._own[:, h, turn] = own * here[h]
                for w in range(shape[0]):
                    self._hull[w, h, turn] = hull(theta, speeds[w] * slowed[h], even)[0]

    def sail(self, sea: Sea, wind: Sea | None, px: AnyArray, py: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """As `TablePolar.sail`."""
        assert wind is not None
        theta = _from(wind, px, py)
        between = np.where(sea.directed & wind.directed, theta - _from(sea, px, py), 0.0)
        delta = (between % (2.0 * math.pi)) / (2.0 * math.pi) * TURNS
        first = np.floor(delta).astype(int)
        part = delta - first
        (w0, w1, ws), (h0, h1, hs) = self.wind.cell(wind.height), self.waves.cell(sea.height)
        speeds = []
        for rows in (self._hull, self._own):
            total = 0.0 * part
            for w, w_share in ((w0, 1.0 - ws), (w1, ws)):
                for h, h_share in ((h0, 1.0 - hs), (h1, hs)):
                    for turn, share in ((first % TURNS, 1.0 - part), ((first + 1) % TURNS, part)):
                        total = total + w_share * h_share * share * around(rows, (w, h, turn), theta)
            speeds.append(total)
        return speeds[0], speeds[1], self.wind.beyond(wind.height) | self.waves.beyond(sea.height)


def _from(sea: Sea, px: AnyArray, py: AnyArray) -> AnyArray:
    """Angle from where waves or wind come from to p, rad; 0 where there is no direction."""
    return np.where(sea.directed, np.arctan2(py * sea.kx - px * sea.ky, px * sea.kx + py * sea.ky), 0.0)


Tabled = TablePolar | WindWavePolar
