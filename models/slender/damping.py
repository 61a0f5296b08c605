"""Exact step of a towed slender body: constant matrices, a tow speed that may change, a lateral motion of the craft.

    z' = A(U(t)) z + b(U(t)) w(t),   z = (scale q, q'),   A, b polynomials in U of degree 2

With U constant the step is exact for w a cubic of time: w and its three derivatives join the state and one matrix
exponential advances both. A changing U is frozen in the middle of the step, which is of second order. On a ramp from 1.5
to 3 m/s in 20 s (L = 10 m, w = 0.1 sin(t/2)) the error is 3e-4, 3e-5, 2e-6 of the motion for steps of 0.4, 0.2, 0.1 s;
with w only linear over a step it is 3e-3, 8e-4, 2e-4.

| symbol | meaning | unit |
|---|---|---|
| q, q' | modal displacements and velocities of `galerkin` | m, m/tau |
| U, w | tow speed, lateral position of the craft | m/s, m |
| tau | time unit L^2 sqrt((m + M)/EI) | s |

Fast modes. A truncated Legendre basis has growing fast modes that the body does not have (n = 14: Re s = 0.35/tau at
u = 0.7 and 10.6/tau at u = 12, |s| about 1850/tau), because convection feeds what is not resolved. Modes of (K0, M) with
frequency above `FAST` get the damping 2 zeta frequency and no other mode does:

    E = 2 zeta M f(M^-1 K0) = 2 zeta kappa P T^-1/2 kappa,   T = kappa M^-1 kappa,   P = (1 + sign(T/FAST^2 - 1))/2

with f(l) = sqrt(l) above FAST^2 and 0 below; kappa = diag(sqrt K0) without its two zeros. Sign and root by Newton's
iteration: fixed counts of solves, which CasADi traces as numpy computes them. With zeta = 0.02 no such growth is left
(n = 12 to 20, u to 12) and the first five modes change by 5e-6 (n = 14); damping from 500/tau on in the vectors of K0
alone costs 1.1e-4.

Source: C. F. Van Loan, IEEE Trans. Automatic Control 23 (1978) 395-404 (inputs in the exponential); N. J. Higham,
SIAM J. Matrix Analysis 26 (2005) 1179-1193 (scaling and squaring), and Functions of Matrices (2008), sections 5.5 and
6.3 (scaled Newton and product Denman-Beavers iterations); the damping is ours.
"""

from __future__ import annotations

import math

import numpy as np

from ..numeric.arrays import Array
from ..numeric.matrix_ops import Matrix, MatrixOps
from ..numeric.ops import Value
from .galerkin import Matrices

FAST = 800.0
"""kappa, in 1/tau, above which a mode of (K0, M) is beyond the resolution that the unit promises (|s| < 125/tau)."""
SIGN_STEPS, ROOT_STEPS = 20, 10
"""Newton steps: 4000 random bodies with 6 to 24 functions needed 15 and 7 at most."""

PADE = (
    64764752532480000.0, 32382376266240000.0, 7771770303897600.0, 1187353796428800.0, 129060195264000.0,
    10559470521600.0, 670442572800.0, 33522128640.0, 1323241920.0, 40840800.0, 960960.0, 16380.0, 182.0, 1.0,
)  # fmt: skip
"""Coefficients of the Pade approximant of order 13 of the exponential (Higham 2005, table 10.4 of his book)."""
PADE_NORM = 5.371920351148152
"""1-norm up to which it is exact to double precision."""


def exponential(a: Array) -> Array:
    """exp(a) by scaling and squaring of the Pade approximant of order 13, shape of ``a``.

    scipy's function does the same, but waits for the threads of its BLAS, which on a busy machine costs 12 ms for 8 rows
    as for 32, against 0.2 ms here.
    """
    norm = float(np.abs(a).sum(axis=0).max())
    squarings = max(0, math.ceil(math.log2(norm / PADE_NORM))) if norm > 0.0 else 0
    a = a / 2.0**squarings
    one = np.eye(len(a))
    a2 = a @ a
    a4 = a2 @ a2
    a6 = a4 @ a2
    b = PADE
    odd = a @ (a6 @ (b[13] * a6 + b[11] * a4 + b[9] * a2) + b[7] * a6 + b[5] * a4 + b[3] * a2 + b[1] * one)
    even = a6 @ (b[12] * a6 + b[10] * a4 + b[8] * a2) + b[6] * a6 + b[4] * a4 + b[2] * a2 + b[0] * one
    result = np.linalg.solve(even - odd, even + odd)
    for _ in range(squarings):
        result = result @ result
    return np.asarray(result)


def fast_mode_damping(system: Matrices, zeta: Value, matrices: MatrixOps) -> Matrix:
    """The damping matrix of the fast modes, shape (n, n), for numpy or CasADi."""
    n = system.n
    if n <= 2:
        return matrices.zeros(n, n)
    kappa = matrices.constant(np.diag(system.kappa)[2:]) / FAST
    one = matrices.eye(n - 2)
    square = kappa @ matrices.solve(system.mass, kappa.T)
    sign = square - one
    for _ in range(SIGN_STEPS):
        inverse = matrices.solve(sign, one)
        c = _balance(inverse, sign, matrices)
        sign = 0.5 * (c * sign + inverse / c)
    fast = 0.5 * (one + sign)
    rest, root = fast @ square + one - fast, one
    for _ in range(ROOT_STEPS):
        inverse = matrices.solve(rest, one)
        c = _balance(inverse, rest, matrices)
        g = matrices.scalars.sqrt(c)
        root = root @ (0.5 * (g * one + inverse / g))
        rest = 0.5 * one + 0.25 * (c * rest + inverse / c)
    return 2.0 * zeta * FAST * (kappa.T @ fast @ root @ kappa)


def _balance(inverse: Matrix, matrix: Matrix, matrices: MatrixOps) -> Value:
    """sqrt(|inverse|/|matrix|) in the norm of Frobenius: the factor that brings eigenvalues of both sizes next to 1."""
    row = matrices.constant(np.ones((1, matrix.shape[0])))

    def total(a: Matrix) -> Value:
        return (row @ (a * a) @ row.T)[0, 0]

    root = matrices.scalars.sqrt
    return root(root(total(inverse) / total(matrix)))


def propagator(a: Array, b: Array, h: float) -> Array:
    """[F G] with z(h) = F z + G (w0, w1, w2, w3) for z' = a z + b w, w = w0 + w1 t + w2 t^2 + w3 t^3, ``h`` in s; shape
    (2n, 2n + 4)."""
    n = len(a)
    generator = np.zeros((n + 4, n + 4))
    generator[:n, :n] = h * a
    generator[:n, n : n + 1] = h * b
    generator[n, n + 1] = generator[n + 1, n + 2] = generator[n + 2, n + 3] = 1.0
    step = exponential(generator)[:n]
    step[:, n:] *= (1.0, h, 2.0 * h * h, 6.0 * h**3)
    return step
