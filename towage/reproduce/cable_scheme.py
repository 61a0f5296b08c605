"""The scheme of the printed programs OMWAY and OMFLO, which reproduces their sample tables. These prove it wrong in two ways:

1. it freezes phi0, T0 and the loads at node J over a segment and takes phi0' from a forward difference: first order in
   the segment whatever the integrator does, 1 to 4 % in this very sample;
2. its columns CX, CY are the increments phi1(J) DS (-sin, cos) of single segments; the listing has no sum. Accumulated,
   as [56] and [58] say, the towpoint moves 0.598 of the heave's amplitude relative to the body instead of 0.218.
"""

from __future__ import annotations

import itertools
import json
import math
from importlib.resources import files
from typing import Any

import numpy as np

from towage.models.cable.case import Body, Cable, Tow
from towage.models.cable.loading import eames
from towage.models.cable.steady.perturbation import Excitation, body_rows, coefficients, towpoint_values
from towage.models.cable.steady.steady import slopes

POINTS = 20
SAMPLES: dict[str, Any] = json.loads((files("towage") / "reference" / "cable_samples.json").read_text("utf-8"))
"""The printed tables, with the dimensionless groups that were identified from them."""


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
    """A sample in units of the segment, the tow speed and the tension at the body."""
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
    """(The sample of OMWAY, its frequency, the printed rows)."""
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


def omflo() -> tuple[Any, Any]:
    """(Printed, computed) complex CY of OMFLO's rows: the two free amplitudes at the towpoint, which the report does not
    print, are those that fit best."""
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
    known = np.array([p is not None for p in phase])
    values = magnitude * np.exp(1j * np.array([p if p is not None else 0.0 for p in phase]))
    rows = np.array([m[0] * math.cos(p) for m, p in zip(modes, phi)])
    fits = []
    for basis in (rows[:19], rows[1:20]):
        weights = np.linalg.lstsq(basis[known], values[known], rcond=None)[0]
        fits.append(basis @ weights)
    return values, min(fits, key=lambda fit: np.abs(np.abs(fit) - magnitude).max())
