"""The margin of a changing tow speed against the lateral motion with the forces of dU/dt, which the unit leaves out.

In the weak form of `towage.models.slender.galerkin`, with u' = du/dt', they add to the stiffness

    u' [ sqrt(beta) int y' phi + (1 - beta)/sqrt(beta) int (1/2 - xi) y' phi' + 2 mu/sqrt(beta) (rope) ]

that is: the water's M dU/dt y'; the tension m dU/dt (L/2 - x) behind each section; the rope, whose pull grows by m_x dU/dt
(mu = m_x over (m + M) L) in the terms of g5 to g8 and in the force of the craft.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from towage.models.numeric.ops import FLOATS
from towage.models.slender import body, galerkin
from towage.models.slender.prepared import prepare
from towage.models.slender.setup import Parameters, axial_mass, dimensionless, masses
from towage.registry import UNITS

Array = NDArray[np.float64]
H = 0.1


def towed(**changes: float) -> Parameters:
    start: Any = {v.name: v.start for v in UNITS.get("slender_body").parameters}
    return Parameters(**({name: start[name] for name in Parameters.__dataclass_fields__} | changes))


def left_out(p: Parameters) -> tuple[Array, Array]:
    """(stiffness, force of the craft) for u' = 1."""
    numbers, n = dimensionless(p, FLOATS), prepare(p).n
    made, (fluid, mass) = galerkin.weak_forms(n), masses(p, FLOATS)
    beta, lam, rope = float(numbers.mass_ratio), float(numbers.end_length), float(numbers.rope_length)
    root, mu = math.sqrt(beta), float(axial_mass(p, FLOATS) / (mass + fluid) / p.length)
    points, weights = np.polynomial.legendre.leggauss(n + 4)
    value, slope = galerkin.basis(n, points / 2.0)
    water = (value * weights[:, None] / 2.0).T @ slope
    tension = (slope * ((0.5 - points / 2.0) * weights / 2.0)[:, None]).T @ slope
    f = made.forms
    pull = (0.5 * (f["g6"] - lam * f["g5"]) + 0.5 * lam * (f["g8"] - (lam + rope) * f["g7"])) / rope
    stiffness = root * water + (1.0 - beta) / root * tension + 2.0 * mu / root * pull
    force = mu / root / rope * (made.nose - lam * made.nose1)
    return made.change.T @ stiffness @ made.change, made.change.T @ force


def motion(p: Parameters, speeds: tuple[float, float], ramp: float, period: float, full: bool) -> tuple[Array, float]:
    """(tip and tail, m, every `H` s; the largest share of m_x dU/dt in the pull) behind a craft that sways by 0.1 m."""
    made = prepare(p)
    n, tau = made.n, made.tau
    stiffness, force = left_out(p)
    inverse = np.linalg.inv(made.system.mass)
    z, rows, largest = np.zeros(2 * n), [], 0.0
    for k in range(round(min(1.3 * ramp, 100.0) / H)):
        s = min((k + 0.5) * H / ramp, 1.0)
        speed = speeds[0] + (speeds[1] - speeds[0]) * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        rate = (speeds[1] - speeds[0]) * 30.0 * (s * (1.0 - s)) ** 2 / ramp
        largest = max(largest, float(made.constants.axial_mass) * abs(rate) / (made.pull * speed**2))
        a, b = made.system.companion(speed / made.speed), made.system.load(speed / made.speed)
        if full:
            changed = rate / made.speed * tau
            a[n:, :n] -= changed * inverse @ stiffness / made.system.scale
            b[n:] += changed * inverse @ force
        step = np.zeros((2 * n + 2, 2 * n + 2))
        step[: 2 * n, : 2 * n], step[: 2 * n, 2 * n], step[2 * n, 2 * n + 1] = a / tau, b / tau, 1.0 / H
        w = [0.1 * math.sin(2.0 * math.pi * t * H / period) for t in (k, k + 1)]
        z = (expm(H * step) @ np.concatenate([z, [w[0], w[1] - w[0]]]))[: 2 * n]
        rows.append(made.points[:2] @ z[:n])
    return np.array(rows), largest


def test_a_straight_tow_stays_straight() -> None:
    """Neither rope nor water turns a body that is towed straight, whatever its position: craft and body as far to port."""
    p = towed(flexible=0.0)
    stiffness, force = left_out(p)
    aside = np.zeros(prepare(p).n)
    aside[0] = 1.0  # phi_0 = 1
    assert stiffness @ aside == pytest.approx(force, abs=1e-12)


@pytest.mark.parametrize("count", [4, pytest.param(24, marks=pytest.mark.slow)])
def test_the_margin_bounds_the_error_of_a_stable_body(count: int) -> None:
    """Random ramps of a rigid body with a blunt tail, which is stable, while its rope is taut."""
    rng, ratios = np.random.default_rng(2), []
    for _ in range(count):
        p = towed(tail_cut=0.4, flexible=0.0, rope_length=rng.uniform(5.0, 20.0))
        start, ramp, period = rng.uniform(1.0, 3.5), 10 ** rng.uniform(0.9, 2.3), rng.uniform(6.0, 20.0)
        speeds = start, start * rng.uniform(0.6, 1.8)
        full, share = motion(p, speeds, ramp, period, True)
        frozen, _ = motion(p, speeds, ramp, period, False)
        error = float((np.abs(full - frozen).max(0) / np.abs(full).max(0)).max())
        if share < 1.0:
            ratios.append(body.FELT * share / error)
    assert len(ratios) > 0.6 * count
    assert min(ratios) >= 1.0
    assert np.median(ratios) < 6.0
