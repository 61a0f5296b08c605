"""The wheel works where there is no repository: installed in a new environment, it runs a scene in an empty directory."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from towage.fmus import UNITS

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_wheel_runs_a_scene_outside_the_repository(tmp_path):
    if not shutil.which("make"):
        pytest.skip("needs make")
    copy = tmp_path / "copy"  # building in the work tree would disturb it
    shutil.copytree(
        ROOT, copy, symlinks=True, ignore=shutil.ignore_patterns(".*", "__pycache__", "dist", "out", "build", "tests")
    )
    (copy / ".venv").mkdir()
    (copy / ".venv" / "created").touch()
    (copy / ".venv" / "installed").touch()
    subprocess.run(
        ["make", "-s", "wheel", f"BIN={Path(sys.executable).parent}"],
        cwd=copy, env=os.environ | {"PYTHONPATH": str(copy)}, check=True, timeout=300,
    )  # fmt: skip
    assert not (copy / "towage" / "shipped").exists(), "FMUs in the work tree would go stale"
    (wheel,) = (copy / "dist").glob("towage-*.whl")
    members = zipfile.ZipFile(wheel).namelist()
    assert {f"towage/shipped/{name}.fmu" for name in UNITS} <= set(members)
    runtime = "towage/fmus/native/runtime/core/unit.h"
    for member in ("towage/scenes/sea_cliff.toml", "towage/models/heave/cradle.py", runtime, "towage/py.typed"):
        assert member in members
    place = tmp_path / "new"
    venv.create(place, with_pip=True)
    wheel = wheel.rename(tmp_path / wheel.name)
    shutil.rmtree(copy)
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "TOWAGE", "VIRTUAL_ENV"))}
    pip = [place / "bin" / "python", "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    subprocess.run([*pip, wheel], env=clean, check=True, timeout=600)
    empty, cache = tmp_path / "empty", tmp_path / "cache"
    empty.mkdir()
    done = subprocess.run(
        [place / "bin" / "towage", "run", "sea_cliff"], cwd=empty, env=clean | {"TOWAGE_CACHE": str(cache)},
        check=True, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert "ship resonance, 3.92 s: invalid" in done.stdout
    assert (empty / "out" / "sea_cliff" / "report.html").stat().st_size > 10_000
    assert not (cache / "fmus").exists(), "the FMUs of the wheel were used, none was built"
