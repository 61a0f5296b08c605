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
FLAVOURS = ("python", "native")
Results = Callable[[str, str], dict[tuple[str, str], str | None]]


def checks() -> list[Any]:
    """(flavour, program, check, unit), read from the programs."""
    found = []
    for name in PROGRAM_NAMES:
        marks = [pytest.mark.slow] if name in SLOW else []
        for node in ast.parse((PROGRAMS / f"{name}.py").read_text()).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("check_"):
                only = next((d for d in node.decorator_list if isinstance(d, ast.Call)), None)
                units = tuple(ast.literal_eval(a) for a in only.args) if only and only.args else UNITS
                flavours = [ast.literal_eval(k.value) for k in only.keywords] if only and only.keywords else FLAVOURS
                found += [pytest.param(f, name, node.name, unit, marks=marks) for f in flavours for unit in units]
    return found


@pytest.fixture(scope="module")
def results(flavours: Callable[[str], Path], program: Program, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Failures of a program by check and unit; None where there was none."""

    @cache
    def run(flavour: str, name: str) -> dict[tuple[str, str], str | None]:
        lines = program(name, flavours(flavour), tmp_path_factory.mktemp("unpacked"), *UNITS).splitlines()
        return {(check, unit): failure for check, unit, failure in map(json.loads, lines)}

    return run


@pytest.mark.parametrize(("flavour", "name", "check", "unit"), checks(), ids=lambda value: value.removeprefix("check_"))
def test_artefact(flavour: str, name: str, check: str, unit: str, results: Results) -> None:
    found = results(flavour, name)
    assert (check, unit) in found, "the check did not run"
    failure = found[check, unit]
    assert failure is None, failure
