"""The adversary's own parts, and a sample of it: random scenes against the verdict (`fool`). ``make fool`` is the long form."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.verdict import fool, heave
from tests.verdict.truth import Pair, solve, truth
from towage.errors import TowageError
from towage.fmus.native.compiler import CompileError, compiler, host
from towage.models.heave.system import Simulation
from towage.scene.flavour import resolve
from towage.sweeps.row import Row
from towage.verify.monolithic import monolithic

try:
    compiler(host())
except CompileError as missing:
    pytest.skip(str(missing), allow_module_level=True)

SAMPLE = range(16)
"""Scenes of the sample, of every kind."""
SEED = 1969


@pytest.mark.parametrize("index", [0, 15, 17])
@pytest.mark.parametrize("two_way", [False, True])
def test_the_truth_is_that_of_the_monolithic_solution(index: int, two_way: bool) -> None:
    """Two programs that share nothing, taut and slack: 1e-6 of the motion over 10 periods."""
    drawn = heave.draw(SEED, index)
    assert drawn.sea == "regular"
    step, samples = drawn.pair.period / 16.0, 160
    own, _ = solve(drawn.pair, two_way, step, samples)
    system = replace(monolithic(resolve(heave.scene(drawn), None, "python")), two_way=two_way)
    run = Simulation(system, rtol=1e-10)
    other = np.array([run.advance(k * step)[-2] for k in range(samples)])
    assert np.abs(own - other).max() < 1e-6 * other.std()


def test_a_ship_that_nothing_moves_leaves_no_error() -> None:
    omega = 0.5
    heavy = Pair(1e12, 0.0, 1e12, 1.0, 0.5, 1.0, 100.0, 0.0, (1.0,), (omega,), (0.0,), 2.0 * math.pi / omega)
    found = truth(heavy, 200.0, 400.0)
    assert found.error < 1e-6 and not found.chaotic


def test_draws_cover_the_ranges_and_are_possible() -> None:
    drawn = [heave.draw(3, index) for index in range(400)]
    ratios = np.array([[d.pair.mass / d.pair.ship_mass, d.pair.stiffness / d.pair.ship_stiffness] for d in drawn])
    assert ratios.min() < 3e-4 and ratios.max() > 0.3 and ratios.min() >= 1e-4 and ratios.max() <= 1.0
    slack = [d.pair.weight / (d.pair.stiffness * d.pair.size) < 4.0 for d in drawn]
    assert 0.3 < np.mean(slack) < 0.5
    assert all(d.pair.weight <= 0.9001 * 9.80665 * d.pair.mass for d in drawn)
    assert {heave.kind(d) for d in drawn} == {
        f"{line}, {sea}" for line in ("taut", "slack") for sea in ("regular", "two frequencies", "irregular")
    }
    assert heave.draw(3, 7) == heave.draw(3, 7) != heave.draw(4, 7)


def row(word: str, error: float, noise: float = 0.0, chaotic: float = 0.0) -> Row:
    return Row(0, "done", word, "", {"error": error, "noise": noise, "chaotic": chaotic}, "taut, regular")


@pytest.mark.parametrize(
    ("told", "what"),
    [
        (row("valid", 0.051), "false valid"), (row("valid", 0.049), ""), (row("valid", 0.06, 0.02), ""),
        (row("invalid", 0.024), "false invalid"), (row("invalid", 0.026), ""), (row("marginal", 0.5), ""),
        (row("not judged", 0.5), ""),
    ],
)  # fmt: skip
def test_what_is_false(told: Row, what: str) -> None:
    assert fool.fault(told, 0.05) == what


def test_a_sample_fools_nobody_and_is_continued(tmp_path: Path) -> None:
    """The whole program on scenes of every kind; the same command continues a journal."""
    first = fool.run("heave", len(SAMPLE) // 2, SEED, 1, tmp_path)
    rows = fool.run("heave", len(SAMPLE), SEED, 1, tmp_path)
    assert rows[: len(first)] == first and [each.index for each in rows] == list(SAMPLE)
    text = fool.table(rows, heave.TOLERANCE)
    assert not [each for each in rows if fool.fault(each, heave.TOLERANCE)], text
    assert sum(each.verdict == "not judged" and not each.measures["chaotic"] for each in rows) <= 1, text
    assert fool.sharpness(rows) < 3.0
    with pytest.raises(TowageError, match="is of another sweep"):
        fool.run("heave", 1, SEED + 1, 1, tmp_path)
