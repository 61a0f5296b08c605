"""The speed of a ship at a place, and the Hamiltonian of the minimal-time problem.

    h(x, t, l) = m [-c A + S] + m u.l,   A = l.k,   B = l.k',   S = sqrt(a^2 A^2 + b^2 B^2)
    x' = dh/dl = m [(-c + a^2 A/S) k + (b^2 B/S) k' + u],      l' = -dh/dx

| symbol | meaning | unit |
|---|---|---|
| x, t | place on the plane and time | m, s |
| l | adjoint vector, normal to the front of places that can be reached | - |
| m | scale of the map | - |
| a, b, c, k, k' | the ellipse of speeds (`polar`) and its axes | m/s |
| u | current | m/s |
| D | determinant of the adjoint columns, D' = -D div, div = sum d^2 h/(dx_i dl_i) | - |
| rho | curvature radius of the ellipse, d^2 h/dl^2 = (m rho/|l|) n'n' with n' across l | m/s |

h is the support function of the set of velocities: no quadrants, no arctangent and no division by the sine of a course
angle, where the source divides by zero on courses along the waves. The terms with rho and D give the source's own
Jacobian (`shooting`).

Assumptions: those of `polar`; 0 lies inside the ellipse, so that waiting never helps.

Source: Minimal-time ship routing (1964), equations (7)-(10), (13), (14), (16), (26).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..numeric.arrays import AnyArray
from ..numeric.ops import Value, arrays
from .fields import Field, Sea, ShearCurrent
from .maps import RouteMap
from .polar import Polar, TablePolar

OPS = arrays()
STILL = ShearCurrent()


@dataclass(frozen=True)
class Medium:
    """Map, field and polar of a problem, and a current where there is one."""

    map: RouteMap
    field: Field
    polar: Polar
    current: ShearCurrent = STILL

    @property
    def smooth(self) -> bool:
        """Whether the polar is an ellipse, so that shooting applies."""
        return not isinstance(self.polar, TablePolar)

    def _axes(self, sea: Sea) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray, AnyArray, AnyArray]:
        """Axes of the ellipse and their derivatives; the smallest circle where the waves have no direction."""
        if isinstance(self.polar, TablePolar):
            raise TypeError("a table has no ellipse")
        a, b, c, da, db, dc = self.polar.axes(sea.height, OPS)
        if sea.directed.all():
            return a, b, c, da, db, dc
        least = np.minimum(a - np.abs(c), b)
        slope = np.where(a - np.abs(c) < b, da - np.sign(c) * dc, db)
        pick, zero = sea.directed, np.zeros_like(a)
        return (
            np.where(pick, a, least), np.where(pick, b, least), np.where(pick, c, zero),
            np.where(pick, da, slope), np.where(pick, db, slope), np.where(pick, dc, zero),
        )  # fmt: skip

    def rates(self, t: AnyArray, x: AnyArray, y: AnyArray, lx: AnyArray, ly: AnyArray, d: AnyArray) -> tuple[AnyArray, ...]:
        """(x', y', lx', ly', D', J') with J' = m rho D^2/|l|^3, all arrays of one shape."""
        sea = self.field.at(x, y, t)
        a, b, c, da, db, dc = self._axes(sea)
        m, mx, my = self.map.scale(x, y)
        A, B = lx * sea.kx + ly * sea.ky, ly * sea.kx - lx * sea.ky
        S = np.sqrt((a * A) ** 2 + (b * B) ** 2)
        inverse = 1.0 / S
        p, q = a * a * A * inverse, b * b * B * inverse  # dS/dA, dS/dB
        g = p - c
        vx, vy = m * (g * sea.kx - q * sea.ky), m * (g * sea.ky + q * sea.kx)
        h = m * (S - c * A)
        s_h = (a * da * A * A + b * db * B * B) * inverse
        h_h = m * (s_h - dc * A)
        h_k = m * B * (g - b * b * A * inverse)
        u, w = self.current.at(x, y)
        u_y, w_x = self.current.rate_x, self.current.rate_y
        drift = u * lx + w * ly
        lx_rate = -(mx / m * h + h_h * sea.height_x + h_k * sea.angle_x + mx * drift + m * w_x * ly)
        ly_rate = -(my / m * h + h_h * sea.height_y + h_k * sea.angle_y + my * drift + m * u_y * lx)
        # d^2 h/(dx_i dl_i): derivatives of (g, q) along k and k' with H and K, dotted with their gradients
        g_h = (2.0 * a * da * A - p * s_h) * inverse - dc
        q_h = (2.0 * b * db * B - q * s_h) * inverse
        s_k = (p * B - q * A)
        g_k = (a * a * B - p * s_k) * inverse
        q_k = (-b * b * A - q * s_k) * inverse
        along_h = sea.kx * sea.height_x + sea.ky * sea.height_y
        across_h = sea.kx * sea.height_y - sea.ky * sea.height_x
        along_k = sea.kx * sea.angle_x + sea.ky * sea.angle_y
        across_k = sea.kx * sea.angle_y - sea.ky * sea.angle_x
        div = m * (g_h * along_h + q_h * across_h + (g_k - q) * along_k + (q_k + g) * across_k)
        vx, vy = vx + m * u, vy + m * w
        div = div + (vx * mx + vy * my) / m
        # m rho/|l|^3 = m a^2 b^2/S^3: rho = a^2 b^2/(S/|l|)^3
        return vx, vy, lx_rate, ly_rate, -d * div, m * (a * b * d) ** 2 * inverse**3

    def velocity(self, t: AnyArray, x: AnyArray, y: AnyArray, lx: AnyArray, ly: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """x', y' and h for the best control at l."""
        sea = self.field.at(x, y, t)
        a, b, c = self._axes(sea)[:3]
        m = self.map.scale(x, y)[0]
        A, B = lx * sea.kx + ly * sea.ky, ly * sea.kx - lx * sea.ky
        S = np.sqrt((a * A) ** 2 + (b * B) ** 2)
        g, q = a * a * A / S - c, b * b * B / S
        u, w = self.current.at(x, y)
        vx, vy = m * (g * sea.kx - q * sea.ky + u), m * (g * sea.ky + q * sea.kx + w)
        return vx, vy, vx * lx + vy * ly

    def normal(self, t: float, x: float, y: float, direction: float) -> float:
        """Angle of the l whose best velocity without current points along ``direction``, rad."""
        one = np.array([1.0])
        sea = self.field.at(x * one, y * one, t * one)
        a, b, c = (float(v[0]) for v in self._axes(sea)[:3])
        px, py = np.cos(direction), np.sin(direction)
        along, across = float((px * sea.kx + py * sea.ky)[0]), float((py * sea.kx - px * sea.ky)[0])
        v = float(_radius(a, b, -c, 0.0, along, across))
        nx, ny = (v * along + c) / a**2, v * across / b**2
        kx, ky = float(sea.kx[0]), float(sea.ky[0])
        return float(np.arctan2(nx * ky + ny * kx, nx * kx - ny * ky))

    def speed_along(self, t: AnyArray, x: AnyArray, y: AnyArray, px: AnyArray, py: AnyArray) -> AnyArray:
        """Largest speed on the plane, m/s, along the unit vector p; 0 where the ship cannot make it good."""
        sea = self.field.at(x, y, t)
        m = self.map.scale(x, y)[0]
        along, across = px * sea.kx + py * sea.ky, py * sea.kx - px * sea.ky
        if isinstance(self.polar, TablePolar):
            theta = np.where(sea.directed, np.arctan2(across, along), 0.0)
            return np.asarray(m * self.polar.speed_along(sea.height, theta))
        a, b, c = self._axes(sea)[:3]
        u, w = self.current.at(x, y)
        v = _radius(a, b, u * sea.kx + w * sea.ky - c, w * sea.kx - u * sea.ky, along, across)
        return np.asarray(m * np.maximum(0.0, v))


def _radius(a: Value, b: Value, ck: Value, cn: Value, along: Value, across: Value) -> Value:
    """v > 0 with v (along, across) on the ellipse of semi-axes a, b about (ck, cn); 0 where there is none."""
    qa = (along / a) ** 2 + (across / b) ** 2
    qb = along * ck / a**2 + across * cn / b**2
    qc = (ck / a) ** 2 + (cn / b) ** 2 - 1.0
    root = qb * qb - qa * qc
    return np.where(root >= 0.0, (qb + np.sqrt(np.maximum(root, 0.0))) / qa, 0.0)
