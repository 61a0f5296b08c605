"""Elastic bar with a load at its lower end, moved at its upper end: what a line is that `spring_line` takes for a spring.

    T_top = K (x - y) + m (a x'' + b y'')      T_low = K (x - y) - m (b x'' + a y'')      M y'' = T_low - c |y'| y'
    a = (1 - theta cot theta)/theta^2,   b = (theta/sin theta - 1)/theta^2,   theta = omega L/c0 = omega sqrt(m/K)

| symbol | meaning | unit |
|---|---|---|
| x, y | heave of the upper end and of the load from the static equilibrium, positive up | m |
| T_top, T_low | tension at the upper and the lower end, above the static one | N |
| K, m | stiffness EA/L and mass of the wire; m = 0 is the massless spring | N/m, kg |
| M, c | virtual mass and drag factor of the load | kg, kg/m |
| W | static tension at the load | N |
| c0 | speed of waves along the wire, sqrt(EA L/m) | m/s |

With a and b taken at omega both tensions are those of the bar at that frequency, exactly: T_top = K theta (x cos theta - y)/sin
theta and T_low = K theta (x - y cos theta)/sin theta. Without drag that is

    y/x = 1/(cos theta - (M omega^2/K) sin theta/theta)

For theta towards 0 they are 1/3 and 1/6, the consistent mass of a rod; both grow with theta, so that a higher omega than that
of the motion overrates the wire.

Where the line goes slack the load falls free of the wire. When it is taut again while both ends part at v, a wave of
v sqrt(K m) runs up the wire on top of the tension of the spring: sqrt(K m) = EA/c0 is the impedance of the bar. Waves die out
as exp(-zeta omega1 t), zeta the damping ratio of the wire's first mode and omega1 = (pi/2) sqrt(K/m) its frequency, the slowest:
at worst all that is left of earlier snaps is in step with the next.

Assumptions: (1) theta < pi/2: below the first frequency of the wire alone; (2) no drag along the wire; (3) the wire leaves
slack straight and at rest in itself, so that the wave of an impact is that of one end that starts at v.
Source: the wave equation of a bar with a mass at its end; B. de Saint-Venant's impact of a mass on a bar, of which v sqrt(K M) +
v sqrt(K m) is the limit of a heavy load (S. Timoshenko, J. N. Goodier, Theory of Elasticity, longitudinal impact of bars).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

SMALL = 0.02
"""theta below which a and b are taken from their series."""


class Lift(NamedTuple):
    """K, N/m; m, kg; M, kg; c, kg/m; W, N; ``omega``, rad/s, at which a and b are taken."""

    stiffness: float
    wire: float
    load: float
    drag: float
    weight: float
    omega: float


class Path(NamedTuple):
    """y, m; T_top and T_low with the static tension W, N, at every second time of the motion of the top; ``impact``: the
    largest v at which a slack line became taut, m/s, at any time from ``settled`` on; ``ringing``: the same with what is left
    of the impacts before it, all in step."""

    load: list[float]
    top: list[float]
    low: list[float]
    impact: float
    ringing: float


def angle(omega: float, stiffness: float, wire: float) -> float:
    """theta = omega L/c0, of the stiffness, N/m, and mass of the wire, kg."""
    return omega * math.sqrt(wire / stiffness)


def shares(theta: float) -> tuple[float, float]:
    """(a, b). Raises ``ValueError`` for theta of pi/2 and more."""
    if not theta < 0.5 * math.pi:
        raise ValueError(f"omega L/c = {theta:.3g}: expected less than pi/2, the first frequency of the wire alone")
    if theta < SMALL:
        t2 = theta * theta
        return 1.0 / 3.0 + t2 / 45.0, 1.0 / 6.0 + 7.0 * t2 / 360.0
    return (1.0 - theta / math.tan(theta)) / theta**2, (theta / math.sin(theta) - 1.0) / theta**2


def response(omega: float, stiffness: float, wire: float, load: float) -> tuple[float, float, float]:
    """(y/x, T_top/x, T_low/x), - and N/m, at ``omega``, rad/s, without drag; ``wire`` = 0 is the massless spring."""
    theta = angle(omega, stiffness, wire)
    sine = math.sin(theta) / theta if theta else 1.0
    y = 1.0 / (math.cos(theta) - load * omega**2 / stiffness * sine)
    return y, stiffness * (math.cos(theta) - y) / sine, stiffness * (1.0 - y * math.cos(theta)) / sine


def follow(
    lift: Lift, h: float, top: Sequence[float], acceleration: Sequence[float], start: tuple[float, float], settled: int = 0,
    decay: float = 0.0,
) -> Path:  # fmt: skip
    """The load and both tensions under ``top`` (x, m) and its ``acceleration`` (m/s2) at times h/2 apart, an odd number of
    them, from ``start`` (y, m, and y', m/s) on, by the classical Runge-Kutta method of step ``h``, s. ``settled``: step from
    which on impacts count; ``decay``: of waves in the wire, 1/s."""
    a, b = shares(angle(lift.omega, lift.stiffness, lift.wire))
    k, weight, drag, load = lift.stiffness, lift.weight, lift.drag, lift.load
    ma, mb = lift.wire * a, lift.wire * b
    moving = load + ma

    def pulled(x: float, x2: float, y: float, v: float) -> tuple[float, float, float]:
        """(y'', T_low, T_top)."""
        force = drag * abs(v) * v
        spring = k * (x - y)
        y2 = (spring - mb * x2 - force) / moving
        low = weight + spring - mb * x2 - ma * y2
        if low > 0.0:
            return y2, low, weight + spring + ma * x2 + mb * y2
        return (-weight - force) / load, 0.0, 0.0

    y, v = start
    y2, low, high = pulled(top[0], acceleration[0], y, v)
    positions, tops, lows, impact = [y], [high], [low], 0.0
    waves, ringing, fade = 0.0, 0.0, math.exp(-decay * h)
    half, sixth = 0.5 * h, h / 6.0
    for n in range(0, len(top) - 2, 2):
        x0, x1, x2 = top[n], top[n + 1], top[n + 2]
        f1, f2 = acceleration[n + 1], acceleration[n + 2]
        v1 = v + half * y2
        a1 = pulled(x1, f1, y + half * v, v1)[0]
        v2 = v + half * a1
        a2 = pulled(x1, f1, y + half * v1, v2)[0]
        v3 = v + h * a2
        a3 = pulled(x2, f2, y + h * v2, v3)[0]
        y += sixth * (v + 2.0 * v1 + 2.0 * v2 + v3)
        v += sixth * (y2 + 2.0 * a1 + 2.0 * a2 + a3)
        was = low
        y2, low, high = pulled(x2, f2, y, v)
        waves *= fade
        if was <= 0.0 < low:
            speed = max(0.0, (x2 - x0) / h - v)
            waves += speed
            if n >= 2 * settled:
                impact, ringing = max(impact, speed), max(ringing, waves)
        positions.append(y)
        tops.append(high)
        lows.append(low)
    return Path(positions, tops, lows, impact, ringing)
