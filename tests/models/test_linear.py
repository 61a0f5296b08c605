"""The linear twin against independent solutions of the same equation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from towage.models.heave import linear
from towage.models.heave.system import Simulation
from towage.verify.cradle import dimensionless_system


def exponential(t: float, m: float, c: float, k: float, x0: float, omega: float, y0: float, v0: float) -> np.ndarray:
    """The state by a matrix exponential: (y, v, sin, cos) is a linear system."""
    a = np.zeros((4, 4))
    a[0, 1], a[1, 0], a[1, 1], a[1, 2] = 1.0, -k / m, -c / m, k * x0 / m
    a[2, 3], a[3, 2] = omega, -omega
    return np.asarray(expm(a * t) @ np.array([y0, v0, 0.0, 1.0]))


@pytest.mark.parametrize("zeta", [0.0, 1e-9, 0.02, 0.3, 0.999999999, 1.0, 1.000000001, 1.7, 50.0])
@pytest.mark.parametrize("r", [0.1, 0.9999999, 1.0, 1.0000001, 3.0])
def test_consistency_with_matrix_exponential(zeta: float, r: float) -> None:
    m, k, x0 = 2.0, 18.0, 0.7
    c, omega = 2.0 * zeta * math.sqrt(k * m), r * math.sqrt(k / m)
    for t in (0.0, 1e-3, 0.4, 5.0):
        y, v = linear.transient(t, m, c, k, x0, omega, 0.4, -1.1)
        expected = exponential(t, m, c, k, x0, omega, 0.4, -1.1)
        # expm itself loses digits with the norm of its argument (zeta = 50: norm 1500)
        tolerance = 1e-12 * (1.0 + 10.0 * zeta)
        assert y == pytest.approx(expected[0], abs=tolerance)
        assert v == pytest.approx(expected[1], abs=3.0 * tolerance)


def test_undamped_resonance() -> None:
    """Y = (sin tau - tau cos tau)/2 at tau = 100, the closed form of the hard case."""
    y, v = linear.transient(100.0, 1.0, 0.0, 1.0, 1.0, 1.0)
    assert (y, v) == pytest.approx(linear.resonance(100.0), rel=1e-13)
    assert (y, v) == pytest.approx((-43.36912643493907, -25.31828205548794), rel=1e-13)


def test_transient_approaches_the_steady_response() -> None:
    m, c, k, x0, omega = 3.0, 1.2, 12.0, 0.5, 1.7
    ratio, lag = linear.response(m, c, k, omega)
    t = 200.0  # exp(-c t/2 m) = 4e-18
    y, _ = linear.transient(t, m, c, k, x0, omega, 5.0, 5.0)
    assert y == pytest.approx(ratio * x0 * math.sin(omega * t - lag), abs=1e-13)


@pytest.mark.parametrize("zeta", [0.01, 0.25, 0.7])
def test_peak_is_the_largest_response(zeta: float) -> None:
    omega, ratio = linear.peak(1.0, 2.0 * zeta, 1.0)
    assert linear.response(1.0, 2.0 * zeta, 1.0, omega)[0] == pytest.approx(ratio, rel=1e-13)
    for near in (0.99 * omega, 1.01 * omega):
        assert linear.response(1.0, 2.0 * zeta, 1.0, near)[0] < ratio


def test_no_peak_beyond_its_damping() -> None:
    assert linear.peak(1.0, 2.0, 1.0) == (0.0, 1.0)


def test_linear_model_is_the_limit_of_the_cradle() -> None:
    """Without drag the nonlinear model is the linear one."""
    run = Simulation(dimensionless_system(0.0, 0.8, None), 0.0, (0.3, -0.2))
    assert run.advance(50.0) == pytest.approx(linear.transient(50.0, 1.0, 0.0, 1.0, 1.0, 0.8, 0.3, -0.2), abs=1e-11)


@given(st.floats(1e-6, 1e3), st.floats(1e-3, 10.0), st.floats(1e-3, 10.0), st.floats(1e-2, 1e3), st.floats(1e-3, 1e2))
def test_lorentz_solves_its_own_equation(drag: float, r: float, x0: float, m: float, k: float) -> None:
    omega = r * math.sqrt(k / m)
    size, lag = linear.lorentz(m, drag, k, x0, omega)
    c = linear.equivalent_damping(drag, omega, size)
    ratio, phase = linear.response(m, c, k, omega)
    assert size == pytest.approx(ratio * x0, rel=1e-10)  # at r = 1 the difference K - M omega^2 keeps 10 digits less
    assert lag == pytest.approx(phase, abs=1e-10)
    assert size <= linear.lorentz_peak(m, drag, k, x0)[1] * (1.0 + 1e-12)


def test_lorentz_peak_is_attained() -> None:
    """B = 0.3: r* = 0.880749, Y = 2.111562 (peak curve of the spec, section 2)."""
    omega, size = linear.lorentz_peak(1.0, 0.3, 1.0, 1.0)
    assert (omega, size) == pytest.approx((0.880749, 2.111562), abs=5e-7)
    assert linear.lorentz(1.0, 0.3, 1.0, 1.0, omega)[0] == pytest.approx(size, rel=1e-13)


def test_equivalent_damping_loses_the_same_energy() -> None:
    drag, omega, size = 0.7, 1.3, 0.4
    theta = np.linspace(0.0, 2.0 * math.pi, 20001)[:-1]
    v = size * omega * np.cos(theta)
    quadratic = np.mean(drag * np.abs(v) ** 3)
    viscous = np.mean(linear.equivalent_damping(drag, omega, size) * v**2)
    assert quadratic == pytest.approx(viscous, rel=1e-8)  # the kink leaves the trapezoidal rule 1/n^2
