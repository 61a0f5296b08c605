"""Limits of what a ship, and what hangs from her, may answer to the sea along a route.

    use(H, T, mu) <= 1,   use = expected response over its limit

| symbol | meaning | unit |
|---|---|---|
| H, T | significant height and peak period where and when the ship is there | m, s |
| mu | angle between her course through the water and the waves' travel, 0 following, pi head sea; both sides are alike | rad |

A limit is a table of the use over periods and headings, for 1 m of height where the answer is linear, or over heights too.
Between the entries it is linear. Above the largest height of a table nothing is known, which counts as beyond the limit; below
the least one, and beyond the periods, the nearest entries count, and for how long is told. Where the waves have no direction the
worst heading counts.

A route is searched in what the limits leave of place, time and heading, with `SPARE` to spare. A ship that tacks is asked for the
course that she makes good.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..numeric.arrays import AnyArray
from .fields import Sea

if TYPE_CHECKING:
    from .medium import Medium

SPARE = 1e-3
"""Of the limit: between the places where a leg is asked the use may be a little higher."""
ROUND, BEATING = 3e-4, 1e-2
"""Measured errors of lattice paths around a storm that is too high, and against waves from which a ship must keep off 30 degrees
(0.8 %)."""
CLOSE, FINE = 0.2, 8
"""Length between places where a long leg is asked, in details of the sea; least places on a leg of a finished route."""


@dataclass(frozen=True, eq=False)
class Limit:
    """``use`` (heights, periods, headings) over ``periods``, s, and ``headings``, rad, 0 to pi, ascending; ``heights``, m, or
    None where ``use`` (1, periods, headings) is that of 1 m. ``text``: what may not be more than what, "heave 1.5 m"."""

    name: str
    text: str
    periods: AnyArray
    headings: AnyArray
    use: AnyArray
    heights: AnyArray | None = None

    def of(self, height: AnyArray, period: AnyArray, heading: AnyArray) -> AnyArray:
        """The use, of any shape; without end above the heights that are known."""
        (j, b), (k, c) = _place(self.periods, period), _place(self.headings, heading)
        if self.heights is None:
            return np.asarray(height * self._plane(np.zeros_like(j), j, k, b, c))
        i, a = _place(self.heights, height)
        low, high = (self._plane(n, j, k, b, c) for n in (i, np.minimum(i + 1, len(self.heights) - 1)))
        known = height <= self.heights[-1] * (1.0 + 1e-9)
        return np.where(known, (1.0 - a) * low + a * high, math.inf)

    def _plane(self, i: AnyArray, j: AnyArray, k: AnyArray, b: AnyArray, c: AnyArray) -> AnyArray:
        """At the heights ``i``."""
        jj, kk = np.minimum(j + 1, len(self.periods) - 1), np.minimum(k + 1, len(self.headings) - 1)
        use = self.use
        return np.asarray((1.0 - b) * ((1.0 - c) * use[i, j, k] + c * use[i, j, kk])
                          + b * ((1.0 - c) * use[i, jj, k] + c * use[i, jj, kk]))  # fmt: skip

    def beyond(self, height: AnyArray, period: AnyArray) -> AnyArray:
        """Whether the nearest entries count."""
        lowest = -math.inf if self.heights is None else self.heights[0]
        return np.asarray((height < lowest) | (period < self.periods[0]) | (period > self.periods[-1]))

    def in_sea(self, sea: Sea, period: AnyArray, px: AnyArray, py: AnyArray) -> AnyArray:
        """The use on the course p through the water."""
        toward = np.clip(px * sea.kx + py * sea.ky, -1.0, 1.0)
        found = self.of(sea.height, period, np.arccos(-toward))
        if np.all(sea.directed):
            return found
        worst = np.max([self.of(sea.height, period, np.full(found.shape, mu)) for mu in self.headings], axis=0)
        return np.where(sea.directed, found, worst)


def _place(axis: AnyArray, value: AnyArray) -> tuple[AnyArray, AnyArray]:
    """(entry below, share of the next); the nearest end beyond."""
    v = np.clip(value, axis[0], axis[-1])
    k = np.clip(np.searchsorted(axis, v, side="right") - 1, 0, max(0, len(axis) - 2))
    width = axis[np.minimum(k + 1, len(axis) - 1)] - axis[k]
    return k, np.asarray(np.where(width > 0.0, (v - axis[k]) / np.where(width > 0.0, width, 1.0), 0.0))


def exceeded(
    medium: Medium, t: AnyArray, spent: AnyArray, x0: AnyArray, y0: AnyArray, dx: AnyArray, dy: AnyArray
) -> AnyArray:
    """Whether legs (dx, dy) from (x0, y0), begun at ``t`` and sailed in ``spent``, break a limit; arrays that broadcast."""
    length = np.hypot(dx, dy)
    known = np.isfinite(spent) & (length > 0.0)
    px, py = dx / np.maximum(length, 1e-300), dy / np.maximum(length, 1e-300)
    longest = float(np.max(length, initial=0.0))
    count = int(np.clip(math.ceil(longest / (CLOSE * medium.detail)), 1, 24))
    shape = np.broadcast(t, spent, dx, x0).shape
    share = np.linspace(0.0, 1.0, count + 1).reshape(-1, *[1] * len(shape))
    time = np.where(known, spent, 0.0)
    places = np.broadcast_arrays(t + share * time, x0 + share * dx, y0 + share * dy, px, py)
    return np.asarray(np.any(np.array(medium.uses(*places)) > 1.0 - SPARE, axis=(0, 1)) & known)


@dataclass(frozen=True)
class Kept:
    """How a route keeps a limit: its largest ``use``, where (m) and when (s), and the share of the time in which the nearest
    entries of the table count."""

    limit: Limit
    use: float
    x: float
    y: float
    time: float
    beyond: float

    @property
    def place(self) -> str:
        """Where and when."""
        return f"({self.x:.6g}, {self.y:.6g}) m after {self.time / 3600.0:.2f} h"


def kept(medium: Medium, time: AnyArray, x: AnyArray, y: AnyArray) -> tuple[Kept, ...]:
    """How a finished route of legs keeps every limit, asked at `FINE` places a leg or more."""
    if not medium.limits or len(time) < 2:
        return ()
    longest = float(np.max(np.hypot(np.diff(x), np.diff(y))))
    fine = FINE if math.isinf(medium.detail) else int(np.clip(2.0 * longest / (CLOSE * medium.detail), FINE, 512))
    share = (np.arange(fine) + 0.5) / fine
    share = np.concatenate([[0.0], share, [1.0]])
    t, at_x, at_y = (np.ravel(v[:-1, None] + np.diff(v)[:, None] * share) for v in (time, x, y))
    dx, dy = (np.repeat(np.diff(v), len(share)) for v in (x, y))
    size = np.maximum(np.hypot(dx, dy), 1e-300)
    uses = medium.uses(t, at_x, at_y, dx / size, dy / size)
    sea = medium.field.at(at_x, at_y, t)
    period = medium.period(sea, at_x, at_y, t)
    weight = np.repeat(np.diff(time), len(share)) / len(share) / time[-1]
    found = []
    for limit, use in zip(medium.limits, uses):
        k = int(np.argmax(use))
        beyond = float(np.sum(weight * limit.beyond(sea.height, period)))
        found.append(Kept(limit, float(use[k]), float(at_x[k]), float(at_y[k]), float(t[k]), beyond))
    return tuple(found)


def error(medium: Medium) -> float:
    """Of a refined lattice path, as a share of its time: larger where a limit asks for the heading, and a ship has to beat."""
    return max((BEATING if np.any(np.ptp(limit.use, axis=-1) > 1e-9) else ROUND for limit in medium.limits), default=0.0)


def broken(found: Sequence[Kept]) -> Kept | None:
    """The limit that is broken most, if one is."""
    worst = max(found, key=lambda one: one.use, default=None)
    return worst if worst is not None and worst.use > 1.0 else None
