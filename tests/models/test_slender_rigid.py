"""The rigid body: quartic against projection, published table, closed yaw criterion."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from towage.models.slender import rigid as slender_rigid
from towage.models.slender.coefficients import Body
from towage.models.slender.modes import matrices, roots

bodies = st.builds(
    Body,
    end_length=st.floats(0.0126, 0.3),
    tail_length=st.just(0.0) | st.floats(0.0126, 0.3),
    rope_length=st.floats(0.05, 20.0),
    tail_cut=st.floats(0.01, 1.0),
    friction=st.floats(0.3, 3.0),
    normal_drag=st.floats(0.0, 2.0),
    mass_ratio=st.floats(0.2, 0.8),
    theory=st.sampled_from(["present", "corrected"]),
)


@given(bodies)
def test_quartic_is_the_two_mode_projection(body: Body) -> None:
    """Program F against the weak form on {1, xi}; 1e-12 of the largest coefficient, all are of order 1 to 100."""
    closed, projected = slender_rigid.quartic(body), slender_rigid.projected_quartic(body)
    assert projected == pytest.approx(closed, abs=1e-12 * float(np.max(np.abs(closed))))


@given(bodies)
def test_yaw_criterion_is_the_sign_of_the_static_coefficient(body: Body) -> None:
    criterion, last = slender_rigid.yaw_criterion(body), slender_rigid.quartic(body)[4]
    assert abs(criterion) < 1e-9 or (criterion > 0.0) == (last > 0.0)


@given(bodies, st.floats(0.1, 10.0))
def test_exponents_scale_with_speed(body: Body, u: float) -> None:
    """s = S u/sqrt(beta), through the eigensolver of the flexible body with two functions. Simple roots to 1e-7."""
    found = roots(matrices(body, 2), u)
    for s in slender_rigid.exponents(body) * u / np.sqrt(body.mass_ratio):
        assert np.min(np.abs(found - s)) < 1e-7 * u * 10.0


def test_published_table_2_rigid() -> None:
    """Thesis table 2: all legible numbers, within rounding."""
    table = {
        0.5: (-0.412, 0.822, 1.899, 0.050),
        1.0: (-0.422, 0.641, 1.496, 0.145),
        5.0: (-0.455, 0.202, 1.089, 0.381),
        10.0: (-0.466, 0.102, 1.046, 0.437),
    }
    for rope, wanted in table.items():
        omega = -1j * slender_rigid.exponents(Body(rope_length=rope))
        still = np.sort(omega.imag[np.abs(omega.real) < 1e-12])
        swing = omega[omega.real > 1e-6][0]
        assert (*still, swing.real, swing.imag) == pytest.approx(wanted, abs=5.0e-4)  # half a unit of the last digit


def test_neutral_tail_cuts() -> None:
    """Thesis: stable for al < .5 (lam = .015) and .57 (lam = .05); spec: six digits, over slenderness three."""
    assert slender_rigid.neutral_tail_cut(Body()) == pytest.approx(0.521435, abs=5e-7)
    wide = Body(end_length=0.05)
    assert slender_rigid.neutral_tail_cut(wide) == pytest.approx(0.565733, abs=5e-7)
    for eps, cut in ((20.0, 0.413), (30.0, 0.496), (60.0, 0.682), (100.0, 0.869)):
        found = slender_rigid.neutral_tail_cut(replace(wide, slenderness=eps, friction=0.025 * eps))
        assert found == pytest.approx(cut, abs=5e-4)
    assert slender_rigid.neutral_tail_cut(Body(normal_drag=50.0)) is None


@given(st.floats(0.02, 1.0), st.floats(0.01, 100.0))
def test_yaw_does_not_depend_on_the_rope(cut: float, rope: float) -> None:
    here, there = (slender_rigid.yaw_criterion(Body(tail_cut=cut, rope_length=x)) for x in (1.0, rope))
    assert here == there


def test_short_rope_makes_the_rigid_body_oscillate() -> None:
    """Beyond the thesis' range: growth at Lam <= 0.3, lam = .015, full tail."""
    for rope, growth in ((0.3, 0.0067), (0.1, 0.089)):
        assert np.max(slender_rigid.exponents(Body(rope_length=rope)).real[2:]) == pytest.approx(growth, abs=5e-4)


def test_corrected_signs() -> None:
    omega = -1j * slender_rigid.exponents(Body(theory="corrected"))
    assert omega[omega.real > 1e-6][0] == pytest.approx(1.309 + 0.133j, abs=6e-4)  # three printed digits
