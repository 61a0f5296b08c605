"""The sweep over foreign units, with units of the zoo."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.foreign import sweep
from tests.zoo.zoo import animal


def test_each_unit_is_run_in_both_and_every_refusal_has_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for place in ("here", "there"):
        (tmp_path / place).mkdir()
    sound = animal(tmp_path / "here" / "a.fmu", experiment='<DefaultExperiment stopTime="1" stepSize="0.25"/>')
    shutil.copy(sound, tmp_path / "there" / "same.fmu")
    (tmp_path / "there" / "text.fmu").write_text("no archive")
    kept = tmp_path / "found.json"
    assert sweep.main([str(tmp_path), "--json", str(kept)]) == 0
    found = json.loads(kept.read_text())
    assert {name: each["word"] for name, each in found.items()} == {
        "here/a.fmu": "equal to the bit", "there/text.fmu": "refused",
    }  # fmt: skip
    assert found["here/a.fmu"]["gap"][2:] == [5, 8]  # times; outputs that are numbers
    shown = capsys.readouterr().out
    assert "| there | 1 | 0 | 0 | 0 | 0 | 1 | 0 |" in shown and "damaged or truncated archive" in shown
    assert str(tmp_path) not in shown


def test_the_gap_sees_values_and_missing_numbers_at_common_times() -> None:
    time = np.array([0.0, 0.5, 0.5, 1.0])  # two rows at an event: the last counts
    one = time, {"y": np.array([1.0, 5.0, 2.0, np.nan]), "z": np.zeros(4)}
    other = np.array([0.0, 0.5, 1.0]), {"y": np.array([1.0, 2.5, np.nan]), "x": np.zeros(3)}
    assert sweep.gap(one, other) == (0.2, "y", 3, 1)
    share, name, *_ = sweep.gap(one, (other[0], {"y": np.array([1.0, 2.0, 3.0]), "z": np.ones(3)}))
    assert np.isnan(share) and name == "y"
