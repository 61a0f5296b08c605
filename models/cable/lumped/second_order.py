"""Response of a tow to second order: what a regular motion shifts in the mean, and what it moves at twice its frequency.

    q = q0 + Re(q1 exp(-i omega t)) + q20 + Re(q22 exp(-2 i omega t)),   q20, q22 ~ amplitude^2

q1 is the linear response; q20 and q22 answer the quadratic terms of drag, geometry and inertia of q1, through the same linear
operator: the first correction of ``picard.py`` for a motion so small that its higher terms vanish, scaled back. Its
segments have an error of second order, which is extrapolated away (Richardson, from N and 2 N segments).

Assumptions: those of ``picard.py``; amplitudes small enough for q20 and q22 to be the next term (`linearity` tells).

Source: second-order perturbation of Equations [1]-[10] of the small-perturbation report on towed cables, which stops at the
first; mean shift and double frequency as in the drift forces of ship hydrodynamics.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array
from ..case import CableError, Tow
from ..steady.perturbation import Excitation
from ..steady.response import check_frequency
from .lumped import equilibrium, hanging
from .picard import Motion, Picard

SEGMENTS, POINTS = 30, 16
SMALL = 1e-4
"""Largest velocity of the scaled motion over the tow speed: terms of fourth order are below 1e-8 of those of second."""


@dataclass(frozen=True)
class Amplitudes:
    """Tensions at top and body, N, and position of the body from the towpoint, forward and up, m."""

    tension_top: complex
    tension_body: complex
    body_surge: complex
    body_heave: complex


@dataclass(frozen=True)
class SecondOrder:
    """``first``: amplitudes q1 at omega; ``mean``: q20, real; ``second``: q22 at 2 omega; of Re(q exp(-i k omega t))."""

    omega: float
    first: Amplitudes
    mean: Amplitudes
    second: Amplitudes


def second_order(tow: Tow, omega: float, excitation: Excitation, quadratic_drag: bool) -> SecondOrder:
    """To second order, for motions and forces of these amplitudes at ``omega``, rad/s; ``quadratic_drag``: the body's drag is
    D_B |v| v/c^2, else constant. Raises `CableError` as `equilibrium`, and without a frequency or an excitation."""
    check_frequency(omega)
    count = hanging(tow, SEGMENTS).count
    coarse, fine = (_harmonics(tow, omega, excitation, quadratic_drag, n) for n in (count, 2 * count))
    whole = (4.0 * fine - coarse) / 3.0
    return SecondOrder(omega, *(Amplitudes(*map(complex, row)) for row in whole))


def _harmonics(tow: Tow, omega: float, e: Excitation, quadratic_drag: bool, segments: int) -> Array:
    """(first, mean, second) by the fields of `Amplitudes`, (3, 4)."""
    drive = np.array([-1j * omega * e.surge, -1j * omega * e.heave, -e.drag, e.lift])
    size = max(np.abs(drive[:2]).max() / tow.speed, np.abs(drive[2:]).max() / tow.end_tension)
    if not size > 0.0:
        raise CableError("no excitation: expected a motion of the towpoint or a force on the body")
    scale = SMALL / size
    step = 2.0 * math.pi / omega / POINTS
    turning = np.exp(-1j * omega * step * np.arange(POINTS))
    made = Picard(equilibrium(tow, segments), quadratic_drag, step, POINTS).run((scale * drive[:, None] * turning).real, 1)
    linear, corrected = (_rows(motion) for motion in (made.linear, made.corrected[0]))
    change = corrected - linear
    first = 2.0 * (linear * turning.conj()).mean(axis=1) / scale
    second = 2.0 * (change * turning.conj() ** 2).mean(axis=1) / scale**2
    return np.array([first, change.mean(axis=1) / scale**2, second])


def _rows(motion: Motion) -> Array:
    rows: Array = np.vstack([motion.tension_top, motion.tension_body, motion.body])
    return rows
