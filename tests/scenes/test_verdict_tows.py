"""The word on a linear tow: cases from practice, the numbers of the nonlinear cable beside them."""

from __future__ import annotations

import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import towage
from tests.verdict.tows import word_of
from towage.checks.linearity import drive_of, margin_of, resolution_of
from towage.checks.margins import ROUGH, item_of, rough
from towage.models.cable.case import CableError
from towage.models.cable.lumped.linearity import Linearity
from towage.models.cable.units.ports import MarginSmallPerturbation
from towage.report.page import text_summary
from towage.result.records import Item, Margin
from towage.result.result import Result
from towage.scene.scene import Scene

CASES = Path(__file__).parent / "verdict"


def case(name: str) -> Result:
    return towage.run(CASES / f"{name}.toml", flavour="python")


def premises(result: Result) -> Item:
    return next(item for item in result.verdict.items if item.name == "premises")


def test_a_near_vertical_cable_is_valid() -> None:
    """The flow along it vanishes: once a margin divided by that."""
    result = case("near_vertical")
    assert result.verdict.word == "valid" and not any("flow" in name for name in result.columns)
    bound, word = word_of(result)
    assert word == "valid" and 0.001 < (premises(result).number or 0.0) < 0.003
    assert bound < 0.05  # the band ends near a resonance, where the unit's segments cost 3 %


def test_a_light_fish_is_invalid() -> None:
    """v/c = 0.18, abs(U1)/U0 = 0.54: the nonlinear cable's tension is 11.5 % off in time with 20 segments."""
    result = case("sonar_fish")
    told = premises(result)
    assert result.verdict.word == told.word == "invalid" and told.remedy == "take wire"
    assert told.number == pytest.approx(0.115, rel=0.05) and told.limit == 0.05 and told.time is not None
    assert 60.0 <= told.time <= 120.0 and "tension at the top of tow" in told.reason
    assert "invalid" in text_summary(result) and "take wire" in text_summary(result)


def test_an_irregular_sea_is_judged() -> None:
    result = case("tow_in_sea")
    bound, word = word_of(result)
    assert word == "valid" and 0.03 < bound < 0.05
    # a sea as high again makes it a tenth and more
    rough = towage.run(CASES / "tow_in_sea.toml", set={"ship.wave_height": 10.0}, flavour="python")
    assert word_of(rough)[0] > 0.1 and premises(rough).word == "invalid"


@pytest.mark.slow
def test_a_fast_tow_is_run_and_invalid() -> None:
    """Ten segments leave the quadrant, twice as many do not."""
    result = case("tow_15kn")
    assert result.status == "done" and premises(result).word == "invalid" and word_of(result)[0] > 0.17


WIRE = {
    "tow_speed": 0.05, "loading_form": 0, "wire_length": 3000.0, "wire_mass": 45.0, "wire_weight": 383.0, "wire_diameter": 0.08,
    "wire_axial_stiffness": 5e8, "wire_normal_drag": 1.2, "wire_tangential_drag": 0.03, "body_mass": 150e3,
    "body_added_mass": 1e5, "body_weight": 1.28e6, "body_drag_area": 2.0 * 10.0 / (1025.0 * 0.05**2),
    "velocity_tolerance": 1e-5, "tolerance": 1e-6,
}  # fmt: skip
"""The tow of `p01_deep_tow` as a `wire`."""


@pytest.mark.slow
def test_a_deep_lift_at_walking_pace() -> None:
    """In the steady state 3 % off. In the second half of the 60 s of the scene the linear tow rings on at its resonance, which it
    hardly damps at this speed: the nonlinear wire under the same ship is 11.7 % away at the top, 11.9 % at the body."""
    scene = tomllib.loads((CASES / "p01_deep_tow.toml").read_text("utf-8"))
    scene["units"]["wire"] = {"fmu": "wire", "parameters": WIRE}
    scene["connections"].append("ship.velocity -> wire.velocity_heave")
    scene["coupling"]["error_estimate"] = False
    result = towage.run(Scene.from_dict(scene), flavour="python")
    late = result.time >= 30.0
    for name, expected in (("tension_top", 0.117), ("tension_body", 0.119)):
        linear, wire = (result[f"{unit}.{name}"] - result[f"{unit}.{name}"][0] for unit in ("tow", "wire"))
        assert np.abs(linear - wire)[late].max() / np.abs(linear[late]).max() == pytest.approx(expected, rel=0.03)
    margin = next(m for m in result.margins if m.variable == "tow.margin_small_perturbation")
    assert result.verdict.word == margin.word == "invalid"
    assert margin.error == pytest.approx(0.119, rel=0.03) and "motion" not in margin.reason
    assert not any("flow" in m.variable for m in result.margins)


@pytest.mark.slow
def test_the_deep_lift_started_softly_is_valid() -> None:
    """Nothing rings: what is left is the 3 % of the steady state."""
    result = case("p01_deep_tow_soft")
    bound, word = word_of(result)
    assert result.verdict.word == word == "valid" and premises(result).number == pytest.approx(0.032, rel=0.05) and bound < 0.05


def test_a_rough_sign_decides_nothing() -> None:
    """Nor does its other sign: v/c says little of the error."""
    for worst in (-2.0, 0.5):
        told = item_of([rough(Margin("tows.margin_small_perturbation", worst, 0.0, True))])
        assert told is not None and told.word == "not judged" and "a rough sign" in told.reason
    assert MarginSmallPerturbation.__metadata__[0].description.count(ROUGH) == 1


def errors(tension: float, bound: float, rise: float = 0.0, followed: bool = True) -> Linearity:
    return Linearity(tension, 0.5 * tension, 0.2 * tension, bound, rise, 0.0, 1.0, 12.0, followed)


@pytest.mark.parametrize(
    ("found", "word", "number"),
    [
        (errors(0.02, 0.03), "valid", 0.02), (errors(0.06, 0.07), "invalid", 0.06), (errors(0.048, 0.053), "marginal", 0.053),
        (errors(0.02, 0.03, rise=-0.2), "marginal", 0.2), (errors(0.02, 9.0, followed=False), "not judged", 0.02),
        (errors(0.2, 9.0, followed=False), "invalid", 0.2), ("there is no such tow", "not judged", None),
    ],
)  # fmt: skip
def test_words(found: Linearity | str, word: str, number: float | None) -> None:
    margin = margin_of("tow", found, 0.05, ())
    assert (margin.word, margin.error, margin.limit, margin.decides) == (word, number, 0.05, True)
    assert (margin.remedy == "") == (word == "valid")
    assert not margin_of("tow", found, 0.05, ("tow.margin_small_perturbation",)).decides


def test_segments_alone_make_no_run_invalid() -> None:
    fine, rough_one = (resolution_of("tow", model, 0.05, ()) for model in (0.02, 0.1))
    assert fine.word == "" and fine.worst == pytest.approx(0.6) and fine.error == 0.02
    assert rough_one.word == "marginal" and rough_one.worst == pytest.approx(-1.0) and "tow.band" in rough_one.remedy


def test_a_drive_that_nobody_observed_is_named() -> None:
    connection = SimpleNamespace(source_unit="hull", source="velocity", target_unit="tow", target="velocity_heave", factor=1.0)
    run: Any = SimpleNamespace(scene=SimpleNamespace(connections=[connection]), track=SimpleNamespace(columns={}))
    with pytest.raises(CableError, match=r"hull\.velocity, which drives tow\.velocity_heave, was not observed"):
        drive_of(run, "tow", "velocity_heave")


def test_the_mean_shift_is_told() -> None:
    assert "in the mean the body runs 0.2 m deeper" in margin_of("tow", errors(0.02, 0.03, rise=-0.2), 0.05, ()).reason
    assert "in the mean" not in margin_of("tow", errors(0.02, 0.03, rise=1e-6), 0.05, ()).reason


def test_the_gravest_margin_speaks() -> None:
    """An error that a check knows stands beside margins of which only the sign is known."""
    known = Margin("tow.margin_small_perturbation", 0.6, 3.0, True, "marginal", "shift", 0.2, 0.05, "another unit")
    small, broken = Margin("line.margin_taut", 0.1, 1.0, True), Margin("line.margin_breaking", -0.1, 2.0, True)
    assert item_of([known, small]) == Item("marginal", "shift", 0.2, 0.05, 3.0, "another unit", "premises")
    told = item_of([known, small, broken])
    assert told is not None and told.word == "invalid" and told.number == -0.1
    shown = Margin("tow.margin_small_perturbation", -2.0, 3.0, False, "invalid", "error", 0.2, 0.05)
    assert item_of([shown]) is None
