"""The matrix of Newton's method over all nodes of a chain: banded, factorised once, used many times."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ...numeric.arrays import AnyArray, Array


@cache
def _band_index(elements: int, degree: int, dimensions: int) -> AnyArray:
    """Where the entries (E, p+1, d, p+1, d) stand in the band (3 w + 1, n d), flat, as LAPACK's gbtrf wants it."""
    p, d = degree, dimensions
    node = np.arange(elements)[:, None] * p + np.arange(p + 1)
    equation = (node[:, :, None] * d + np.arange(d)).reshape(elements, -1)
    width = (p + 1) * d - 1
    row, column = equation[:, :, None], equation[:, None, :]
    index: AnyArray = ((2 * width + row - column) * ((elements * p + 1) * d) + column).ravel()
    return index


@dataclass(frozen=True)
class Factors:
    """Of a band: LAPACK's LU and pivots, its half ``width``, first equation and number of those that are solved."""

    lu: Array
    pivots: AnyArray
    width: int
    first: int
    count: int

    def solve(self, right: Array) -> Array:
        """Solution for values at the free nodes (m, d), in the same shape."""
        from scipy.linalg.lapack import dgbtrs  # loads slowly, see `exact_step`

        solution, _ = dgbtrs(self.lu, self.width, self.width, right.reshape(-1), self.pivots)
        values: Array = solution.reshape(right.shape)
        return values


def factorised(local: Array, free: slice) -> Factors | None:
    """Of the sum of elements' matrices (E, p+1, d, p+1, d) at the ``free`` nodes; None where it is singular."""
    from scipy.linalg.lapack import dgbtrf

    elements, per, dimensions = local.shape[:3]
    size = (elements * (per - 1) + 1) * dimensions
    width = per * dimensions - 1
    band: Any = np.bincount(
        _band_index(elements, per - 1, dimensions), weights=local.ravel(), minlength=(3 * width + 1) * size
    ).reshape(3 * width + 1, size)
    first, last = free.indices(size // dimensions)[:2]
    first, last = first * dimensions, last * dimensions
    if not np.all(np.isfinite(band)):
        return None
    # equations that are not solved are cut off: their columns here, their rows by the length
    cut = band[:, first:last].copy()
    for k in range(min(width, last - first)):
        cut[: 2 * width - k, k] = 0.0
        cut[2 * width + k + 1 :, last - first - 1 - k] = 0.0
    lu, pivots, info = dgbtrf(cut, width, width)
    if info != 0:
        return None
    return Factors(lu, pivots, width, first, last - first)
