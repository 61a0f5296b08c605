"""Cross-compiled FMUs: a library for every platform, which exports the standard's functions and nothing else. Those of Windows
and of Linux on 64-bit Arm run under emulators; no test of this project runs on macOS.
"""

from __future__ import annotations

import importlib.util
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from towage.fmus.native.build import build

from .cases import NATIVE
from .exported import exports
from .platforms import EMULATED, SMALL, Emulation, difference, here

FOLDERS = {
    2: {"linux64", "aarch64-linux", "win64", "darwin64"},
    3: {"x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-darwin", "aarch64-darwin"},
}
FUNCTIONS = {2: 44, 3: 75}
"""Numbers of functions in FMI 2.0 and 3.0 for co-simulation and model exchange, as in the standard's headers."""
LINKER = {"_mh_dylib_header", "__dso_handle"}
"""Names that the Mach-O linker itself defines."""


ZIG = pytest.mark.skipif(
    importlib.util.find_spec("ziglang") is None, reason="needs the ziglang wheel: pip install towage[native]"
)
ROUNDING = {"tow_cable": 5e-8}
"""As in `test_native_host`: what roundings, here of other elementary functions, become in an elastic cable. Others: 1e-10."""


@pytest.mark.slow
@ZIG
@pytest.mark.parametrize("fmi", [2, 3])
def test_every_platform_exports_the_standard_and_nothing_else(fmi: int, tmp_path: Path) -> None:
    path, _ = build("cradle", tmp_path, fmi=fmi, platforms="all")
    with zipfile.ZipFile(path) as archive:
        libraries = {Path(n).parent.name: archive.read(n) for n in archive.namelist() if n.startswith("binaries/")}
    assert set(libraries) == FOLDERS[fmi]
    for folder, library in libraries.items():
        if "linux" in folder:
            continue  # `test_native_build` reads those
        slices = exports(library)
        assert len(slices) == (2 if folder == "darwin64" else 1)
        for names in slices:
            assert {n for n in names if not n.startswith(f"fmi{fmi}")} <= LINKER
            assert len([n for n in names if n.startswith(f"fmi{fmi}")]) == FUNCTIONS[fmi]


@pytest.fixture(scope="module")
def emulation(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Emulation]:
    @cache
    def started(platform: str) -> Emulation:
        try:
            return Emulation(platform, tmp_path_factory.mktemp(platform))
        except LookupError as missing:
            pytest.skip(str(missing))

    return started


@pytest.mark.slow
@ZIG
@pytest.mark.skipif(sys.platform != "linux", reason="emulators of Linux")
@pytest.mark.parametrize("platform", EMULATED)
@pytest.mark.parametrize("name", NATIVE)
def test_other_platforms_give_the_same_numbers(
    name: str, platform: str, emulation: Callable[[str], Emulation], tmp_path: Path
) -> None:
    there = emulation(platform)
    fmus = {fmi: build(name, tmp_path / str(fmi), fmi, structure=SMALL.get(name))[0] for fmi in (2, 3)}
    found = {fmi: there.rows(fmu, fmi) for fmi, fmu in fmus.items()}
    assert np.array_equal(found[2], found[3])
    assert difference(here(fmus[2], 2, tmp_path), found[2]) <= ROUNDING.get(name, 1e-10)
    there.rows(fmus[2], 2, "states")  # the program compares them to the last bit
