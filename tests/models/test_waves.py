"""Spectra, Gauss rules and phases against closed forms and published numbers."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from towage.models.sea import waves


def test_consistency_with_closed_moments() -> None:
    m0, m1, m2 = waves.closed_moments(6.0, 0.6)
    assert m0 == pytest.approx(2.25, rel=1e-15)
    # beyond x = h the density is 5 x^-5 but for 5/4 h^-4: the tails are 5/3 h^-3 of m1 and 5/2 h^-2 of m2
    high = 6.0
    near = [waves.integrate(lambda x, k=k: x**k * waves.shape(x), 0.2, high) for k in (1, 2)]
    exact = [m1 / 0.6 / 2.25, m2 / 0.36 / 2.25]
    tails = [5.0 / 3.0 * high**-3 - 1.25 * 5.0 / 7.0 * high**-7, 2.5 * high**-2 - 1.25 * 5.0 / 6.0 * high**-6]
    # next term of the tail's series: 0.5 (5/4)^2 5/11 h^-11
    assert [n + t for n, t in zip(near, tails)] == pytest.approx(exact, abs=2e-8)


def test_pierson_moskowitz_period_of_a_20_ft_sea() -> None:
    assert waves.peak_frequency(6.096) == pytest.approx(0.5089165892961309, rel=1e-14)
    assert waves.peak_frequency(6.096, 10.0) == pytest.approx(0.2 * math.pi)


@pytest.mark.parametrize("gamma", [1.0, 2.0, 3.3, 7.0])
def test_shape_has_unit_variance(gamma: float) -> None:
    inner = waves.integrate(lambda x: waves.shape(x, gamma), 0.2, 3.0)
    # above the peak's reach the shape is C times Bretschneider's, whose tail is 1 - exp(-5/4 x^-4)
    outer = waves.shape(3.0, gamma) / waves.shape(3.0) * -math.expm1(-1.25 * 3.0**-4)
    assert inner + outer == pytest.approx(1.0, abs=1e-13)  # rounding of 480 terms


def test_published_jonswap_values() -> None:
    omega_p = 2.0 * math.pi / 8.0
    assert waves.spectrum(omega_p, 3.0, omega_p, 3.3) == pytest.approx(2.220206035492452, rel=1e-13)
    assert waves.spectrum(1.0, 3.0, omega_p, 3.3) == pytest.approx(0.44136758940979154, rel=1e-13)


@pytest.mark.parametrize(("n", "gamma"), [(5, 1.0), (20, 3.3), (100, 1.0), (200, 1.0)])
def test_moments_of_the_gauss_rule_are_exact(n: int, gamma: float) -> None:
    rule = waves.gauss_rule(n, gamma)
    for k in range(min(2 * n, 9)):
        exact = waves.integrate(lambda x, k=k: x**k * waves.shape(x, gamma), *waves.BAND)
        assert math.fsum(w * x**k for x, w in rule) == pytest.approx(exact, rel=1e-12)
    assert all(w >= 0.0 for _, w in rule)  # the outermost weights of 200 nodes underflow
    assert all(a[0] < b[0] for a, b in pairwise(rule))
    assert waves.BAND[0] < rule[0][0] and rule[-1][0] < waves.BAND[1]


def test_a_gauss_rule_is_not_exact_beyond_its_degree() -> None:
    exact = waves.integrate(lambda x: x**12 * waves.shape(x), *waves.BAND)
    assert abs(math.fsum(w * x**12 for x, w in waves.gauss_rule(4)) / exact - 1.0) > 1e-3


def test_consistency_with_legendre_rule_of_two_points() -> None:
    assert sorted(x for x, _ in waves.legendre_rule(2)) == pytest.approx([-1.0 / math.sqrt(3.0), 1.0 / math.sqrt(3.0)])


@pytest.mark.parametrize("arguments", [(0,), (301,), (10, 1.0, (0.0, 4.0)), (10, 1.0, (4.0, 0.5))])
def test_bad_rules_are_refused(arguments: tuple[object, ...]) -> None:
    with pytest.raises(ValueError, match="expected"):
        waves.gauss_rule(*arguments)  # type: ignore[arg-type]


def test_phases_are_those_of_splitmix64() -> None:
    assert waves.phases(1964, 3) == (4.534581801393926, 4.8205620729434075, 2.8232251212163915)
    # first output of the published reference implementation for seed 0: 0xE220A8397B1DCDAF
    assert waves.phases(0, 1)[0] == 2.0 * math.pi * (0xE220A8397B1DCDAF >> 11) * 2.0**-53


@pytest.mark.parametrize("s", [0, 1, 5, 12])
def test_harmonics_of_the_spreading_are_exact(s: int) -> None:
    fan = waves.spreading(s, s + 3)
    # first harmonic of cos^2s(mu/2): s/(s + 1); second: s (s - 1)/((s + 1)(s + 2))
    assert math.fsum(w for _, w in fan) == pytest.approx(1.0)
    assert math.fsum(w * math.cos(mu) for mu, w in fan) == pytest.approx(s / (s + 1), abs=1e-14)
    assert math.fsum(w * math.cos(2 * mu) for mu, w in fan) == pytest.approx(s * (s - 1) / ((s + 1) * (s + 2)), abs=1e-14)
    with pytest.raises(ValueError, match="directions"):
        waves.spreading(s, s + 2)
