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
from functools import cached_property, reduce
from typing import Any

import numpy as np

from ..numeric.arrays import AnyArray
from ..numeric.ops import Value, arrays
from ..sea.waves import steepest_frequency
from .fields import Current, Field, LinearCurrent, Sea
from .hulls import TablePolar, WindWavePolar
from .limits import Limit
from .maps import RouteMap
from .polar import Polar

OPS = arrays()
STILL = LinearCurrent()
TOP_SPEED = 60.0
"""No ship is faster through the water, m/s."""
CALM = 0.1
"""Height below which a period is that of this height, m."""
AROUND = 72
"""Directions in which a largest speed is looked for."""
ANGLES = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)


@dataclass(frozen=True)
class Medium:
    """Map, wave field and polar of a problem, a current and the true wind where there are (``wind``: its speed as a height), and
    ``limits`` of what the sea may do to the ship."""

    map: RouteMap
    field: Field
    polar: Polar
    current: Current = STILL
    wind: Field | None = None
    limits: tuple[Limit, ...] = ()

    @property
    def smooth(self) -> bool:
        """Whether the polar is an ellipse, so that shooting applies."""
        return not isinstance(self.polar, (TablePolar, WindWavePolar))

    @property
    def parts(self) -> tuple[Field | Current, ...]:
        """Waves, current and wind."""
        return (self.field, self.current, *([self.wind] if self.wind else []))

    @property
    def horizon(self) -> float:
        """Time of the first last forecast, s; infinite for formulas."""
        return min(part.horizon for part in self.parts)

    @property
    def detail(self) -> float:
        """Length within which waves, current or wind change much, m."""
        return min(part.detail for part in self.parts)

    def inside(self, x: AnyArray, y: AnyArray) -> AnyArray:
        """Whether there are all data at these places."""
        known: AnyArray = np.ones(np.broadcast(x, y).shape, dtype=bool)
        for part in self.parts:
            known = known & part.inside(x, y)
        return known

    def _axes(self, sea: Sea) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray, AnyArray, AnyArray]:
        """Axes of the ellipse and their derivatives; the smallest circle where the waves have no direction."""
        if isinstance(self.polar, (TablePolar, WindWavePolar)):
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
        u, w, u_x, u_y, w_x, w_y = self.current.at(x, y, t)
        drift = u * lx + w * ly
        lx_rate = -(mx / m * h + h_h * sea.height_x + h_k * sea.angle_x + mx * drift + m * (u_x * lx + w_x * ly))
        ly_rate = -(my / m * h + h_h * sea.height_y + h_k * sea.angle_y + my * drift + m * (u_y * lx + w_y * ly))
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
        div = div + (vx * mx + vy * my) / m + m * (u_x + w_y)
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
        u, w = self.current.at(x, y, t)[:2]
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

    def frozen(self, t: AnyArray, x: AnyArray, y: AnyArray) -> Frozen:
        """Everything at these times and places but the course."""
        sea, scale = self.field.at(x, y, t), self.map.scale(x, y)[0]
        u, w = self.current.at(x, y, t)[:2]
        if isinstance(self.polar, (TablePolar, WindWavePolar)):
            return Frozen(self.polar, scale, u, w, sea, self.wind.at(x, y, t) if self.wind else None, None)
        return Frozen(self.polar, scale, u, w, sea, None, self._axes(sea)[:3])

    def speed_along(self, t: AnyArray, x: AnyArray, y: AnyArray, px: AnyArray, py: AnyArray) -> AnyArray:
        """Largest speed on the plane, m/s, along the unit vector p; 0 where the ship cannot make it good."""
        return self.frozen(t, x, y).along(px, py)

    def period(self, sea: Sea, x: AnyArray, y: AnyArray, t: AnyArray) -> AnyArray:
        """Peak period, s; where it is not known that of a Pierson-Moskowitz sea of the height, of `CALM` at least."""
        own = 2.0 * np.pi / steepest_frequency(np.maximum(sea.height, CALM), OPS)
        given = self.field.period(x, y, t)
        return np.where(given > 0.0, given, own)

    def uses(self, t: AnyArray, x: AnyArray, y: AnyArray, px: AnyArray, py: AnyArray) -> list[AnyArray]:
        """Of every limit its use on the course p over the ground, arrays of one shape."""
        sea = self.field.at(x, y, t)
        if self.current is not STILL:
            now = self.frozen(t, x, y)
            v = now.along(px, py) / now.scale
            vx, vy = v * px - now.u, v * py - now.w
            size = np.hypot(vx, vy)
            px, py = (np.where(size > 1e-9, part / np.maximum(size, 1e-9), p) for part, p in ((vx, px), (vy, py)))
        period = self.period(sea, x, y, t)
        return [limit.in_sea(sea, period, px, py) for limit in self.limits]

    def fastest(self, t: AnyArray, x: AnyArray, y: AnyArray) -> AnyArray:
        """A bound on the speed on the plane in any direction, m/s."""
        now = self.frozen(t, x, y)
        return np.asarray(np.max([now.support(np.cos(v), np.sin(v)) for v in ANGLES], axis=0) / np.cos(np.pi / AROUND))


@dataclass(frozen=True)
class Frozen:
    """The set of velocities at times and places, arrays of one shape: scale of the map, current, sea and wind, and the axes of
    the ellipse where the polar is one."""

    polar: Polar
    scale: AnyArray
    u: AnyArray
    w: AnyArray
    sea: Sea
    wind: Sea | None
    axes: tuple[AnyArray, AnyArray, AnyArray] | None
    asked: AnyArray | None = None

    @cached_property
    def fan(self) -> AnyArray:
        """Speeds of a table through the water in the directions `ANGLES`, (AROUND, ...)."""
        if self.asked is not None:
            return self.asked
        one = np.ones(np.shape(self.scale))
        return np.array([self.sail(np.cos(v) * one, np.sin(v) * one)[0] for v in ANGLES])

    def part(self, index: tuple[Any, ...]) -> Frozen:
        """The same at a part of the places."""
        def cut(values: Any) -> Any:
            return None if values is None else tuple(v[index] for v in values)

        sea, wind = Sea(*cut(self.sea)), None if self.wind is None else Sea(*cut(self.wind))
        fan = self.fan[(slice(None), *index)] if self.axes is None else None
        return Frozen(self.polar, self.scale[index], self.u[index], self.w[index], sea, wind, cut(self.axes), fan)

    def sail(self, px: AnyArray, py: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """(speed through the water along p, m/s, that without tacking, whether waves or wind are beyond the polar's range)."""
        sea = self.sea
        if isinstance(self.polar, (TablePolar, WindWavePolar)):
            return self.polar.sail(sea, self.wind, px, py)
        assert self.axes is not None
        a, b, c = self.axes
        v = _radius(a, b, -c, 0.0, px * sea.kx + py * sea.ky, py * sea.kx - px * sea.ky)
        return v, v, np.asarray(self.polar.beyond(sea.height)) & np.ones(np.shape(v), dtype=bool)

    def along(self, px: AnyArray, py: AnyArray) -> AnyArray:
        """Largest speed on the plane along the unit vector p, m/s; 0 where the ship cannot make it good."""
        if self.axes is None:
            return np.asarray(self.scale * self._table_along(px, py))
        sea, u, w = self.sea, self.u, self.w
        a, b, c = self.axes
        along, across = px * sea.kx + py * sea.ky, py * sea.kx - px * sea.ky
        v = _radius(a, b, u * sea.kx + w * sea.ky - c, w * sea.kx - u * sea.ky, along, across)
        return np.asarray(self.scale * np.maximum(0.0, v))

    def support(self, lx: Value, ly: Value) -> AnyArray:
        """h = max of l.x' over all velocities x' on the plane; of a table a bound."""
        if self.axes is None:
            sails = (speed * (np.cos(v) * lx + np.sin(v) * ly) for speed, v in zip(self.fan, ANGLES))
            own = reduce(np.maximum, sails) / np.cos(np.pi / AROUND)
        else:
            (a, b, c), sea = self.axes, self.sea
            A, B = lx * sea.kx + ly * sea.ky, ly * sea.kx - lx * sea.ky
            own = np.sqrt((a * A) ** 2 + (b * B) ** 2) - c * A
        return np.asarray(self.scale * (own + self.u * lx + self.w * ly))

    def _table_along(self, px: AnyArray, py: AnyArray) -> AnyArray:
        """Largest v >= 0 for which v p - (u, w) lies in the hull of a table. The gauge of a convex set is convex along a line, so
        that Newton's method from above comes down on the largest v without passing it."""
        if not (np.any(self.u) or np.any(self.w)):
            return self.sail(px, py)[0]

        def gauge(v: AnyArray) -> AnyArray:
            vx, vy = v * px - self.u, v * py - self.w
            size = np.hypot(vx, vy)
            safe = np.maximum(size, 1e-12)
            return np.asarray(size / np.maximum(self.sail(vx / safe, vy / safe)[0], 1e-9))

        v = np.full(np.broadcast(px, self.u).shape, TOP_SPEED) + np.hypot(self.u, self.w)
        for _ in range(40):
            step = 1e-6 * (1.0 + v)
            g = gauge(v)
            slope = (g - gauge(v - step)) / step
            lower = np.where(slope > 0.0, v - (g - 1.0) / np.where(slope > 0.0, slope, 1.0), -1.0)
            done = np.abs(lower - v) < 1e-9 * (1.0 + v)
            v = np.where(g > 1.0, np.maximum(lower, -1.0), v)
            if np.all(done | (g <= 1.0) | (v < 0.0)):
                break
        return np.asarray(np.maximum(0.0, v))


def _radius(a: Value, b: Value, ck: Value, cn: Value, along: Value, across: Value) -> Value:
    """v > 0 with v (along, across) on the ellipse of semi-axes a, b about (ck, cn); 0 where there is none."""
    qa = (along / a) ** 2 + (across / b) ** 2
    qb = along * ck / a**2 + across * cn / b**2
    qc = (ck / a) ** 2 + (cn / b) ** 2 - 1.0
    root = qb * qb - qa * qc
    return np.where(root >= 0.0, (qb + np.sqrt(np.maximum(root, 0.0))) / qa, 0.0)
