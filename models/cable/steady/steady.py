"""Steady shape and tension of a tow cable.

    T0 phi0' = w cos phi0 - F_L(phi0),   T0' = F_G(phi0) + w sin phi0                  [31] [32]
    x0' = (1 + T0/EA) cos phi0,          y0' = (1 + T0/EA) sin phi0,   ' = d/ds        [55] [57]
    T0(0) = hypot(D_B, L_B - W_B),       phi0(0) = atan2(W_B - L_B, D_B), in II atan2(L_B - W_B, -D_B)    [33] [34]

Symbols, units and assumptions: ``cable/case.py``. The equations are integrated in phi0 and ln T0 twice: by an embedded
Runge-Kutta method, whose steps grade the mesh (they are as short as T0/D where the body hangs on a slight tension), and
on that mesh by Gauss collocation to rounding error. A cable that leaves its quadrant is refused: the loading is not
valid there.

Source: small-perturbation report on towed cables, Equations [31]-[34], [55], [57].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...numeric.arrays import Array
from ..case import CableError, Tow

DEGREE = 16
"""Polynomial degree in an element: errors at rounding for elements over which solutions change by e^2."""
QUADRANT_SLACK = 1e-9
"""rad; an angle on the quadrant's edge is inside."""
MAX_STEPS = 20_000


@lru_cache
def basis(degree: int = DEGREE) -> tuple[Array, Array, Array]:
    """Chebyshev nodes on [-1, 1] from -1, shape (p+1,), and the matrices (p, p+1) that take node values to values and
    to slopes at the p Gauss points."""
    from scipy.special import roots_legendre  # takes long to load, and a unit may never ask

    k = np.arange(degree + 1)
    nodes = -np.cos(np.pi * k / degree)
    weights = (-1.0) ** k
    weights[[0, -1]] *= 0.5
    gauss, _ = roots_legendre(degree)
    difference = gauss[:, None] - nodes
    if degree % 2 or degree < 2:
        raise ValueError(f"degree {degree}: expected an even number, so that no node is a Gauss point")
    # an even degree has a node at 0 and no Gauss point there
    terms = weights / difference
    values = terms / terms.sum(1, keepdims=True)
    slopes = np.empty_like(values)
    for j in range(degree + 1):
        unit = np.zeros(degree + 1)
        unit[j] = 1.0
        # derivative of the barycentric interpolant away from its nodes
        slopes[:, j] = ((values[:, j, None] - unit) / difference * terms).sum(1) / terms.sum(1)
    return nodes, values, slopes


@dataclass(frozen=True)
class Steady:
    """Steady state on a mesh of ``edges`` (distances from the body, m, shape (K+1,)) at the nodes of every element,
    shape (K, p+1): angle, rad, log of the tension, N, and position relative to the body, m. The direction of s is
    that of `Tow.sign`."""

    tow: Tow
    edges: Array
    angle: Array
    log_tension: Array
    x: Array
    y: Array

    @property
    def tension(self) -> Array:
        """T0 at the nodes, N."""
        return np.exp(self.log_tension)

    def place(self, distance: float) -> tuple[int, Array]:
        """The element at a distance from the body, m, 0 to L, and the row that takes its node values to the value there."""
        k = min(max(int(np.searchsorted(self.edges, distance, side="right")) - 1, 0), len(self.edges) - 2)
        left, right = self.edges[k], self.edges[k + 1]
        return k, interpolation(2.0 * (distance - left) / (right - left) - 1.0)

    def at(self, distance: float) -> tuple[float, float, float, float]:
        """(phi0, rad; T0, N; x0, y0, m) at a distance from the body, m, 0 to L."""
        k, row = self.place(distance)
        values = [float(row @ f[k]) for f in (self.angle, self.log_tension, self.x, self.y)]
        return values[0], math.exp(values[1]), values[2], values[3]


def interpolation(point: float, degree: int = DEGREE) -> Array:
    """Row that takes node values to the value at ``point`` of [-1, 1]."""
    nodes = basis(degree)[0]
    difference = point - nodes
    hit = np.flatnonzero(np.abs(difference) < 1e-14)
    if len(hit):
        row: Array = np.zeros(degree + 1)
        row[hit[0]] = 1.0
        return row
    weights = (-1.0) ** np.arange(degree + 1)
    weights[[0, -1]] *= 0.5
    row = weights / difference
    row /= row.sum()
    return row


def slopes(tow: Tow, angle: Array, log_tension: Array) -> tuple[Array, Array]:
    """d/dsigma of (phi0, ln T0), 1/m, sigma the distance from the body."""
    sine, cosine = np.sin(angle), np.cos(angle)
    drag = tow.drag_factor * tow.speed**2
    normal, _, tangential, _ = tow.cable.loading.gradients(sine, cosine)
    scale = tow.sign * np.exp(-log_tension)
    return (
        scale * (tow.cable.weight * cosine - drag * normal),
        scale * (tow.cable.weight * sine + drag * tangential),
    )


def graded_edges(tow: Tow) -> Array:
    """Element edges from the steps of an embedded method, m. Raises `CableError` where the cable leaves its quadrant
    or loses its tension."""
    from scipy.integrate import solve_ivp  # takes long to load, and a unit may never ask

    start = np.array([tow.end_angle, math.log(tow.end_tension)])
    low, high = (0.0, 0.5 * math.pi) if tow.quadrant == 1 else (0.5 * math.pi, math.pi)

    def rates(s: float, y: Array) -> Array:
        return np.array(slopes(tow, y[0], y[1]))

    def leaves(s: float, y: Array) -> float:
        return float(min(y[0] - low, high - y[0])) + QUADRANT_SLACK

    def vanishes(s: float, y: Array) -> float:
        return float(y[1] - start[1]) + 60.0

    leaves.terminal = vanishes.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(
        rates, (0.0, tow.cable.length), start, "DOP853", rtol=1e-8, atol=1e-8, events=(leaves, vanishes),
    )  # fmt: skip
    if solution.status == 1:
        where = float(solution.t[-1])
        if len(solution.t_events[0]):
            raise CableError(
                f"the cable leaves Quadrant {'I' * tow.quadrant} at {where:.6g} of {tow.cable.length:g} from the body "
                f"(angle {math.degrees(solution.y[0, -1]):.4g} deg): the loading is not valid there; expected a shorter "
                "or lighter cable, or more pull of the body"
            )
        raise CableError(f"the cable has no tension at {where:.6g} of {tow.cable.length:g} from the body")
    if not solution.success or len(solution.t) > MAX_STEPS:
        raise CableError(f"the steady shape was not found within {MAX_STEPS} steps: {solution.message}")
    edges: Array = solution.t
    return edges


def steady(tow: Tow, edges: Array | None = None) -> Steady:
    """Steady state on ``edges`` (default: the graded mesh). Raises `CableError` as `graded_edges`, or where Newton's
    method does not converge in an element."""
    if edges is None:
        edges = graded_edges(tow)
    nodes, values, derivative = basis()
    count = len(edges) - 1
    angle, log_tension, x, y = (np.empty((count, len(nodes))) for _ in range(4))
    state = np.array([tow.end_angle, math.log(tow.end_tension)])
    x_end = y_end = 0.0
    solve_integral: Array = np.linalg.inv(derivative[:, 1:]).astype(float)
    for k in range(count):
        half = 0.5 * (edges[k + 1] - edges[k])
        angle[k], log_tension[k] = _element(tow, state, half, values, derivative)
        state = np.array([angle[k, -1], log_tension[k, -1]])
        at_gauss = values @ angle[k]
        stretch = half * tow.sign * (1.0 + np.exp(values @ log_tension[k]) / tow.cable.axial_stiffness)
        x[k, 0], y[k, 0] = x_end, y_end
        x[k, 1:] = x_end + solve_integral @ (stretch * np.cos(at_gauss))
        y[k, 1:] = y_end + solve_integral @ (stretch * np.sin(at_gauss))
        x_end, y_end = x[k, -1], y[k, -1]
    return Steady(tow, edges, angle, log_tension, x, y)


def _element(tow: Tow, start: Array, half: float, values: Array, derivative: Array) -> tuple[Array, Array]:
    """(phi0, ln T0) at the nodes of one element by Newton's method with finite differences of the local slopes."""
    p = len(values)
    y = np.repeat(start[:, None], p + 1, axis=1)
    best = math.inf
    for _ in range(60):
        at = values @ y[0], values @ y[1]
        f = np.array(slopes(tow, *at))
        residual = np.concatenate([derivative @ y[0] - half * f[0], derivative @ y[1] - half * f[1]])
        step = 1e-7
        columns = [
            (np.array(slopes(tow, at[0] + step, at[1])) - f) / step,
            (np.array(slopes(tow, at[0], at[1] + step)) - f) / step,
        ]
        jacobian = np.empty((2 * p, 2 * p))
        for row in range(2):
            for column in range(2):
                block = -half * columns[column][row][:, None] * values[:, 1:]
                jacobian[row * p : (row + 1) * p, column * p : (column + 1) * p] = block + (
                    derivative[:, 1:] if row == column else 0.0
                )
        change = np.linalg.solve(jacobian, residual)
        size = float(np.max(np.abs(change)))
        y[0, 1:] -= change[:p]
        y[1, 1:] -= change[p:]
        if size < 1e-15 * (1.0 + float(np.max(np.abs(y)))) or (size < 1e-12 and size > 0.3 * best):
            return y[0], y[1]
        best = min(best, size)
    raise CableError("the steady shape did not converge within 60 iterations in an element of the mesh")
