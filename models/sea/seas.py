"""Seas of one or two peaks, or by a table, as lists of components.

A sea is a shape over x = omega/omega_p, which stays while significant height and peak period change. Two peaks have a rule
and directions each; a table has one rule a direction. As the nodes of Gauss rules are nowhere equidistant, no record repeats,
whatever its length: there is no period that it could outlast.

Sources: `waves`; the six parameters of Ochi and Hubble (1976) are heights, peak frequencies and orders of two peaks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from . import waves
from .heave_response import Components, Row, listed, peak


class Shape(NamedTuple):
    """Parameters of `ship_in_sea` by which the components are made. ``second_share``: of m0, in the second peak;
    ``second_frequency``: its peak over that of the first; ``second_direction``: relative to the first, rad."""

    components: float = 100.0
    peakedness: float = 1.0
    spreading: float = -1.0
    directions: float = 8.0
    order: float = 1.0
    second_share: float = 0.0
    second_frequency: float = 0.5
    second_peakedness: float = 1.0
    second_order: float = 1.0
    second_direction: float = 0.0


@dataclass(frozen=True)
class SeaTable:
    """A measured spectrum: densities, m2 s/rad, by direction over ``frequencies``, rad/s, linear between them and nothing
    beyond; for every direction its angle relative to the mean one, rad, and its width, rad (a single one: 0 and 1).
    ``height`` and ``frequency`` are its significant height, m, and peak frequency, rad/s."""

    frequencies: tuple[float, ...]
    directions: tuple[tuple[float, float], ...]
    densities: tuple[tuple[float, ...], ...]
    height: float
    frequency: float


@lru_cache(maxsize=32)
def sea_components(shape: Shape, table: SeaTable | None, seed: int) -> Components:
    """The components, at most 300 a rule. Raises ``ValueError`` as `waves` does."""
    return listed(rows_of_table(table, round(shape.components)) if table else rows_of(shape), seed)


def rows_of(shape: Shape) -> list[Row]:
    """The components of one peak or two, shared between them by halves."""
    n, spread, directions = round(shape.components), round(shape.spreading), round(shape.directions)
    if shape.second_share <= 0.0:
        return peak(n, shape.peakedness, spread, directions, order=shape.order)
    first = peak(n - n // 2, shape.peakedness, spread, directions, order=shape.order)
    second = peak(max(1, n // 2), shape.second_peakedness, spread, directions, order=shape.second_order)
    share = math.sqrt(shape.second_share)
    rest = math.sqrt(1.0 - shape.second_share)
    return [
        *((x, rest * a, mu) for x, a, mu in first),
        *((shape.second_frequency * x, share * a, mu + shape.second_direction) for x, a, mu in second),
    ]


def rows_of_table(table: SeaTable, n: int) -> list[Row]:
    """The components of a table, by direction in proportion to what comes from there."""
    measures = [measure(table.frequencies, row) for row in table.densities]
    energies = [width * sum(w for _, w in points) for points, (_, width) in zip(measures, table.directions)]
    m0, rows = math.fsum(energies), []
    for points, energy, (mu, width) in zip(measures, energies, table.directions):
        if energy <= 1e-6 * m0:
            continue
        own = min(300, len(points), max(2, round(n * energy / m0)))
        # a = sqrt(2 w), Hs = 4 sqrt(m0)
        for omega, w in waves.rule_of(points, own):
            rows.append((omega / table.frequency, math.sqrt(2.0 * width * w / (16.0 * m0)), mu))
    return rows


def measure(frequencies: Sequence[float], densities: Sequence[float]) -> list[tuple[float, float]]:
    """(omega, weight) that integrate powers of omega over a spectrum of straight lines: Gauss-Legendre, 8 points a line."""
    points = []
    for a, b, s, e in zip(frequencies, frequencies[1:], densities, densities[1:]):
        for x, w in waves.legendre_rule(8):
            share = 0.5 + 0.5 * x
            weight = 0.5 * (b - a) * w * (s + share * (e - s))
            if weight > 0.0:
                points.append((a + share * (b - a), weight))
    return points
