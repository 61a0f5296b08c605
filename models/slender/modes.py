"""Towed slender body: the modes at a tow speed, from the matrices of `galerkin`.

    (s^2 M + s (nu K0 + u D1) + K0 + u^2 K2) q = 0

Against the series determinant about the middle (90 terms), 26 functions give the first six roots to 1e-14 .. 2e-13 for u
from 0.01 to 12 and Lam from 0.5 to 10, and to 3e-9 for Lam = 1e-6. Chebyshev collocation of the strong form reaches
1e-6 .. 1e-7: its fourth derivative is ill conditioned.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..numeric.arrays import ComplexArray
from ..numeric.matrix_ops import numbers
from .coefficients import Body
from .galerkin import Matrices, galerkin

FUNCTIONS = 26
"""Shape functions of the converged spectrum."""


@lru_cache(maxsize=64)
def matrices(body: Body, n: int = FUNCTIONS) -> Matrices:
    """`galerkin` for numpy, remembered."""
    return galerkin(body.numbers, n, numbers())


def roots(system: Matrices, u: float) -> ComplexArray:
    """All 2n exponents s at tow speed ``u``, by magnitude. Raises ``ValueError`` for a negative or infinite speed."""
    return modes(system, u, vectors=False)[0]


def modes(system: Matrices, u: float, vectors: bool = True) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """(s, right, left): exponents of shape (2n,) by magnitude, vectors q of shape (n, 2n) with
    pencil(u, s) q = 0 and left^H pencil(u, s) = 0 (empty if not wanted)."""
    check_speed(u)
    n = system.n
    a = system.companion(u)
    if not vectors:
        s = np.linalg.eigvals(a).astype(complex)
        return s[np.argsort(np.abs(s), kind="stable")], np.empty((n, 0), complex), np.empty((n, 0), complex)
    from scipy.linalg import eig  # loads slowly, see `exact_step`

    s, left, right = eig(a, left=True, right=True)
    order = np.argsort(np.abs(s), kind="stable")
    # a left vector (p, r) of the companion form has r^H M^-1 as the left vector of the pencil
    lower = np.linalg.solve(system.mass.T, left[n:, order])
    return s[order], right[:n, order] / system.scale[:, None], lower


def check_speed(u: float) -> None:
    """Raises ``ValueError`` for a tow speed that is negative or not finite."""
    if not 0.0 <= u < np.inf:
        raise ValueError(f"tow speed {u:g}: expected a finite number that is not negative; the body is towed nose first")


def spectrum(system: Matrices, u: float, count: int) -> ComplexArray:
    """The ``count`` modes of smallest magnitude at tow speed ``u``: exponents with Im s >= 0, by magnitude.

    The eigensolver's error is that of the largest entry; one Rayleigh quotient w^H P v / w^H P_s v, which sees the
    small entries of smooth vectors, recovers two digits where a short rope is stiff. Left out at a double root, where
    its denominator vanishes and the correction is no longer small.
    """
    s, right, left = modes(system, u)
    chosen = np.flatnonzero(s.imag >= 0.0)[:count]
    d, k = system.first_order(u)
    exponents = s[chosen]
    for place, (value, v, w) in enumerate(zip(exponents, right[:, chosen].T, left[:, chosen].conj().T)):
        mv, dv = system.mass @ v, d @ v
        below = w @ (2.0 * value * mv + dv)
        step = -(w @ (value * value * mv + value * dv + k @ v)) / below if below else 0.0
        if abs(step) < 1e-6 * abs(value):
            exponents[place] = value + (step if value.imag else step.real)
    return np.asarray(exponents[np.argsort(np.abs(exponents), kind="stable")])


def rates_of_change(system: Matrices, u: float, s: ComplexArray, right: ComplexArray, left: ComplexArray) -> ComplexArray:
    """ds/du = -w^H (K_u + s D_u) v / w^H (2 s M + D) v of simple roots, shape of ``s``; infinite at a double root."""
    d, _ = system.first_order(u)
    result = np.empty(len(s), complex)
    for k, value in enumerate(s):
        v, w = right[:, k], left[:, k].conj()
        below = w @ (2.0 * value * (system.mass @ v) + d @ v)
        above = w @ (value * (system.damping @ v) + 2.0 * u * (system.stiffness @ v))
        result[k] = -above / below if below else np.inf
    return result


def growth_rate(body: Body, u: float, n: int = FUNCTIONS, within: float = 150.0) -> float:
    """Largest Re s of the modes with |s| < ``within``, in 1/tau: beyond, n = 26 is not converged."""
    s = roots(matrices(body, n), u)
    return float(np.max(s.real[np.abs(s) < within]))
