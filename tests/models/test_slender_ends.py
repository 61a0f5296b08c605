"""End integrals against quadrature of what they are integrals of, at their limits, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from towage.models.numeric.ops import FLOATS
from towage.models.slender import ends as slender_ends
from towage.models.slender.coefficients import Body

SLENDERNESS = 40.0


def by_quadrature(lam: float, s: slender_ends.Shape, al: float) -> list[float]:
    e2, k1, k2, l3 = s.e**2, s.k1, s.k2, s.l3
    integrands = (
        lambda x: lam * np.sqrt(1.0 - x * x),
        lambda x: lam * (1.0 - x * x),
        lambda x: lam * (1.0 - x * x) * k2,
        lambda x: (1.0 + k1) * (1.0 + k2) * x * (1.0 - x * x) / (1.0 - e2 * x * x),
        lambda x: lam**2 * l3 * x * (1.0 - x * x),
        lambda x: lam * (1.0 - x * x) * ((1.0 + k1) * (1.0 + l3 * (2.0 * x * x - 1.0)) / (1.0 - e2 * x * x) - 1.0),
        lambda x: x * ((1.0 + k1) ** 2 * (1.0 - x * x) / (1.0 - e2 * x * x) - 1.0),
    )
    nodes, weights = np.polynomial.legendre.leggauss(200)  # in the angle of x = sin(angle): no root at the tip
    half = 0.5 * math.asin(al)
    angle = half * (nodes + 1.0)
    return [float(half * weights @ (f(np.sin(angle)) * np.cos(angle))) for f in integrands]


@pytest.mark.parametrize("al", [1e-6, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("product", [0.5 + 1e-9, 0.51, 0.54, 0.57735, 0.5774, 0.6, 1.0, 8.0])
def test_consistency_with_quadrature(product: float, al: float) -> None:
    """Both sides of the change from series to closed form (e = 0.5 at lam eps = 0.57735) and both ends of the range."""
    lam = product / SLENDERNESS
    s = slender_ends.shape(lam, SLENDERNESS, FLOATS)
    found = slender_ends.integrals(lam, s, al, FLOATS)
    for value, wanted in zip(found, by_quadrature(lam, s, al)):
        # 1e-12: i7 and i6 are differences of terms up to ten times their size; 1e-30 is zero
        assert value == pytest.approx(wanted, rel=1e-12, abs=1e-30)


@given(st.floats(1e-12, 0.05))
def test_sphere_limit_of_inertia_coefficients(excess: float) -> None:
    """k1 = 1/2 - 3 e^2/10, k2 = 1/2 + 3 e^2/20, l3 = e^2/3 to first order in e^2; the next term is below e^4."""
    s = slender_ends.shape((0.5 + excess) / SLENDERNESS, SLENDERNESS, FLOATS)
    assert s.k1 == pytest.approx(0.5 - 0.3 * s.e**2, abs=s.e**4 + 1e-15)
    assert s.k2 == pytest.approx(0.5 + 0.15 * s.e**2, abs=s.e**4 + 1e-15)
    assert s.l3 == pytest.approx(s.e**2 / 3.0, abs=s.e**4 + 1e-15)


def test_needle_limit_of_inertia_coefficients() -> None:
    s = slender_ends.shape(1e5 / SLENDERNESS, SLENDERNESS, FLOATS)
    # they approach 0, 1, 1 like (1 - e^2) log(1/(1 - e^2)), 6e-10 at lam eps = 1e5
    assert (s.k1, s.k2, s.l3) == pytest.approx((0.0, 1.0, 1.0), abs=1e-8)


def test_series_meets_closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    lam = 0.5771 / SLENDERNESS  # e = 0.4993
    series = slender_ends.shape(lam, SLENDERNESS, FLOATS)
    ends = slender_ends.integrals(lam, series, 0.8, FLOATS)
    monkeypatch.setattr(slender_ends, "SERIES_BELOW", 0.0)
    # 1e-12: what the closed form of l3 has lost at e = 0.5
    assert slender_ends.shape(lam, SLENDERNESS, FLOATS) == pytest.approx(series, rel=1e-12)
    assert slender_ends.integrals(lam, series, 0.8, FLOATS) == pytest.approx(ends, rel=1e-12)


def test_corrected_theory_has_no_drag_in_potential_flow() -> None:
    """d'Alembert: two full half spheroids. As published they have 0.19973 of rho U^2 S/2."""
    published, corrected = Body(), Body(theory="corrected")
    assert 2.0 * (published.ends.signed_nose.i7 + published.ends.tail.i7) == pytest.approx(0.19973, abs=5e-6)
    assert corrected.ends.signed_nose.i7 + corrected.ends.tail.i7 == 0.0
    # tension with and without it, five printed digits
    assert (published.tension, corrected.tension) == pytest.approx((1.22329, 1.02356), abs=5e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"end_length": 0.01}, "more than 0.5"),
        ({"end_length": 0.0125}, "more than 0.5"),
        ({"end_length": -0.015}, "end_length"),
        ({"rope_length": 0.0}, "rope_length"),
        ({"rope_length": -1.0}, "rope_length"),
        ({"tail_cut": 0.0}, "tail_cut"),
        ({"tail_cut": 1.0001}, "tail_cut"),
        ({"tail_cut": -0.5}, "tail_cut"),
        ({"friction": -1.0}, "friction"),
        ({"normal_drag": -1e-9}, "normal_drag"),
        ({"damping": -1e-9}, "damping"),
        ({"mass_ratio": 0.0}, "mass_ratio"),
        ({"mass_ratio": 1.0}, "mass_ratio"),
        ({"slenderness": math.inf}, "finite"),
        ({"end_length": math.nan}, "finite"),
        ({"theory": "old"}, "theory"),
    ],
)
def test_refusals_give_the_reason(change: dict[str, float | str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(Body(), **change)  # type: ignore[arg-type]
