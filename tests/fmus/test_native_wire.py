"""The native wire: equal to the Python flavour, derivatives against differences, states of different sizes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave

from towage.fmus.declare.unit import load
from towage.fmus.native.trace_chain import flat
from towage.fmus.python.instance import Instance
from towage.models.cable.units import wire_ports
from towage.models.numeric.ops import FLOATS

UNIT = load("wire")
ARRAY = {
    "in_space": 1.0, "tail_length": 60.0, "tail_weight": 0.2, "clump_mass": 50.0, "clump_weight": 300.0, "clump_drag_area": 0.1,
    "current_surge": -0.5, "current_sway": 0.3, "current_depth": 60.0, "breaking_load": 3e4, "velocity_tolerance": 0.01,
    "momentum_added_mass": 1.0, "body_added_mass_heave": 500.0, "body_lift": 200.0, "body_drag": 150.0,
}  # fmt: skip
HANGING = {
    "elements": 12.0, "degree": 1.0, "loading_form": 0.0, "wire_tangential_drag": 0.02, "wire_damping": 1e4, "tow_speed": 0.0,
    "velocity_tolerance": 0.01,
}  # fmt: skip
SINES = {
    "velocity_surge": (0.5, 0.6), "velocity_sway": (0.6, 0.5), "velocity_heave": (0.8, 1.0), "payout_speed": (0.3, 0.4),
    "body_force_heave": (50.0, 0.7),
}  # fmt: skip
OBSERVED = [v.name for v in UNIT.observed]
Make = Callable[..., FMU2Slave]


def inputs(t: float, plane: bool) -> dict[str, float]:
    """Smooth motions with their derivatives; from rest, so that no wave of the start is excited."""
    found = {}
    for name, (a, w) in SINES.items():
        # a (1 - cos w t) for a velocity that begins at 0 with an acceleration of 0
        s, c = math.sin(w * t), math.cos(w * t)
        if not (plane and name == "velocity_sway"):
            values = (a * (1.0 - c), a * w * s, a * w * w * c, -a * w**3 * s)
            found |= {f"{name}{suffix}": v for suffix, v in zip(("", "_d1", "_d2", "_d3"), values)}
    return found


@pytest.fixture(scope="module")
def make(native: Callable[[str, int], Path], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Make]:
    path = native("wire", 2)
    description = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path), str(tmp_path_factory.mktemp("wire")))
    made = []

    def start(values: dict[str, float], begin: bool = True) -> FMU2Slave:
        unit = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="wire", instanceName="wire")
        unit.instantiate()
        made.append(unit)
        unit.setupExperiment(startTime=0.0)
        put(unit, values)
        unit.enterInitializationMode()
        if begin:
            unit.exitInitializationMode()
        return unit

    yield start
    for unit in made:
        unit.freeInstance()


def put(unit: Any, values: dict[str, float]) -> None:
    unit.setReal([UNIT.index[name] for name in values], list(values.values()))


def seen(unit: Any, names: list[str] = OBSERVED) -> np.ndarray:
    return np.array(unit.getReal([UNIT.index[name] for name in names]))


def moved(unit: Any, steps: int, plane: bool, step: float = 0.1, first: int = 0) -> np.ndarray:
    """The outputs after so many steps, the inputs set for the next."""
    for k in range(first, first + steps):
        put(unit, inputs(k * step, plane))
        unit.doStep(k * step, step)
    put(unit, inputs((first + steps) * step, plane))
    return seen(unit)


@pytest.mark.parametrize("start", [ARRAY, HANGING], ids=["array", "hanging"])
def test_equals_the_python_flavour(start: dict[str, float], make: Make) -> None:
    """Set-up and forty steps with payout, to 1e-10 of each quantity: the same elements, steps and iterations. Were a wire to
    snap, rounding would grow from one wave to the next, in both."""
    unit, it, plane = make(start), Instance(UNIT), not start.get("in_space")
    it.set_values([UNIT.index[n] for n in start], list(start.values()))
    it.set_up(0.0, None)
    it.enter_initialization()
    it.exit_initialization()
    calculated = [v.name for v in UNIT.calculated]
    # the error of the mesh comes from two marches of the steady shape, each to 1e-8
    assert seen(unit, calculated) == pytest.approx(it.get_values([UNIT.index[n] for n in calculated]), rel=1e-9, abs=1e-9)
    rows = []
    for k in range(40):
        values = inputs(0.1 * k, plane)
        put(unit, values)
        it.set_values([UNIT.index[n] for n in values], list(values.values()))
        unit.doStep(0.1 * k, 0.1)
        it.do_step(0.1 * k, 0.1)
        rows.append((seen(unit), np.array(it.get_values([UNIT.index[n] for n in OBSERVED]))))
    found, wanted = (np.array(each) for each in zip(*rows))
    # forces are differences of EA times a strain: 8e6 N of which 1e-16 is rounding
    scale = np.maximum(np.abs(wanted).max(axis=0), 1e-3)
    assert (np.abs(found - wanted).max(axis=0) / scale).max() < 1e-10


def test_derivatives_against_differences(make: Make) -> None:
    """Of outputs by every input and its rate (1e-7: the differences), and in time, by steps of a millisecond."""
    unit = make(ARRAY)
    moved(unit, 30, False)
    references = [UNIT.index[n] for n in OBSERVED]
    for name in (v.name for v in UNIT.inputs):
        for known in (UNIT.index[name], UNIT.index[f"{name}_d1"]):
            exact = np.array(unit.getDirectionalDerivative(references, [known], [1.0]))
            (value,), e, ends = unit.getReal([known]), 1e-2 if "force" in name else 1e-4, []
            for sign in (1.0, -1.0):
                unit.setReal([known], [value + sign * e])
                ends.append(seen(unit))
            unit.setReal([known], [value])
            assert exact == pytest.approx((ends[0] - ends[1]) / (2.0 * e), rel=1e-6, abs=1e-6), name
    smooth = ["depth", "layback", "offset", "body_surge", "body_heave", "length", "body_velocity_heave", "margin_resolution"]
    rates = np.array(unit.getRealOutputDerivatives([UNIT.index[n] for n in smooth], [1] * len(smooth)))
    values = [seen(unit, smooth)]
    for k in range(2):
        unit.doStep(3.0 + 1e-3 * k, 1e-3)
        values.append(seen(unit, smooth))
    # the curvature of a motion with waves in it
    assert rates == pytest.approx((4.0 * values[1] - 3.0 * values[0] - values[2]) / 2e-3, rel=1e-3, abs=1e-3)


def test_states_belong_to_their_parameters(make: Make) -> None:
    """A state of another number of elements brings its parameters with it; one that was changed is refused."""
    coarse, fine = make({**ARRAY, "elements": 4.0}), make({**ARRAY, "elements": 9.0})
    moved(coarse, 5, False)
    kept = coarse.getFMUState()
    ahead = moved(coarse, 5, False, first=5)
    data = coarse.serializeFMUstate(kept)
    assert len(data) < len(fine.serializeFMUstate(fine.getFMUState()))
    fine.setFMUState(fine.deSerializeFMUstate(data))
    assert list(moved(fine, 5, False, first=5)) == list(ahead)
    changed = bytearray(data)
    changed[200] ^= 1
    with pytest.raises(FMICallException):
        fine.deSerializeFMUstate(bytes(changed))


def test_refusals_say_what_helps(make: Make) -> None:
    """After a refused step the wire is where it was."""
    with pytest.raises(FMICallException):
        make({"tolerance": 1e-10, "degree": 1.0})
    unit = make({**HANGING, "wire_length": 20.0})
    # hauled in faster and faster: 20 m are gone after 6.3 s
    put(unit, {"payout_speed": 0.0, "payout_speed_d1": -1.0})
    unit.doStep(0.0, 2.0)
    before = seen(unit)
    with pytest.raises(FMICallException):
        unit.doStep(2.0, 10.0)
    assert list(seen(unit)) == list(before)
    put(unit, {"payout_speed": -2.0, "payout_speed_d1": 0.0})
    unit.doStep(2.0, 1.0)
    assert seen(unit, ["length"])[0] == pytest.approx(20.0 - 2.0 - 2.0)


def test_numbers_are_those_of_the_model() -> None:
    """What C takes is what Python makes of the same parameters, section by section."""
    p = wire_ports.Parameters(**{**{v.name: v.start for v in UNIT.parameters}, **ARRAY})
    wire, found = wire_ports.wire_of(p), wire_ports.numbers(p, FLOATS)
    assert (found.tail, found.wire) == tuple(part.material(p.water_density) for part in wire.sections)
    assert wire.body is not None and found.body[3] == wire.body.weight and found.clump[3] == wire.clumps[0][1].weight
    assert len(list(flat(found))) == 10 + 2 * 16 + 2 * 6 + 2 + 6
