"""Exact step of a linear system whose inputs are polynomials of time over the step.

    x' = A x + B u(t),  u(t0 + s) = a_0 + a_1 s + ... + a_p s^p
    x(t0 + h) = Ad x(t0) + sum_k G_k a_k,   Ad = exp(A h),  G_k = int_0^h exp(A (h - s)) s^k ds B

All of Ad and G_k come from one exponential of [[A, B, 0], [0, 0, I], [0, 0, 0]]-like blocks (Van Loan), formed once for
a step length. There is no stability limit: the spectral radius of Ad is exp(max Re(eigenvalues) h). A is balanced by a
diagonal similarity first; without it the mixed units of displacements and velocities cost digits in the squaring.

Not to be confused with exponential Runge-Kutta methods: nothing is nonlinear here.

Source: Van Loan, IEEE Trans. Automatic Control 23 (1978); the input order is that of the co-simulation signals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .arrays import Array

ORDER = 3
"""Degree of the inputs over a communication step."""


@dataclass(frozen=True)
class ExactStep:
    """``transition`` (n, n) and ``gains`` (n, m (p+1)), input by input for each power of time in turn."""

    transition: Array
    gains: Array

    def advance(self, x: Array, coefficients: Array) -> Array:
        """State after the step; ``coefficients`` (p+1, m) are those of 1, s, s^2, ..."""
        after: Array = self.transition @ x + self.gains @ coefficients.ravel()
        return after

    @property
    def spectral_radius(self) -> float:
        """Below 1: the step damps every perturbation in the long run."""
        return float(np.abs(np.linalg.eigvals(self.transition)).max())


def exact_step(a: Array, b: Array, step: float, order: int = ORDER) -> ExactStep:
    """The operators for ``step`` > 0, s."""
    from scipy.linalg import (  # half of a unit's load time, which a host that only looks need not pay
        expm,
        matrix_balance,
    )

    n, m = b.shape
    if not n:
        return ExactStep(np.zeros((0, 0)), np.zeros((0, m * (order + 1))))
    balanced, (scale, _) = matrix_balance(a, permute=False, separate=True)
    size = n + m * (order + 1)
    block = np.zeros((size, size))
    block[:n, :n] = balanced * step
    block[:n, n : n + m] = b / scale[:, None] * step
    for k in range(order):
        block[n + k * m : n + (k + 1) * m, n + (k + 1) * m : n + (k + 2) * m] = np.eye(m)
    whole = expm(block)
    gains = [whole[:n, n + k * m : n + (k + 1) * m] * math.factorial(k) * step**k for k in range(order + 1)]
    return ExactStep(whole[:n, :n] * scale[:, None] / scale, np.hstack(gains) * scale[:, None])
