"""Towed slender body: modes followed over the tow speed.

A path is a pair of exponents: a conjugate pair, or two real exponents that will meet or have met. From one speed to the
next every exponent is predicted with its derivative ds/du and matched to the exponents found there by the assignment of
least total distance. Pairs on the real axis are handed over as pairs: sum and product of a pair stay smooth where its
exponents meet (s - s* ~ sqrt(u - u*)), and if exponents of two paths meet, partners are exchanged.

Measured on five oscillatory modes from u = 0.3 to 6.4 (lam = .015, Lam = 1): nearest neighbour, extrapolation or
assignment alone lose one mode with steps of 0.5 and 1; derivative and assignment together lose none up to 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ..numeric.arrays import Array, ComplexArray
from .galerkin import Matrices
from .modes import modes, rates_of_change


@dataclass
class Path:
    """One mode over the speeds: ``roots`` of shape (len(speeds), 2), with Im >= 0 first, the larger first where both are
    real."""

    roots: ComplexArray

    @property
    def total(self) -> Array:
        """Sum of the pair, real, shape (len(speeds),)."""
        return np.asarray(self.roots.sum(axis=1).real)

    @property
    def product(self) -> Array:
        """Product of the pair, real, shape (len(speeds),)."""
        return np.asarray(self.roots.prod(axis=1).real)

    @property
    def oscillates(self) -> NDArray[np.bool_]:
        """Whether the pair is a conjugate pair at each speed, shape (len(speeds),)."""
        return np.asarray(self.roots[:, 0].imag > 0.0)


def track(system: Matrices, speeds: Array, within: float = 150.0, count: int | None = None) -> list[Path]:
    """Modes with |s| < ``within`` at the first speed, the first ``count`` of them by magnitude, followed over ``speeds``
    (ascending or descending). Raises ``ValueError`` if the speeds are fewer than one or not finite."""
    speeds = np.asarray(speeds, dtype=float)
    if not len(speeds) or not np.all(np.isfinite(speeds)):
        raise ValueError("track: expected finite tow speeds, at least one")
    s, right, left = modes(system, float(speeds[0]))
    pairs = _pairs(s, within)[:count]
    history = [[_ordered(s[i], s[j]) for i, j in pairs]]
    for here, there in pairwise(speeds):
        chosen = [k for pair in pairs for k in pair]
        step = float(there - here)
        slope = rates_of_change(system, float(here), s[chosen], right[:, chosen], left[:, chosen])
        move = slope * step
        # near a double root the derivative is without bound: no further than its neighbour is needed
        bound = np.array([np.sort(np.abs(s - s[k]))[1] for k in chosen]) + 0.5 * np.abs(step) * (1.0 + np.abs(s[chosen]))
        size = np.abs(move)
        safe = np.where(np.isfinite(size), size, 1.0)
        move = np.where(np.isfinite(size), move, 0.0) * np.minimum(1.0, bound / np.maximum(safe, 1e-300))
        predicted = s[chosen] + move
        s, right, left = modes(system, float(there))
        _, columns = linear_sum_assignment(np.abs(predicted[:, None] - s[None, :]))
        pairs = _repair([(int(columns[2 * k]), int(columns[2 * k + 1])) for k in range(len(pairs))], s)
        history.append([_ordered(s[i], s[j]) for i, j in pairs])
    return [Path(np.array([row[k] for row in history])) for k in range(len(pairs))]


def _ordered(a: complex, b: complex) -> tuple[complex, complex]:
    return (a, b) if (a.imag, a.real) >= (b.imag, b.real) else (b, a)


def _conjugate(s: ComplexArray, i: int) -> int:
    return int(np.argmin(np.abs(s - np.conj(s[i]))))


def _pairs(s: ComplexArray, within: float) -> list[tuple[int, int]]:
    """Conjugate pairs and neighbouring real exponents, by magnitude of the first; a last single real one joins the next
    real one beyond ``within``, if there is one."""
    pairs: list[tuple[int, int]] = []
    waiting: int | None = None
    for i, value in enumerate(s):
        if value.imag > 0.0 and abs(value) < within:
            pairs.append((i, _conjugate(s, i)))
        elif value.imag == 0.0:
            if waiting is not None:
                pairs.append((waiting, i))
                waiting = None
            elif abs(value) < within:
                waiting = i
    return sorted(pairs)


def _repair(pairs: list[tuple[int, int]], s: ComplexArray) -> list[tuple[int, int]]:
    """Partners such that every pair is conjugate or real: complex exponents get their conjugate, real ones left without
    partner find each other in the order of the paths."""
    result: list[tuple[int, int] | None] = []
    used: set[int] = set()
    single: list[tuple[int, int]] = []
    for place, (i, j) in enumerate(pairs):
        if s[i].imag == 0.0 and s[j].imag == 0.0:
            result.append((i, j))
            used |= {i, j}
            continue
        lead = next((k for k in (i, j) if s[k].imag != 0.0 and k not in used), None)
        if lead is not None:
            partner = _conjugate(s, lead)
            if partner not in used:
                result.append((lead, partner))
                used |= {lead, partner}
                single += [(place, k) for k in (i, j) if s[k].imag == 0.0]
                continue
        result.append(None)
        single += [(place, k) for k in (i, j) if s[k].imag == 0.0]
    for place, pair in enumerate(result):
        if pair is None:
            free = [k for _, k in single if k not in used]
            free += [k for k in range(len(s)) if s[k].imag == 0.0 and k not in used and k not in free]
            if len(free) < 2:  # two paths claimed one conjugate pair: take the next that is free
                lead = next(k for k in range(len(s)) if s[k].imag > 0.0 and k not in used)
                free = [lead, _conjugate(s, lead)]
            result[place] = (free[0], free[1])
            used |= {free[0], free[1]}
    return [pair for pair in result if pair is not None]
