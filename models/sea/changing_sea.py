"""Heave of a ship in a sea of many components: a steady one, and one that goes over into another.

    x = sum A_i cos(phi_i),   phi_i = x_i P - x_i^2 (cos(mu_i) C - sin(mu_i) D) + e_i

Symbols, units and assumptions: `ship_in_sea`, which this serves with the sums over all components.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from . import heave_response
from .waves import GRAVITY

Heave = tuple[float, float, float, float]
"""Heave, m, its rate, m/s, and acceleration, m/s2; variance, m2."""
Phases = tuple[float, float, float]
"""P, C and D, rad."""


class Sea(NamedTuple):
    """Significant height, m, peak frequency, rad/s, direction, rad, speed of the ship, m/s."""

    height: float
    frequency: float
    direction: float
    speed: float


@lru_cache(maxsize=64)
def _table(sea: Sea, components: heave_response.Components, hull: heave_response.Hull) -> tuple[
    tuple[float, ...], tuple[float, ...], float
]:
    """Amplitudes, m, and frequencies of encounter, rad/s, of all components, and the variance of their sum, m2."""
    height, omega_p, direction, speed = sea
    amplitudes = heave_response.heave_amplitudes(height, omega_p, speed, direction, hull, components)
    c, s = doppler(sea)
    rates = tuple(
        x * omega_p - x * x * (mc * c - ms * s) for x, mc, ms in zip(components.x, components.cos, components.sin)
    )
    return amplitudes, rates, 0.5 * math.fsum(a * a for a in amplitudes)


def doppler(sea: Sea) -> tuple[float, float]:
    """C' and D', rad/s."""
    scale = sea.frequency * sea.frequency * sea.speed / GRAVITY
    return scale * math.cos(sea.direction), scale * math.sin(sea.direction)


def steady_heave(
    phases: Phases, sea: Sea, components: heave_response.Components, hull: heave_response.Hull
) -> Heave:
    """While amplitudes and frequencies stay."""
    amplitudes, rates, variance = _table(sea, components, hull)
    phase_p, phase_c, phase_d = phases
    value = rate = acceleration = 0.0
    sin, cos, c = math.sin, math.cos, components
    for a, w, n, mc, ms, e in zip(amplitudes, rates, c.x, c.cos, c.sin, c.phase):
        phi = n * (phase_p - n * (mc * phase_c - ms * phase_d)) + e
        along, across = a * cos(phi), a * w * sin(phi)
        value += along
        rate -= across
        acceleration -= w * w * along
    return value, rate, acceleration, variance


def changing_heave(
    phases: Phases, old: Sea, new: Sea, blending: tuple[float, float, float],
    components: heave_response.Components, hull: heave_response.Hull,
) -> Heave:  # fmt: skip
    """While amplitudes and frequencies go over to those of the new sea by ``blending``, a share and its two rates."""
    (a0, w0, _), (a1, w1, _) = _table(old, components, hull), _table(new, components, hull)
    (phase_p, phase_c, phase_d), (blend, blend1, blend2) = phases, blending
    value = rate = acceleration = variance = 0.0
    sin, cos, c = math.sin, math.cos, components
    for b0, b1, f0, f1, n, mc, ms, e in zip(a0, a1, w0, w1, c.x, c.cos, c.sin, c.phase):
        phi = n * (phase_p - n * (mc * phase_c - ms * phase_d)) + e
        da, dw = b1 - b0, f1 - f0
        a, w = b0 + blend * da, f0 + blend * dw
        sine, cosine = sin(phi), cos(phi)
        value += a * cosine
        rate += blend1 * da * cosine - a * w * sine
        acceleration += (blend2 * da - a * w * w) * cosine - (2.0 * blend1 * da * w + a * blend1 * dw) * sine
        variance += a * a
    return value, rate, acceleration, 0.5 * variance
