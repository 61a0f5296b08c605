"""Towed slender body: critical tow speeds, yawing and oscillatory, and double roots.

    yaw:          det(K0 + u^2 K2) = 0, an eigenproblem in u^2: no search and no start value
    oscillatory:  f(u, i omega) = 0
    double root:  f(u, s) = df/ds(u, s) = 0, s real

f is the scalar of the bordered pencil P(u, s) = s^2 M + s D + K,

    [P  b] [v]   [0]
    [c  0] [f] = [1],      [w^T f] [P b; c 0] = [0 1]

zero where P is singular and smooth there, at double roots too, where the eigenvalue itself is not (s - s* ~
sqrt(u - u*), and an eigensolver gives 1e-5 at a residual of 1e-10). Its derivatives are -w^T P_x v, and by one more
solve the second ones, hence Newton in (u, omega) and in (u, s).

| symbol | meaning |
|---|---|
| u, s, omega | tow speed, exponent, frequency of `coefficients`, dimensionless |
| b, c | borders: the vectors of P at the start of Newton's iteration, which is then close to its limit |

Assumptions and source as `coefficients`; W. Govaerts, Numerical Methods for Bifurcations of Dynamical
Equilibria (2000), chapter 3, for the bordered function.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, svd

from ..numeric.arrays import ComplexArray
from .coefficients import Body
from .galerkin import Matrices
from .modes import FUNCTIONS, matrices, roots
from .tracking import track


class Critical(NamedTuple):
    """An oscillatory critical point: tow speed u and frequency omega; ``destabilising`` if growth begins above u."""

    u: float
    omega: float
    destabilising: bool


class DoubleRoot(NamedTuple):
    """Tow speed u at which two real exponents meet at s."""

    u: float
    s: float


class Bordered:
    """The function f(u, s) near a point, with its derivatives."""

    def __init__(self, system: Matrices, u: float, s: complex) -> None:
        self.system = system
        left, _, right = svd(system.pencil(u, s))
        self._b, self._c = left[:, -1], right[-1].conj()

    def at(self, u: float, s: complex) -> tuple[complex, complex, complex, complex, complex]:
        """(f, f_s, f_u, f_ss, f_su)."""
        m, n = self.system, self.system.n
        border = np.zeros((n + 1, n + 1), complex)
        border[:n, :n] = m.pencil(u, s)
        border[:n, n], border[n, :n] = self._b, self._c.conj()
        unit = np.zeros(n + 1, complex)
        unit[n] = 1.0
        right, left = np.linalg.solve(border, unit), np.linalg.solve(border.T, unit)
        v, w = right[:n], left[:n]
        d, _ = m.first_order(u)
        p_s, p_u = 2.0 * s * m.mass + d, m.speed_derivative(u, s)
        loads = np.zeros((n + 1, 2), complex)
        loads[:n, 0], loads[:n, 1] = -p_s @ v, -p_u @ v
        v_s, v_u = np.linalg.solve(border, loads)[:n].T
        return (
            complex(right[n]), complex(-w @ (p_s @ v)), complex(-w @ (p_u @ v)),
            complex(-w @ (2.0 * (m.mass @ v) + 2.0 * (p_s @ v_s))),
            complex(-w @ (m.damping @ v + p_s @ v_u + p_u @ v_s)),
        )  # fmt: skip


def yaw(body: Body, u_max: float = 14.0, n: int = FUNCTIONS) -> list[float]:
    """Tow speeds in (0, ``u_max``] at which a real exponent passes through zero, ascending."""
    m = matrices(body, n)
    # det(K2 + x K0) with x = 1/u^2: K0 is singular, its rigid modes have x infinite (u = 0)
    scale = 1.0 / np.sqrt(1.0 + np.abs(np.diag(m.bending)))
    k2, k0 = m.stiffness * np.outer(scale, scale), m.bending * np.outer(scale, scale)
    a, b = eig(k2, -k0, right=False, homogeneous_eigvals=True)
    speeds = []
    for above, below in zip(a, b):
        # u^2 = below/above
        if abs(above) > 0.0:
            square = below / above
            if abs(square.imag) <= 1e-9 * abs(square) and 1e-8 < square.real <= u_max * u_max:
                speeds.append(float(np.sqrt(square.real)))
    return sorted(speeds)


def oscillatory_near(system: Matrices, u: float, omega: float, iterations: int = 30) -> tuple[float, float]:
    """(u, omega) of the critical point that Newton reaches from a start. Raises ``ArithmeticError`` if it reaches
    none."""
    f = Bordered(system, u, 1j * omega)
    for _ in range(iterations):
        value, f_s, f_u, _, _ = f.at(u, 1j * omega)
        jacobian = np.array([[f_u.real, -f_s.imag], [f_u.imag, f_s.real]])  # df/d omega = i f_s
        step = np.linalg.solve(jacobian, [-value.real, -value.imag])
        u, omega = u + float(step[0]), omega + float(step[1])
        if abs(step[0]) <= 1e-13 * max(1.0, abs(u)) and abs(step[1]) <= 1e-12 * max(1.0, abs(omega)):
            return u, omega
    if abs(step[0]) <= 1e-9 and abs(step[1]) <= 1e-9 * max(1.0, abs(omega)):
        return u, omega
    raise ArithmeticError(f"Newton found no oscillatory critical point: it stopped at u = {u:g}, omega = {omega:g}")


def oscillatory(
    body: Body, u_max: float = 12.5, n: int = FUNCTIONS, step: float = 0.05, within: float = 150.0
) -> list[Critical]:
    """Oscillatory critical points for u in (0, ``u_max``] with omega < ``within``, by frequency (which is by mode).

    ComplexArray roots are followed from one speed of a grid to the next; where Re s changes sign, Newton finds the point.
    """
    m = matrices(body, n)
    speeds = np.linspace(step, u_max, round(u_max / step))
    points: list[Critical] = []
    paths = track(m, speeds, within=within)
    for path in paths:
        s = path.roots[:, 0]
        for k in range(len(speeds) - 1):
            a, b = s[k], s[k + 1]
            if not (abs(a.imag) > 1e-9 and abs(b.imag) > 1e-9 and a.real * b.real < 0.0):
                continue
            share = a.real / (a.real - b.real)
            start = a + share * (b - a)
            try:
                u, omega = oscillatory_near(m, float(speeds[k] + share * step), abs(float(start.imag)))
            except (ArithmeticError, np.linalg.LinAlgError):
                continue
            inside = speeds[k] - step < u < speeds[k + 1] + step and omega > 1e-6
            if inside and not any(abs(u - c.u) < 1e-8 and abs(omega - c.omega) < 1e-6 for c in points):
                points.append(Critical(u, omega, bool(b.real > a.real)))
    return sorted(points, key=lambda c: (c.omega, c.u))


def double_root_near(system: Matrices, u: float, s: float, iterations: int = 40) -> DoubleRoot:
    """The double real root that Newton reaches from a start. Raises ``ArithmeticError`` if it reaches none."""
    f = Bordered(system, u, s)
    step = np.array([np.inf, np.inf])
    for _ in range(iterations):
        value, f_s, f_u, f_ss, f_su = f.at(u, s)
        jacobian = np.array([[f_u.real, f_s.real], [f_su.real, f_ss.real]])
        step = np.linalg.solve(jacobian, [-value.real, -f_s.real])
        u, s = u + float(step[0]), s + float(step[1])
        if np.abs(step).max() <= 1e-13 * max(1.0, abs(u), abs(s)):
            break
    if np.abs(step).max() > 1e-8 * max(1.0, abs(u), abs(s)):
        raise ArithmeticError(f"Newton found no double root: it stopped at u = {u:g}, s = {s:g}")
    return DoubleRoot(u, s)


def double_roots(
    body: Body, u_max: float = 12.0, n: int = FUNCTIONS, step: float = 0.01, within: float = 60.0
) -> list[DoubleRoot]:
    """Double real roots with |s| < ``within`` for u in (0, ``u_max``], ascending in u: the number of real exponents is
    watched on a grid of ``step`` and Newton finds the point."""
    m = matrices(body, n)
    doubles: list[DoubleRoot] = []
    before: ComplexArray | None = None
    for u in np.linspace(step, u_max, round(u_max / step)):
        s = roots(m, float(u))
        s = s[np.abs(s) < within]
        real = np.sort(s.real[s.imag == 0.0]).astype(complex)
        if before is not None and len(real) != len(before):
            many = (real if len(real) > len(before) else before).real
            for gap in np.argsort(np.diff(many))[: (abs(len(real) - len(before)) + 1) // 2]:
                try:
                    point = double_root_near(m, float(u), 0.5 * float(many[gap] + many[gap + 1]))
                except (ArithmeticError, np.linalg.LinAlgError):
                    continue
                if abs(point.u - u) < 3.0 * step and not any(abs(point.u - d.u) < 1e-7 for d in doubles):
                    doubles.append(point)
        before = real
    return sorted(doubles)


def stability_limits(body: Body, u_max: float = 12.5, n: int = FUNCTIONS) -> list[float]:
    """All critical speeds of either kind, ascending: between two of them the number of growing modes is constant."""
    return sorted([*yaw(body, u_max, n), *(c.u for c in oscillatory(body, u_max, n))])
