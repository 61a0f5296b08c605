"""The comparison of a coupled with a one-way run where nothing moves, or next to nothing."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import towage
from towage.checks.comparison import compare, response, runs
from towage.checks.sdof_section import Sdof
from towage.checks.signals import dominant_frequency
from towage.checks.track import Track
from towage.models.heave.sdof import Pair
from towage.result.records import Comparison

TIME = np.arange(2001) * 0.05
CHECK = Sdof(
    ("line.reaction -> ship.reaction",), "ship.heave", "body.heave", "line.tension", reaction="line.reaction", ship="ship"
)


def unit(name: str, **constants: float) -> SimpleNamespace:
    return SimpleNamespace(name=name, constant=constants.get)


ONE_SHIP = SimpleNamespace(
    units=[unit("ship", port_mass=1e6, natural_frequency=math.sqrt(1.49), damping_ratio=0.0), unit("line"), unit("body")]
)
"""A ship whose dynamic stiffness is 1e6 N/m at 0.7 rad/s, and units that tell nothing."""


def judged(coupled: float, one_way: float, weight: float = 1e5, drive: float = 1.0) -> Comparison:
    """The comparison of two harmonic motions of these amplitudes, m, on a line of 1e5 N/m."""
    wave = np.sin(0.7 * TIME)
    two, one = [
        {"ship.heave": drive * wave, "body.heave": a * wave, "line.tension": weight - 1e5 * a * wave,
         "line.reaction": -1e5 * a * wave} for a in (coupled, one_way)
    ]  # fmt: skip
    settled = runs(CHECK, TIME, Track(TIME, two), Track(TIME, one))
    return compare(CHECK, settled, TIME, ONE_SHIP, chaotic=False)


def test_a_body_at_rest_is_judged_valid() -> None:
    for weight, motions in ((1e5, (0.0, 0.0)), (0.0, (0.0, 0.0)), (1e5, (1e-16, 2e-16)), (1e5, (0.0, 1e-16))):
        found = judged(*motions, weight)
        assert (found.word, found.amplitude, found.peak_tension, found.rms) == ("valid", 0.0, 0.0, 0.0)


def test_a_body_that_moves_in_one_run_only_is_judged_invalid() -> None:
    for motions in ((0.0, 0.5), (0.5, 0.0)):
        found = judged(*motions)
        assert found.word == "invalid"
        assert math.inf in (found.amplitude, found.rms)


def test_a_ship_that_hardly_moves() -> None:
    """Its indicator is the pull of the line over a motion that is zero, or nearly."""
    assert judged(0.5, 0.5, drive=0.0).indicator is None
    assert judged(0.5, 0.5, drive=1e-300).word == "marginal"


@pytest.mark.parametrize("size", [1.0, 1e-150, 1e-300, 1e-310, 5e-324, 0.0])
def test_frequency_of_a_motion_of_any_size(size: float) -> None:
    found = dominant_frequency(TIME, size * np.sin(0.7 * TIME))
    assert found == pytest.approx(0.7, rel=0.02) or (size < 1e-290 and (found is None or math.isfinite(found)))


def test_transmissibility_without_drag(monkeypatch: pytest.MonkeyPatch) -> None:
    """Infinite at the cradle's resonance, which is one of the frequencies: left out of the curve."""
    pair = Pair(400.0, 20.0, 1000.0, 1.0, 4.0, 0.0, 0.5)
    monkeypatch.setattr("towage.checks.comparison.pair", lambda system, check: pair)
    columns = {"ship.heave": np.sin(0.7 * TIME), "body.heave": 2.0 * np.sin(0.7 * TIME)}
    curve = response(None, CHECK, 0.7, columns, TIME)  # type: ignore[arg-type]
    assert curve is not None
    known = [(r, a) for r, a in zip(curve["ratio"], curve["amplitude"]) if not math.isnan(a)]
    assert len(known) == len(curve["ratio"]) - 1
    for r, a in known:
        assert a == pytest.approx(1.0 / abs(1.0 - r * r), rel=1e-9)


def test_scene_without_drag_has_a_verdict() -> None:
    bare = {"cradle.drag_coefficient": 0.0, "stop_time": "40 s", "checks.sdof.settle": "10 s"}
    result = towage.run("slack", set=bare, flavour="python")
    assert result.verdict.word in ("valid", "marginal", "invalid")
    assert result.response is not None
