"""Cross-compiled FMUs: a library for every platform, which exports the standard's functions and nothing else.

They are built and read here, not run: no test of this project runs on Windows or macOS.
"""

from __future__ import annotations

import importlib.util
import zipfile
from pathlib import Path

import pytest

from towage.fmus.native.build import build

from .exported import exports

FOLDERS = {2: {"linux64", "win64", "darwin64"}, 3: {"x86_64-linux", "x86_64-windows", "x86_64-darwin", "aarch64-darwin"}}
FUNCTIONS = {2: 44, 3: 75}
"""Numbers of functions in FMI 2.0 and 3.0 for co-simulation and model exchange, as in the standard's headers."""
LINKER = {"_mh_dylib_header", "__dso_handle"}
"""Names that the Mach-O linker itself defines."""


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="needs the ziglang wheel: pip install towage[native]")
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
