"""The families of hard cases of the spec (section 5), beyond the values in the reference files."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from towage.models.heave import linear, orbits, sdof
from towage.models.heave.system import Simulation
from towage.verify.cradle import dimensionless_system as system

GRAZING = 2.2664909717833694  # w at which the line of B = 0.3, r = 1 just stays taut (register row 21)


def test_undamped_resonance() -> None:
    """|error| < 1e-12 of an amplitude of 50 after 16 periods: 16 times the local tolerance 1e-13."""
    y, v = Simulation(system(0.0, 1.0, None)).advance(100.0)
    assert (y, v) == pytest.approx(linear.resonance(100.0), abs=5e-11)


@pytest.mark.parametrize("drag", [1e-6, 1e-4])
def test_small_drag_is_a_perturbation(drag: float) -> None:
    """From rest at resonance the energy lost to drag is of first order in B."""
    exact, _ = linear.resonance(50.0)
    small = Simulation(system(drag, 1.0, None)).advance(50.0)[0] - exact
    smaller = Simulation(system(0.1 * drag, 1.0, None)).advance(50.0)[0] - exact
    assert small == pytest.approx(10.0 * smaller, rel=30.0 * 50.0 * drag)  # next order: B times the path


def test_huge_drag_is_quasi_static() -> None:
    """B -> infinity: B v^2 balances the stretch. The lag of the velocity stays below the orbit's scale B^-1/2."""
    for drag in (1e2, 1e3):
        orbit = orbits.steady(system(drag, 1.0, None))
        assert orbit.heave_max < 1.4 / math.sqrt(drag)
        assert 1.0 - orbit.tension_max < 1.4 / math.sqrt(drag)


def test_stiff_line_follows_the_ship() -> None:
    """r << 1: y = sin(r tau)/(1 - r^2) up to the drag B r^2."""
    orbit = orbits.steady(system(0.3, 0.01, None))
    assert orbit.heave_max == pytest.approx(1.0 / (1.0 - 1e-4), abs=0.3 * 1e-4)


def test_grazing_slack_vanishes_with_its_depth() -> None:
    """The duration of slack goes with the square root of its depth, and a graze is not counted."""
    fractions = []
    for eps in (1e-4, 1e-6):
        orbit = orbits.steady(system(0.3, 1.0, GRAZING * (1.0 - eps)))
        assert orbit.slack_events == 1
        fractions.append(orbit.slack_fraction)
    assert fractions[0] / fractions[1] == pytest.approx(10.0, rel=2e-3)  # next order: the square root of 1e-4 / 5
    for w in (GRAZING, GRAZING * (1.0 + 1e-9)):
        orbit = orbits.steady(system(0.3, 1.0, w))
        assert orbit.slack_events == 0 and orbit.slack_fraction == 0.0


def test_taut_orbit_does_not_know_of_slack() -> None:
    taut, free = orbits.steady(system(0.3, 1.0, 3.0)), orbits.steady(system(0.3, 1.0, None))
    assert taut.state == pytest.approx(free.state, abs=1e-12)
    assert taut.tension_max - 3.0 == pytest.approx(free.tension_max, abs=1e-12)


@pytest.mark.parametrize(("drag", "r", "w"), [(0.3, 1.2, 0.2), (0.1, 1.5, 0.2), (0.03, 0.7, 0.2)])
def test_chaotic_motion_pointwise(drag: float, r: float, w: float) -> None:
    """For 8 periods two tolerances agree to what the Lyapunov exponent (up to 0.6 a period) leaves."""
    case = system(drag, r, w)
    fine = Simulation(case).advance(8.0 * case.period)
    coarse = Simulation(case, rtol=1e-10).advance(8.0 * case.period)
    assert coarse == pytest.approx(fine, abs=1e-10 * 100.0 * math.exp(8 * 0.6))
    assert fine != coarse


@pytest.mark.slow
@pytest.mark.parametrize(("drag", "r", "exponent"), [(0.3, 1.2, 0.381), (0.1, 1.5, 0.433), (0.03, 0.7, 0.587)])
def test_lyapunov_exponents(drag: float, r: float, exponent: float) -> None:
    case = system(drag, r, 0.2)
    x = Simulation(case, rtol=1e-10).advance(100.0 * case.period)
    assert orbits.lyapunov(case, x, 400) == pytest.approx(exponent, abs=0.06)  # 400 periods, deviation about 1 each


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.05, 2.0), st.floats(0.3, 3.0))
@example(0.0, 2.2e-311, 1.0, 1.0)
@example(-1e-8, 0.0, 1.0, 1.0)
def test_energy_balance_with_slack(y0: float, v0: float, w: float, r: float) -> None:
    """Undamped on a ship at rest, spring and weight conserve v^2/2 + V(y), V the potential of pull and weight."""

    def energy(y: float, v: float) -> float:
        stretch = max(w - y, 0.0)
        return 0.5 * v * v + 0.5 * stretch * stretch + w * y

    run = Simulation(system(0.0, r, w, amplitude=0.0), 0.0, (y0, v0))
    y, v = run.advance(20.0)
    size = energy(abs(y0), v0) + w * w + 1.0
    assert energy(y, v) == pytest.approx(energy(y0, v0), abs=1e-11 * size)  # 1e-13 a step, about a hundred steps


@pytest.mark.parametrize(
    ("y0", "v0", "w"),
    [
        (0.0, 0.0, 1.0), (0.0, 2.2e-311, 1.0), (5e-324, 0.0, None), (0.0, -1e-160, None), (-1e-8, 0.0, 1.0),
        (1e-12, 1e-13, 0.5), (0.0, 1e-8, 1e3), (1e-17, 0.0, 1.0), (2e-16, -1e-16, 2.0),
    ],
)  # fmt: skip
@pytest.mark.parametrize("two_way", [False, True])
def test_motion_near_rest(y0: float, v0: float, w: float | None, two_way: bool) -> None:
    """y0 cos t + v0 sin t, to what the stretch w - y can tell, in as many steps as a large motion takes."""
    hull = (1e30, 0.0, 1e30)  # which the line does not move
    run = Simulation(
        system(0.0, 1.0, w, amplitude=0.0, hull=hull, two_way=two_way), 0.0, (0.0, 0.0, y0, v0) if two_way else (y0, v0)
    )
    steps: list[float] = []
    accepted = run._accepted
    run._accepted = lambda *step: (steps.append(step[3]), accepted(*step))[1]  # type: ignore[method-assign]
    *_, y, v = run.advance(20.0)
    assert len(steps) < 200
    # a force within rounding of the stretch, at its own frequency: half of it times the time, and 1e-13 a step
    tolerance = 10.0 * 2.0**-53 * (w or 0.0) + 1e-11 * (abs(y0) + abs(v0)) + 1e-300  # 5e-324 is rest
    assert y == pytest.approx(y0 * math.cos(20.0) + v0 * math.sin(20.0), rel=0.0, abs=tolerance)
    assert v == pytest.approx(v0 * math.cos(20.0) - y0 * math.sin(20.0), rel=0.0, abs=tolerance)


def test_time_of_slack_in_closed_form() -> None:
    """Thrown up at the point of slack with speed u the body falls freely: 2 u/w without drag, then it is caught."""
    w, u = 0.5, 0.8
    run = Simulation(system(0.0, 1.0, w, amplitude=0.0), 0.0, (w, u))
    run.advance(2.0 * u / w + 1.0)
    assert run.slack_time == pytest.approx(2.0 * u / w, abs=1e-11)
    assert run.heave_max == pytest.approx(w + 0.5 * u * u / w, abs=1e-12)
    assert run.tension_max > w


def test_extremes_do_not_depend_on_where_a_run_is_cut() -> None:
    whole, parts = (Simulation(system(0.3, 1.0, 1.6), 0.0, (-2.0, 0.0)) for _ in range(2))
    whole.advance(31.0)
    for k in range(1, 312):
        parts.advance(0.1 * k if k < 311 else 31.0)
    assert parts.t == 31.0
    for name in ("heave_max", "heave_min", "tension_max", "slack_time"):
        assert getattr(parts, name) == pytest.approx(getattr(whole, name), abs=1e-11)
    assert parts.slack_events == whole.slack_events


@pytest.mark.parametrize("mu", [0.0578, 1.0, 10.0])
@pytest.mark.parametrize("w", [0.05, 0.5, None])
def test_light_and_heavy_bodies_both_ways(mu: float, w: float | None) -> None:
    """Two tolerances agree, with many or no switches."""
    hull = (1.0 / mu, 0.1 * math.sqrt(2.25) / mu, 2.25 / mu)
    case = system(0.3, 1.0, w, amplitude=0.0, hull=hull, two_way=True, force=(1.0 / mu, 1.1))
    fine, coarse = Simulation(case), Simulation(case, rtol=1e-10)
    a, b = fine.advance(40.0), coarse.advance(40.0)
    # mu = 10 with slack separates nearby motions
    assert b == pytest.approx(a, abs=1e-10 * 1e4 * max(map(abs, a)))
    assert fine.taut_switches == coarse.taut_switches
    assert (fine.taut_switches > 0) == (w == 0.05 or (w == 0.5 and mu < 10.0))


def test_free_pair_is_the_sum_of_its_modes() -> None:
    """mu = 1, Omega = 2.039: x(0) = 1, all else at rest."""
    k1 = 2.039**2
    upper, lower = sdof.modes(1.0, k1, 1.0, 1.0)
    share = lower.shape / (lower.shape - upper.shape)  # of the upper mode, so that y(0) = 0
    case = system(0.0, 1.0, None, amplitude=0.0, hull=(1.0, 0.0, k1), two_way=True)
    x, _, y, _ = Simulation(case, 0.0, (1.0, 0.0, 0.0, 0.0)).advance(50.0)
    c1, c2 = share * math.cos(50.0 * upper.omega), (1.0 - share) * math.cos(50.0 * lower.omega)
    assert x == pytest.approx(c1 + c2, abs=1e-11)
    assert y == pytest.approx(upper.shape * c1 + lower.shape * c2, abs=1e-11)
