"""The two sample tables printed with OMWAY and OMFLO, reproduced by the printed program's own scheme."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from towage.models.cable.steady.perturbation import Excitation
from towage.models.cable.steady.response import respond
from towage.reproduce.cable_scheme import POINTS, frozen_angles, omflo, omway


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
    printed, found = omflo()
    # printed to 1e-6 and smaller than 1e-4 over most of the table
    assert float(np.abs(np.abs(found) - np.abs(printed)).max()) < 2e-6
