"""Hostile calls of the native sources under the address and undefined behaviour sanitizers (``host/fuzz.c``)."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from .conftest import compiler_found
from .hostile import EXAMPLE, LARGE, LINEAR, SANITIZERS, SMALL, has_sanitizers, program


@pytest.fixture(scope="module")
def fuzz(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int, int], str]:
    """What the fuzzer prints for a unit, a seed and a number of turns."""
    if not compiler_found():
        pytest.skip("no C compiler")
    directory = tmp_path_factory.mktemp("fuzz")
    if not has_sanitizers(directory):
        pytest.skip("the C compiler has no address sanitizer")

    @cache
    def made(name: str) -> Path:
        return program(name, directory, *SANITIZERS)[0]

    def run(name: str, seed: int, turns: int) -> str:
        done = subprocess.run(
            [made(name), str(seed), str(turns)], capture_output=True, text=True, timeout=1200,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr[-3000:]
        return done.stdout

    return run


def accepted(said: str) -> tuple[int, int]:
    """(turns, calls that were accepted)"""
    words = said.split()
    return int(words[0]), int(words[4])


@pytest.mark.parametrize("seed", range(3))
def test_random_calls(seed: int, fuzz: Callable[[str, int, int], str]) -> None:
    turns, good = accepted(fuzz("cradle_on_line", seed, 10_000))
    assert turns == 10_000
    assert 0.2 < good / turns < 0.8, "all hostile or all harmless: the fuzzer finds nothing then"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 103))
@pytest.mark.parametrize("name", (*SMALL, EXAMPLE))
def test_many_random_calls(name: str, seed: int, fuzz: Callable[[str, int, int], str]) -> None:
    assert accepted(fuzz(name, seed, 300_000))[0] == 300_000


@pytest.mark.slow
@pytest.mark.parametrize("name", (*LINEAR, *LARGE))
def test_many_random_calls_of_larger_units(name: str, fuzz: Callable[[str, int, int], str]) -> None:
    turns, good = accepted(fuzz(name, 7, 100_000))
    assert turns == 100_000
    assert 0.2 < good / turns < 0.8
