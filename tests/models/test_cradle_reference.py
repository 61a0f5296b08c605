"""Every reference value that was computed independently, through ``towage.verify.verify``."""

import json
import math
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from towage.errors import SceneError
from towage.verify.cradle import SOLVERS
from towage.verify.verify import OWN_FILES, check, compare, verify

OWN = {name: json.loads((files("towage") / "reference" / name).read_text("utf-8"))["cases"] for name in OWN_FILES}
SHARED = Path(__file__).parents[2].parent / "shared" / "reference"
EASY = {"B": 0.0, "r": 2.0, "y0": 0.0, "v0": 0.0, "tau": 1.0, "w": None}
TIGHTER = {"slender.json": 1e-11}  # asked for: 1e-8, integrals 1e-10; measured at most 1.1e-12


def listed(cases: dict[str, list[dict[str, Any]]]) -> list[Any]:
    """(file, case), one scope of pytest-xdist a kind."""
    return [
        pytest.param(name, case, id=f"{name} {case['kind']}::{case.get('name', k)}")
        for name, group in cases.items() for k, case in enumerate(group)
    ]  # fmt: skip


@pytest.mark.parametrize(("file", "case"), listed(OWN))
def test_own_copy_agrees(file: str, case: dict[str, Any]) -> None:
    result = check(case)
    assert result.ok, result.message
    assert result.worst_error < TIGHTER.get(file, math.inf)


def test_own_copy_is_what_verify_verifies_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every case once, of every kind."""
    monkeypatch.setattr("towage.verify.verify.check", lambda case: case)
    assert verify() == [case for cases in OWN.values() for case in cases]
    assert {case["kind"] for cases in OWN.values() for case in cases} >= set(SOLVERS)


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared reference values are not beside this repository")
@pytest.mark.parametrize("file", [name for name in OWN_FILES if (SHARED / name).is_file()])
def test_shared_reference_agrees(file: str) -> None:
    results = verify(SHARED / file)
    assert len(results) > 5
    assert [r for r in results if not r.ok] == []
    assert max(r.worst_error for r in results) < TIGHTER.get(file, math.inf)


def test_rule_of_comparison() -> None:
    assert compare([1.0, 1e-12], [1.0, 0.0], 1e-8) == (1e-12, [])  # judged against the largest of the list
    assert compare({"a": 0.0, "b": 100.0}, {"a": 1e-7, "b": 100.0}, 1e-8)[1] == []
    assert compare({"a": 0.0}, {"a": 1e-7}, 1e-8)[1] != []
    assert compare([2.0], [1.0, 2.0], 1e-8)[1] != []
    assert compare(3, 3.0, 1e-8)[1] == []
    assert compare(4, 3, 0.5)[1] != []  # integers exactly
    assert compare(1, True, 0.5)[1] != []  # and booleans
    assert compare(math.nan, 1.0, 1e-8)[1] != []
    assert compare({}, {"a": 1.0}, 1e-8)[1] == ["no value is computed for a"]
    assert compare({"a": [{"b": 1.0}]}, {"a": [{"b": 2.0}]}, 1e-8)[1][0].startswith("a[0].b: computed 1.0")


def test_wrong_value_fails() -> None:
    exact = {"y": math.sin(1.0), "v": 0.0}
    result = check({"kind": "transient", "name": "", "inputs": EASY, "expected": exact})
    assert not result.ok and "y: computed" in result.message
    assert result.rtol == 1e-8


@pytest.mark.parametrize(
    ("case", "message"),
    [
        ({"kind": "tide", "inputs": {}, "expected": {}}, "unknown kind 'tide'"),
        ({"kind": "transient", "inputs": {"B": 0.1}, "expected": {"y": 1.0}}, "input 'r' is missing"),
        ({"kind": "transient", "inputs": {**EASY, "r": "two"}, "expected": {"y": 1.0}}, "TypeError"),
        ({"kind": "transient", "inputs": {**EASY, "r": 0.0}, "expected": {"y": 1.0}}, "ZeroDivisionError"),
        ({"kind": "transient", "inputs": EASY, "expected": {"heat": 1.0}}, "no value is computed for heat"),
    ],
)
def test_what_cannot_be_computed_fails_with_a_reason(case: dict[str, object], message: str) -> None:
    result = check(case)
    assert not result.ok and message in result.message


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("{", ""),
        ("[]", ""),
        ('{"cases": [1]}', "cases[0]"),
        ('{"cases": [{"kind": "x", "inputs": {}}]}', "cases[0].expected"),
        ('{"cases": [{"kind": "x", "inputs": {}, "expected": {}, "rtol": "a"}]}', "cases[0].rtol"),
    ],
)
def test_malformed_file_is_refused(tmp_path: Path, text: str, key: str) -> None:
    file = tmp_path / "cases.json"
    file.write_text(text)
    with pytest.raises(SceneError) as caught:
        verify(file)
    assert caught.value.file == file and caught.value.key == key


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError):
        verify(tmp_path / "none.json")


def test_other_inputs_are_followed() -> None:
    """A plastic capture by a submersible that moves with the cradle is the continuous docking."""
    common = {
        "M1": 450.0, "M2": 3361.0, "K": 1000.0, "omega": 0.7, "B1": 0.2, "b2_over_b1": 2.5,
        "y0_steady": 0.3, "v0_steady": -0.2, "t_dock": 1.5, "t_end": 20.0,
    }  # fmt: skip
    soft = SOLVERS["docking"]({**common, "mode": "continuous"}, {})
    hard = SOLVERS["docking"]({**common, "mode": "plastic", "v_sub": soft["v_before"]}, {})
    assert hard["y_end"] == pytest.approx(soft["y_end"], abs=1e-11)  # the same motion, integrated to 1e-13
    hovering = SOLVERS["docking"]({**common, "mode": "plastic", "v_sub": 0.0}, {})
    assert hovering["v_after"] == pytest.approx(450.0 / 3361.0 * soft["v_before"], rel=1e-14)
    with pytest.raises(ValueError, match="mode is 'bounce'"):
        SOLVERS["docking"]({**common, "mode": "bounce"}, {})


def test_two_dof_without_force_stays_at_rest() -> None:
    inputs = {"m1": 2.0, "m2": 1.0, "K1": 5.0, "K2": 1.0, "zeta1": 0.1, "B": 0.3, "w": 0.5, "tau": 7.0}
    values = SOLVERS["two_dof_nonlinear"](inputs, {})
    assert values["x"] == values["y"] == 0.0 and values["taut_switches"] == 0


def test_sample_table_in_any_order() -> None:
    inputs = {"B": 0.2, "r": 0.9, "y0": -2.4, "v0": 0.0, "T": [0.1, 0.0, 0.04, 0.1]}
    values = SOLVERS["sample_table"](inputs, {})["Y"]
    assert values[1] == -2.4 and values[0] == values[3]
    # row 26 of the register, 7 digits in the listing's place
    assert values[2] == pytest.approx(-2.32263, abs=5e-6)
