"""Minimal-time routes by shooting: the source's iteration, and the safeguarded one.

Unknown are the direction alpha of the adjoint vector at the start and the time T. With D the miss at the end,

    V dT + j n' d alpha = D,      n = l/|l|,   n' across it to the left

| symbol | meaning | unit |
|---|---|---|
| V | velocity at the end | m/s |
| j_exact | true derivative of the end along n' with alpha, at fixed T | m/rad |
| j_seed | (|l|/D) int m rho D^2/|l|^3 dt: the source's, as if the displaced track met the same waves | m/rad |

Near a solution an iteration with fraction f of the step multiplies the error of alpha by 1 - f j_exact/j. With
j = j_seed (``seed``, f = 1: the source) it therefore converges linearly, oscillates with growing amplitude where
j_exact > 2 j_seed, that is where a storm focuses the tracks, and, because j_seed > 0, is driven away from extremals
behind a conjugate point, where j_exact < 0. ``safeguarded`` takes j = max(j_seed, j_exact), |dT| <= 0.2 T and
|d alpha| <= 0.3, the latter bound halved whenever alpha turns back and grown where it goes on: the multiplier lies in
[0, 1) at every local minimum and above 1 elsewhere, so it ends in minima only, and limit cycles across the ridge
between two of them die out. Once the miss is small and j_exact > 0, j = j_exact: a saddle has j_exact < 0, so Newton's
method cannot end in one there.

Certificate: j_exact > 0 along the whole track is Jacobi's condition (no conjugate point); with the convex polar this
makes the track a strict local minimum.

Assumptions: those of `medium`; no forbidden areas. Integration: fixed steps of order 8 (`system`); order 2 to 4 on
gridded data, whose second derivatives jump. How many steps, `extremals` decides.

Source: Minimal-time ship routing (1964), equations (16), (20)-(22); the finding on j is the project's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..heave.system import DORMAND_PRINCE_8
from ..numeric.arrays import AnyArray
from .medium import Medium

DELTA = 1e-6
"""Difference of alpha for j_exact, rad: the error of a share 1e-6 lies far below what the iteration feels."""
TURN_LIMIT, TIME_LIMIT = 0.3, 0.2
NEAR = 0.02
"""Miss over the distance below which j = j_exact > 0 is taken: quadratic convergence in mild seas too."""
Point = tuple[float, float]


@dataclass(frozen=True)
class Track:
    """A route at n + 1 instants, each (n + 1,): ``time`` (s), ``x``, ``y`` (m), adjoint angle ``normal`` (rad), ``j_exact``
    (m/rad), and what the source prints beside them: ``adjoint`` |l|, its J ``j_seed`` (m/rad)."""

    time: AnyArray
    x: AnyArray
    y: AnyArray
    normal: AnyArray
    j_exact: AnyArray
    adjoint: AnyArray
    j_seed: AnyArray

    @property
    def certified(self) -> bool:
        """Whether no conjugate point lies on it, the end included."""
        return bool(np.all(self.j_exact[1:] > 0.0))


@dataclass(frozen=True)
class Shots:
    """What became of k starts, arrays of shape (k,); ``miss`` in m, ``alpha`` not wrapped."""

    alpha: AnyArray
    time: AnyArray
    miss: AnyArray
    converged: NDArray[np.bool_]
    iterations: NDArray[np.int64]
    j_seed: AnyArray
    j_exact: AnyArray


def _fly(
    medium: Medium, start: Point, alpha: AnyArray, time: AnyArray, steps: int, keep: bool = False
) -> tuple[AnyArray, AnyArray]:
    """State (6, k): x, y, lx, ly, D, J after ``time`` (k,), and with ``keep`` all states (steps + 1, 6, k)."""
    one = np.ones_like(alpha)
    state = np.array([start[0] * one, start[1] * one, np.cos(alpha), np.sin(alpha), one, 0.0 * one])
    h = time / steps
    c, a, b = DORMAND_PRINCE_8.c, DORMAND_PRINCE_8.a, DORMAND_PRINCE_8.b
    history = [state]
    slopes = np.empty((len(c), *state.shape))
    rows = [np.array(row) for row in a]
    weights = np.array(b)
    flat = slopes.reshape(len(c), -1)
    for k in range(steps):
        for stage, row in enumerate(rows):
            at = state + h * (row @ flat[:stage]).reshape(state.shape) if stage else state
            slopes[stage] = medium.rates((k + c[stage]) * h, at[0], at[1], at[2], at[3], at[4])
        state = state + h * (weights @ flat).reshape(state.shape)
        if keep:
            history.append(state)
    return state, np.array(history) if keep else state[None]


def shoot(
    medium: Medium, start: Point, end: Point, alpha: Sequence[float] | AnyArray, time: Sequence[float] | AnyArray, *,
    method: str = "safeguarded", fraction: float = 1.0, steps: int = 32, iterations: int = 80, tolerance: float = 1e-10,
) -> Shots:
    """Iterate from every pair of starting values (k,) at once.

    ``method``: safeguarded, seed (the source's) or exact (Newton's, which also converges to saddles). ``tolerance``:
    miss over the distance. Starts that leave the range of numbers or reach a negative time end unconverged.
    """
    if method not in ("safeguarded", "seed", "exact"):
        raise ValueError(f"method {method!r}: expected safeguarded, seed or exact")
    alpha = np.array(alpha, dtype=float)
    time = np.array(time, dtype=float)
    k = len(alpha)
    miss, j_seed, j_exact = (np.full(k, math.inf) for _ in range(3))
    done, count = np.zeros(k, dtype=bool), np.zeros(k, dtype=int)
    turn, last = np.full(k, TURN_LIMIT), np.zeros(k)
    active = np.arange(k)
    span = math.dist(start, end)
    reach = tolerance * span
    ceiling = 50.0 * float(np.max(time, initial=0.0))
    for _ in range(iterations + 1):
        n = len(active)
        if not n:
            break
        pair = np.concatenate([alpha[active], alpha[active] + DELTA])
        with np.errstate(all="ignore"):
            state, _h = _fly(medium, start, pair, np.tile(time[active], 2), steps)
            x, y, lx, ly, d, integral = state[:, :n]
            vx, vy, _h = medium.velocity(time[active], x, y, lx, ly)
            size = np.hypot(lx, ly)
            nx, ny = lx / size, ly / size
            seed = integral * size / d
            exact = (nx * (state[1, n:] - y) - ny * (state[0, n:] - x)) / DELTA
            dx, dy = end[0] - x, end[1] - y
            distance = np.hypot(dx, dy)
            near = (exact > 0.0) & (distance < NEAR * span)
            guarded = np.where(near, exact, np.maximum(seed, exact))
            j = {"safeguarded": guarded, "seed": seed, "exact": exact}[method]
            d_time = (nx * dx + ny * dy) / (nx * vx + ny * vy)
            d_alpha = (nx * (dy - vy * d_time) - ny * (dx - vx * d_time)) / j
        miss[active], j_seed[active], j_exact[active] = distance, seed, exact
        hit = distance <= reach
        bad = ~np.isfinite(d_time + d_alpha + distance)
        done[active[hit]] = True
        if method == "safeguarded":
            swings = d_alpha * last[active] < 0.0
            turn[active] = np.where(swings, 0.5 * turn[active], np.minimum(TURN_LIMIT, 1.5 * turn[active]))
            d_alpha = np.clip(d_alpha, -turn[active], turn[active])
            d_time = np.clip(d_time, -TIME_LIMIT * time[active], TIME_LIMIT * time[active])
        last[active] = d_alpha
        go = ~hit & ~bad
        moved = active[go]
        alpha[moved] += fraction * d_alpha[go]
        time[moved] += fraction * d_time[go]
        count[moved] += 1
        active = moved[(time[moved] > 0.0) & (time[moved] < ceiling)]
    return Shots(alpha, time, miss, done, count, j_seed, j_exact)


def tracks(
    medium: Medium, start: Point, alpha: Sequence[float] | AnyArray, time: Sequence[float] | AnyArray, steps: int = 32
) -> list[Track]:
    """The extremals of k pairs ``alpha``, ``time`` at ``steps`` + 1 instants each."""
    k = len(alpha)
    first, last = np.array(alpha, dtype=float), np.array(time, dtype=float)
    _, history = _fly(medium, start, np.concatenate([first, first + DELTA]), np.tile(last, 2), steps, keep=True)
    tracks = []
    for i in range(k):
        x, y, lx, ly = (history[:, c, i] for c in range(4))
        size = np.hypot(lx, ly)
        j = (lx / size * (history[:, 1, k + i] - y) - ly / size * (history[:, 0, k + i] - x)) / DELTA
        tracks.append(Track(np.linspace(0.0, last[i], steps + 1), x, y, np.unwrap(np.arctan2(ly, lx)), j, size,
                            history[:, 5, i] * size / history[:, 4, i]))  # fmt: skip
    return tracks
