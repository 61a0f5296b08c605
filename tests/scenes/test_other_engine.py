"""The same FMUs in libcosim, whose fixed-step algorithm is our ``jacobi``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from towage.flavour import Flavour
from towage.master import Master
from towage.monolithic import dimensionless_scene

pytest.importorskip("libcosimpy")

PROGRAM = """
import json, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

job = json.load(sys.stdin)
log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_step_size(int(round(job["step"] * 1e9)))
index = {}
for name, unit in job["units"].items():
    index[name] = execution.add_local_slave(CosimLocalSlave(unit["path"], name))
    for reference, value in unit["start"]:
        execution.real_initial_value(index[name], reference, value)
for a, b, c, d in job["connections"]:
    execution.connect_real_variables(index[a], b, index[c], d)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
rows = []
for _ in range(job["steps"]):
    execution.step(1)
    rows.append([observer.last_real_values(index[name], [reference])[0] for name, reference in job["watch"]])
print(json.dumps(rows))
"""


@pytest.mark.parametrize("flavour", ["python", "native"])
def test_jacobi_equals_libcosim(flavour: Flavour, tmp_path: Path) -> None:
    """To round-off over 300 steps, ship, line and cradle coupled both ways."""
    import json

    if flavour == "native":
        pytest.importorskip("casadi")
    step, steps = 0.05, 300
    scene = dimensionless_scene(
        0.3,
        1.1,
        2.0,
        periods=steps * step * 1.1 / (2.0 * np.pi),
        coupling={"scheme": "jacobi", "step": step},
        ship={"mass": 10.0, "stiffness": 22.5, "damping": 1.5},
    )
    master = Master(scene, flavour=flavour)
    result = master.run()
    references = {
        name: {v.name: v.value_reference for v in unit.description.variables}
        for name, unit in master.resolved.units.items()
    }
    watch = ["cradle.heave", "line.tension", "ship.heave"]
    job = {
        "step": step,
        "steps": steps,
        "units": {
            name: {
                "path": str(unit.path),
                "start": [[references[name][p], float(v)] for p, v in unit.parameters.items()],
            }
            for name, unit in master.resolved.units.items()
        },
        "connections": [
            [c.source_unit, references[c.source_unit][c.source], c.target_unit, references[c.target_unit][c.target]]
            for c in master.resolved.connections
        ],
        "watch": [[name.split(".")[0], references[name.split(".")[0]][name.split(".")[1]]] for name in watch],
    }
    finished = subprocess.run(
        [sys.executable, "-c", PROGRAM], input=json.dumps(job), capture_output=True, text=True, cwd=tmp_path, check=True
    )
    rows = np.array(json.loads(finished.stdout.splitlines()[-1]))
    for k, name in enumerate(watch):
        ours = result[name][1 : steps + 1]
        scale = float(np.max(np.abs(ours)))
        assert np.max(np.abs(rows[: len(ours), k] - ours)) <= 1e-12 * scale, name
