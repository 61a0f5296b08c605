"""The bracket of Illinois: it ends just beyond the zero, in few tries, at its order."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from towage.models.numeric.root import Bracket

FUNCTIONS: list[tuple[Callable[[float], float], float, float]] = [
    (lambda s: math.cos(s), 3.0, 0.5 * math.pi),
    (lambda s: 2.0 - s * s, 2.0, math.sqrt(2.0)),
    (lambda s: math.exp(-5.0 * s) - 0.5, 2.0, math.log(2.0) / 5.0),
    (lambda s: s**5 - 1e-5, 1.0, 0.1),
]
"""Function, end of the bracket that begins at 0, the zero between."""


def tries(g: Callable[[float], float], high: float, width: float) -> tuple[Bracket, list[float]]:
    """The bracket at the end, and the places that were tried."""
    bracket = Bracket(0.0, g(0.0), high, g(high), width)
    places = []
    while bracket.size > width:
        places.append(place := bracket.secant())
        if (g(place) > 0.0) == (g(0.0) > 0.0):
            bracket.raise_low(place, g(place))
        else:
            bracket.lower_high(place, g(place))
    return bracket, places


@pytest.mark.parametrize(("g", "high", "zero"), FUNCTIONS)
def test_ends_beyond_the_zero_within_the_width(g: Callable[[float], float], high: float, zero: float) -> None:
    bracket, places = tries(g, high, 1e-10)
    assert bracket.low < zero <= bracket.high  # which is beyond
    assert bracket.high - zero <= 1e-10
    assert len(places) < 30  # bisection needs 34 and more


def test_order_is_that_of_the_rule() -> None:
    """Errors fall by the power 1.44 a try, so that their logarithm grows 1.44-fold (Dowell and Jarratt 1971)."""
    _, places = tries(FUNCTIONS[0][0], 3.0, 1e-14)
    errors = [math.log(abs(place - FUNCTIONS[0][2])) for place in places]
    settled = [value for value in errors if -30.0 < value < -2.0]  # neither at the start nor rounding
    growth = (settled[-1] / settled[0]) ** (1.0 / (len(settled) - 1))
    assert growth > 1.3


def test_places_keep_off_both_ends() -> None:
    bracket = Bracket(0.0, 1.0, 1.0, -1e-300, 0.1)  # the secant ends at 1
    assert bracket.secant() == pytest.approx(1.0 - 0.05)
    bracket.restart(0.0, 1e-300, 1.0, -1.0)
    assert bracket.secant() == pytest.approx(0.05)  # 0.3 of the width on, and at least a half


def test_values_that_underflow_are_flat() -> None:
    bracket = Bracket(0.0, 0.0, 1.0, -5e-324, 1e-9)
    assert not bracket.flat
    bracket.raise_low(0.25, 0.0)
    bracket.raise_low(0.5, 0.0)  # halves what was the smallest number
    assert bracket.flat
    assert bracket.middle() == 0.75
