"""The two sample tables printed with OMWAY and OMFLO, reproduced by the printed program's own scheme.

The scheme lives here only, because it is wrong in two ways that the table proves:
1. it freezes phi0, T0 and the loads at node J over a segment and takes phi0' from a forward difference: first order in
   the segment whatever the integrator does, 1 to 4 % in this very sample;
2. its columns CX, CY are the increments phi1(J) DS (-sin, cos) of single segments; the listing has no sum. Accumulated,
   as [56] and [58] say, the towpoint moves 0.598 of the heave's amplitude relative to the body instead of 0.218.
"""

from __future__ import annotations

import cmath
import itertools
import json
import math
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from towage.models.cable.case import Body, Cable, Tow
from towage.models.cable.loading import eames
from towage.models.cable.steady.perturbation import Excitation, body_rows, coefficients, towpoint_values
from towage.models.cable.steady.response import respond
from towage.models.cable.steady.steady import slopes

POINTS = 20
SAMPLES: dict[str, Any] = json.loads((files("towage") / "reference" / "cable_samples.json").read_text("utf-8"))


def merson(rates: Any, y: Any, h: float) -> Any:
    """One Kutta-Merson step of y' = rates(y)."""
    k1 = h * rates(y)
    k2 = h * rates(y + k1 / 3.0)
    k3 = h * rates(y + k1 / 6.0 + k2 / 6.0)
    k4 = h * rates(y + k1 / 8.0 + 3.0 * k3 / 8.0)
    k5 = h * rates(y + k1 / 2.0 - 1.5 * k3 + 2.0 * k4)
    return y + (k1 + 4.0 * k4 + k5) / 6.0


def frozen(tow: Tow, omega: float, points: int = POINTS) -> tuple[list[Any], Any]:
    """The matrices in s, one a segment, and the angles at the points, both from the body on."""
    step = tow.cable.length / (points - 1)

    def rates(y: Any) -> Any:
        turn, growth = slopes(tow, y[0], np.log(y[1]))
        return np.array([turn, growth * y[1]])

    states = [np.array([tow.end_angle, tow.end_tension])]
    for _ in range(points - 1):
        states.append(merson(rates, states[-1], step))
    matrices = []
    for here, there in itertools.pairwise(states):
        node = here if tow.quadrant == 1 else there
        a = tow.sign * coefficients(tow, omega, np.array(node[0]), np.array(math.log(node[1])))
        slope = tow.sign * (there[0] - here[0]) / step
        a[0, 1], a[2, 3], a[3, 2] = -slope / node[1], slope, -slope
        matrices.append(a)
    return matrices, np.array([s[0] for s in states])


def sample_tow(sample: Any, quadrant: int, drag: float, weight: float, mass: float, lam: float) -> Tow:
    """The sample in units of the segment, the tow speed and the tension at the body."""
    # thickness from lam = rho pi h^2/(4 mu), drag coefficient from rho h C_D c^2/2
    thickness = math.sqrt(4.0 * mass * lam / math.pi)
    phi = sample["phi0_1"]
    cable = Cable(POINTS - 1.0, mass, weight, thickness, 2.0 * drag / thickness, eames(0.05), 1.0, True)
    pull = (math.cos(phi), math.sin(phi)) if quadrant == 1 else (-math.cos(phi), -math.sin(phi))
    body = Body(
        0.0, sample.get("m_plus_ms", 0.0), sample.get("m_plus_mh", 0.0), max(pull[1], 0.0), max(-pull[1], 0.0), pull[0]
    )
    return Tow(cable, body, 1.0, 1.0, quadrant)


def omway() -> tuple[Tow, float, Any]:
    s = SAMPLES["OMWAY"]
    tow = sample_tow(s, 1, s["D_DS_over_T0"], s["w_DS_over_T0"], s["mu_c2_over_T0"], s["lam"])
    return tow, s["omega_DS_over_c"], np.array(s["printed_rows_J2_to_20_CXM_DCX_CYM_DCY"])


def frozen_angles(tow: Tow, omega: float, excitation: Excitation, points: int = POINTS) -> tuple[Any, Any]:
    """(phi1, phi0) at the points by frozen coefficients and superposition of two modes, Quadrant I."""
    matrices, angles = frozen(tow, omega, points)
    rows, _ = body_rows(tow, omega, excitation)
    start = np.zeros((4, 2), dtype=complex)
    start[2, 0] = start[3, 1] = 1.0
    start[:2] = np.linalg.solve(rows[:, :2], -rows[:, 2:])
    modes = [start]
    for a in matrices:
        modes.append(merson(a.__matmul__, modes[-1], tow.cable.length / (points - 1)))
    wanted = towpoint_values(omega, float(angles[-1]), excitation)
    weights = np.linalg.solve(modes[-1][2:], wanted)
    return np.array([m[0] @ weights for m in modes]), angles


def test_omway_table_by_the_printed_scheme() -> None:
    tow, omega, printed = omway()
    turn, phi = frozen_angles(tow, omega, Excitation(heave=1.0))
    for j, (cxm, dcx, cym, dcy) in enumerate(printed):
        x, y = -turn[j] * math.sin(phi[j]), turn[j] * math.cos(phi[j])
        # printed to 1e-6; phases carry the amplitude's rounding over amplitudes of 0.012 and more, and the fit's 1e-6
        assert abs(abs(x) - cxm) < 1e-6 and abs(abs(y) - cym) < 1e-6
        assert abs(cmath.phase(x * cmath.exp(-1j * dcx))) < 2e-6
        assert abs(cmath.phase(y * cmath.exp(-1j * dcy))) < 2e-6


def test_omway_columns_are_increments_not_sums() -> None:
    _, _, printed = omway()
    # -sin and cos of one real factor are in antiphase in every row, which sums over a turning cable cannot be
    gap = np.abs(np.abs(printed[:, 1] - printed[:, 3]) - math.pi)
    assert gap.max() < 2e-6


def test_omway_true_configuration_is_another() -> None:
    tow, omega, printed = omway()
    found = respond(tow, omega, Excitation(heave=1.0))
    x1, y1 = (abs(v[-1, -1]) for v in found.configuration)
    # to the four digits that were computed independently at 40 decimals
    assert x1 == pytest.approx(0.1708, abs=6e-5) and y1 == pytest.approx(0.5981, abs=6e-5)
    assert printed[-1][0] == pytest.approx(0.107, abs=5e-4) and printed[-1][2] == pytest.approx(0.218, abs=5e-4)


def test_frozen_coefficients_are_of_first_order() -> None:
    tow, omega, _ = omway()
    exact = respond(tow, omega, Excitation(heave=1.0)).angle[-1, -1]
    errors = []
    for points in (POINTS, 153, 305):
        turn, _ = frozen_angles(tow, omega, Excitation(heave=1.0), points)
        errors.append(abs(turn[-1] - exact) / abs(exact))
    # 1 to 4 % in the sample itself
    assert 0.005 < errors[0] < 0.06
    # halving the segment halves the error: order 1 within the next order's share
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.1)


def test_omflo_table_by_the_printed_scheme() -> None:
    s = SAMPLES["OMFLO"]
    drag = s["D_DS_over_T0"]
    weight = drag / s["D_over_w"]
    tow = sample_tow(s, 2, drag, weight, weight * s["mu_over_w"], s["lam"])
    matrices, phi = frozen(tow, s["omega_DS_over_c"])
    # upwards from the towpoint, where both velocities vanish; modes: unit angle and unit tension there
    modes = [np.eye(4, 2, dtype=complex)]
    for a in reversed(matrices):
        modes.append(merson(a.__matmul__, modes[-1], 1.0))
    modes.reverse()
    magnitude, phase = np.array(s["CYM"]), s["DCY"]
    rows = np.array([m[0] * math.cos(p) for m, p in zip(modes, phi)])
    best = math.inf
    for shift in (0, 1):
        basis = rows[shift : shift + 19]
        known = np.array([p is not None for p in phase])
        values = magnitude * np.exp(1j * np.array([p if p is not None else 0.0 for p in phase]))
        for sign in (1.0, -1.0):
            weights = np.linalg.lstsq(basis[known], sign * values[known], rcond=None)[0]
            best = min(best, float(np.abs(np.abs(basis @ weights) - magnitude).max()))
    # printed to 1e-6 and smaller than 1e-4 over most of the table
    assert best < 2e-6
