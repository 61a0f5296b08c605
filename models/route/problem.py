"""What is asked of a route, what an answer is, and why there may be none."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..numeric.arrays import AnyArray
from .areas import Area
from .graph import Point
from .medium import Medium
from .shooting import Track


class RouteError(ValueError):
    """No route, and why. ``reason``: a word for programs (outside, forbidden, unreachable, diverged, input)."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True)
class Problem:
    """From ``start`` to ``end``, m, in ``medium`` without touching ``areas``; time 0 is the departure."""

    medium: Medium
    start: Point
    end: Point
    areas: tuple[Area, ...] = ()


@dataclass(frozen=True)
class Route:
    """A way to sail: ``time``, ``x``, ``y`` (n,) in s and m. ``kind``: extremal, visibility, corridor, straight, geodesic or
    none (start = end). ``certified``: an extremal that is a local minimum by Jacobi's condition, with ``j_exact`` and
    ``j_seed``, m/rad, and its ``track``, or a shortest path of the visibility graph. ``error``: estimated, of the duration, s."""

    kind: str
    time: AnyArray
    x: AnyArray
    y: AnyArray
    certified: bool = False
    j_exact: float = math.nan
    j_seed: float = math.nan
    iterations: int = 0
    alpha: float = math.nan
    error: float = math.nan
    track: Track | None = None

    @property
    def duration(self) -> float:
        """Time of arrival, s."""
        return float(self.time[-1])
