"""``towage new unit``: what it writes is a sound unit as it stands, in a checkout and as a package of its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.third_party.install import install
from towage import cli

ROOT = Path(__file__).parents[1]
SCENE = """title = "Winch"
stop_time = "20 s"
connections = []
[units.winch]
fmu = "odd_winch"
[units.winch.parameters]
displacement_start = "1 m"
[coupling]
step = "0.1 s"
"""


def run(command: Sequence[object], directory: Path, *paths: Path) -> str:
    """What a program prints that imports from ``paths`` first."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, paths))}
    done = subprocess.run(
        [sys.executable, *map(str, command)], cwd=directory, env=environment, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, f"{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done.stdout


def test_a_package_of_its_own_runs_in_a_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", "unit", "odd_winch", "--out", str(tmp_path)]) == 0
    assert "towage_odd_winch/unit.py" in capsys.readouterr().out
    package = tmp_path / "towage_odd_winch"
    project = tomllib.loads((package / "pyproject.toml").read_text("utf-8"))
    (point,) = project["project"]["entry-points"].items()
    assert point == ("towage.units", {"odd_winch": "towage_odd_winch.unit:UNIT"})
    install(
        tmp_path / "site", project["project"]["name"], {point[0]: "odd_winch = towage_odd_winch.unit:UNIT"},
        package / "towage_odd_winch",
    )  # fmt: skip
    (tmp_path / "scene.toml").write_text(SCENE, "utf-8")
    assert "odd_winch" in run(["-m", "towage", "list"], tmp_path, tmp_path / "site")
    shown = run(["-m", "towage", "run", "scene.toml", "--flavour", "python"], tmp_path, tmp_path / "site")
    assert "Winch: valid" in shown, shown


def copied(directory: Path) -> Path:
    """The sources of this work tree, with nothing of its own units listed."""
    for name in ("models", "fmus", "towage", "tests"):
        shutil.copytree(ROOT / name, directory / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__", "shipped"))
    for name in ("build_fmus.py", "pyproject.toml"):
        shutil.copy(ROOT / name, directory)
    return directory


def test_in_a_checkout_it_becomes_a_unit_of_the_project(tmp_path: Path) -> None:
    tree = copied(tmp_path)
    run(["-m", "towage", "new", "unit", "odd_winch"], tree, tree)
    assert "odd_winch" in run(["-m", "towage", "list"], tree, tree)
    run(["build_fmus.py", "odd_winch", "--out", tmp_path / "dist"], tree, tree)
    code = "import sys, fmpy.validation as v; print(v.validate_fmu(sys.argv[1]))"
    assert run(["-c", code, tmp_path / "dist" / "odd_winch.fmu"], tmp_path).strip() == "[]"
    run(["-m", "ruff", "check", "models/odd_winch.py", "fmus/odd_winch.py", "fmus/__init__.py"], tree)


@pytest.mark.slow
def test_it_passes_the_tests_of_artefacts(tmp_path: Path) -> None:
    tree = copied(tmp_path)
    run(["-m", "towage", "new", "unit", "odd_winch"], tree, tree)
    # two more, whose states the tests offer to it; the others are tested elsewhere
    (tree / "fmus" / "__init__.py").write_text('UNITS = ("ship", "cradle", "odd_winch")\n', "utf-8")
    run(["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/fmus/test_artefact.py"], tree, tree)


@pytest.mark.parametrize(
    ("name", "said"),
    [("2fast", "cannot name a unit"), ("class", "cannot name a unit"), ("ship", "there is a unit 'ship' already")],
)
def test_names_that_cannot_be_are_refused(
    name: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "unit", name, "--out", str(tmp_path)]) == 3
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", "unit", "winch", "--out", str(tmp_path)]) == 0
    assert cli.main(["new", "unit", "winch", "--out", str(tmp_path)]) == 3
    assert "exists already" in capsys.readouterr().err
