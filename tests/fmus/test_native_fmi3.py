"""FMI 3: the description, arrays, derivatives, modes; through fmpy, whose methods raise for any status but OK."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelVariable
from fmpy.validation import validate_fmu

from towage.fmus.declare import quantities
from towage.fmus.declare.arrays import array_of, lengths
from towage.fmus.declare.dependencies import dependencies
from towage.fmus.declare.unit import load, named
from towage.fmus.native import build as native_fmu
from towage.fmus.native.trace import trace
from towage.fmus.python.instance import Instance
from towage.master.master import run_resolved
from towage.models.protocol.variables import local
from towage.scene.flavour import resolve
from towage.scene.scene import Scene

from . import linear_example
from .cases import CASES, NATIVE
from .native_host import ESTIMATED, run_of

Path3 = Callable[[str], Path]


@pytest.fixture(scope="module")
def fmu3(native: Callable[[str, int], Path]) -> Path3:
    return lambda name: native(name, 3)


@pytest.fixture(scope="module")
def linear(native: Callable[[str, int], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A linear unit: its states and extras are arrays. (``native`` skips where there is no compiler.)"""
    traced = trace(linear_example.UNIT, {})
    return native_fmu.package(traced, "", tmp_path_factory.mktemp("linear"), 3, "host")[0]


@pytest.fixture
def begin(tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Instances by path, ready for the first step or in event mode."""
    started = []

    def start(path: Path, kind: type = FMU3Slave, **values: float) -> tuple[Any, dict[str, ModelVariable]]:
        description = fmpy.read_model_description(str(path))
        if not started:  # the library must not be written over while it is loaded
            fmpy.extract(str(path), str(tmp_path))
        it = kind(
            guid=description.guid, unzipDirectory=str(tmp_path), modelIdentifier=description.modelName, instanceName="it"
        )
        it.instantiate()
        started.append(it)
        variables = {v.name: v for v in description.modelVariables}
        it.setFloat64([variables[n].valueReference for n in values], list(values.values()))
        it.enterInitializationMode(startTime=0.0)
        it.exitInitializationMode()
        return it, variables

    yield start
    for it in started:
        it.freeInstance()


@pytest.mark.parametrize("name", NATIVE)
def test_description(name: str, fmu3: Path3) -> None:
    """Valid, with the references of FMI 2, units whose display factors point the right way, and both interfaces."""
    path, unit = fmu3(name), load(name)
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    variables = description.modelVariables
    assert [(v.name, v.valueReference) for v in variables[: len(unit.variables)]] == [
        (v.name, i) for i, v in enumerate(unit.variables)
    ]
    for declared, v in zip(unit.variables, variables):
        assert (v.causality, v.variability, v.unit) == (declared.causality, declared.variability, declared.unit)
        assert (v.start is None) == (declared.start is None)
        if declared.display:
            (of,) = [u for u in description.unitDefinitions if u.name == declared.unit]
            (display,) = [d for d in of.displayUnits if d.name == declared.display]
            # display value = factor * value; two roundings
            factor = display.factor * quantities.convert(1.0, declared.display, declared.unit)
            assert factor == pytest.approx(1.0, rel=1e-15)
    (time,) = [v for v in variables if v.causality == "independent"]
    assert time.name == "time" and time.unit == "s"
    assert bool(description.modelExchange) != bool(unit.model.numbers)  # a wire steps by itself
    for outer in filter(None, (description.coSimulation, description.modelExchange)):
        assert outer.canGetAndSetFMUstate and outer.canSerializeFMUstate
    assert description.coSimulation.maxOutputDerivativeOrder == 1  # event mode: `test_native_events`
    assert {u.variable.name for u in description.outputs} == {v.name for v in unit.variables if v.causality == "output"}
    for unknown in description.outputs:
        inputs = {d.name for d in unknown.dependencies if d.causality == "input"}
        assert inputs == set(dependencies(unit)[unit.variables[unknown.variable.valueReference].name])


@pytest.mark.parametrize("name", NATIVE)
def test_co_simulation_in_fmpy_equals_the_instance(name: str, fmu3: Path3) -> None:
    unit, step = load(name), 0.125  # a power of two: fmpy adds times up
    start, sines = run_of(fmu3(name))
    times = step * np.arange(33)
    signal = np.array(
        [(t, *(a * np.sin(w * t) for a, w in sines.values())) for t in times],
        dtype=[("time", float), *((entry, float) for entry in sines)],
    )
    outputs = [v.name for v in unit.variables if v.causality == "output"]
    found = fmpy.simulate_fmu(
        str(fmu3(name)), fmi_type="CoSimulation", stop_time=4.0, step_size=step, output_interval=step,
        start_values=start, input=signal if sines else None, output=outputs,
    )  # fmt: skip
    it = Instance(unit)
    it.set_values([unit.index[n] for n in start], list(start.values()))
    it.enter_initialization()
    it.exit_initialization()
    for k in range(32):
        it.set_values([unit.index[entry] for entry in sines], [float(signal[entry][k]) for entry in sines])
        it.do_step(float(times[k]), step)
        for n, value in zip(outputs, it.get_values([unit.index[n] for n in outputs])):
            # the traced code adds in another order: some 1e3 roundings
            allowed = 1e-10 * float(np.max(np.abs(found[n])))
            if not (n in ESTIMATED and unit.model.linear):
                assert found[n][k + 1] == pytest.approx(value, rel=1e-10, abs=allowed), (n, k)


@pytest.mark.parametrize("name", ["ship", "cradle", "cradle_on_line"])
def test_model_exchange_finds_the_same_motion(name: str, fmu3: Path3) -> None:
    """With the events of the line and the docking, located by fmpy's CVode instead of the unit's own integrator."""
    ends = []
    for kind in ("ModelExchange", "CoSimulation"):
        rows = fmpy.simulate_fmu(
            str(fmu3(name)), fmi_type=kind, stop_time=6.0, output_interval=0.5, relative_tolerance=1e-9,
            start_values=CASES[name].start | ({"velocity_start": 1.5} if name != "ship" else {}), output=["heave", "velocity"],
        )  # fmt: skip
        # fmpy adds rows before and after each event
        ends.append(rows[[int(np.argmin(np.abs(rows["time"] - 0.5 * k))) for k in range(13)]])
    for column in ("heave", "velocity"):
        scale = np.max(np.abs(ends[1][column]))
        # CVode's 1e-9 a step, and fmpy steps over an event by its own tolerance, 1e-5 or so of the motion
        assert np.max(np.abs(ends[0][column] - ends[1][column])) < 1e-4 * scale, column
    assert np.ptp(ends[0]["heave"]) > 0.01


def test_one_reference_delivers_an_array(linear: Path, begin: Callable[..., Any]) -> None:
    it, v = begin(linear, FMU3Model, start=0.3)
    states = it.getFloat64([v["state.z"].valueReference], nValues=4)
    assert len(v["state.z"].dimensions) == 1 and v["der(state.z)"].derivative is v["state.z"]
    vector = np.zeros(5)
    it.getContinuousStates(vector.ctypes.data_as(fmpy.fmi3.POINTER(fmpy.fmi3.fmi3Float64)), 5)
    assert list(vector[:4]) == list(states) and any(states)
    # scalars and arrays in one call, in their order
    mixed = it.getFloat64([v["first"].valueReference, v["row"].valueReference, v["last"].valueReference], nValues=6)
    assert mixed[0] == it.getFloat64([v["first"].valueReference])[0]
    assert list(mixed[1:5]) == list(it.getFloat64([v["row"].valueReference], nValues=4))
    assert mixed[5] == it.getFloat64([v["last"].valueReference])[0]
    for wrong in (3, 5):
        with pytest.raises(Exception, match="fmi3GetFloat64"):
            it.getFloat64([v["state.z"].valueReference], nValues=wrong)
    with pytest.raises(Exception, match="fmi3GetFloat64"):
        it.getFloat64([v["state.z"].valueReference + 1])  # has no reference of its own


def test_directional_and_adjoint_derivatives(linear: Path, fmu3: Path3, begin: Callable[..., Any]) -> None:
    """The columns by directional, the rows by adjoint derivatives: one matrix, over arrays; a column by differences."""
    it, v = begin(linear, FMU3Model, start=0.3, force=0.7, pace=0.4)
    unknowns = [v["der(state.z)"].valueReference, v["first"].valueReference, v["last"].valueReference]
    knowns = [v["state.z"].valueReference, v["force"].valueReference]
    columns = [it.getDirectionalDerivative(unknowns, knowns, list(row), 6) for row in np.eye(5)]
    rows = [it.getAdjointDerivative(unknowns, knowns, list(row), 5) for row in np.eye(6)]
    # the rows are made of the columns
    assert np.array_equal(np.array(columns).T, np.array(rows))

    def rates(force: float) -> Any:
        it.setFloat64([v["force"].valueReference], [force])
        return np.array(it.getFloat64(unknowns, nValues=6))

    # linear in the force but for round-off over a difference of 2
    assert (rates(1.7) - rates(-0.3)) / 2.0 == pytest.approx(np.array(columns[4]), rel=1e-12, abs=1e-13)
    with pytest.raises(Exception, match="fmi3GetDirectionalDerivative"):
        it.getDirectionalDerivative(unknowns, [v["time"].valueReference], [1.0], 6)


@pytest.mark.parametrize("name", ["tow_system", "tow_cable"])
def test_both_kinds_say_the_same_of_their_error(name: str, fmu3: Path3, begin: Callable[..., Any]) -> None:
    """Model exchange keeps all states: what the reduction of co-simulation costs is a bound there."""
    errors = {}
    for reduced in (0.0, 1.0):
        for kind in (FMU3Slave, FMU3Model):
            it, v = begin(fmu3(name), kind, reduced=reduced)
            names = ("model_error", "margin_resolution", "margin_slack", "steady_tension_top")
            errors[reduced, kind] = it.getFloat64([v[n].valueReference for n in names])
        assert errors[reduced, FMU3Slave] == errors[reduced, FMU3Model]
    assert 0.0 < errors[0.0, FMU3Slave][0] < errors[1.0, FMU3Slave][0]


def test_output_derivatives_are_the_rates(fmu3: Path3, begin: Callable[..., Any]) -> None:
    it, v = begin(fmu3("cradle"), **CASES["cradle"].start)
    it.setFloat64([v["line_tension"].valueReference, v["line_tension_d1"].valueReference], [3e4, 2e3])
    it.doStep(0.0, 0.5)
    names = ("heave", "velocity")
    found = it.getOutputDerivatives([v[n].valueReference for n in names], [1, 1])
    assert list(found) == it.getFloat64([v[n].valueReference for n in ("heave_rate", "acceleration")])
    with pytest.raises(Exception, match="fmi3GetOutputDerivatives"):
        it.getOutputDerivatives([v["heave"].valueReference], [2])


def test_time_and_indicators_are_variables(fmu3: Path3, begin: Callable[..., Any]) -> None:
    it, v = begin(fmu3("cradle_on_line"), **CASES["cradle_on_line"].start)
    it.doStep(0.0, 0.5)
    assert it.getFloat64([v["time"].valueReference]) == [0.5]
    velocity, taut = it.getFloat64([v[n].valueReference for n in ("velocity", "event_taut")])
    indicators = it.getFloat64([v["event_indicator"].valueReference], nValues=2)
    assert indicators[0] == velocity and indicators[1] == pytest.approx(taut, rel=1e-12)  # traced apart
    with pytest.raises(Exception, match="fmi3SetFloat64"):
        it.setFloat64([v["time"].valueReference], [1.0])


def test_what_is_absent_is_refused(fmu3: Path3, begin: Callable[..., Any]) -> None:
    it, v = begin(fmu3("ship"))
    for call in (it.enterConfigurationMode, it.enterEventMode, it.enterStepMode):
        with pytest.raises(Exception, match="fmi3Enter"):
            call()
    assert it.getInt32([]) == []
    with pytest.raises(Exception, match="fmi3GetInt32"):
        it.getInt32([v["heave"].valueReference])
    it.doStep(0.0, 0.1)


def test_arrays_are_found_by_name() -> None:
    names = ["a", "z[1]", "z[2]", "der(z[1])", "der(z[2])", "y[1]", "w[2]", "w[3]", "q[1]", "q[3]", "a[2]"]
    counts = lengths([named(n, local("1", "")) for n in names])
    assert counts == [1, 2, 0, 2, 0, 1, 1, 1, 1, 1, 1]
    assert [array_of(counts, k) for k in range(5)] == [0, 1, 1, 3, 3]


def test_a_scene_of_our_units_runs_in_both_versions_to_the_same_bits(native: Callable[[str, int], Path]) -> None:
    results = {}
    for fmi in (2, 3):
        units = {name: {"fmu": str(native(name, fmi))} for name in ("ship", "spring_line", "cradle")}
        scene = Scene.from_dict({
            "title": "Ours", "stop_time": 20.0, "units": units, "coupling": {"step": 0.1},
            "connections": ["ship.heave -> spring_line.heave_top", "cradle.heave -> spring_line.heave_bottom",
                            "spring_line.tension -> cradle.line_tension"],
        })  # fmt: skip
        results[fmi] = run_resolved(resolve(scene))
    old, new = results[2], results[3]
    assert new.status == "done", new.message
    assert new.scheme == "hermite"
    assert new.flavours == dict.fromkeys(units, "native")
    assert not [finding for finding in new.checks if finding.name in ("units", "noise")]
    assert old.columns.keys() == new.columns.keys()
    for name, values in old.columns.items():
        assert np.array_equal(values, new[name]), name
