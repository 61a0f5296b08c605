"""The FMUs as a host sees them: every ``check_*`` of the programs, each program once, in a process of its own."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest

from .conftest import PROGRAMS, UNITS, Program

CHECKED = ("states", "errors", "instances", "hosts")


def checks() -> list[tuple[str, str, str]]:
    """(program, check, unit), read from the programs."""
    found = []
    for name in CHECKED:
        for node in ast.parse((PROGRAMS / f"{name}.py").read_text()).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("check_"):
                marked = [d.args for d in node.decorator_list if isinstance(d, ast.Call)]
                units = tuple(ast.literal_eval(a) for a in marked[0]) if marked else UNITS
                found += [(name, node.name, unit) for unit in units]
    return found


@pytest.fixture(scope="module")
def results(
    fmus: Path, program: Program, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, dict[tuple[str, str], str]]:
    """Failures by check and unit, for every program that was run."""
    seen: dict[str, dict[tuple[str, str], str]] = {}
    for name in CHECKED:
        lines = program(name, fmus, tmp_path_factory.mktemp("unpacked"), *UNITS).splitlines()
        seen[name] = {(check, unit): failure for check, unit, failure in map(json.loads, lines)}
    return seen


@pytest.mark.parametrize(("name", "check", "unit"), checks(), ids=lambda value: value.removeprefix("check_"))
def test_artefact(name: str, check: str, unit: str, results: dict[str, dict[tuple[str, str], str]]) -> None:
    assert (check, unit) in results[name], "the check did not run"
    failure = results[name][check, unit]
    assert failure is None, failure
