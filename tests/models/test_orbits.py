"""Periodic orbits: tables of the spec (section 2), invariants, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from towage.models.heave import linear, orbits
from towage.models.heave.shooting import flow, shoot, tangent_flow
from towage.verify.cradle import dimensionless_system as system


@pytest.mark.parametrize(
    ("r", "drag", "ymax", "lag"),
    [
        (0.3, 0.05, 1.09943684, 0.264),
        (0.5, 5.0, 0.91460135, 51.264),
        (0.7, 0.2, 1.88683790, 17.131),
        (0.8, 1.0, 1.31430626, 64.456),
        (0.85, 0.1, 3.01931101, 33.878),
        (0.9, 0.05, 4.20799592, 37.436),
        (1.0, 0.3, 1.99113644, 91.239),
        (1.0, 5.0, 0.50352795, 92.659),
        (1.1, 0.5, 1.36908185, 107.995),
        (1.2, 0.05, 2.17357704, 163.223),
        (1.5, 1.0, 0.59102627, 138.584),
        (2.0, 0.3, 0.33114615, 173.588),
        (2.5, 5.0, 0.15084510, 143.405),
        (3.0, 0.1, 0.12499061, 179.316),
    ],
)
def test_amplitude_and_phase_of_the_table(r: float, drag: float, ymax: float, lag: float) -> None:
    orbit = orbits.steady(system(drag, r, None))
    assert orbit.heave_max == pytest.approx(ymax, abs=5.1e-9)  # the printed digits
    assert math.degrees(orbit.lag) == pytest.approx(lag, abs=5.1e-4)
    assert orbit.heave_min == pytest.approx(-orbit.heave_max, rel=1e-12)  # symmetric
    assert orbit.stable and orbit.residual < 1e-12


@pytest.mark.parametrize(("drag", "r", "ymax"), [(0.01, 0.995572, 10.88113229), (1.0, 0.655933, 1.38247808)])
def test_peak_of_the_table(drag: float, r: float, ymax: float) -> None:
    omega, orbit = orbits.peak(system(drag, 1.0, None), 0.6 * r, min(1.3 * r, 1.1), points=9)
    assert omega == pytest.approx(r, abs=5.1e-7)
    assert orbit.heave_max == pytest.approx(ymax, abs=5.1e-9)


def test_without_drag_the_orbit_is_the_linear_one() -> None:
    ratio, _ = linear.response(1.0, 0.0, 1.0, 0.6)
    orbit = orbits.steady(system(1e-13, 0.6, None))
    assert orbit.heave_max == pytest.approx(ratio, rel=1e-10)
    assert [abs(m) for m in orbit.multipliers] == pytest.approx([1.0, 1.0], abs=1e-6)  # the tangents' tolerance


def test_orbit_closes() -> None:
    case = system(0.3, 1.0, 1.6)
    orbit = orbits.steady(case)
    assert flow(case, orbit.state, case.period) == pytest.approx(orbit.state, abs=1e-12)
    assert abs(orbit.multipliers[0]) == pytest.approx(0.111, abs=5e-4)  # spec, thesis operating point


def test_tangents_agree_with_differences() -> None:
    """The derivative of the flow across slack and drag reversal against central differences."""
    case, x, h = system(0.3, 1.0, 1.6), (-1.5, 0.2), 1e-4
    _, slope = tangent_flow(case, x, case.period, np.eye(2))
    for j in range(2):
        ahead, behind = (flow(case, tuple(np.array(x) + s * h * np.eye(2)[j]), case.period) for s in (1.0, -1.0))
        # the second derivative jumps at events: differences are first order there
        assert np.subtract(ahead, behind) / (2.0 * h) == pytest.approx(slope[:, j], abs=2e-5)


def test_multipliers_obey_liouville() -> None:
    """Their product is exp(-integral of 2 B |v|) = exp(-4 B (ymax - ymin)) for one turn up and down a period."""
    orbit = orbits.steady(system(0.3, 1.0, None))
    product = (orbit.multipliers[0] * orbit.multipliers[1]).real
    assert product == pytest.approx(math.exp(-4.0 * 0.3 * (orbit.heave_max - orbit.heave_min)), rel=1e-6)


def test_scaling_to_si() -> None:
    """X0, M, K other than 1 give the same orbit in other units."""
    x0, m, k, b, r = 1.4, 2.5e4, 1.6e4, 3e3, 0.9
    omega0 = math.sqrt(k / m)
    here = orbits.steady(system(b, r * omega0, 1.6 * k * x0, amplitude=x0, mass=m, stiffness=k))
    same = orbits.steady(system(b * x0 / m, r, 1.6))
    assert here.heave_max / x0 == pytest.approx(same.heave_max, rel=1e-10)
    assert here.tension_max / (k * x0) == pytest.approx(same.tension_max, rel=1e-10)
    assert here.slack_fraction == pytest.approx(same.slack_fraction, rel=1e-9)


def test_both_attractors_of_one_sea() -> None:
    """B = 0.1, r = 0.5, w = 0.4: a taut orbit and a bouncing one with 3.12 times its tension."""
    found, others = orbits.attractors(system(0.1, 0.5, 0.4), [(0.0, 0.0), (-2.4, 0.0)])
    taut, bouncing = sorted(found, key=lambda orbit: orbit.tension_max)
    assert others == ()
    assert (taut.heave_max, taut.tension_max) == pytest.approx((1.333463370, 0.738680258), abs=6e-10)
    assert (bouncing.heave_max, bouncing.tension_max) == pytest.approx((4.410330057, 2.307335436), abs=6e-10)
    assert bouncing.slack_fraction == pytest.approx(0.712, abs=5e-4)


def test_period_two_is_not_taken_for_period_one() -> None:
    case = system(1.0, 1.2, 0.2)
    with pytest.raises(orbits.OrbitError, match=r"no orbit of one period after 20 periods.*`attractors`"):
        orbits.steady(case, limit=20)
    (orbit,), _ = orbits.attractors(case, [(0.0, 0.0)])
    assert orbit.period == 2 and len(orbit.section) == 2
    assert flow(case, orbit.section[0], case.period) == pytest.approx(orbit.section[1], abs=1e-11)


def test_multiple_of_a_period_is_reduced() -> None:
    case = system(0.3, 1.0, 1.6)
    assert orbits.orbit_at(case, orbits.steady(case).state, 3).period == 1


def test_chaos_is_reported_instead_of_an_orbit() -> None:
    """B = 0.3, r = 1.2, w = 0.2: Lyapunov exponent 0.381 per period."""
    found, others = orbits.attractors(system(0.3, 1.2, 0.2), [(0.0, 0.0)], limit=30)
    assert found == () and others[0].chaotic
    assert others[0].lyapunov == pytest.approx(0.381, abs=0.08)  # 150 periods of a quantity with deviation 1


def test_shooting_is_bounded() -> None:
    with pytest.raises(orbits.OrbitError, match="1 shooting steps over 1 periods leave"):
        shoot(system(0.3, 1.0, None), (50.0, 50.0), limit=1)


def test_curve_follows_its_branch() -> None:
    frequencies = [0.5, 0.75, 1.0, 1.25]
    curve = orbits.response_curve(system(0.3, 1.0, None), frequencies)
    alone = [orbits.steady(system(0.3, r, None)) for r in frequencies]
    assert [o.heave_max for o in curve] == pytest.approx([o.heave_max for o in alone], rel=1e-12)


def test_wave_force_sets_the_period() -> None:
    case = system(0.3, 1.0, None, amplitude=0.0, hull=(4.0, 0.4, 9.0), two_way=True, force=(2.0, 1.3))
    orbit = orbits.steady(orbits.at_frequency(case, 1.1))
    assert flow(replace(case, force_frequency=1.1), orbit.state, 2.0 * math.pi / 1.1) == pytest.approx(
        orbit.state, abs=1e-12
    )


@pytest.mark.parametrize("drag", [1e-6, 1e-2, 1.0, 1e3])
@pytest.mark.parametrize("r", [pytest.param(0.2, marks=pytest.mark.slow), 1.0 / 3.0, 1.0, 3.0, 10.0])
def test_whole_range_of_drag(drag: float, r: float) -> None:
    """An orbit for every drag; its amplitude within 6 % of Lorentz (register row 27: 2.55 % up to B = 10)."""
    orbit = orbits.steady(system(drag, r, None))
    assert orbit.stable and orbit.residual < 1e-11
    assert orbit.amplitude == pytest.approx(linear.lorentz(1.0, drag, 1.0, 1.0, r)[0], rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("drag", [1e-6, 1e3])
def test_slowest_motion(drag: float) -> None:
    orbit = orbits.steady(system(drag, 1e-3, None))
    assert orbit.heave_max == pytest.approx(1.0, abs=2e-6)  # r^2, and the lag of the drag B r^2
    assert orbit.residual < 1e-11
