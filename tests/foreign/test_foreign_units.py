"""Scenes with FMUs that know nothing of towage: no rates, no units of measure, no way back, variables of other types."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.errors import SceneError
from towage.master.master import run_resolved
from towage.process.worker import run_isolated
from towage.result.result import Result
from towage.scene.flavour import resolve
from towage.scene.scene import Scene

from .units import hostile

STOP = 4.0
STEP = 0.02
CRUDE = 6e-4
"""Signals are straight lines, an error of second order; measured 1.0e-4 (hermite) and 2.6e-4 (extrapolate), four times as
much at twice the step."""
BACK_AND_FORTH = ["a.y -> b.u", "b.y -> a.u"]
ON_SPRING = ["mass.position -> spring.end[0]", "spring.pull[0] -> mass.force"]


def scene(units: dict[str, dict[str, Any]], connections: list[str], **coupling: object) -> Scene:
    """A scene of these units."""
    tables: dict[str, Any] = {
        "title": "Foreign units",
        "stop_time": STOP,
        "connections": connections,
        "units": units,
        "coupling": {"step": STEP, "error_estimate": False, **coupling},
    }
    return Scene.from_dict(tables)


def run(units: dict[str, dict[str, Any]], connections: list[str], **coupling: object) -> Result:
    """The result of such a scene, which comes to its end."""
    result = run_isolated(resolve(scene(units, connections, **coupling)))
    assert result.status == "done", result.message
    return result


def rotating(directory: Path, rollback: bool, **parameters: object) -> dict[str, dict[str, Any]]:
    """a' = -b, b' = a by the plain C unit: a = cos t."""
    fmu = str(hostile(directory / "plain.fmu", rollback=rollback))
    return {"a": {"fmu": fmu, "parameters": {"gain": -1.0, "x0": 1.0, **parameters}}, "b": {"fmu": fmu}}


@pytest.mark.parametrize(("rollback", "scheme"), [(True, "hermite"), (False, "extrapolate")])
def test_plain_c_units_run_and_the_scheme_is_stated(tmp_path: Path, rollback: bool, scheme: str) -> None:
    result = run(rotating(tmp_path, rollback), BACK_AND_FORTH)
    assert result.scheme == scheme
    told = next(check.message for check in result.checks if check.name == "scheme")
    assert told.startswith(f"auto: {scheme}, because ")
    assert ("a, b cannot save and restore the state" in told) != rollback
    assert result["a.y"] == pytest.approx(np.cos(result.time), abs=CRUDE)
    assert result.flavours == {"a": "by hand", "b": "by hand"}
    assert set(result.columns) == {f"{unit}.{name}" for unit in "ab" for name in ("y", "steps", "moving")}
    assert set(result.texts) == {"a.word", "b.word"}


def test_parameters_of_all_types_reach_the_unit(tmp_path: Path) -> None:
    """gain -1, factor 4 and reversed: a' = 4 b, where b' = -a."""
    units = rotating(tmp_path, True, factor=4, reversed=True, label="aft winch")
    units["b"]["parameters"] = {"gain": -1.0}
    result = run(units, BACK_AND_FORTH)
    assert result["a.y"] == pytest.approx(
        np.cos(2.0 * result.time), abs=4.0 * CRUDE
    )  # second order: twice the frequency


@pytest.mark.parametrize(
    ("parameter", "value", "says"),
    [("factor", 1.5, "no Integer"), ("factor", -1, "out of range"), ("reversed", 1, "no Boolean"), ("label", 3, "no String"),
     ("gain", "1 m", "declares no unit")],
)  # fmt: skip
def test_values_of_another_type_are_refused(tmp_path: Path, parameter: str, value: object, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        run(rotating(tmp_path, True, **{parameter: value}), BACK_AND_FORTH)


@pytest.mark.parametrize("end", ["b.factor", "b.steps"])
def test_signals_of_other_types_are_refused(tmp_path: Path, end: str) -> None:
    with pytest.raises(SceneError, match=r"expected an input|expected an output|joins|only Real"):
        run(rotating(tmp_path, True), ["a.steps -> b.u" if end == "b.steps" else f"a.y -> {end}"])


def test_pythonfmu_with_hidden_state_is_caught(tmp_path: Path, hidden_mass: dict[bool, Path]) -> None:
    """Its description offers the state; what it keeps back would falsify every corrector step."""
    units = {"mass": {"fmu": str(hidden_mass[True])}, "b": {"fmu": str(hostile(tmp_path / "plain.fmu"))}}
    units["b"]["parameters"] = {"x0": 1.0}  # type: ignore[assignment]
    connections = ["b.y -> mass.force"]
    with pytest.raises(AssertionError, match=r"mass\.position, t = .*does not restore its state.*'extrapolate'"):
        run(units, connections, scheme="hermite")
    for offers in (True, False):
        units["mass"]["fmu"] = str(hidden_mass[offers])
        result = run(units, connections, scheme="extrapolate", events=False)
        assert result["mass.position"] == pytest.approx(
            1.0 + 0.5 * result.time**2, rel=1e-12
        )  # a constant force is exact


def test_component_model_and_pythonfmu_together(hidden_mass: dict[bool, Path], component_spring: Path) -> None:
    """A mass on a spring, neither of which declares dependencies: the scene has to say that the loop has a state."""
    units = {"mass": {"fmu": str(hidden_mass[False])}, "spring": {"fmu": str(component_spring)}}
    with pytest.raises(SceneError, match=r"algebraic loop .*count as direct.*'extrapolate'"):
        run(units, ON_SPRING)
    result = run(units, ON_SPRING, scheme="extrapolate")
    error = np.max(np.abs(result["mass.position"] - np.cos(result.time)))
    assert error < 0.03  # measured 0.015: for want of declarations the mass gets the pull at the end of the step
    finer = run(units, ON_SPRING, scheme="extrapolate", step=STEP / 2.0)
    assert np.max(np.abs(finer["mass.position"] - np.cos(finer.time))) < 0.6 * error  # measured 0.0077: first order
    assert result.units["spring.pull[0]"] == "kilogram * meter / second ** 2"
    assert result.flavours == {"mass": "PythonFMU 0.7.0", "spring": "PythonFMU 0.7.0"}


def test_a_unit_that_a_process_may_hold_once(tmp_path: Path) -> None:
    """It has processes of its own, two in a scene and for the run with longer steps."""
    once = 'canBeInstantiatedOnlyOncePerProcess="true"'
    fmu = str(hostile(tmp_path / "once.fmu", options=once))
    other = str(hostile(tmp_path / "other.fmu"))
    turning = {"gain": -1.0, "x0": 1.0}
    once_twice = {"a": {"fmu": fmu, "parameters": turning}, "b": {"fmu": fmu}}
    usual = run({"a": {"fmu": other, "parameters": turning}, "b": {"fmu": other}}, BACK_AND_FORTH, step=0.2)
    assert run(once_twice, BACK_AND_FORTH, step=0.2)["a.y"].tolist() == usual["a.y"].tolist()
    units = {"a": {"fmu": fmu}, "b": {"fmu": other}}
    result = run(units, BACK_AND_FORTH, error_estimate=True, step=0.2)
    assert result["a.y"].tolist() == [0.0] * 21
    with pytest.raises(SceneError, match=r"units\.b\.fmu: once\.fmu can be instantiated only once in a process"):
        run_resolved(resolve(scene(once_twice, BACK_AND_FORTH)))
