"""The FMUs as a host sees them: every ``check_*`` of the programs, each program once, in a process of its own."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from .conftest import FLAVOURS, PROGRAMS, Program

PROGRAM_NAMES = ("states", "errors", "instances", "hosts", "endurance")
SLOW = ("endurance",)
Results = Callable[[str, str], dict[tuple[str, str], str | None]]


def checks() -> list[Any]:
    """(flavour, program, check, unit), read from the programs."""
    listed = []
    for name in PROGRAM_NAMES:
        for node in ast.parse((PROGRAMS / f"{name}.py").read_text()).body:
            if not (isinstance(node, ast.FunctionDef) and node.name.startswith("check_")):
                continue
            only = next((d for d in node.decorator_list if isinstance(d, ast.Call)), ast.Call(ast.Name("only"), [], []))
            units = [ast.literal_eval(a) for a in only.args]
            flavours = [ast.literal_eval(k.value) for k in only.keywords] or FLAVOURS
            for flavour in flavours:
                listed += [
                    pytest.param(
                        flavour, name, node.name, unit, marks=[pytest.mark.slow] * (name in SLOW),
                        # pytest-xdist takes what is before the colons for a scope, and runs it in one process
                        id=f"{flavour}-{name}::{node.name.removeprefix('check_')}-{unit}",
                    )
                    for unit in FLAVOURS[flavour] if not units or unit in units
                ]  # fmt: skip
    return listed


@pytest.fixture(scope="module")
def results(flavours: Callable[[str], Path], program: Program, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Failures of a program by check and unit; None where there was none."""

    @cache
    def run(flavour: str, name: str) -> dict[tuple[str, str], str | None]:
        lines = program(name, flavours(flavour), tmp_path_factory.mktemp("unpacked"), *FLAVOURS[flavour]).splitlines()
        return {(check, unit): failure for check, unit, failure in map(json.loads, lines)}

    return run


@pytest.mark.parametrize(("flavour", "name", "check", "unit"), checks())
def test_artefact(flavour: str, name: str, check: str, unit: str, results: Results) -> None:
    outcomes = results(flavour, name)
    assert (check, unit) in outcomes, "the check did not run"
    failure = outcomes[check, unit]
    assert failure is None, failure
