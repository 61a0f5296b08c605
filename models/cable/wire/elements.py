"""Gauss-Lobatto points of an element: where its nodes are, how they weigh, and derivatives between them.

    P'_p(x) = 0 and x = -1, 1;   w = 2/(p (p + 1) P_p(x)^2);   D[q, j] = slope of the j-th Lagrange polynomial at x_q

Nodes are quadrature points, so that the mass of an element of degree p is diagonal; degree 1 is the lumped mass. The
quadrature is exact for degree 2p - 1, which keeps the order of the elements.

Source: C. Canuto, M. Y. Hussaini, A. Quarteroni, T. A. Zang, *Spectral Methods: Fundamentals in Single Domains*
(Springer 2006), Section 2.3.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ...numeric.arrays import Array

LARGEST_DEGREE = 6


class Rule(NamedTuple):
    """``points`` in [-1, 1], ``weights``, (p+1,); ``slopes`` D and ``integrals`` (from -1 to the points), (p+1, p+1)."""

    points: Array
    weights: Array
    slopes: Array
    integrals: Array


@cache
def rule(degree: int) -> Rule:
    """Of an element of ``degree`` 1 to `LARGEST_DEGREE`."""
    if not 1 <= degree <= LARGEST_DEGREE:
        raise ValueError(f"degree of an element: expected 1 to {LARGEST_DEGREE}, not {degree}")
    legendre = np.polynomial.Legendre.basis(degree)
    points = np.concatenate([[-1.0], np.sort(legendre.deriv().roots().real), [1.0]])
    # one more step of Newton's method; symmetric to the last bit
    inner, second = points[1:-1], legendre.deriv(2)
    inner -= legendre.deriv()(inner) / second(inner)
    points = 0.5 * (points - points[::-1])
    values = legendre(points)
    difference = points[:, None] - points[None, :]
    np.fill_diagonal(difference, 1.0)
    slopes = values[:, None] / values[None, :] / difference
    np.fill_diagonal(slopes, 0.0)
    # a constant has no slope
    np.fill_diagonal(slopes, -slopes.sum(axis=1))
    integrals = np.empty_like(slopes)
    for j in range(degree + 1):
        others = np.delete(points, j)
        basis = np.polynomial.Polynomial.fromroots(others) / np.prod(points[j] - others)
        integrals[:, j] = basis.integ(lbnd=-1.0)(points)
    return Rule(points, 2.0 / (degree * (degree + 1) * values**2), slopes, integrals)


def lagrange(degree: int, x: Array) -> Array:
    """Values at ``x`` in [-1, 1], shape (m,), of the element's polynomials, (m, p+1)."""
    points = rule(degree).points
    table = np.ones((len(x), degree + 1))
    for j in range(degree + 1):
        for k in range(degree + 1):
            if k != j:
                table[:, j] *= (x - points[k]) / (points[j] - points[k])
    return table


@cache
def legendre(k: int, degree: int) -> Array:
    """Row that takes values at the points of an element to the k-th Legendre coefficient, k below the degree."""
    points = rule(degree)
    row: Array = (k + 0.5) * points.weights * np.polynomial.Legendre.basis(k)(points.points)
    return row
