"""Towed slender body: Legendre-Galerkin matrices and the modes at a tow speed.

    (s^2 M + s (nu K0 + u D1) + K0 + u^2 K2) q = u^2 f w,   y(xi) = sum q_k phi_k(xi)

The weak form of the equation of `slender_coefficients`, tested with phi_j; boundary conditions are natural:

    g0 int y'' phi'' + int [(C1 + C2 xi) y'' + C3 y' + C4 y] phi
      + (g5 y' + g6 y) phi - (g7 y' + g8 y) phi'  at -1/2     - (g9 y' + g10 y) phi  at 1/2  =  0

phi_k = sqrt(2k + 1) P_k(2 xi), orthonormal on (-1/2, 1/2). phi_0, phi_1 are the rigid body: n = 2 is its two-mode
projection. All integrals follow from the exact recurrence P'_{k+1} = P'_{k-1} + (2k + 1) P_k, whose coefficients are
positive: no quadrature, no cancellation. An orthogonal change of basis from the singular values kappa of y -> y'' then
makes K0 = diag(kappa^2); with displacements counted in units of 1/kappa the companion matrix is balanced, its norm the
largest kappa and not the largest kappa^2. w is the lateral position of the craft over L.

Against the series determinant about the middle (90 terms), 26 functions give the first six roots to 1e-14 .. 2e-13 for u
from 0.01 to 12 and Lam from 0.5 to 10, and to 3e-9 for Lam = 1e-6. Chebyshev collocation of the strong form reaches
1e-6 .. 1e-7: its fourth derivative is ill conditioned.

Source: weak form of thesis equation 61 with its boundary conditions; programs E and F for the coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from .slender_coefficients import Body, coefficients

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
FUNCTIONS = 26
"""Shape functions of the converged spectrum."""


@dataclass(frozen=True, eq=False)
class Matrices:
    """M, D1, K2 of shape (n, n), K0 = diag(kappa^2), ``kappa`` and f of shape (n,), in the basis whose functions are the
    columns of ``change`` in terms of phi_k; ``nu`` is the Kelvin-Voigt number, ``extra`` a further damping matrix, zero
    unless a model adds one."""

    mass: Array
    kappa: Array
    damping: Array
    stiffness: Array
    force: Array
    nu: float
    extra: Array
    change: Array

    @property
    def bending(self) -> Array:
        """K0."""
        return np.diag(self.kappa**2)

    @property
    def scale(self) -> Array:
        """max(1, kappa), by which displacements are multiplied in the first-order form, shape (n,)."""
        return np.maximum(1.0, self.kappa)

    @property
    def n(self) -> int:
        """Number of shape functions."""
        return len(self.force)

    def first_order(self, u: float) -> tuple[Array, Array]:
        """(D, K) at tow speed ``u``."""
        return self.nu * self.bending + u * self.damping + self.extra, self.bending + u * u * self.stiffness

    def pencil(self, u: float, s: complex) -> Complex:
        """s^2 M + s D + K, shape (n, n)."""
        d, k = self.first_order(u)
        return np.asarray(s * s * self.mass + s * d + k, dtype=complex)

    def speed_derivative(self, u: float, s: complex) -> Complex:
        """Derivative of `pencil` by u."""
        return np.asarray(s * self.damping + 2.0 * u * self.stiffness, dtype=complex)

    def companion(self, u: float) -> Array:
        """A of z' = A z, z = (scale q, q'), in the time unit tau, shape (2n, 2n)."""
        d, k = self.first_order(u)
        lower = np.linalg.solve(self.mass, np.hstack([-k / self.scale, -d]))
        return np.vstack([np.hstack([np.zeros((self.n, self.n)), np.diag(self.scale)]), lower])

    def load(self, u: float) -> Array:
        """b of z' = A z + b w, shape (2n,)."""
        return np.concatenate([np.zeros(self.n), np.linalg.solve(self.mass, u * u * self.force)])

    def rows(self, xi: Array) -> tuple[Array, Array]:
        """(Y, Y') with y(xi) = Y q and y'(xi) = Y' q, each of shape (len(xi), n)."""
        value, slope = basis(self.n, xi)
        return value @ self.change, slope @ self.change


def basis(n: int, xi: Array) -> tuple[Array, Array]:
    """(phi, phi') of n functions at the points ``xi`` in [-1/2, 1/2], each of shape (len(xi), n)."""
    x = 2.0 * np.asarray(xi, dtype=float)
    p = np.zeros((len(x), n))
    d = np.zeros((len(x), n))
    p[:, 0] = 1.0
    if n > 1:
        p[:, 1], d[:, 1] = x, 1.0
    for k in range(1, n - 1):
        p[:, k + 1] = ((2 * k + 1) * x * p[:, k] - k * p[:, k - 1]) / (k + 1)
        d[:, k + 1] = d[:, k - 1] + (2 * k + 1) * p[:, k]
    norm = np.sqrt(2.0 * np.arange(n) + 1.0)
    return p * norm, 2.0 * d * norm


def derivative(n: int) -> Array:
    """E with phi_k' = sum_j phi_j E[j, k], shape (n, n)."""
    norm = np.sqrt(2.0 * np.arange(n) + 1.0)
    result = np.zeros((n, n))
    for k in range(n):
        for j in range(k - 1, -1, -2):
            result[j, k] = 2.0 * norm[j] * norm[k]
    return result


def position(n: int) -> Array:
    """X with xi phi_k = sum_j phi_j X[j, k] for k < n - 1, shape (n, n)."""
    k = np.arange(1, n)
    off = 0.5 * k / np.sqrt(4.0 * k * k - 1.0)
    return np.diag(off, 1) + np.diag(off, -1)


def assemble(body: Body, n: int = FUNCTIONS) -> Matrices:
    """The Galerkin matrices of ``body`` with ``n`` >= 2 shape functions."""
    if n < 2:
        raise ValueError(f"{n} shape functions: expected at least 2, the rigid body")
    c = coefficients(body)
    first = derivative(n)
    second = first @ first
    inner = {"c1": second, "c2": position(n) @ second, "c3": first, "c4": np.eye(n)}
    (nose, tail), (nose1, tail1) = basis(n, np.array([-0.5, 0.5]))
    edges = {
        "g5": np.outer(nose, nose1), "g6": np.outer(nose, nose), "g7": -np.outer(nose1, nose1),
        "g8": -np.outer(nose1, nose), "g9": -np.outer(tail, tail1), "g10": -np.outer(tail, tail),
    }  # fmt: skip
    forms = inner | edges

    def total(part: int) -> Array:
        return np.asarray(sum(getattr(c, name)[part] * form for name, form in forms.items()))

    pull = 0.5 * body.tension / body.rope_length
    kappa, change = np.zeros(n), np.eye(n)
    if n > 2:  # the first two columns and the last two rows of ``second`` are zero
        _, singular, right = np.linalg.svd(second[: n - 2, 2:])
        kappa[2:], change[2:, 2:] = singular[::-1], right[::-1].T
    mass, damping, stiffness = (change.T @ total(part) @ change for part in (2, 1, 0))
    return Matrices(
        mass=mass, kappa=kappa, damping=damping, stiffness=stiffness,
        force=change.T @ (pull * (nose - body.end_length * nose1)),
        nu=body.damping, extra=np.zeros((n, n)), change=change,
    )  # fmt: skip


@lru_cache(maxsize=64)
def matrices(body: Body, n: int = FUNCTIONS) -> Matrices:
    """`assemble`, remembered."""
    return assemble(body, n)


def roots(system: Matrices, u: float) -> Complex:
    """All 2n exponents s at tow speed ``u``, by magnitude. Raises ``ValueError`` for a negative or infinite speed."""
    return modes(system, u, vectors=False)[0]


def modes(system: Matrices, u: float, vectors: bool = True) -> tuple[Complex, Complex, Complex]:
    """(s, right, left): exponents of shape (2n,) by magnitude, vectors q of shape (n, 2n) with
    pencil(u, s) q = 0 and left^H pencil(u, s) = 0 (empty if not wanted)."""
    check_speed(u)
    n = system.n
    a = system.companion(u)
    if not vectors:
        s = np.linalg.eigvals(a).astype(complex)
        return s[np.argsort(np.abs(s), kind="stable")], np.empty((n, 0), complex), np.empty((n, 0), complex)
    s, left, right = eig(a, left=True, right=True)
    order = np.argsort(np.abs(s), kind="stable")
    # a left vector (p, r) of the companion form has r^H M^-1 as the left vector of the pencil
    lower = np.linalg.solve(system.mass.T, left[n:, order])
    return s[order], right[:n, order] / system.scale[:, None], lower


def check_speed(u: float) -> None:
    """Raises ``ValueError`` for a tow speed that is negative or not finite."""
    if not 0.0 <= u < np.inf:
        raise ValueError(f"tow speed {u:g}: expected a finite number that is not negative; the body is towed nose first")


def spectrum(system: Matrices, u: float, count: int) -> Complex:
    """The ``count`` modes of smallest magnitude at tow speed ``u``: exponents with Im s >= 0, by magnitude.

    The eigensolver's error is that of the largest entry; one Rayleigh quotient w^H P v / w^H P_s v, which sees the
    small entries of smooth vectors, recovers two digits where a short rope is stiff. Left out at a double root, where
    its denominator vanishes and the correction is no longer small.
    """
    s, right, left = modes(system, u)
    chosen = np.flatnonzero(s.imag >= 0.0)[:count]
    d, k = system.first_order(u)
    found = s[chosen]
    for place, (value, v, w) in enumerate(zip(found, right[:, chosen].T, left[:, chosen].conj().T)):
        mv, dv = system.mass @ v, d @ v
        below = w @ (2.0 * value * mv + dv)
        step = -(w @ (value * value * mv + value * dv + k @ v)) / below if below else 0.0
        if abs(step) < 1e-6 * abs(value):
            found[place] = value + (step if value.imag else step.real)
    return np.asarray(found[np.argsort(np.abs(found), kind="stable")])


def rates_of_change(system: Matrices, u: float, s: Complex, right: Complex, left: Complex) -> Complex:
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
