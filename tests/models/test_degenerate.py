"""Scales that are zero, or nearly: no drag, no motion, no damping, no weight, equal frequencies."""

import math
from dataclasses import replace

import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance
from towage.models.heave import cradle, linear, orbits, sdof, ship, spring_line
from towage.models.heave.sdof import Pair
from towage.models.numeric.ops import FLOATS
from towage.models.numeric.ramp import ramp
from towage.models.sea import heave_response, waves
from towage.verify.cradle import dimensionless_system

TINY = (0.0, 5e-324, 2.2e-311, 1e-160)


def test_amplitude_at_resonance_without_drag() -> None:
    """Infinite, the limit of sqrt(3 pi M X0/(8 b)) at a lag of a quarter; without motion of the upper end there is none."""
    assert linear.lorentz(2.0, 0.0, 8.0, 1.0, 2.0) == (math.inf, 0.5 * math.pi)
    assert linear.lorentz(2.0, 0.0, 8.0, 0.0, 2.0) == (0.0, 0.5 * math.pi)
    size, lag = linear.lorentz(2.0, 1e-12, 8.0, 1.0, 2.0)
    assert size == pytest.approx(math.sqrt(3.0 * math.pi * 2.0 / 8e-12), rel=1e-12) and lag == 0.5 * math.pi


def test_peaks_without_drag_or_motion() -> None:
    assert linear.peak(2.0, 0.0, 8.0) == (2.0, math.inf)
    assert linear.lorentz_peak(2.0, 0.0, 8.0, 1.0) == (2.0, math.inf)
    assert linear.lorentz_peak(2.0, 0.3, 8.0, 0.0) == (2.0, 0.0)
    for drag in (1e-90, 1e-101, 1e-250):  # where c^2 can be told from zero, and where not
        omega, size = linear.lorentz_peak(2.0, drag, 8.0, 1.0)
        assert omega == 2.0
        assert size == pytest.approx(math.sqrt(3.0 * math.pi * 2.0 / 8.0) / math.sqrt(drag), rel=1e-12)


def test_ship_without_damping_at_its_resonance() -> None:
    """D1 = 0: no force is left that could move the pair, however far the ship alone would go."""
    response = sdof.two_way(Pair.dimensionless(1.0, 1.0, 0.0, 1.0), 1.0)
    assert (response.ship, response.cradle_two_way) == (0.0, 0.0)
    assert abs(response.cradle_one_way) > 1.0
    assert response.eps == response.bound == response.amplitude_error == math.inf
    near = sdof.two_way(Pair.dimensionless(1.0, 1.0, 0.0, 1.0), 1.0 - 1e-9)
    assert abs(near.cradle_two_way) < 1e-8 and near.amplitude_error > 1e8
    assert sdof.worst(Pair.dimensionless(1.0, 1.0, 0.0, 1.0), 0.5, 1.5, 10)[1:] == (math.inf, math.inf)


@pytest.mark.parametrize("zeta1", [1e-100, 1.6e-192, 1e-300])
def test_ship_with_next_to_no_damping_at_its_resonance(zeta1: float) -> None:
    """Y = K2 D1 X0/((D1 + K2)(Z + i h A) - K2^2) to first order in D1 = 2 i zeta1, where Z = 0: -2 i zeta1."""
    response = sdof.two_way(Pair.dimensionless(1.0, 1.0, zeta1, 1.0), 1.0)
    assert response.cradle_two_way == pytest.approx(-2j * zeta1, rel=1e-12)


@pytest.mark.parametrize("amplitude", [1e-100, 1.6e-192, 1e-300])
def test_small_motion_at_the_resonance_of_the_pair(amplitude: float) -> None:
    """(D1 + K2) Z = K2^2 with D1 = 2, K2 = 2, Z = 1: A^2 = K2 D1 X0/(h (D1 + K2)) = X0/h, h = 8 b omega^2/(3 pi)."""
    response = sdof.two_way(Pair(0.25, 0.0, 3.0, 0.25, 2.0, 0.7, amplitude), 2.0)
    expected = math.sqrt(amplitude / (8.0 * 0.7 * 4.0 / (3.0 * math.pi)))
    assert abs(response.cradle_two_way) == pytest.approx(expected, rel=1e-12)


def test_pair_without_drag() -> None:
    """The linear pair: Y = K2 D1 X0/((D1 + K2) Z - K2^2); Y1way is infinite at the cradle's resonance."""
    pair = Pair.dimensionless(0.5, 0.25, 0.0, 0.0)
    r = 1.3
    d1, z = pair.ship_stiffness - pair.ship_mass * r * r, 1.0 - r * r
    response = sdof.two_way(pair, r)
    assert response.cradle_two_way == pytest.approx(d1 / ((d1 + 1.0) * z - 1.0), rel=1e-13)
    assert response.cradle_one_way == pytest.approx(1.0 / z, rel=1e-13)
    assert response.amplitude_error == pytest.approx(abs(abs(((d1 + 1.0) * z - 1.0) / (d1 * z)) - 1.0), rel=1e-12)
    alone = sdof.two_way(pair, 1.0)
    assert abs(alone.cradle_one_way) == alone.amplitude_error == alone.eps == math.inf
    assert abs(alone.cradle_two_way) == pytest.approx(abs(pair.ship_stiffness - pair.ship_mass), rel=1e-13)


def test_resonance_of_the_pair_without_drag_and_damping() -> None:
    """K1 = 3, K2 = 2, m1 omega^2 = m2 omega^2 = 1: (D1 + K2) Z = (2 + 2) 1 = K2^2 to the last bit."""
    response = sdof.two_way(Pair(0.25, 0.0, 3.0, 0.25, 2.0, 0.0, 1.0), 2.0)
    assert abs(response.cradle_two_way) == abs(response.ship) == math.inf
    assert response.amplitude_error == 1.0


def test_motion_that_vanishes() -> None:
    """X0 = 0: nothing moves, and eps is that of a pair without drag."""
    still = sdof.two_way(Pair(20.0, 3.0, 50.0, 1.0, 1.0, 0.3, 0.0), 1.4)
    assert still.ship == still.cradle_two_way == still.cradle_one_way == 0.0
    assert still.amplitude_error == 0.0
    small = sdof.two_way(Pair(20.0, 3.0, 50.0, 1.0, 1.0, 0.3, 1e-12), 1.4)
    assert still.eps == pytest.approx(small.eps, rel=1e-10)
    assert sdof.two_way(Pair(20.0, 3.0, 50.0, 1.0, 1.0, 0.3, 0.0), 1.0).eps == math.inf


def test_ship_without_stiffness() -> None:
    free = Pair(20.0, 3.0, 0.0, 1.0, 1.0, 0.3, 1.0)
    assert free.ship_damping_ratio == math.inf
    assert replace(free, ship_damping=0.0).ship_damping_ratio == 0.0
    assert sdof.closed_form_of(free) == pytest.approx(0.05 * math.sqrt(1.0 + 3.0 * math.pi / 2.4), rel=1e-14)
    assert sdof.closed_form_of(replace(free, ship_damping=0.0)) == math.inf
    assert math.isfinite(sdof.worst(free, points=20)[1])
    upper = sdof.modes(20.0, 0.0, 1.0, 1.0)[0].omega
    assert sdof.frequency_shift(20.0, 0.0, 1.0, 1.0) == pytest.approx(upper - 1.0, rel=1e-14)


def test_body_too_light_to_be_seen() -> None:
    """A mode then has the frequency of the body alone to the last bit."""
    for shape, transmissibility in sdof.eigenvector_test(1e20, 1e20, 1.0, 1.0):
        assert not math.isnan(shape) and not math.isnan(transmissibility)


def test_orbits_of_what_does_not_move() -> None:
    for w in (None, 0.5):
        for drag in (0.0, 0.3):
            orbit = orbits.steady(dimensionless_system(drag, 1.0, w, amplitude=0.0))
            assert orbit.state == (0.0, 0.0) and orbit.heave_max == orbit.amplitude == orbit.residual == 0.0
    joined = dimensionless_system(0.3, 1.0, None, amplitude=0.0, hull=(1.0, 0.1, 1.0), two_way=True, force=(1.0, 0.0))
    assert orbits.steady(joined).state == (0.0, 0.0, 0.0, 0.0)  # a force of no frequency is none


def test_orbit_of_a_motion_at_the_smallest_numbers() -> None:
    """Linear: drag vanishes, y/X0 = 1/(1 - r^2)."""
    orbit = orbits.steady(dimensionless_system(0.3, 0.7, None, amplitude=1e-12))
    assert orbit.heave_max == pytest.approx(1e-12 / 0.51, rel=1e-9)
    assert orbits.steady(dimensionless_system(0.0, 2.0, None)).heave_max == pytest.approx(1.0 / 3.0, rel=1e-12)


def test_no_steady_motion_at_undamped_resonance() -> None:
    with pytest.raises(orbits.OrbitError, match="without drag there is no steady motion at a resonance"):
        orbits.steady(dimensionless_system(0.0, 1.0, None))


@pytest.mark.parametrize("weight", TINY)
def test_margins_of_a_line_that_carries_next_to_nothing(weight: float) -> None:
    p = spring_line.Parameters(1e5, 0.0, 30.0, 1e6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, weight)
    slack = spring_line.margins(0.0, -2.0, 1e5, weight, p, FLOATS)
    taut = spring_line.margins(2e5, 2.0, 1e5, weight, p, FLOATS)
    assert slack[0] < 0.0 and taut[0] == 1.0 and taut[1] == pytest.approx(0.8)
    assert all(map(math.isfinite, (*slack, *taut)))


@pytest.mark.parametrize("speed", TINY)
def test_line_whose_waves_are_not_known(speed: float) -> None:
    """A speed of waves that is next to nothing gives no mass, or one that no line bears, but always a number."""
    p = spring_line.Parameters(1e5, 0.0, 30.0, 0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0, 1e5)
    assert spring_line.wire_mass(p, FLOATS) >= 0.0
    assert spring_line.margins(1e5, 1.0, 1e5, 1e5, p, FLOATS)[1] == 1.0


def test_springs_of_no_stiffness() -> None:
    assert spring_line.series(0.0, 2.0) == 0.0 and spring_line.series(2.0, 2.0) == 1.0
    for length in TINY:
        p = spring_line.Parameters(0.0, 1e6, length, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e5)
        assert math.isfinite(spring_line.stiffness(p, FLOATS))
        assert not spring_line.requirements(p, FLOATS)[0][0] > 0.0
        assert all(value > 0.0 for value, _ in spring_line.requirements(replace(p, length=10.0), FLOATS))


@pytest.mark.parametrize("weight", TINY)
def test_margin_of_a_weightless_body(weight: float) -> None:
    p = cradle.Parameters(
        1e3, 0.0, weight, 10.0, 1.2, 1025.0, 3.0, 1e-6, 1e6, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    )  # fmt: skip
    assert math.isfinite(cradle.margin_drag_reynolds(1.0, 0.0, p, FLOATS))


@pytest.mark.parametrize("time", TINY)
def test_ramp_that_takes_no_time(time: float) -> None:
    assert ramp(0.0, time, FLOATS) == ramp(1.0, time, FLOATS) == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("amplitude", TINY)
def test_margin_of_a_ship_without_motion_of_its_own(amplitude: float) -> None:
    p = ship.Parameters(amplitude, 8.0, 0.0, 0.0, 1e6, 1e5, 1e6, 0.05)
    u, du = ship.Inputs(1e5), ship.Inputs(0.0)
    assert ship.outputs(0.0, ship.State(0.3, 0.1), ship.Modes(), u, du, p, FLOATS).margin_sdof == 1.0


def test_band_without_waves() -> None:
    for band in ((0.01, 0.1), (0.1, 0.21)):
        with pytest.raises(ValueError, match="carries no energy"):
            waves.gauss_rule(20, 3.3, band)


def test_heave_in_waves_of_no_frequency() -> None:
    hull = heave_response.Hull(120.0, 14.0, 5.0)
    for omega in (0.0, 5e-324, 1e-160):
        assert heave_response.heave_rao(omega, 7.0, -1.0, hull, FLOATS) == 1.0
    assert heave_response.heave_rao(1e-6, 7.0, -1.0, hull, FLOATS) == pytest.approx(1.0, abs=1e-11)  # k T = 5e-13


def test_heave_of_a_hull_without_breadth_is_finite_at_resonance() -> None:
    """2 k T = 1: eta = 1/0."""
    omega = 2.0
    hull = heave_response.Hull(10.0, 0.0, 0.5, 1.0)
    assert 1e40 < heave_response.heave_rao(omega, 0.0, 0.0, hull, FLOATS, gravity=4.0) < math.inf


def test_slender_body_that_hardly_moves() -> None:
    """As one at rest: the margin of stability is per length of path."""
    found = []
    for speed in (0.0, 5e-324, 1e-160):
        it = Instance(load("slender_body"))
        it.set_values([it.unit.index["tow_speed"]], [speed])
        it.enter_initialization()
        it.exit_initialization()
        found.append(it.get_values([it.unit.index["margin_stability"]])[0])
    assert found[0] == found[1] == found[2] == 1.0
