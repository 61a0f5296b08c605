"""Exact step of a towed slender body: constant matrices, a tow speed that may change, a lateral motion of the craft.

    z' = A(U(t)) z + b(U(t)) w(t),   z = (scale q, q'),   A, b polynomials in U of degree 2

With U constant the step is exact for w a cubic of time: w and its three derivatives join the state and one matrix
exponential advances both. A changing U is frozen in the middle of the step, which is of second order. On a ramp from 1.5
to 3 m/s in 20 s (L = 10 m, w = 0.1 sin(t/2)) the error is 3e-4, 3e-5, 2e-6 of the motion for steps of 0.4, 0.2, 0.1 s;
with w only linear over a step it is 3e-3, 8e-4, 2e-4.

| symbol | meaning | unit |
|---|---|---|
| q, q' | modal displacements and velocities of `slender_modes` | m, m/tau |
| U, w | tow speed, lateral position of the craft | m/s, m |
| tau | time unit L^2 sqrt((m + M)/EI) | s |

Fast modes. A truncated Legendre basis has growing fast modes that the body does not have (n = 14: Re s = 0.35/tau at
u = 0.7 and 10.6/tau at u = 12, |s| about 1850/tau), because convection feeds what is not resolved. Modes of (K0, M) with
kappa above `FAST` get the damping 2 zeta kappa and no other mode does: written in left and right vectors of the pair,
the damping matrix is zero on slow modes. With zeta = 0.02 no such growth is left (n = 12 to 20, u to 12) and the first
five modes change by 5e-6 (n = 14); damping from 500/tau on in the vectors of K0 alone costs 1.1e-4.

Source: C. F. Van Loan, IEEE Trans. Automatic Control 23 (1978) 395-404 (inputs in the exponential); N. J. Higham,
SIAM J. Matrix Analysis 26 (2005) 1179-1193 (scaling and squaring); the damping is ours.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from .slender_modes import Matrices

Array = NDArray[np.float64]
FAST = 800.0
"""kappa, in 1/tau, above which a mode of (K0, M) is beyond the resolution that the unit promises (|s| < 125/tau)."""


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


def fast_mode_damping(system: Matrices, zeta: float) -> Array:
    """The damping matrix of the fast modes, shape (n, n)."""
    n = system.n
    if n <= 2 or zeta == 0.0:
        return np.zeros((n, n))
    square, left, right = eig(system.bending, system.mass, left=True, right=True)
    kappa = np.sqrt(np.maximum(square.real, 0.0))
    norm = np.einsum("ij,ij->j", left.conj(), system.mass @ right)
    wanted = np.flatnonzero(kappa > FAST)
    weight = 2.0 * zeta * kappa[wanted] / norm[wanted]
    form = (system.mass @ right[:, wanted]) * weight @ (left[:, wanted].conj().T @ system.mass)
    return np.asarray(form.real)


def propagator(system: Matrices, u: float, h: float) -> tuple[Array, Array]:
    """(F, G) with z(h) = F z + G (w, h w', h^2 w'', h^3 w''') for constant ``u``, ``h`` in tau, shapes (2n, 2n) and
    (2n, 4)."""
    n = 2 * system.n
    generator = np.zeros((n + 4, n + 4))
    generator[:n, :n] = h * system.companion(u)
    generator[:n, n] = h * system.load(u)
    generator[n, n + 1] = generator[n + 1, n + 2] = generator[n + 2, n + 3] = 1.0
    full = exponential(generator)
    return full[:n, :n], full[:n, n:]
