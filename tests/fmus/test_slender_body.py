"""The units `slender_body` and `sway_craft`: what they refuse, what an FMU carries, and the native flavour beside Python."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path

import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.build import build
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError

REFUSED: dict[str, list[dict[str, float]]] = {
    "slender_body": [{"end_length": 0.1}, {"theory": 0.5}, {"tail_cut": 2.0}, {"shape_functions": 5.5}],
    "sway_craft": [{"speed_end": -1.0}, {"mass": 0.0}],
}


@pytest.mark.parametrize(("name", "values"), [(name, values) for name, each in REFUSED.items() for values in each])
def test_parameters_that_make_no_body_are_refused(name: str, values: dict[str, float]) -> None:
    unit = load(name)
    it = Instance(unit)
    it.set_values([unit.index[k] for k in values], list(values.values()))
    it.set_up(0.0, None)
    with pytest.raises(CallError, match=next(iter(values))):
        it.enter_initialization()
        it.exit_initialization()


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
