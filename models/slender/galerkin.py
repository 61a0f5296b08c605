"""Towed slender body: its Galerkin matrices in Legendre functions, for numpy and CasADi alike.

    (s^2 M + s (nu K0 + u D1) + K0 + u^2 K2) q = u^2 f w,   y(xi) = sum q_k phi_k(xi)

The weak form of the equation of `coefficients`, tested with phi_j; boundary conditions are natural:

    g0 int y'' phi'' + int [(C1 + C2 xi) y'' + C3 y' + C4 y] phi
      + (g5 y' + g6 y) phi - (g7 y' + g8 y) phi'  at -1/2     - (g9 y' + g10 y) phi  at 1/2  =  0

phi_k = sqrt(2k + 1) P_k(2 xi), orthonormal on (-1/2, 1/2). phi_0, phi_1 are the rigid body: n = 2 is its two-mode
projection. All integrals follow from the exact recurrence P'_{k+1} = P'_{k-1} + (2k + 1) P_k, whose coefficients are
positive: no quadrature, no cancellation. An orthogonal change of basis from the singular values kappa of y -> y'' then
makes K0 = diag(kappa^2); with displacements counted in units of 1/kappa the companion matrix is balanced, its norm the
largest kappa and not the largest kappa^2. w is the lateral position of the craft over L.

Source: weak form of thesis equation 61 with its boundary conditions; programs E and F for the coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from ..numeric.arrays import Array, ComplexArray
from ..numeric.matrix_ops import Matrix, MatrixOps, numbers
from ..numeric.ops import Value
from .coefficients import Numbers, coefficients, ends


class StateSpace(NamedTuple):
    """z' = (A0 + u A1 + u^2 A2) z + u^2 b w with z = (scale q, q') in the time unit tau: ``a`` = (A0, A1, A2) of shape
    (2n, 2n), ``b`` of shape (2n, 1)."""

    a: tuple[Matrix, Matrix, Matrix]
    b: Matrix


@dataclass(frozen=True, eq=False)
class Matrices:
    """M, D1, K2 of shape (n, n), K0 = diag(kappa^2), and f of shape (n, 1), numpy or CasADi; ``kappa`` of shape (n,), in
    the basis whose functions are the columns of ``change`` in terms of phi_k; ``nu`` is the Kelvin-Voigt number,
    ``extra`` a further damping matrix, zero unless a model adds one; ``tension`` is P."""

    mass: Matrix
    kappa: Array
    damping: Matrix
    stiffness: Matrix
    force: Matrix
    nu: Value
    extra: Matrix
    change: Array
    tension: Value

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
        return len(self.kappa)

    def first_order(self, u: float) -> tuple[Array, Array]:
        """(D, K) at tow speed ``u``."""
        return self.nu * self.bending + u * self.damping + self.extra, self.bending + u * u * self.stiffness

    def pencil(self, u: float, s: complex) -> ComplexArray:
        """s^2 M + s D + K, shape (n, n)."""
        d, k = self.first_order(u)
        return np.asarray(s * s * self.mass + s * d + k, dtype=complex)

    def speed_derivative(self, u: float, s: complex) -> ComplexArray:
        """Derivative of `pencil` by u."""
        return np.asarray(s * self.damping + 2.0 * u * self.stiffness, dtype=complex)

    def state_space(self, matrices: MatrixOps) -> StateSpace:
        """The first-order form."""
        n = self.n
        constant, zero = matrices.constant, matrices.zeros(n, n)
        bending, per_scale = constant(self.bending), constant(np.diag(1.0 / self.scale))
        blocks = (
            bending @ per_scale, self.nu * bending + self.extra, self.damping, self.stiffness @ per_scale, self.force,
        )  # fmt: skip
        solved = matrices.solve(self.mass, matrices.hstack(blocks))
        k0, d0, d1, k2 = (-solved[:, k * n : (k + 1) * n] for k in range(4))

        def whole(upper: Matrix, left: Matrix, right: Matrix) -> Matrix:
            return matrices.vstack([matrices.hstack([zero, upper]), matrices.hstack([left, right])])

        a = whole(constant(np.diag(self.scale)), k0, d0), whole(zero, zero, d1), whole(zero, k2, zero)
        return StateSpace(a, matrices.vstack([matrices.zeros(n, 1), solved[:, 4 * n :]]))

    @cached_property
    def _numbers(self) -> StateSpace:
        return self.state_space(numbers())

    def companion(self, u: float) -> Array:
        """A of z' = A z, z = (scale q, q'), in the time unit tau, shape (2n, 2n)."""
        a0, a1, a2 = self._numbers.a
        return np.asarray(a0 + u * (a1 + u * a2))

    def load(self, u: float) -> Array:
        """b of z' = A z + b w, shape (2n,)."""
        return np.asarray(u * u * self._numbers.b[:, 0])

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


class Basis(NamedTuple):
    """What depends on the number of functions alone. ``forms``: the integral or edge term that each coefficient of the
    weak form multiplies; ``nose``, ``nose1``: phi and phi' at -1/2; ``kappa`` and ``change`` as of `Matrices`."""

    forms: dict[str, Array]
    nose: Array
    nose1: Array
    kappa: Array
    change: Array


@lru_cache(maxsize=64)
def weak_forms(n: int) -> Basis:
    """For ``n`` >= 2 shape functions."""
    if n < 2:
        raise ValueError(f"{n} shape functions: expected at least 2, the rigid body")
    first = derivative(n)
    second = first @ first
    (nose, tail), (nose1, tail1) = basis(n, np.array([-0.5, 0.5]))
    forms = {
        "c1": second, "c2": position(n) @ second, "c3": first, "c4": np.eye(n),
        "g5": np.outer(nose, nose1), "g6": np.outer(nose, nose), "g7": -np.outer(nose1, nose1),
        "g8": -np.outer(nose1, nose), "g9": -np.outer(tail, tail1), "g10": -np.outer(tail, tail),
    }  # fmt: skip
    kappa, change = np.zeros(n), np.eye(n)
    if n > 2:  # the first two columns and the last two rows of ``second`` are zero
        _, singular, right = np.linalg.svd(second[: n - 2, 2:])
        kappa[2:], change[2:, 2:] = singular[::-1], right[::-1].T
    return Basis(forms, nose, nose1, kappa, change)


def galerkin(body: Numbers, n: int, matrices: MatrixOps) -> Matrices:
    """The Galerkin matrices of ``body`` with ``n`` >= 2 shape functions, for numpy or CasADi."""
    its_ends = ends(body, matrices.scalars)
    c = coefficients(body, its_ends, matrices.scalars)
    made = weak_forms(n)
    change = matrices.constant(made.change)
    forms = {name: matrices.constant(form) for name, form in made.forms.items()}

    def total(part: int) -> Matrix:
        return change.T @ sum(getattr(c, name)[part] * form for name, form in forms.items()) @ change

    nose, nose1 = (change.T @ matrices.constant(values[:, None]) for values in (made.nose, made.nose1))
    pull = 0.5 * its_ends.tension / body.rope_length
    return Matrices(
        mass=total(2), kappa=made.kappa, damping=total(1), stiffness=total(0),
        force=pull * (nose - body.end_length * nose1), nu=body.damping, extra=matrices.zeros(n, n), change=made.change,
        tension=its_ends.tension,
    )  # fmt: skip
