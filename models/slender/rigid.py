"""Towed slender body held rigid: the quartic of its two modes and the closed yaw criterion.

    | A  B  |          A = A1 S^2 + A2 S + A3 and so on: rows are the balance of force and of moment about the middle,
    | C  Dd | = 0      columns heave eta and yaw angle phi;  y = eta + phi xi,  time unit L/U

In the time unit tau of the flexible body the exponents are s = S u/sqrt(beta).

Closed yaw criterion: a rigid body does not yaw away, whatever the length of the rope and its tension, where

    e_N/2 [(1/2 + lam)(1 + i1 + i1') + (i1' - i1)/2] + lam i4 - (1 + lam) i4' > 0

(the nose's integral bare, the tail's primed), because P/Lam is a factor of E = A3 D3 - B3 C3. The tail cut at which it
is zero is `neutral_tail_cut`.

Assumptions: those of `coefficients`, and EI infinite.
Source: thesis equations 75a, 76a and program F for ``present``; the others by projection of the flexible equation on
{1, xi}, which agrees with program F to 2e-15. The criterion is derived here; with it the thesis' limits al = .57
(lam = .05) and .5 (lam = .015) read .565733 and .521435.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from ..numeric.arrays import Array, ComplexArray
from .coefficients import Body
from .modes import matrices


def quartic(body: Body) -> Array:
    """Coefficients of S^4..S^0, leading 1, shape (5,), from the closed forms of program F for `present` and
    `corrected`, by projection for `modified_old`."""
    a, b, c, d = _projected(body) if body.theory == "modified_old" else _closed(body)
    polynomial = np.polysub(np.polymul(a, d), np.polymul(b, c))
    return np.asarray(polynomial / polynomial[0])


def projected_quartic(body: Body) -> Array:
    """The same from the Galerkin matrices of two shape functions, for every theory."""
    a, b, c, d = _projected(body)
    polynomial = np.polysub(np.polymul(a, d), np.polymul(b, c))
    return np.asarray(polynomial / polynomial[0])


def exponents(body: Body) -> ComplexArray:
    """The four roots S of the quartic, in U/L, by magnitude."""
    s = np.roots(quartic(body)).astype(complex)
    return s[np.argsort(np.abs(s), kind="stable")]


def _closed(body: Body) -> tuple[Array, Array, Array, Array]:
    """(A, B, C, Dd) of program F. It takes beta (i2 -/+ i3) for the masses of the ends, right at beta = 1/2 only; with
    m/M = 1/beta - 1 in place of 1 the body's mass is that of any beta."""
    ends = body.ends
    lam, rope, pull = body.end_length, body.rope_length, ends.tension
    i1, i2, i3, i4, i5, i6, _ = ends.signed_nose
    j1, j2, j3, j4, j5, j6, _ = ends.tail
    normal = body.friction + body.normal_drag
    ratio = 1.0 / body.mass_ratio - 1.0  # m/M
    area, lever = 1.0 + i1 + j1, 0.25 * normal * (j1 - i1)
    side = 0.5 * normal * area + i4 - j4
    slope = 0.5 * pull / rope
    shift = 0.5 * (ratio * (j2 - i2) + i3 + j3)
    turn = lever - 0.5 * (i4 + j4)
    a = (1.0 + ratio * (1.0 + i2 + j2) - i3 + j3, side, slope)
    b = (shift - i5 + j5, 2.0 - i3 + j3 + i6 - j6 + turn, side - slope * (0.5 + lam + rope))
    c = (shift, turn, -slope * (0.5 + lam))
    d = (
        (1.0 + ratio) / 12.0 + 0.25 * (ratio * (i2 + j2) - i3 + j3) + 0.5 * (i5 + j5),
        0.5 * (i3 + j3 - i6 - j6) + 0.25 * (i4 - j4) + 0.125 * normal * (1.0 / 3.0 + i1 + j1),
        turn + slope * (0.5 + lam + rope) * (0.5 + lam),
    )
    return np.array(a), np.array(b), np.array(c), np.array(d)


def _projected(body: Body) -> tuple[Array, Array, Array, Array]:
    """(A, B, C, Dd) from the two-mode Galerkin matrices, in the time unit L/U and divided by u^2."""
    m = matrices(replace(body, damping=0.0), 2)
    beta = body.mass_ratio
    forms = np.array([m.mass / beta, m.damping / np.sqrt(beta), m.stiffness])
    forms = forms * np.outer([1.0, 12.0**-0.5], [1.0, 12.0**-0.5])  # from phi_1 = sqrt(12) xi to xi
    return forms[:, 0, 0], forms[:, 0, 1], forms[:, 1, 0], forms[:, 1, 1]


def yaw_criterion(body: Body) -> float:
    """Positive where the rigid body does not yaw away, dimensionless. Raises ``ValueError`` for the old theory, whose
    end factors replace the integrals."""
    if body.theory == "modified_old":
        return float(quartic(body)[4] * quartic(body)[0])
    nose, tail, lam = body.ends.signed_nose, body.ends.tail, body.end_length
    normal = body.friction + body.normal_drag
    return float(
        0.5 * normal * ((0.5 + lam) * (1.0 + nose.i1 + tail.i1) + 0.5 * (tail.i1 - nose.i1))
        + lam * nose.i4 - (1.0 + lam) * tail.i4
    )  # fmt: skip


def neutral_tail_cut(body: Body) -> float | None:
    """The tail cut al in (1e-6, 1) at which the rigid body is neutral in yaw, blunter tails being stable; None if every
    tail is stable or every tail unstable."""
    low, high = (yaw_criterion(replace(body, tail_cut=al)) for al in (1e-6, 1.0))
    if low * high > 0.0:
        return None
    return float(brentq(lambda al: yaw_criterion(replace(body, tail_cut=al)), 1e-6, 1.0, xtol=1e-14))
