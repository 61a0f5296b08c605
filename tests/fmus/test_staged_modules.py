"""What a Python FMU carries: every module in it is reached by its model's functions, and nothing heavy is loaded for a type."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest

from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.fmus.python.build import build

RUN = """
import json, sys
sys.path.insert(0, sys.argv[1])
script, start, inputs = json.loads(sys.argv[2])
module = __import__(script)
loaded = sorted(sys.modules)
unit = script.removesuffix("_fmu").rpartition("_")[0]
it = getattr(module, unit)(instance_name="it", resources=sys.argv[1]).instance
index = it.unit.index
it.set_values([index[n] for n in start], list(start.values()))
it.set_up(0.0, None); it.enter_initialization(); it.exit_initialization()
for k in range(3):
    it.set_values([index[n] for n in inputs], [0.1] * len(inputs))
    it.do_step(0.1 * k, 0.1)
    it.get_values(list(range(len(it.values))))
it.restore(it.state())
print(json.dumps([loaded, sorted(sys.modules)]))
"""
"""As the bridge imports it, in an interpreter that finds nothing but the unpacked FMU; then a short run."""


@pytest.fixture(scope="module", params=UNITS)
def seen(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    unit, directory = load(request.param), tmp_path_factory.mktemp(request.param)
    with zipfile.ZipFile(build(unit.name, directory)[0]) as archive:
        archive.extractall(directory)
    resources = directory / "resources"
    script = (resources / "slavemodule.txt").read_text().strip()
    given = json.dumps([script, dict(unit.start), list(unit.reference_inputs)])
    done = subprocess.run(
        [sys.executable, "-I", "-c", RUN, str(resources), given], capture_output=True, text=True, cwd=directory, timeout=120
    )
    assert done.returncode == 0, done.stderr
    at_import, after = json.loads(done.stdout)
    package = script.removesuffix("_fmu")
    files = (path.relative_to(resources).with_suffix("") for path in (resources / package).rglob("*.py"))
    staged = {".".join(path.parts).removesuffix(".__init__") for path in files}
    own = {name for name in after if name == package or name.startswith(f"{package}.")}
    return {"unit": unit.name, "staged": staged, "reached": own, "import": at_import}


def test_an_fmu_carries_exactly_what_its_model_reaches(seen: dict[str, Any]) -> None:
    assert seen["staged"] == seen["reached"]


def test_import_loads_no_solver(seen: dict[str, Any]) -> None:
    """Solvers come with the first tow that is solved; a scalar unit needs no numpy at all."""
    assert not [name for name in seen["import"] if name.startswith("scipy")]
    arrays = seen["unit"].startswith("tow_") or seen["unit"] in ("slender_body", "wire")
    assert ("numpy" in seen["import"]) == arrays
    assert "casadi" not in seen["import"]


def test_staging_follows_what_is_executed() -> None:
    """A module that stands for type checkers alone is not carried."""
    from towage.fmus.python.build import staged_modules

    assert "models/protocol/model.py" in staged_modules("cradle")
    assert "models/protocol/linear_model.py" not in staged_modules("cradle")
    assert Path("models/protocol/linear_model.py").as_posix() in staged_modules("tow_system")
