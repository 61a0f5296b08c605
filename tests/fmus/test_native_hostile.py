"""Hostile calls of the native sources under the address and undefined behaviour sanitizers (``host/fuzz.c``)."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from towage.fmus.declare.unit import Unit, load
from towage.fmus.native.trace import trace

from . import linear_example
from .cases import NATIVE
from .conftest import compiler_found
from .native_host import HOST, compile_c, write_sources

SANITIZERS = ("-std=c99", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")

LINEAR: dict[str, tuple[str, dict[str, float]]] = {
    "tow_system": ("tow_system", {"segments": 4.0, "extensible": 0.0}),
    "tow_system elastic": ("tow_system", {"segments": 4.0, "extensible": 1.0}),
    "tow_system, two states": ("tow_system", {"segments": 1.0, "extensible": 0.0}),
    "tow_cable": ("tow_cable", {"segments": 5.0}),
    "tow_cable, one node": ("tow_cable", {"segments": 2.0}),
    "slender_body": ("slender_body", {"flexible": 1.0, "shape_functions": 4.0}),
    "slender_body rigid": ("slender_body", {"flexible": 0.0}),
}
"""Unit and structure: few states, so that many runs begin in the time."""
EXAMPLE = "linear_example"
LARGE = ("voyage", "ship_in_sea", "playback")
SMALL = tuple(name for name in NATIVE if name not in (*LINEAR, *LARGE))


def usable(unit: Unit) -> Unit:
    """The unit with start values with which a run can begin: no start value, no step."""
    starts = {**unit.start, "axial_stiffness": 4e6}
    parameters, inputs = (
        tuple(replace(v, start=starts.get(v.name, v.start)) for v in group) for group in (unit.parameters, unit.inputs)
    )
    return replace(unit, parameters=parameters, inputs=inputs)


@pytest.fixture(scope="module")
def fuzz(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int, int], str]:
    """What the fuzzer prints for a unit, a seed and a number of calls."""
    if not compiler_found():
        pytest.skip("no C compiler")
    directory = tmp_path_factory.mktemp("fuzz")
    try:
        (directory / "empty.c").write_text("int main(void) { return 0; }\n")
        compile_c([directory / "empty.c"], directory / "empty", *SANITIZERS)
        subprocess.run([directory / "empty"], check=True, timeout=60)
    except (AssertionError, subprocess.CalledProcessError):
        pytest.skip("the C compiler has no address sanitizer")

    @cache
    def program(name: str) -> Path:
        base, structure = LINEAR.get(name, (name, {}))
        traced = trace(linear_example.UNIT if name == EXAMPLE else usable(load(base)), structure)
        sources = [*HOST.glob("fuzz*.c"), *write_sources(traced, directory / name)]
        return compile_c(sources, directory / f"fuzz_{name}", *SANITIZERS, f"-I{directory / name}")

    def run(name: str, seed: int, calls: int) -> str:
        done = subprocess.run(
            [program(name), str(seed), str(calls)], capture_output=True, text=True, timeout=1200,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr[-3000:]
        return done.stdout

    return run


def accepted(said: str) -> tuple[int, int]:
    """(calls, those that were accepted)"""
    words = said.split()
    return int(words[0]), int(words[2])


@pytest.mark.parametrize("seed", range(3))
def test_random_calls(seed: int, fuzz: Callable[[str, int, int], str]) -> None:
    calls, good = accepted(fuzz("cradle_on_line", seed, 10_000))
    assert calls == 10_000
    assert 0.2 < good / calls < 0.8, "all hostile or all harmless: the fuzzer finds nothing then"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 103))
@pytest.mark.parametrize("name", (*SMALL, EXAMPLE))
def test_many_random_calls(name: str, seed: int, fuzz: Callable[[str, int, int], str]) -> None:
    assert accepted(fuzz(name, seed, 300_000))[0] == 300_000


@pytest.mark.slow
@pytest.mark.parametrize("name", (*LINEAR, *LARGE))
def test_many_random_calls_of_larger_units(name: str, fuzz: Callable[[str, int, int], str]) -> None:
    calls, good = accepted(fuzz(name, 7, 100_000))
    assert calls == 100_000
    assert 0.2 < good / calls < 0.8
