"""What a reference case of the nonlinear wire in motion does to its wire: path of the top, payout, a held lower end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from towage.models.cable.wire.chain import Drive, Paid
from towage.models.numeric.arrays import Array
from towage.verify.wire import vector

Values = Mapping[str, Any]


def smooth(x: float) -> tuple[float, float, float]:
    """S = x^3 (10 - 15 x + 6 x^2) between 0 and 1, and its two derivatives."""
    if not 0.0 < x < 1.0:
        return (0.0 if x <= 0.0 else 1.0), 0.0, 0.0
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * x * x * (1.0 - x) ** 2, 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)


def smooth_integral(x: float) -> float:
    """Of S from 0 to x."""
    y = min(max(x, 0.0), 1.0)
    return float(y**4 * (2.5 - 3.0 * y + y * y) + max(x - 1.0, 0.0))


@dataclass(frozen=True)
class Path:
    """What a case does to its wire, by its ``inputs``."""

    inputs: Values
    dimensions: int

    def _steady(self, t: float) -> tuple[Array, Array, Array]:
        top, zero = self.inputs["top"], np.zeros(3)
        c, r, u, a = float(top["speed"]), zero.copy(), zero.copy(), zero.copy()
        r[0], u[0] = c * t, c
        if "turn" in top and t > 0.0:
            radius, whole_angle = top["turn"]["radius"], top["turn"]["angle"]
            angle = min(c * t / radius, whole_angle)
            r[:2] = radius * math.sin(angle), radius * (1.0 - math.cos(angle))
            u[:2] = c * math.cos(angle), c * math.sin(angle)
            r += u * max(0.0, t - whole_angle * radius / c)
            if c * t / radius < whole_angle:
                a[:2] = -c * u[1] / radius, c * u[0] / radius
        elif "final_speed" in top:
            more, rise = top["final_speed"] - c, top["rise_time"]
            r[0] += more * rise * smooth_integral(t / rise)
            s, slope, _ = smooth(t / rise)
            u[0], a[0] = c + more * s, more * slope / rise
        return r, u, a

    def _oscillation(self, t: float) -> tuple[float, float, float]:
        """Of S(t/ramp) sin(omega t), and its derivatives."""
        top = self.inputs["top"]
        ramp, omega = float(top.get("ramp_time", 0.0)), float(top["omega"])
        s, s1, s2 = smooth(t / ramp) if ramp > 0.0 else (1.0, 0.0, 0.0)
        s1, s2 = (s1 / ramp, s2 / ramp**2) if ramp > 0.0 else (0.0, 0.0)
        sine, cosine = math.sin(omega * t), math.cos(omega * t)
        return (
            s * sine, s1 * sine + s * omega * cosine, s2 * sine + 2.0 * s1 * omega * cosine - s * omega**2 * sine,
        )  # fmt: skip

    def paid(self, t: float) -> Paid:
        """Wire paid out, its rate and change."""
        plan = self.inputs.get("payout")
        if plan is None:
            return 0.0, 0.0, 0.0
        rate, ramp = plan["rate"], plan["ramp_time"]
        on, off = t / ramp, (t - (plan["total_time"] - ramp)) / ramp
        length = rate * ramp * (smooth_integral(on) - smooth_integral(off))
        first, last = smooth(on), smooth(off)
        return length, rate * (first[0] - last[0]), rate / ramp * (first[1] - last[1])

    def __call__(self, t: float) -> Drive:
        """At time t, s."""
        top, d = self.inputs["top"], self.dimensions
        r, u, a = self._steady(t)
        if "amplitude" in top:
            size = np.array(top["amplitude"], float)
            r, u, a = (x + size * y for x, y in zip((r, u, a), self._oscillation(t)))
        r = r + np.array(top["position"], float)
        lower = None
        if "lower_end" in self.inputs:
            held = np.array(self.inputs["lower_end"]["position"], float)
            c = np.array([float(top["speed"]), 0.0, 0.0])
            lower = vector(held + c * t, d), vector(c, d), np.zeros(d)
        return Drive(vector(r, d), vector(u, d), vector(a, d), self.paid(t), None, lower)

    @property
    def corners(self) -> list[float]:
        """Times at which a derivative of the path jumps, s."""
        top, plan = self.inputs["top"], self.inputs.get("payout")
        found = [float(top[key]) for key in ("ramp_time", "rise_time") if key in top]
        if "turn" in top:
            found.append(top["turn"]["angle"] * top["turn"]["radius"] / top["speed"])
        if plan is not None:
            found += [plan["ramp_time"], plan["total_time"] - plan["ramp_time"], plan["total_time"]]
        return found

    @property
    def speed(self) -> float:
        """The largest of the case, m/s."""
        top, plan = self.inputs["top"], self.inputs.get("payout") or {"rate": 0.0}
        swing = float(np.abs(top.get("amplitude", (0.0,))).max()) * float(top.get("omega", 0.0))
        return max(float(top["speed"]), float(top.get("final_speed", 0.0)), swing, abs(float(plan["rate"])))
