"""Random tows against the verdict: a sample of the adversary's, and its truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.verdict import fool, tow_truth, tows
from towage.fmus.native.compiler import CompileError, compiler, host
from towage.models.cable.lumped.nonlinear import nonlinear_cable
from towage.models.protocol.physical import GRAVITY

try:
    compiler(host())
except CompileError as missing:
    pytest.skip(str(missing), allow_module_level=True)

SEED = 1969
SAMPLE = (3, 6, 24, 33)
"""One far off; one that is right; one whose reduced model is 6 % off in the motion of its body, for surge and heave cancel there;
one whose segments leave more than the unit's own tolerance, and less than the scene's."""
WORDS = ("invalid", "valid", "marginal", "valid")


def test_a_sample_fools_nobody(tmp_path: Path) -> None:
    rows = fool.run("tows", max(SAMPLE) + 1, SEED, 1, tmp_path, SAMPLE)
    assert not [row for row in rows if fool.fault(row, tows.TOLERANCE)], fool.table(rows, tows.TOLERANCE)
    assert tuple(row.verdict for row in rows) == WORDS
    assert all(row.measures["noise"] < max(0.05 * row.measures["error"], 1e-3) for row in rows)


def test_drawn_tows_are_possible() -> None:
    for index in range(20):
        drawn = tows.draw(3, index)
        tow = drawn.tow
        assert 50.0 <= tow.cable.length <= 3000.0 and 0.3 <= tow.speed <= 8.0
        assert tow.body.weight < tow.body.mass * GRAVITY and tow.cable.weight < tow.cable.mass * GRAVITY
        assert len(drawn.sea.omega) in (1, 16) and drawn.stop >= 4.0 * drawn.sea.ramp


def test_the_truth_is_that_of_lumped_masses() -> None:
    """Two nonlinear models that share the loading alone; 30 segments and 80 steps a period leave 1 %."""
    drawn = next(d for d in (tows.draw(3, k) for k in range(50)) if len(d.sea.omega) == 1 and d.tow.cable.length < 200.0)
    sea, step = drawn.sea, 2.0 * np.pi / float(drawn.sea.omega[0]) / 80.0
    times = step * np.arange(121)
    found = tow_truth.solve(drawn.tow, sea, times, *tow_truth.LEVELS[1])
    cable = nonlinear_cable(drawn.tow, 30)

    def velocity(t: float) -> np.ndarray:
        s = min(1.0, t / sea.ramp)
        r, r1 = s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * (s * (1.0 - s)) ** 2 / sea.ramp
        x = sea.amplitudes[0] * np.exp(-1j * sea.omega[0] * t)
        return np.array([*(r1 * x - 1j * sea.omega[0] * r * x).real, 0.0, 0.0])

    state, low = cable.start(), []
    for t in times:
        low.append(cable.tensions(state)[0])
        state = cable.step(float(t), step, state, velocity)
    other = np.array(low)
    assert np.abs((found.body - found.body[0]) - (other - other[0])).max() < 0.02 * np.abs(other - other[0]).max()
