"""Exported scenes in libcosim, whose fixed-step algorithm is our ``jacobi``.

libcosim runs in a process of its own, because a crash there would end the tests. It reads what ``towage export`` wrote and
nothing else: values, connections and the step come from the files.
"""

from __future__ import annotations

import functools
import json
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

from towage.export import prepare
from towage.export_osp import write_osp
from towage.export_ssp import write_ssp
from towage.flavour import Flavour, resolve
from towage.master import Master
from towage.result import Result
from towage.scene import Checks, Coupling, Record, Scene, available_scenes

pytest.importorskip("libcosimpy")

PROGRAM = """
import json, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

job = json.load(sys.stdin)
log_output_level(CosimLogLevel.ERROR)
make = CosimExecution.from_osp_config_file if job["kind"] == "osp" else CosimExecution.from_ssp_file
execution = make(job["path"])
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
watched = {execution.slave_index_from_instance_name(name): list(v.values()) for name, v in job["watch"].items()}
rows = []
for _ in range(job["steps"]):
    assert execution.step(1), "libcosim refused a step"
    rows.append([value for index, names in watched.items() for value in observer.last_real_values(index, names)])
print(json.dumps([execution.status().current_time, rows]))
"""
ROUND_OFF = 1e-12
"""Relative to a variable's largest value: both engines do the same operations, only times differ by a rounding."""
STEPS = 30
LONG = 200
LOOSE_STEP = 0.1
"""Step, s, of scenes that leave theirs to the error control."""


def test_jacobi_equals_libcosim_osp(tmp_path: Path) -> None:
    """Ship, line and cradle coupled both ways, their ports as group connections."""
    compare(short("sea_cliff", STEPS), "python", "osp", tmp_path)


def test_jacobi_equals_libcosim_ssp(tmp_path: Path) -> None:
    """A system with velocities on its ports, from an SSP archive with the step in its annotation."""
    compare(short("tow_600ft", STEPS), "python", "ssp", tmp_path)


def test_jacobi_equals_libcosim_native(tmp_path: Path) -> None:
    """FMUs without Python."""
    pytest.importorskip("casadi")
    compare(short("sea_cliff", STEPS), "native", "osp", tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["osp", "ssp"])
@pytest.mark.parametrize("flavour", ["python", "native"])
@pytest.mark.parametrize("name", [scene.name for scene in available_scenes()])
def test_jacobi_equals_libcosim_everywhere(name: str, flavour: Flavour, kind: str, tmp_path: Path) -> None:
    """Every shipped scene; units that have no native flavour run in Python."""
    if flavour == "native":
        pytest.importorskip("casadi")
    compare(short(name, LONG), flavour, kind, tmp_path)


def compare(scene: Scene, flavour: Flavour, kind: str, directory: Path) -> None:
    """Every output of every unit, at every step."""
    ours, theirs = run(scene, "jacobi", flavour), libcosim(scene, flavour, kind, directory)
    for name, values in theirs.items():
        expected = ours[name][1:]
        scale = float(np.max(np.abs(expected)))
        assert len(values) == len(expected)
        assert np.max(np.abs(values - expected)) <= ROUND_OFF * scale, name


def short(name: str, steps: int) -> Scene:
    """The first steps of a shipped scene, with all its outputs recorded and nothing judged."""
    scene = Scene.load(name)
    step = scene.coupling.step or LOOSE_STEP
    coupling = Coupling(scene.coupling.scheme, step, error_estimate=False)
    return msgspec.structs.replace(
        scene,
        coupling=coupling,
        stop_time=steps * step,
        record=Record(interval=step),
        checks=Checks(),
        cases=(),
    )


def run(scene: Scene, scheme: str, flavour: Flavour, share: float = 1.0) -> Result:
    """In our master, with ``share`` of the step."""
    step = (scene.coupling.step or 0.0) * share
    coupling = msgspec.structs.replace(scene.coupling, scheme=scheme, step=step)  # type: ignore[arg-type]
    result = Master(msgspec.structs.replace(scene, coupling=coupling), None, None, flavour).run()
    assert result.status == "done", result.message
    return result


def libcosim(scene: Scene, flavour: Flavour, kind: str, directory: Path) -> dict[str, np.ndarray]:
    """All Real outputs at the end of every step."""
    resolved = resolve(scene, flavour=flavour)
    export = prepare(resolved)
    path = directory / "scene.ssp" if kind == "ssp" else directory
    if kind == "ssp":
        write_ssp(export, path)
    else:
        write_osp(export, path)
    steps = round(scene.stop_time / export.step)
    watch: dict[str, dict[str, int]] = {}
    for unit, name in resolved.record:
        watch.setdefault(unit, {})[name] = export.variable(unit, name).value_reference
    job = {"kind": kind, "path": str(path), "steps": steps, "watch": watch}
    finished = subprocess.run(
        [sys.executable, "-c", PROGRAM], input=json.dumps(job), capture_output=True, text=True, cwd=directory, timeout=600
    )
    assert finished.returncode == 0, finished.stdout[-2000:] + finished.stderr[-2000:]
    ticks, rows = json.loads(finished.stdout.splitlines()[-1])
    assert ticks == steps * round(export.step * 1e9)
    names = [f"{unit}.{name}" for unit, names in watch.items() for name in names]
    return dict(zip(names, np.array(rows).T, strict=True))
