"""``towage response``: excitations, and the table along the cable."""

from __future__ import annotations

import cmath
import csv
import json
import math
from pathlib import Path

import pytest

from towage.cli import main
from towage.errors import SceneError
from towage.frequency_response.along import along
from towage.frequency_response.excitation import excitation_of, in_words
from towage.frequency_response.response import response
from towage.models.cable.steady.perturbation import Excitation
from towage.verify.cable import excitation_of as excitation_of_case
from towage.verify.cable import tow_of

REFERENCE = Path(__file__).parents[1] / "towage" / "reference" / "cable.json"
CASES = {case["name"]: case for case in json.loads(REFERENCE.read_text())["cases"] if case["kind"] == "cable_response"}


@pytest.mark.parametrize("name", CASES)
def test_the_table_along_the_cable_has_the_reference_at_its_ends(name: str) -> None:
    """Surge and heave with phases in Quadrant I (OMWAY), drag and lift in Quadrant II (OMFLO)."""
    case = CASES[name]
    inputs, expected = case["inputs"], case["expected"]
    omega = inputs.get("omega") or 2.0 * math.pi * inputs["excitation"]["f"]
    rows = along(tow_of(inputs), omega, excitation_of_case(inputs), 5)
    assert [row["distance"] / inputs["L"] for row in rows] == [0.0, 0.25, 0.5, 0.75, 1.0]
    for row, station in zip(rows, expected["steady"]):
        assert (row["tension"], row["angle"]) == pytest.approx((station["T0"], station["phi0"]), rel=1e-9)
    columns = {"phi1": "angle1", "T1": "tension1", "Up": "normal1", "Vp": "tangential1", "x1": "x1", "y1": "y1"}
    for row, end in ((rows[0], "body"), (rows[-1], "tow")):
        for ours, theirs in ((columns[k], complex(*v)) for k, v in expected[end].items()):
            found = cmath.rect(row[ours], row[f"{ours}_phase"])
            assert found == pytest.approx(theirs, rel=1e-8, abs=1e-9), (end, ours)


def test_excitations_in_words_numbers_and_units() -> None:
    drive = excitation_of({"surge": "2 ft @ 40 deg", "heave": 3.0}, 1)
    assert drive.surge == pytest.approx(cmath.rect(0.6096, math.radians(40.0))) and drive.heave == 3.0
    assert in_words(drive) == "0.6096 m of surge of the towpoint @ 0.6981 rad and 3 m of heave of the towpoint"
    assert excitation_of({}, 1) == Excitation(heave=1.0) and excitation_of({}, 2) == Excitation(lift=1.0)
    assert excitation_of({"drag": 50 + 20j, "lift": "18 lbf"}, 2).drag == 50 + 20j


@pytest.mark.parametrize(
    ("given", "quadrant", "words"),
    [
        ({"sway": 1.0}, 1, "expected one of surge, heave, drag, lift"),
        ({"heave": 1.0}, 2, "in Quadrant II the towpoint moves steadily"),
        ({"heave": "2 kg"}, 1, "excitation heave: .*expected as in 2, '2 ft'"),
        ({"heave": "2 @ up"}, 1, "excitation heave"),
        ({"heave": math.nan}, 1, "expected a finite amplitude"),
        ({"heave": "0 ft"}, 1, "all amplitudes are 0"),
    ],
)
def test_an_excitation_that_cannot_be_is_refused(
    given: dict[str, float | complex | str], quadrant: int, words: str
) -> None:
    with pytest.raises(SceneError, match=words):
        excitation_of(given, quadrant)


def test_amplitudes_are_linear_in_the_excitation() -> None:
    (one,) = response("tow_600ft", frequencies=[0.2])
    (three,) = response("tow_600ft", frequencies=[0.2], excitation={"heave": "3 m @ 0.5"})
    assert three.gains[0].tension_top == pytest.approx(cmath.rect(3.0, 0.5) * one.gains[0].tension_top, rel=1e-12)
    assert three.per == "3 m of heave of the towpoint @ 0.5 rad"


def test_the_command_writes_the_cable_at_the_frequencies_asked_for(tmp_path: Path) -> None:
    arguments = ["--excite", "heave=3 ft", "--excite", "surge=2 ft@40 deg", "--at", "0.3", "--at", "0.1"]
    assert main(["response", "tow_600ft", *arguments, "--stations", "4", "--points", "3", "--out", str(tmp_path)]) == 0
    rows = list(csv.DictReader((tmp_path / "tow_cable.csv").read_text().splitlines()))
    assert [float(row["frequency_hz"]) for row in rows] == pytest.approx([0.3] * 4 + [0.1] * 4)
    assert float(rows[0]["x1"]) == 0.0 < float(rows[3]["x1"])


@pytest.mark.parametrize(
    ("text", "words"), [("heave", "expected NAME=AMPLITUDE"), ("heave=1 --excite heave=2", "twice")]
)
def test_an_excitation_written_wrongly_ends_in_a_message(
    text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--excite", *text.split(" ")]
    assert main(["response", "tow_600ft", *given, "--out", str(tmp_path)]) == 2
    assert words in capsys.readouterr().err
