"""Premises of a line without mass and of a slender body whose speed changes: words, numbers and remedies on the card."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import towage
from towage.checks.margins import item_of, with_error
from towage.errors import SceneError
from towage.report.page import text_summary
from towage.result.records import Item, Margin
from towage.result.result import Result

LIFT = Path(__file__).parent / "verdict" / "deep_lift.toml"
SHORT = {"coupling.error_estimate": False}
"""A run without it is marginal at best."""


def lift(**changes: Any) -> Result:
    return towage.run(LIFT, set=SHORT | {k.replace("__", "."): v for k, v in changes.items()}, flavour="python")


def items(result: Result) -> dict[str, Item]:
    return {item.name: item for item in result.verdict.items}


def wire(result: Result) -> Any:
    return next(finding for finding in result.checks if finding.name.startswith("wire"))


# ---- the line --------------------------------------------------------------------------------------------------------


def test_a_deep_lift_on_a_spring_is_invalid_with_its_error_and_remedy() -> None:
    """31 % off in the load's motion, 49 % in the tension at the top."""
    result = lift()
    told = items(result)["premises"]
    assert result.verdict.word == told.word == "invalid"
    assert items(result)["SDOF"].word == "valid", "coupled and one-way run share the error"
    assert "31 % in motion and 49 % in tension" in wire(result).message
    assert told.remedy == "take the wire unit: omega L/c = 0.57" and told.limit == 0.05
    assert told.number == pytest.approx(0.49 * (1.1 + 0.5 * 0.49), rel=0.02)
    assert told.time is not None and 200.0 <= told.time <= 300.0
    assert "error up to 6" in told.reason and "%, limit 5 %" in told.reason and "line.margin_wire" in told.reason
    margin = next(m for m in result.margins if m.variable == "line.margin_wire")
    assert margin.worst == pytest.approx(1.0 - told.number / 0.05)
    assert "line.margin_wire" in text_summary(result)


def test_the_speed_of_waves_gives_the_mass() -> None:
    """c^2 = EA/m: 3333.33 m/s are 45 kg/m."""
    result = lift(line__wave_speed=3333.333333, line__mass_per_length=0.0, line__weight_per_length=0.0)
    assert items(result)["premises"].remedy == "take the wire unit: omega L/c = 0.57"


def test_a_light_wire_is_valid_and_its_error_small() -> None:
    """0.45 kg/m: a hundredth of the mass, some 1 % of error in the tension."""
    result = lift(line__mass_per_length=0.45, line__weight_per_length=3.83)
    assert items(result)["premises"].word == "valid" and result.verdict.word == "marginal"
    margin = next(m for m in result.margins if m.variable == "line.margin_wire")
    assert margin.error is not None and 0.002 < margin.error < 0.02


@pytest.mark.parametrize(
    ("change", "word", "decides"),
    [({}, "not judged", True), ({"line__length": 30.0, "line__axial_stiffness": 5e6}, "not judged", False)],
)
def test_a_wire_of_unknown_mass_is_said(change: dict[str, float], word: str, decides: bool) -> None:
    """It is not judged; where even a wire rope of steel errs beyond the tolerance, neither is the run."""
    result = lift(line__mass_per_length=0.0, **change)
    told = items(result)["wire"]
    assert (told.word, told.decides) == (word, decides)
    assert told.remedy == "give line.mass_per_length (and length)" and "as a wire rope of steel of" in told.reason
    assert result.verdict.word == ("not judged" if decides else "marginal")
    assert not any(m.variable == "line.margin_wire" for m in result.margins)


@pytest.mark.parametrize(
    "change",
    [
        {"load__drag_area": 0.0},
        {"ship__heave_amplitude": 0.0},
        {"load__weight_in_water": 0.0, "line__breaking_load": 0.0, "ship__heave_amplitude": 0.0},
        {"load__drag_area": 0.0, "ship__heave_amplitude": 0.0, "line__mass_per_length": 0.0},
    ],
)
def test_nothing_judged_loses_a_finished_run(change: dict[str, float]) -> None:
    """No drag, no amplitude, no weight, no mass."""
    result = lift(**change)
    assert result.status == "done" and "could not be judged" not in text_summary(result)
    if change.get("ship__heave_amplitude") == 0.0:
        assert all(m.worst == 1.0 for m in result.margins if m.variable == "line.margin_wire")
    else:
        assert items(result)["premises"].word == "invalid"


def test_drive_at_the_frequency_of_the_load_itself() -> None:
    """Equal frequencies: the spring resonates without drag, the bar beside it."""
    result = lift(ship__heave_period=2.0 * np.pi * (250e3 * 3000.0 / 5e8) ** 0.5, load__drag_area=0.0)
    assert result.status == "done" and items(result)["premises"].word == "invalid"


def test_a_short_record_is_no_obstacle() -> None:
    result = towage.run(LIFT, set=SHORT | {"stop_time": 0.4, "checks.sdof.settle": 0.2}, flavour="python")
    assert result.status == "done" and "wire could not be judged" not in text_summary(result)


def test_a_margin_that_is_shown_only_does_not_decide() -> None:
    result = towage.run(LIFT, set=SHORT | {"checks.report_only": ["line.margin_wire"]}, flavour="python")
    assert result.verdict.word == "marginal"
    assert next(m for m in result.margins if m.variable == "line.margin_wire").worst < 0.0


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"line__breaking_load": 2.4e6}, "with the line's own weight"),
        ({"line__breaking_load": 2.5e6, "line__weight_per_length": 0.0}, "without it that in air"),
        ({"line__wave_speed": 3000.0}, "both given"),
        ({"line__weight_per_length": 500.0}, "weight_per_length is above g times the mass"),
    ],
)
def test_impossible_wires_are_refused(change: dict[str, float], match: str) -> None:
    with pytest.raises(SceneError, match=match):
        lift(**change)


def test_the_own_weight_counts_against_the_breaking_load() -> None:
    """1 - (T - W)/(T_break - W - w L): 383 N/m on 3000 m are 1.149 MN."""
    result = lift()
    margin, tension = result["line.margin_breaking"], result["line.tension"]
    assert np.allclose(margin, 1.0 - np.maximum(tension - 1.28e6, 0.0) / (5e6 - 1.28e6 - 1.149e6), rtol=1e-12)


# ---- the card ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("worst", "description", "told"),
    [
        (-1.0, "negative beyond: 1 - error / 5 %, pull of the rope; remedy: go slower", (0.1, 0.05, "go slower")),
        (0.5, "1 - error / 2.5 %", (0.0125, 0.025, "")),
        (0.5, "1 - (T - W)/(T_break - W)", (None, None, "")),
    ],
)
def test_a_margin_in_units_of_an_error_tells_it(worst: float, description: str, told: tuple[Any, ...]) -> None:
    margin = with_error(Margin("a.margin_x", worst, 0.0, True), description)
    assert (margin.error, margin.limit, margin.remedy) == pytest.approx(told)


def test_the_card_shows_error_limit_time_and_remedy() -> None:
    told = item_of(
        [
            Margin("a.margin_x", -1.0, 3.0, True, error=0.1, limit=0.05, remedy="go slower"),
            Margin("a.margin_y", 0.3, 0.0, True),
        ]
    )
    assert told == Item(
        "invalid", "a.margin_x at t = 3 s: error up to 10 %, limit 5 %", 0.1, 0.05, 3.0, "go slower", "premises"
    )


# ---- the slender body -------------------------------------------------------------------------------------------------


def ramp(**changes: Any) -> Result:
    return towage.run(
        "slender_speed_ramp", set={"coupling.error_estimate": False, "stop_time": 24.0, "checks.sdof.settle": 20.0} | changes,
        flavour="python",
    )  # fmt: skip


def test_inertia_is_in_the_tension_of_a_changing_speed() -> None:
    """513 kg of body and ends with 4 kg of added mass; at mid-ramp 0.1406 m/s2 on 156 N of drag at 2.25 m/s."""
    result = ramp()
    k = int(np.argmin(np.abs(result.time - 10.0)))
    speed, rate = 2.25, 1.5 / 20.0 * 1.875
    drag = result["body.tension"][-1] * (speed / 3.0) ** 2  # the speed stays 3 m/s from 20 s on
    assert drag == pytest.approx(156.0, abs=1.0)
    mass = (result["body.tension"][k] - drag) / rate
    assert 503.0 < mass < 525.0
    told = items(result)["premises"]
    assert result.verdict.word == told.word == "invalid" and "body.margin_speed_change" in told.reason
    assert told.number is not None and told.number > 4 * 0.45 and told.remedy == "change the speed more slowly"


def test_a_body_that_overtakes_its_rope_leaves_it_slack() -> None:
    """From 3 to 0.5 m/s in 5 s: inertia beyond the drag, no tension, no force on the craft; never a push."""
    result = ramp(**{"craft.speed_start": 3.0, "craft.speed_end": 0.5, "craft.speed_change_time": 5.0})
    assert result["body.tension"].min() == 0.0
    slack = result["body.tension"] == 0.0
    assert slack.any() and (result["body.lateral_force"][slack] == 0.0).all()
    assert result.verdict.word == "invalid"
    assert min(m.worst for m in result.margins if m.variable == "body.margin_speed_change") < -79.0


def test_a_speed_that_stays_has_no_error() -> None:
    result = ramp(**{"craft.speed_end": 1.5})
    assert (result["body.margin_speed_change"] == 1.0).all()


def test_report_only_refuses_what_no_check_and_no_unit_has() -> None:
    with pytest.raises(SceneError, match="no variable 'margin_wires'"):
        towage.run(LIFT, set=SHORT | {"checks.report_only": ["line.margin_wires"]}, flavour="python")
