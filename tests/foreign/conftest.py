"""FMUs of other makes, built as their makers have it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def hidden_mass(tmp_path_factory: pytest.TempPathFactory) -> dict[bool, Path]:
    """PythonFMU's, by whether its description offers to save and restore the state."""
    paths = {}
    for offers in (False, True):
        directory = tmp_path_factory.mktemp("pythonfmu")
        shutil.copy(HERE / "hidden_mass.py", directory)
        command = [sys.executable, "-m", "pythonfmu", "build", *(["--handle-state"] if offers else [])]
        subprocess.run([*command, "-f", "hidden_mass.py"], cwd=directory, check=True, capture_output=True, timeout=60)
        paths[offers] = directory / "HiddenMass.fmu"
    return paths


@pytest.fixture(scope="session")
def component_spring(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """component-model's; built in a process of its own, because it leaves its modules imported."""
    pytest.importorskip("component_model", reason="pip install component-model")
    directory = tmp_path_factory.mktemp("component_model")
    code = "import sys; from component_model.model import Model; Model.build(sys.argv[1], dest=sys.argv[2])"
    command = [sys.executable, "-c", code, str(HERE / "component_spring.py"), str(directory)]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return directory / "ComponentSpring.fmu"
