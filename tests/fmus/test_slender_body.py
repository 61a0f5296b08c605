"""The FMUs `slender.body` and `sway_craft` as artefacts, in a process that cannot import the work tree."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.build import build
from towage.fmus.python.instance import Instance

PROGRAM = """
import json, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

path, work, values = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
assert not any(name.split(".")[0] in ("towage", "models", "fmus") for name in sys.modules)
problems = validate_fmu(path)
description = read_model_description(path)
reference = {v.name: v.valueReference for v in description.modelVariables}
outputs = [v.valueReference for v in description.modelVariables if v.causality == "output"]
directory = extract(path, work)

def make(name, change):
    it = FMU2Slave(guid=description.guid, unzipDirectory=directory,
                   modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
    it.instantiate(loggingOn=False)
    for key, value in (values["start"] | change).items():
        it.setReal([reference[key]], [value])
    it.setupExperiment(startTime=0.0)
    it.enterInitializationMode()
    it.exitInitializationMode()
    return it

def run(it, first, count):
    rows = []
    for k in range(first, first + count):
        for key, slope in values["slopes"].items():
            it.setReal([reference[key], reference[key + "_d1"]], [values["start"].get(key, 0.0) + slope * 0.1 * k, slope])
        it.doStep(0.1 * k, 0.1)
        rows.append(it.getReal(outputs))
    return rows

it = make("a", {})
rows = run(it, 0, 10)
state = it.getFMUState()
first = run(it, 10, 10)
it.setFMUState(state)
again = run(it, 10, 10)
it.setFMUState(state)
serialized = it.serializeFMUstate(state)
other = make("b", {})
other.setFMUState(other.deSerializeFMUstate(serialized))
third = run(other, 10, 10)
refused = []
for change in values["bad"]:
    try:
        make("c", change)
        refused.append("accepted")
    except Exception as error:
        refused.append(type(error).__name__)
step = "none"
if "tow_speed_d1" in reference:
    it.setReal([reference["tow_speed"], reference["tow_speed_d1"]], [-1.0, 0.0])
    try:
        it.doStep(1.0, 0.1)
        step = "accepted"
    except Exception as error:
        step = type(error).__name__
print(json.dumps({"problems": problems, "rows": rows + first, "rollback": first == again, "serialized": first == third,
                  "refused": refused, "negative_speed": step}))
"""
CASES: dict[str, dict[str, Any]] = {
    "slender_body": {
        "start": {"tow_speed": 2.0, "yaw_start": 0.01, "craft_lateral": 0.0},
        "slopes": {"tow_speed": 0.075, "craft_lateral": 0.05},
        "bad": [{"end_length": 0.1}, {"theory": 0.5}, {"tail_cut": 2.0}, {"shape_functions": 5.5}],
    },
    "sway_craft": {
        "start": {"mass": 2e3, "speed_end": 3.0, "speed_change_time": 2.0},
        "slopes": {"lateral_force": 100.0},
        "bad": [{"speed_end": -1.0}, {"mass": 0.0}],
    },
}


def instance_rows(name: str, case: dict[str, Any]) -> list[list[float]]:
    """The same run of the unit without FMI."""
    unit = load(name)
    it = Instance(unit)
    it.set_values([unit.index[k] for k in case["start"]], list(case["start"].values()))
    it.set_up(0.0, None)
    it.enter_initialization()
    it.exit_initialization()
    outputs = [i for i, v in enumerate(unit.variables) if v.causality == "output"]
    rows = []
    for k in range(20):
        for key, slope in case["slopes"].items():
            start = case["start"].get(key, 0.0)
            it.set_values([unit.index[key], unit.index[f"{key}_d1"]], [start + slope * 0.1 * k, slope])
        it.do_step(0.1 * k, 0.1)
        rows.append(it.get_values(outputs))
    return rows


@pytest.mark.parametrize("name", sorted(CASES))
def test_fmu_equals_the_model_and_rolls_back(name: str, tmp_path: Path) -> None:
    """fmpy finds no fault; outputs, a restored and a serialised state are equal to the last bit; bad values are refused."""
    path, _ = build(name, tmp_path)
    case = CASES[name]
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(path), str(tmp_path / "unpacked"), json.dumps(case)], capture_output=True,
        text=True, cwd=tmp_path, env=environment, timeout=240, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["problems"] == []
    assert found["rows"] == instance_rows(name, case)
    assert found["rollback"]
    assert found["serialized"]
    assert "accepted" not in found["refused"]
    assert found["negative_speed"] != "accepted"


def test_two_builds_are_byte_identical_and_carry_only_their_models(tmp_path: Path) -> None:
    first, second = (build("slender_body", tmp_path / folder)[0] for folder in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        models = {name.rsplit("/", 1)[-1] for name in archive.namelist() if "/models/" in name}
    assert "modes.py" in models
    assert not models & {"cradle.py", "ship.py", "critical.py", "series.py"}


@pytest.mark.parametrize("flexible", [0.0, 1.0])
def test_a_refused_step_leaves_the_instance_as_it_was(flexible: float) -> None:
    unit = load("slender_body")
    it = Instance(unit)
    it.set_values([unit.index["flexible"], unit.index["tow_speed"]], [flexible, 2.0])
    it.set_up(0.0, None)
    it.enter_initialization()
    it.exit_initialization()
    it.do_step(0.0, 0.1)
    before = it.state()
    it.set_values([unit.index["tow_speed"]], [-1.0])
    with pytest.raises(Exception, match="towed nose first"):
        it.do_step(0.1, 0.1)
    it.set_values([unit.index["tow_speed"]], [2.0])
    it.do_step(0.1, 0.1)
    after = it.get_values([unit.index["tail"]])
    it.restore(before)
    it.do_step(0.1, 0.1)
    assert it.get_values([unit.index["tail"]]) == after


@pytest.mark.parametrize("flexible", [0.0, 1.0])
def test_native_flavour_steps_as_the_python_flavour(flexible: float, tmp_path: Path) -> None:
    """Every theory, sway and a ramp of speed, with what is found at the start: resolved speed, scales; refusals."""
    pytest.importorskip("casadi")
    from towage.fmus.native.trace import trace

    from .native_instance import DONE, NO_STEP, REFUSED, NativeInstance, unit_library

    unit = load("slender_body")
    traced = trace(unit, {"flexible": flexible})
    library = unit_library(traced, tmp_path)
    names = [v.name for v in (*unit.calculated, *unit.observed)]
    for theory in (0.0, 1.0, 2.0):
        start = {
            "flexible": flexible, "theory": theory, "tow_speed": 2.0, "yaw_start": 0.01, "lateral_start": 0.1,
            "rope_length": 7.0, "tail_cut": 0.7, "structural_damping": 0.5, "tail_factor": 0.8,
        }  # fmt: skip
        native, it = NativeInstance(library, traced, **start), Instance(unit)
        assert native.initialized == DONE
        it.set_values([unit.index[k] for k in start], list(start.values()))
        it.enter_initialization()
        it.exit_initialization()
        references = [unit.index[n] for n in names]
        largest = [abs(v) for v in it.get_values(references)]
        for k in range(60):
            slope = 0.05 if k >= 20 else 0.0
            inputs = {
                "tow_speed": 2.0 + 0.1 * slope * max(0, k - 20), "tow_speed_d1": slope,
                "craft_lateral": 0.1 * math.sin(0.05 * k), "craft_lateral_d1": 0.05 * math.cos(0.05 * k),
            }  # fmt: skip
            assert native.set(**inputs) == DONE
            it.set_values([unit.index[n] for n in inputs], list(inputs.values()))
            assert native.step(0.1 * k, 0.1) == DONE
            it.do_step(0.1 * k, 0.1)
            wanted = it.get_values(references)
            largest = [max(a, abs(b)) for a, b in zip(largest, wanted)]
            # eigenvalues to 1e-16 of the largest, 1e4 times the growth rate: 1e-11; all else is better than 1e-12
            for name, a, b, size in zip(names, native.get(*names), wanted, largest):
                assert a == pytest.approx(b, abs=1e-10 * size), name
        assert native.set(tow_speed=-1.0, tow_speed_d1=0.0) == DONE
        assert native.step(6.0, 0.1) == NO_STEP
    for bad in ({"end_length": 0.1}, {"theory": 0.5}, {"theory": 2.0, "tail_factor": 3.0}):
        assert NativeInstance(library, traced, **({"flexible": flexible} | bad)).initialized == REFUSED
