"""The scene `towline`: statics and the slow swing of the barge against the elastic catenary, in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import towage

LENGTH, WEIGHT, STIFFNESS = 600.0, 100.0, 140e6
PULL = 0.5 * 1025.0 * 54.2 * 9.0
"""Resistance of the barge, N."""
DRY = {"line.wire_normal_drag": 0.0, "line.wire_tangential_drag": 0.0}
CALM = {f"{unit}.heave_amplitude": 0.0 for unit in ("tug_heave", "tug_surge", "barge_heave")}


def catenary(horizontal: float, lower: float) -> tuple[float, float]:
    """(x, z) of the upper end from the lower one, m, for the horizontal pull and the vertical one at the lower end, N."""
    upper = lower + WEIGHT * LENGTH
    x = horizontal / WEIGHT * (math.asinh(upper / horizontal) - math.asinh(lower / horizontal)) + horizontal * LENGTH / STIFFNESS
    z = (math.hypot(horizontal, upper) - math.hypot(horizontal, lower)) / WEIGHT
    return x, z + (upper * upper - lower * lower) / (2.0 * STIFFNESS * WEIGHT)


def test_the_line_hangs_as_the_elastic_catenary() -> None:
    result = towage.run("towline", set={**DRY, **CALM, "stop_time": 1.0})
    x, z = catenary(PULL, -30e3)
    # the elements reach 1e-4 of the length, and far less on so smooth a shape
    assert result["line.layback"][0] == pytest.approx(x, abs=1e-5)
    assert result["line.depth"][0] == pytest.approx(z, abs=1e-5)
    assert result["line.tension_top"][0] == pytest.approx(math.hypot(PULL, WEIGHT * LENGTH - 30e3), rel=1e-8)


def test_the_barge_swings_on_the_sag() -> None:
    """Pushed by 5 kN. The catenary's slope is the spring; the line moves along, which is a hundredth of the mass: its middle goes
    up and down by six times as much as the barge goes."""
    values = {**DRY, **CALM, "barge.drag_change": 5e3, "barge.drag": 250e3, "stop_time": 250.0, "coupling.step": 1.0}
    result = towage.run("towline", set=values)
    velocity, time = result["barge.velocity_surge"], result.time
    crossings = [t - v * (time[k + 1] - t) / (velocity[k + 1] - v)
                 for k, (t, v) in enumerate(zip(time[:-1], velocity[:-1])) if k and v * velocity[k + 1] < 0.0]  # fmt: skip

    def span(horizontal: float) -> float:
        """Between ends of one height, m."""
        lower = brentq(lambda v: catenary(horizontal, v)[1], -40e3, -20e3)
        return catenary(horizontal, lower)[0]

    spring = 1e3 / (span(PULL + 500.0) - span(PULL - 500.0))
    period = 2.0 * math.pi * math.sqrt(10.5e6 / spring)
    assert 2.0 * float(np.diff(crossings).mean()) == pytest.approx(period, rel=0.02)


@pytest.mark.slow
def test_the_verdict_stands() -> None:
    result = towage.run("towline")
    assert result.verdict is not None and result.verdict.word == "valid"
    late = result.time > 120.0
    # the swell pulls at the line more than at the barge
    assert np.ptp(result["line.tension_top"][late]) > 0.5 * PULL and np.ptp(result["barge.surge"][late]) < 0.1
