"""The FMUs as a host sees them: every ``check_*`` of the programs, each program once, in a process of its own."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from .conftest import PROGRAMS, UNITS, Program

PROGRAM_NAMES = ("states", "errors", "instances", "hosts", "endurance")
SLOW = ("endurance",)
Results = Callable[[str], dict[tuple[str, str], str | None]]


def checks() -> list[Any]:
    """(program, check, unit), read from the programs."""
    found = []
    for name in PROGRAM_NAMES:
        marks = [pytest.mark.slow] if name in SLOW else []
        for node in ast.parse((PROGRAMS / f"{name}.py").read_text()).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("check_"):
                marked = [d.args for d in node.decorator_list if isinstance(d, ast.Call)]
                units = tuple(ast.literal_eval(a) for a in marked[0]) if marked else UNITS
                found += [pytest.param(name, node.name, unit, marks=marks) for unit in units]
    return found


@pytest.fixture(scope="module")
def results(fmus: Path, program: Program, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Failures of a program by check and unit; None where there was none."""

    @cache
    def run(name: str) -> dict[tuple[str, str], str | None]:
        lines = program(name, fmus, tmp_path_factory.mktemp("unpacked"), *UNITS).splitlines()
        return {(check, unit): failure for check, unit, failure in map(json.loads, lines)}

    return run


@pytest.mark.parametrize(("name", "check", "unit"), checks(), ids=lambda value: value.removeprefix("check_"))
def test_artefact(name: str, check: str, unit: str, results: Results) -> None:
    assert (check, unit) in results(name), "the check did not run"
    failure = results(name)[check, unit]
    assert failure is None, failure
