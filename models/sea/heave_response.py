"""Heave of a ship in waves in closed form.

    RAO = eta F,   eta = 1/sqrt((1 - 2 k T a^2)^2 + Q^2),   Q = A^2/(k B a^2) = k B a^2 sinc^2(k B a^2/2) exp(-2 k T a^2)
    F = kappa f sinc(k |cos beta| L/2),   f = sqrt((1 - k T)^2 + (Q/a)^2),   omega_e = omega - k V cos(beta) = a omega

| symbol | meaning | unit |
|---|---|---|
| RAO | heave over wave amplitude, with the sign of sinc (it changes where the hull is longer than a wave) | - |
| L, B, T | length, breadth times block coefficient, draught of a box of the ship's displacement | m |
| V, beta | speed; angle between the course and the waves' travel, pi = head sea, 0 = following | m/s, rad |
| k | wave number omega^2/g (deep water) | 1/m |
| a | omega_e/omega: negative where the ship overtakes the waves | - |
| kappa | Smith factor exp(-k T), or exp(-k |cos beta| T) | - |
| sinc(u) | sin(u)/u | - |

Written with sinc, every term is regular at a = 0, where the encounter stands still.

Assumptions: (1) a box-like monohull, linear motion; (2) deep water; (3) Froude number V/sqrt(g L) below about 0.3;
(4) heave uncoupled from pitch and roll, at the centre of the ship; (5) which Smith factor is meant is not settled: the
MSS toolbox has exp(-k |cos beta| T), NetSSE exp(-k T). They agree in head and following seas; in a beam sea at
0.7 rad/s a frigate has 1.78 with the first and 1.21 with the second. exp(-k T) is the default, because the other
tends to a finite heave in short beam waves.

Source: J. J. Jensen, A. E. Mansour, A. S. Olsen, Ocean Engineering 31 (2004) 61-85, as implemented in the two
programs named. Range there: monohulls, V/sqrt(g L) < 0.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from ..numeric.ops import FLOATS, NEGLIGIBLE, Ops, Value
from . import waves
from .waves import GRAVITY

FROUDE_LIMIT = 0.3
HIGHEST = 6.0
"""Highest frequency of `heave_moments`, rad/s (waves of 1.7 m): with the oblique Smith factor m4 diverges in a beam sea
and its value is that of the cut."""


class Hull(NamedTuple):
    """L, B (breadth times block coefficient) and T, m; ``smith_oblique`` 1: kappa = exp(-k |cos beta| T)."""

    length: Value
    breadth: Value
    draught: Value
    smith_oblique: Value = 0.0


def encounter_frequency(omega: Value, speed: Value, cos_beta: Value, gravity: float = GRAVITY) -> Value:
    """omega_e, rad/s, signed: negative where the ship overtakes the waves."""
    return omega - omega * omega / gravity * speed * cos_beta


def _sinc(u: Value, ops: Ops) -> Value:
    small = ops.abs(u) < 1e-4
    return ops.where(small, 1.0 - u * u / 6.0, ops.sin(u) / ops.where(small, 1.0, u))


def heave_rao(omega: Value, speed: Value, cos_beta: Value, hull: Hull, ops: Ops, gravity: float = GRAVITY) -> Value:
    """Signed heave per wave amplitude at ``omega``, rad/s, ``speed``, m/s; 1 at omega = 0, and finite where a hull without
    breadth, undamped, is in resonance."""
    k = omega * omega / gravity
    return _lift(omega, k, speed, cos_beta, hull, ops) * _sinc(0.5 * k * ops.abs(cos_beta) * hull.length, ops)


def pitch_rao(omega: Value, speed: Value, cos_beta: Value, hull: Hull, ops: Ops, gravity: float = GRAVITY) -> Value:
    """Pitch, bow down, per wave amplitude, rad/m, a quarter of a period ahead of the crest amidships: of long waves their
    slope along the ship, k cos(beta)."""
    k = omega * omega / gravity
    s = 0.5 * k * cos_beta * hull.length
    small = ops.abs(s) < 1e-2  # the first term left out is s^4/280 of it
    safe = ops.where(small, 1.0, s)
    slope = ops.where(small, s * (1.0 - 0.1 * s * s) / 3.0, (ops.sin(safe) - safe * ops.cos(safe)) / (safe * safe))
    return _lift(omega, k, speed, cos_beta, hull, ops) * 6.0 / hull.length * slope


def _lift(omega: Value, k: Value, speed: Value, cos_beta: Value, hull: Hull, ops: Ops) -> Value:
    """eta kappa f, which heave and pitch share."""
    a = 1.0 - k * speed * cos_beta / ops.where(omega > 0.0, omega, 1.0)
    a2 = a * a
    kb, kt = k * hull.breadth, k * hull.draught
    c = _sinc(0.5 * kb * a2, ops)
    damping = kb * c * c * ops.exp(-2.0 * kt * a2)  # Q/a^2
    q = damping * a2
    eta = 1.0 / ops.sqrt(ops.maximum((1.0 - 2.0 * kt * a2) * (1.0 - 2.0 * kt * a2) + q * q, NEGLIGIBLE))
    f = ops.sqrt((1.0 - kt) * (1.0 - kt) + (damping * a) * (damping * a))
    depth = ops.where(hull.smith_oblique > 0.5, ops.abs(cos_beta), 1.0)
    return eta * ops.exp(-kt * depth) * f


def heave_moments(
    height: float, omega_p: float, speed: float, beta: float, hull: Hull, gamma: float = 1.0,
    powers: Sequence[int] = (0, 2, 4), highest: float = HIGHEST, gravity: float = GRAVITY,
) -> tuple[float, ...]:
    """int omega_e^k RAO^2 S d omega for k in ``powers``, up to ``highest``, rad/s: for 0, 2 and 4 the variances of
    heave, velocity and acceleration, m2, m2/s2, m2/s4, in a long-crested sea."""
    cos_beta, m0 = math.cos(beta), height * height / 16.0
    totals = []
    for power in powers:

        def density(x: float, power: int = power) -> float:
            omega = x * omega_p
            rao = heave_rao(omega, speed, cos_beta, hull, FLOATS, gravity)
            met: float = encounter_frequency(omega, speed, cos_beta, gravity)
            return float(met**power * rao * rao * waves.shape(x, gamma))

        totals.append(m0 * waves.integrate(density, 0.3, max(highest / omega_p, 1.0)))
    return tuple(totals)


@dataclass(frozen=True)
class Components:
    """The components of a sea, whatever its height and period: ``x`` = omega_i/omega_p, ``amplitude`` per significant
    height, ``phase``, and the cosine and sine of the direction relative to the mean one; n values each."""

    x: tuple[float, ...]
    amplitude: tuple[float, ...]
    phase: tuple[float, ...]
    cos: tuple[float, ...]
    sin: tuple[float, ...]


@lru_cache(maxsize=32)
def components(
    n: int, seed: int, gamma: float = 1.0, spread: int = -1, directions: int = 1,
    band: tuple[float, float] = waves.BAND, order: float = 1.0,
) -> Components:
    """n components of one peak, long-crested for ``spread`` < 0, else cos^2s with s = ``spread`` over ``directions``
    directions. Raises ``ValueError`` as `waves` does."""
    return listed(peak(n, gamma, spread, directions, band, order), seed)


Row = tuple[float, float, float]
"""Of a component: omega/omega_p, amplitude per significant height, direction relative to the mean one, rad."""


def peak(
    n: int, gamma: float, spread: int, directions: int, band: tuple[float, float] = waves.BAND, order: float = 1.0
) -> list[Row]:
    """The components of one peak.

    With directions, each has n/directions components from a Gauss rule of its own, on a band that reaches up to a tenth
    higher, so that no two components share a frequency and a record tells as much as an ensemble."""
    fan: Sequence[tuple[float, float]] = ((0.0, 1.0),) if spread < 0 else waves.spreading(spread, directions)
    fan = [(mu, share) for mu, share in fan if share > 1e-12]
    rows = []
    for j, (mu, share) in enumerate(fan):
        own = (band[0], band[1] * (1.0 + 0.1 * j / len(fan)))
        for x, w in waves.gauss_rule(max(2, n // len(fan)), gamma, own, order):
            rows.append((x, math.sqrt(share * w / 8.0), mu))
    return rows


def listed(rows: Sequence[Row], seed: int) -> Components:
    """Rows as columns, with phases."""
    return Components(
        tuple(r[0] for r in rows), tuple(r[1] for r in rows), waves.phases(seed, len(rows)),
        tuple(math.cos(r[2]) for r in rows), tuple(math.sin(r[2]) for r in rows),
    )  # fmt: skip


def heave_amplitudes(
    height: float, omega_p: float, speed: float, beta: float, hull: Hull, sea: Components, gravity: float = GRAVITY
) -> tuple[float, ...]:
    """Signed amplitude of heave of every component, m."""
    cos_beta, sin_beta = math.cos(beta), math.sin(beta)
    return tuple(
        height * amplitude * heave_rao(omega_p * x, speed, cos_beta * c - sin_beta * s, hull, FLOATS, gravity)
        for x, amplitude, c, s in zip(sea.x, sea.amplitude, sea.cos, sea.sin)
    )
