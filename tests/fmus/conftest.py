"""FMUs built once, and programs that run without the work tree."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict
from functools import cache
from pathlib import Path

import pytest

from tests.sharing import once, shared_directory
from towage.fmus.python.build import build

from .cases import CASES, NATIVE, UNITS

PROGRAMS = Path(__file__).parent / "programs"
FLAVOURS = {"python": UNITS, "native": NATIVE}
"""Units of each flavour."""
Program = Callable[..., str]


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory with the FMUs of this work tree."""

    def make(directory: Path) -> None:
        for name in UNITS:
            build(name, directory)

    return once(shared_directory(tmp_path_factory) / "fmus", make)


@pytest.fixture(scope="session")
def native(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], Path]:
    """Builds the native FMU of a unit for FMI 2 or 3, once; its path."""
    if not compiler_found():
        pytest.skip("no C compiler")
    from towage.fmus.native import build as native_fmu

    directory = shared_directory(tmp_path_factory) / "native"

    @cache
    def built(name: str, fmi: int) -> Path:
        once(directory / f"fmi{fmi}_{name}", lambda _: native_fmu.build(name, directory / f"fmi{fmi}", fmi))
        return directory / f"fmi{fmi}" / f"{name}.fmu"

    return built


@pytest.fixture(scope="session")
def flavours(fmus: Path, request: pytest.FixtureRequest) -> Callable[[str], Path]:
    """The directory with the FMUs (FMI 2) of a flavour."""

    def directory(flavour: str) -> Path:
        if flavour == "python":
            return fmus
        paths = [request.getfixturevalue("native")(name, 2) for name in NATIVE]
        return Path(paths[0]).parent

    return directory


def compiler_found() -> bool:
    """Whether native FMUs can be built here."""
    return shutil.which("cc") is not None or importlib.util.find_spec("ziglang") is not None


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Program:
    """Runs one of `PROGRAMS` on its own: isolated mode, elsewhere, a copy with the cases beside it, so that nothing of the
    work tree is found; returns what it printed."""

    def run(name: str, *arguments: object, stdin: str = "") -> str:
        directory = tmp_path_factory.mktemp(name)
        for file in PROGRAMS.glob("*.py"):
            shutil.copy(file, directory)
        (directory / "cases.json").write_text(json.dumps({unit: asdict(case) for unit, case in CASES.items()}))
        done = subprocess.run(
            [sys.executable, "-I", str(directory / f"{name}.py"), *map(str, arguments)],
            cwd=directory, env={"TMPDIR": str(directory)}, input=stdin, capture_output=True, text=True, timeout=900,
        )  # fmt: skip
        assert done.returncode == 0, (
            f"{name} ended with {done.returncode}:\n{done.stdout[-2000:]}\n{done.stderr[-3000:]}"
        )
        return done.stdout

    return run
