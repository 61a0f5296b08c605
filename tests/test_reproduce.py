"""The reports computed again: every printed number agrees to its digits, or a row of the register says why not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from towage.cli import main
from towage.errors import TowageError
from towage.reproduce import gallery
from towage.reproduce.items import REPORTS, Answer, Item, Printed, Reproduction, items, named, reproduce

LONG = {
    "cradle.figure_5", "cradle.figure_8", "cradle.figure_10", "cradle.breaking_envelope", "cable.experiment_with_the_sample",
    "routing.fronts", "routing.halved_corrections",
    "slender.figure_12", "slender.figure_13", "slender.figure_14", "slender.figure_15a", "slender.figure_15b",
}  # fmt: skip
"""Items that take more than some seconds."""
EVERY = [
    pytest.param(item, marks=pytest.mark.slow if item.full_name in LONG else (), id=item.full_name)
    for report in REPORTS for item in items(report) if not item.missing and not item.explains
]  # fmt: skip


@pytest.mark.parametrize("item", EVERY)
def test_a_printed_number_agrees_or_the_register_says_why(item: Item, tmp_path: Path) -> None:
    found = reproduce(item)
    assert not found.faults
    assert found.answer and (found.rows or found.answer.columns)
    for file in gallery.write_files(found, tmp_path):
        assert file.stat().st_size > 20
    assert gallery.text(found) and item.title in gallery.page(item.report, [found])


def _found(text: str, computed: complex, register: str = "", cut: bool = False, methods: float | None = None) -> Reproduction:
    item = Item("slender", "one", "Table 0", "A number", (Printed("x", text, register=register, cut=cut),))
    return Reproduction(item, Answer({"x": computed}, methods=methods, by="two methods"))


def test_half_a_unit_of_the_last_digit_agrees() -> None:
    assert _found("3.38", 3.3849).word == "reproduced"
    assert _found("3.38", 3.3851).faults == ["x: printed 3.38, computed 3.3851, no row of the register says why"]
    assert not _found("3.38", 3.3889, cut=True).faults
    assert _found("3.38", 4.0, register="a slip").word == "refuted"


def test_a_row_of_the_register_for_a_right_number_is_a_fault() -> None:
    assert _found("3.38", 3.38, register="a slip").faults == ["x agrees, but has a row of the register"]


def test_methods_that_differ_are_a_fault() -> None:
    assert _found("3.38", 3.38, methods=2e-8).faults == ["two methods differ by 2.0e-08, more than 1e-08"]
    assert _found("3.38", 3.38, methods=float("nan")).faults


@pytest.mark.parametrize(
    ("text", "value", "allowed"),
    [
        ("-0.412i", -0.412j, 5e-4), ("1.899+0.050i", 1.899 + 0.05j, 5e-4), ("10.400", 10.4, 5e-4), ("8", 8.0, 0.5),
        ("9.42e4", 94200.0, 50.0), ("33,050", 33050.0, 0.5),
    ],
)
def test_what_is_printed_is_read_with_its_digits(text: str, value: complex, allowed: float) -> None:
    printed = Printed("x", text)
    assert printed.value == value
    assert printed.allowed == pytest.approx(allowed)


def test_the_command_lists_computes_and_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce"]) == 0
    assert "slender.table_2" in capsys.readouterr().out
    assert main(["reproduce", "slender.table_2", "--out", str(tmp_path), "--json"]) == 0
    (answer,) = json.loads(capsys.readouterr().out)["items"]
    assert answer["word"] == "in part" and len(answer["numbers"]) == 24
    assert (tmp_path / "slender.table_2.csv").read_text("utf-8").startswith("mode,Re omega,Im omega\n")
    with pytest.raises(TowageError, match="there is no such report, table or figure; slender has figures_1_to_5"):
        named(["slender.table_3"])
