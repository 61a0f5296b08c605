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
from towage.models.cable.units import wire_parameters
from towage.models.cable.units.wire_seen import prepare
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
PORT = {**ARRAY, "body_port": 1.0, "elements": 4.0, "surface_height": 2.0, "wire_bending_stiffness": 50.0}
SINES = {
    "velocity_surge": (0.5, 0.6), "velocity_sway": (0.6, 0.5), "velocity_heave": (0.8, 1.0), "payout_speed": (0.3, 0.4),
    "body_force_heave": (50.0, 0.7), "lower_velocity_surge": (0.3, 0.6), "lower_velocity_heave": (0.4, 0.9),
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


@pytest.mark.parametrize("start", [ARRAY, HANGING, PORT], ids=["array", "hanging", "port"])
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
    lower = [name.startswith("lower_force") for name in OBSERVED]
    scale[lower] = max(*scale[lower], scale[OBSERVED.index("tension_body")])
    differ = dict(zip(OBSERVED, np.abs(found - wanted).max(axis=0) / scale))
    assert max(differ.values()) < 1e-10, max(differ, key=lambda name: differ[name])


@pytest.mark.parametrize("start", [ARRAY, PORT], ids=["array", "port"])
def test_derivatives_against_differences(start: dict[str, float], make: Make) -> None:
    """Of outputs by every input and its rate (1e-7: the differences), and in time, by steps of a millisecond."""
    unit = make(start)
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
    smooth += ["shape2_layback", "shape3_offset", "shape4_depth", "margin_surface", "margin_drag", "margin_bending"]
    rates = np.array(unit.getRealOutputDerivatives([UNIT.index[n] for n in smooth], [1] * len(smooth)))
    values = [seen(unit, smooth)]
    for k in range(2):
        put(unit, inputs(3.0 + 1e-3 * k, False))
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


LOOSE = {
    "in_space": 1.0, "tow_speed": 0.0, "wire_length": 60.0, "tail_length": 40.0, "tail_weight": 0.5, "clump_mass": 60.0,
    "clump_weight": -200.0, "body_mass": 300.0, "body_added_mass": 0.0, "body_weight": 1500.0, "elements": 4.0, "degree": 3.0,
    "velocity_tolerance": 0.05, "added_mass_coefficient": 0.0,
} | {f"{part}_{drag}_drag": 0.0 for part in ("wire", "tail") for drag in ("normal", "tangential")} | {
    "body_drag_area": 0.0, "clump_drag_area": 0.0,
}  # fmt: skip
"""A buoy between two sections; nothing in the water takes energy."""


def energy_of(unit: Any, prepared: Any) -> float:
    """Kinetic, elastic and potential, J, by the nodes in a stored state."""
    chain, outputs = prepared.chain, 8 * UNIT.layout.observed.start + 8
    size = prepared.nodes.size
    data = bytes(unit.serializeFMUstate(unit.getFMUState()))
    x = np.frombuffer(data[len(data) - outputs - 8 * (7 * size + 7 + chain.dimensions) : len(data) - outputs])
    r, v = x[: 2 * size].reshape(2, *prepared.nodes.shape)
    assert -r[0, -1] == pytest.approx(seen(unit, ["depth"])[0], rel=1e-12)
    half, k = chain.lengths().half, chain.material
    share = chain.rule.weights * half
    stretch = np.linalg.norm(chain.slope(chain.gather(r), half), axis=2) - 1.0
    points = 0.5 * k.mass * (chain.gather(v) ** 2).sum(2) + k.weight * chain.gather(r)[..., -1]
    total = (share * (points + 0.5 * k.stiffness * np.maximum(stretch, 0.0) ** 2)).sum()
    nodes, fixture = chain.fixtures
    for node, mass, weight in zip(nodes, fixture.masses[0], fixture.weight):
        total += 0.5 * mass * (v[node] ** 2).sum() + weight * r[node, -1]
    return float(total)


@pytest.mark.parametrize("steps", [2_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_energy_never_grows_undriven(steps: int, make: Make) -> None:
    """Shaken until it goes slack and snaps, then left alone: to a thousandth of what was put in, which an order of the steps'
    error leaves."""
    unit = make(LOOSE)
    prepared = prepare(wire_parameters.Parameters(**{**{v.name: v.start for v in UNIT.parameters}, **LOOSE}))
    rest, t, least = energy_of(unit, prepared), 0.0, 1.0
    for k in range(80):
        put(unit, {"velocity_heave": 4.0 if k % 20 < 10 else -4.0, "velocity_sway": 1.0 if k % 40 < 20 else -1.0})
        unit.doStep(t, 0.1)
        t += 0.1
        least = min(least, *seen(unit, ["margin_slack"]))
    put(unit, {"velocity_heave": 0.0, "velocity_sway": 0.0})
    unit.doStep(t, 0.1)
    t += 0.1
    first = largest = energy_of(unit, prepared)
    for k in range(steps):
        unit.doStep(t + 0.05 * k, 0.05)
        if k % (steps // 200) == 0:
            largest = max(largest, energy_of(unit, prepared))
    assert least < 0.05 and first > rest + 1e3
    assert largest < first + 1e-3 * (first - rest)


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
    p = wire_parameters.Parameters(**{**{v.name: v.start for v in UNIT.parameters}, **ARRAY})
    wire, found = wire_parameters.wire_of(p), wire_parameters.numbers(p, FLOATS)
    assert (found.tail, found.wire) == tuple(part.material(p.water_density) for part in wire.sections)
    assert wire.body is not None and found.body[3] == wire.body.weight and found.clump[3] == wire.clumps[0][1].weight
    assert len(list(flat(found))) == 16 + 2 * 16 + 2 * 6 + 2 + 6
