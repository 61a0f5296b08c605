"""Towed slender body: modes by the truncated power series and its determinant, the method of the thesis.

    y = sum_{j < N} a_j x^j,  x = xi - xi0,   g0 (j+4)(j+3)(j+2)(j+1) a_{j+4} =
        -(C1 + C2 xi0)(j+2)(j+1) a_{j+2} - (C2 j + C3)(j+1) a_{j+1} - C4 a_j

Four free coefficients a_0..a_3 and four boundary conditions: a 4 x 4 determinant, zero at the exponents s. Symbols as in
`coefficients`; xi0 is the ``centre`` of the expansion. The thesis expands about the nose (xi0 = -1/2: its
program sums the tail conditions with powers of one), and there the order N decides everything: N = 10 has no flexural
mode at any speed, at u = 12 no mode survives below 40 and all need 60 to 70. About the middle (xi0 = 0) the same
accuracy takes about half the terms. Kept to show that, and as a second method: production uses the Galerkin modes.

At s = -1/nu the series is singular (g0 = 0), and roots cluster there.

Source: thesis, equations 73 and 74, program E. Its order is printed as MM = 10, misread by the scan: the tables need at
least 48.
"""

from __future__ import annotations

import numpy as np

from ..numeric.arrays import ComplexArray
from ..numeric.ops import FLOATS
from .coefficients import Body, coefficients

ORDER = 70
NOSE, MIDDLE = -0.5, 0.0
"""Centres of the expansion."""


def determinant(body: Body, u: float, s: complex, order: int = ORDER, centre: float = NOSE) -> complex:
    """The determinant at tow speed ``u`` and exponent ``s``, its rows scaled to unit size. Raises ``ValueError`` for an
    order below 4, ``ZeroDivisionError`` at s = -1/nu."""
    if order < 4:
        raise ValueError(f"series of order {order}: expected at least 4")
    c = coefficients(body.numbers, body.ends, FLOATS)
    g0 = 1.0 + body.damping * s
    c1, c2, c3, c4, g5, g6, g7, g8, g9, g10 = (term.at(u, s) for term in c)
    c1 = c1 + c2 * centre
    a = np.zeros((order, 4), complex)
    a[:4] = np.eye(4)
    for j in range(order - 4):
        a[j + 4] = -(c1 * (j + 2) * (j + 1) * a[j + 2] + (c2 * j + c3) * (j + 1) * a[j + 1] + c4 * a[j]) / (
            g0 * (j + 4) * (j + 3) * (j + 2) * (j + 1)
        )
    k = np.arange(order)
    falling = [np.ones(order), k, k * (k - 1), k * (k - 1) * (k - 2)]
    nose, tail = (
        [(falling[d] * x ** np.maximum(k - d, 0)) @ a for d in range(4)] for x in (-0.5 - centre, 0.5 - centre)
    )
    conditions = np.array([
        g0 * nose[3] + g5 * nose[1] + g6 * nose[0],
        g0 * nose[2] + g7 * nose[1] + g8 * nose[0],
        g0 * tail[3] + g9 * tail[1] + g10 * tail[0],
        tail[2],
    ])  # fmt: skip
    return complex(np.linalg.det(conditions / np.abs(conditions).max(axis=1, keepdims=True)))


def refine(body: Body, u: float, s: complex, order: int = ORDER, centre: float = NOSE) -> complex:
    """The zero of the determinant that the secant method reaches from ``s``; nan if it does not converge.

    The size of the rows changes with s but never vanishes, so that zeros stay zeros and simple.
    """
    previous, here = s * (1.0 + 1e-6) + 1e-9, s
    value_before, value = determinant(body, u, previous, order, centre), determinant(body, u, here, order, centre)
    for _ in range(60):
        if value == value_before:
            break
        step = value * (here - previous) / (value - value_before)
        previous, value_before = here, value
        here -= step
        value = determinant(body, u, here, order, centre)
        if abs(step) <= 1e-14 * max(1.0, abs(here)):
            return here
    return here if abs(here - previous) <= 1e-9 * max(1.0, abs(here)) else complex(np.nan, np.nan)


def spectrum(body: Body, u: float, starts: ComplexArray, order: int = ORDER, centre: float = NOSE) -> ComplexArray:
    """The zeros reached from ``starts`` (exponents s, shape (k,)), nan where one is lost."""
    return np.array([refine(body, u, complex(s), order, centre) for s in starts])
