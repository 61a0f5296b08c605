"""The bound of the linear tow against the truth, on random tows: no error above the tolerance is called valid."""

from __future__ import annotations

import numpy as np
import pytest

from tests.verdict.tows import TOLERANCE, draw, judged, sample, truth
from towage.models.protocol.physical import GRAVITY


@pytest.mark.parametrize(("number", "word"), [(3, "valid"), (23, "marginal")])
def test_two_random_tows(number: int, word: str) -> None:
    """A slow light tow, and a short one whose tension is 4.3 % off and whose mean depth shifts."""
    case = draw(np.random.default_rng([1, number]))
    found = truth(case)
    bound, said, errors = judged(case, found)
    assert said == word and errors.followed
    assert found.error < bound < 1.3 * found.error
    assert abs(errors.rise) / errors.heave == pytest.approx(found.shift, rel=0.1, abs=1e-3)


def test_drawn_tows_are_possible() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        case = draw(rng)
        tow = case.tow
        assert 50.0 <= tow.cable.length <= 3000.0 and 0.3 <= tow.speed <= 8.0
        assert tow.body.weight < tow.body.mass * GRAVITY and tow.cable.weight < tow.cable.mass * GRAVITY
        assert len(case.omega) in (1, 16) and not case.drive(0.0).any()


@pytest.mark.slow
def test_no_random_tow_is_falsely_valid() -> None:
    ratios = []
    for _, found, bound, word in sample(2, 20):
        ratios.append(bound / found.error)
        assert word != "valid" or found.error <= TOLERANCE
        assert word != "invalid" or found.error >= 0.5 * TOLERANCE
    assert min(ratios) > 0.9 and np.median(ratios) < 3.0
