"""Critical speeds, double roots and tracking, at the points where they are hard."""

import numpy as np
import pytest

from towage.models.slender import critical as critical
from towage.models.slender.coefficients import Body
from towage.models.slender.modes import growth_rate, matrices, roots, spectrum
from towage.models.slender.tracking import track

BODY = Body()
YAW = (3.379995896844, 7.935305114211, 11.06778101284)
DOUBLE = {  # spec section 5: (u, s), ten digits
    0.5: [(3.807744529, -2.130186), (7.168045792, -9.470902), (11.384151833, -7.110895)],
    1.0: [(3.788242444, -1.848894), (6.569859332, -8.067828), (11.396186183, -6.777621)],
    5.0: [(7.807558228, -1.311398)],
    10.0: [(7.579362233, -3.837256), (7.629627491, -1.668132), (7.764319747, -9.848891), (7.864557951, -0.659645)],
}


@pytest.mark.parametrize("rope", [0.1, 1.0, 10.0])
def test_yaw_speeds_do_not_depend_on_the_rope(rope: float) -> None:
    """The thesis prints 3.328 to 3.381 for four ropes: the error of its interpolation."""
    assert critical.yaw(Body(rope_length=rope), 12.0) == pytest.approx(YAW, rel=1e-11)


def test_published_table_1() -> None:
    """Exact critical speeds for the thesis' ropes 1 and 5, in its order first (low, high), second, third, fourth. The
    printed numbers lie within 2 % (second mode, Lam = 1: linear interpolation over a step of 1 in u)."""
    printed = {1.0: (4.150, 6.806, 4.592, 7.102, None), 5.0: (4.276, 6.206, 5.562, 7.799, 10.3)}
    exact = {
        1.0: (4.155665957281, 6.840557194241, 4.676593643981, 7.115966593942, 9.620674323512),
        5.0: (4.274113630474, 6.212282292893, 5.569001036909, 7.822373838556, 10.32219395522),
    }
    for rope, wanted in exact.items():
        points = critical.oscillatory(Body(rope_length=rope), 10.5)
        found = [p.u for p in points if not 20.11 < p.omega < 20.13]  # second mode again, beyond the table
        assert found == pytest.approx(wanted, rel=1e-11)
        for u, thesis in zip(found, printed[rope]):
            assert thesis is None or u == pytest.approx(thesis, rel=0.02)


def test_growth_changes_sign_at_every_critical_speed() -> None:
    """One part in 1e7 below and above: the imaginary part of the exponents seen by the eigensolver has changed sign."""
    system = matrices(BODY)
    for point in critical.oscillatory(BODY, 12.0):
        signs = []
        for u in (point.u * (1.0 - 1e-7), point.u * (1.0 + 1e-7)):
            s = roots(system, u)
            signs.append(float(s[np.argmin(np.abs(s - 1j * point.omega))].real))
        assert signs[0] * signs[1] < 0.0
        assert (signs[1] > 0.0) == point.destabilising
    for u in critical.yaw(BODY, 12.0):
        smallest = [spectrum(system, x, 1)[0] for x in (u * (1.0 - 1e-7), u * (1.0 + 1e-7))]
        assert all(s.imag == 0.0 and abs(s) < 1e-5 for s in smallest)
        assert smallest[0].real * smallest[1].real < 0.0


@pytest.mark.parametrize("rope", [0.5, 1.0, 5.0, 10.0])
def test_double_roots(rope: float) -> None:
    found = critical.double_roots(Body(rope_length=rope), 12.0)
    assert [d.u for d in found] == pytest.approx([u for u, _ in DOUBLE[rope]], abs=1e-9)
    assert [d.s for d in found] == pytest.approx([s for _, s in DOUBLE[rope]], abs=1e-6)


@pytest.mark.parametrize("start", [(3.78, -1.8), (3.80, -1.9), (6.56, -8.0)])
def test_newton_is_regular_at_a_double_root(start: tuple[float, float]) -> None:
    """Each exponent is known to the square root of rounding there; u and the mean of the pair to 1e-10."""
    found = critical.double_root_near(matrices(BODY), *start)
    u, s = min(DOUBLE[1.0], key=lambda d: abs(d[0] - start[0]))
    assert (found.u, found.s) == (pytest.approx(u, abs=1e-9), pytest.approx(s, abs=1e-6))
    pair = sorted(roots(matrices(BODY), found.u), key=lambda x: abs(x - found.s))[:2]
    assert (pair[0] + pair[1]).real / 2.0 == pytest.approx(found.s, abs=1e-9)
    assert abs(pair[0] - found.s) < 1e-4


def test_a_start_without_a_critical_point_is_refused() -> None:
    with pytest.raises(ArithmeticError, match="Newton found no"):
        critical.oscillatory_near(matrices(BODY), 2.0, 40.0, iterations=2)
    with pytest.raises(ArithmeticError, match="Newton found no"):
        critical.double_root_near(matrices(BODY), 2.0, -30.0, iterations=2)


def test_statements_of_the_thesis_on_blunt_tails() -> None:
    """Stable at every speed for al <= .5; al = .1 and .02 lose it only at 13.66 and 13.55, beyond its range."""
    assert all(growth_rate(Body(tail_cut=0.5), u) < 0.0 for u in np.linspace(0.2, 12.0, 40))
    for cut, limit in ((0.1, 13.66), (0.02, 13.55)):
        first = min(c.u for c in critical.oscillatory(Body(tail_cut=cut), 14.0) if c.destabilising)
        assert first == pytest.approx(limit, abs=6e-3)


def test_old_theory_window() -> None:
    """Figure 6a, al = .7, f1 = .62, f2 = .43: second mode unstable from 8.55 to 10.96."""
    old = Body(tail_cut=0.7, theory="modified_old", nose_factor=0.62, tail_factor=0.43)
    second = sorted(c.u for c in critical.oscillatory(old, 12.0) if 20.0 < c.omega < 22.0)
    assert second == pytest.approx([8.549, 10.957], abs=1e-3)


@pytest.mark.parametrize("step", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("rope", [0.5, 1.0, 10.0])
def test_no_mode_is_lost_in_coarse_steps(rope: float, step: float) -> None:
    """Against steps of 0.02, which no method loses. Four of the six roads meet a double root on the way."""
    system = matrices(Body(rope_length=rope))
    fine = track(system, np.linspace(0.3, 6.4, 306), within=130.0)
    coarse = track(system, np.append(np.arange(0.3, 6.39, step), 6.4), within=130.0)
    assert len(fine) == 5
    for a, b in zip(coarse, fine):
        assert a.roots[-1] == pytest.approx(b.roots[-1], rel=1e-8)


def test_pairs_are_handed_over_on_the_real_axis() -> None:
    """Through the double root at 3.78824 the zeroth mode's sum and product stay smooth while its exponents do not."""
    u = np.linspace(3.7, 3.9, 201)
    zeroth = track(matrices(BODY), u, within=20.0)[0]
    assert not zeroth.oscillates[0]
    assert zeroth.oscillates[-1]
    change = int(np.argmax(zeroth.oscillates))
    assert u[change] == pytest.approx(3.788242, abs=1e-3)
    for smooth in (zeroth.total, zeroth.product):
        second = np.abs(np.diff(smooth, 2))
        assert np.max(second) < 3.0 * np.median(second) + 1e-9  # no kink
    larger = zeroth.roots[:, 0]
    assert np.max(np.abs(np.diff(larger))) > 5.0 * np.median(np.abs(np.diff(larger)))  # the root itself has one


def test_tracking_refuses_what_it_cannot_follow() -> None:
    with pytest.raises(ValueError, match="finite"):
        track(matrices(BODY), np.array([1.0, np.nan]))
    with pytest.raises(ValueError, match="at least one"):
        track(matrices(BODY), np.array([]))
