"""FMI 3: event mode and early return in co-simulation. Events are located as without; the host handles them."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave

from towage.fmus.declare.unit import load

from .cases import NATIVE
from .native_host import compile_host, rows_of, unpack

EVENTFUL = ("spring_line", "cradle", "cradle_on_line", "ship_in_sea")
# a drop from 3 m makes the line slack and taut again, on and after a docking
DROP = {
    "stiffness": 1e4, "mass": 5e3, "weight_in_water": 2e4, "drag_area": 2.0, "heave_start": 3.0, "docking_time": 3.3,
    "submersible_mass": 8e3,
}  # fmt: skip
DOCK = {"mass": 5e3, "weight_in_water": 2e4, "drag_area": 10.0, "velocity_start": 1.0, "docking_time": 0.37,
        "submersible_mass": 8e3}  # fmt: skip
Native = Callable[[str, int], Path]


class Slave:
    """An instance with event mode, in event mode after its initialisation."""

    def __init__(self, path: Path, directory: Path, early: bool = True, **values: float) -> None:
        description = fmpy.read_model_description(str(path))
        fmpy.extract(str(path), str(directory))
        self.it = FMU3Slave(
            guid=description.guid, unzipDirectory=str(directory), modelIdentifier=description.modelName, instanceName="it"
        )
        self.it.instantiate(eventModeUsed=True, earlyReturnAllowed=early)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.set(**values)
        self.it.enterInitializationMode(startTime=0.0)
        self.it.exitInitializationMode()

    def set(self, **values: float) -> None:
        self.it.setFloat64([self.references[n] for n in values], list(values.values()))

    def get(self, name: str) -> float:
        return float(self.it.getFloat64([self.references[name]])[0])

    def update(self) -> tuple[Any, ...]:
        """From event mode to step mode; what the update of the discrete states says."""
        said = self.it.updateDiscreteStates()
        self.it.enterStepMode()
        return tuple(said)

    def step(self, time: float, size: float) -> tuple[bool, bool, float]:
        """(Event handling needed, early return, last successful time)."""
        event, terminate, early, last = self.it.doStep(time, size)
        assert not terminate
        return bool(event), bool(early), float(last)


@pytest.fixture
def begin(native: Native, tmp_path: Path) -> Iterator[Callable[..., Slave]]:
    made: list[Slave] = []

    def start(name: str, early: bool = True, **values: float) -> Slave:
        made.append(Slave(native(name, 3), tmp_path, early, **values))
        return made[-1]

    yield start
    for each in made:
        each.it.freeInstance()


def refused(call: Callable[..., Any], *arguments: Any) -> None:
    with pytest.raises(Exception, match=r"fmi3\w+ failed with status 3"):
        call(*arguments)


@pytest.mark.parametrize("name", NATIVE)
def test_units_with_events_say_so_and_the_others_refuse_event_mode(name: str, native: Native, tmp_path: Path) -> None:
    path = native(name, 3)
    co_simulation = fmpy.read_model_description(str(path)).coSimulation
    assert co_simulation.hasEventMode == co_simulation.mightReturnEarlyFromDoStep == (name in EVENTFUL)
    assert not co_simulation.providesIntermediateUpdate
    if name not in EVENTFUL:
        with pytest.raises(Exception, match="instantiate"):
            Slave(path, tmp_path)


@pytest.mark.parametrize("name, start", [("cradle_on_line", DROP), ("cradle", DOCK)])
@pytest.mark.parametrize("early", [True, False])
def test_runs_in_fmpy_are_the_same_with_and_without(
    name: str, start: dict[str, float], early: bool, native: Native
) -> None:
    """Communication points every 0.5 s; with early return also at each event, which is where no other run has one."""
    outputs = [v.name for v in load(name).variables if v.causality == "output"]
    run = {"fmi_type": "CoSimulation", "stop_time": 8.0, "output_interval": 0.5, "start_values": start, "output": outputs}
    plain = fmpy.simulate_fmu(str(native(name, 3)), **run)
    rows = fmpy.simulate_fmu(str(native(name, 3)), use_event_mode=True, early_return_allowed=early, **run)
    events = [t for t in rows["time"] if not np.isclose(t / 0.5, round(t / 0.5))]
    assert bool(events) == early
    if name == "cradle" and early:
        assert events == [0.37, 0.37]  # before and after the docking, at its time to the last bit
    ends = {n: [rows[n][np.isclose(rows["time"], t)][-1] for t in plain["time"]] for n in outputs}
    for n in outputs:
        scale = np.max(np.abs(plain[n]))
        # the integrator restarts at an event in either case; times count from other points, some roundings
        assert np.max(np.abs(ends[n] - plain[n])) <= 1e-12 * scale + 1e-300, n
    if name == "cradle_on_line":
        assert min(plain["tension"]) == 0.0 < max(plain["tension"])


def test_a_line_returns_early_where_it_goes_slack_and_changes_its_branch_in_event_mode(begin: Callable[..., Slave]) -> None:
    it = begin("spring_line", stiffness=1e4, static_tension=2e4, freeze_branches=0.0)
    assert it.update() == (False, False, False, False, False, 0.0)
    it.set(heave_top=0.0, heave_top_d1=-4.0)
    event, early, last = it.step(0.0, 1.0)
    assert event and early
    assert last == pytest.approx(0.5, rel=1e-9) and last >= 0.5  # W/K = 2 m at 4 m/s; just beyond the event
    assert it.get("event_taut") <= 0.0 and it.get("tension") == 0.0
    it.it.enterEventMode()
    it.set(heave_top=-2.0 - 1e-9, heave_top_d1=-4.0)
    assert it.update()[:2] == (False, False)
    assert it.step(last, 1.0 - last) == (False, False, 1.0)


def test_inputs_that_demand_a_change_end_the_step_where_it_begins(begin: Callable[..., Slave]) -> None:
    it = begin("spring_line", stiffness=1e4, static_tension=2e4)
    it.update()
    it.set(heave_top=-3.0)
    assert it.step(0.0, 1.0) == (True, True, 0.0)
    it.it.enterEventMode()
    it.update()
    assert it.step(0.0, 1.0) == (False, False, 1.0)


def test_an_event_at_the_end_of_a_step_waits_there(begin: Callable[..., Slave]) -> None:
    it = begin("cradle", **DOCK)
    said = it.update()
    assert said[4:] == (True, 0.37)  # the next event is announced
    assert it.step(0.0, 0.37) == (True, False, 0.37)
    before = it.get("velocity")
    it.it.enterEventMode()
    assert it.update() == (False, False, False, True, False, 0.0)  # the velocity jumps
    assert abs(it.get("velocity")) < 0.5 * abs(before)


def test_calls_in_the_wrong_mode_are_refused(begin: Callable[..., Slave], native: Native, tmp_path: Path) -> None:
    it = begin("cradle", **DOCK)
    refused(it.step, 0.0, 0.1)  # event mode after initialisation
    refused(it.it.enterEventMode)
    refused(it.it.fmi3EnterContinuousTimeMode, it.it.component)
    refused(it.it.fmi3SetTime, it.it.component, 1.0)
    it.set(weight_in_water=2.1e4)  # tunable
    it.update()
    refused(it.it.updateDiscreteStates)
    refused(it.it.enterStepMode)
    refused(lambda: it.set(weight_in_water=2e4))
    it.set(line_tension=2e4, line_tension_d1=1.0)  # inputs and their derivatives belong to the communication point
    assert it.step(0.0, 0.1)[2] == 0.1
    it.it.enterEventMode()
    it.set(weight_in_water=2e4)
    it.update()
    state = it.it.getFMUState()
    assert it.step(0.1, 0.1)[2] == 0.2
    it.it.setFMUState(state)
    assert it.step(0.1, 0.1)[2] == 0.2
    it.it.freeFMUState(state)
    it.it.enterEventMode()
    it.it.terminate()


@pytest.mark.parametrize("name, start", [("cradle_on_line", DROP), ("cradle", DOCK)])
def test_the_c_host_handles_events(name: str, start: dict[str, float], native: Native, tmp_path: Path) -> None:
    """Inputs are held, so that a communication point at an event changes nothing but roundings of time."""
    host, fmu, index = compile_host(tmp_path), unpack(native(name, 3), 3, tmp_path, step=0.5, steps=20), load(name).index
    lines = [f"start {index[n]} {value!r}" for n, value in start.items()]
    script = "\n".join([*lines, *fmu.script.splitlines()[-2:]]) + "\n"
    plain, handled = (
        rows_of(subprocess.run(fmu.command(host, word), input=script, capture_output=True, text=True, check=True).stdout)
        for word in ("run", "events")
    )
    assert np.shape(plain) == np.shape(handled)
    assert np.max(np.abs(plain - handled) / (1e-300 + np.max(np.abs(plain), axis=0))) < 1e-12
