"""Reduction of linear units in C against the Python flavour: models, errors, what a reduced unit shows and refuses."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.fmus.native.trace import trace
from towage.fmus.python.instance import Instance
from towage.models.cable.lumped.fidelity import tow_elastic, tow_rigid
from towage.models.cable.lumped.reduction import reduce
from towage.models.cable.parameters import tow_of
from towage.models.numeric.ops import FLOATS

from .native_instance import DONE, MODEL_EXCHANGE, REFUSED, Library, NativeInstance, unit_library

SEGMENTS = 8.0


@pytest.fixture(scope="module", params=[0.0, 1.0], ids=["rigid", "elastic"])
def tow(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Library, bool]:
    unit = load("tow_system")
    unit = replace(
        unit, parameters=tuple(
            replace(v, variability="tunable") if v.name == "body_mass" else v for v in unit.parameters
        )
    )  # fmt: skip
    traced = trace(unit, {"segments": SEGMENTS, "extensible": request.param})
    library = unit_library(traced, tmp_path_factory.mktemp(f"tow{request.param:.0f}"))
    return (library, traced), request.param > 0.5


CASE = {"axial_stiffness": 4e6}


def python_model(elastic: bool) -> Any:
    unit = load("tow_system")
    values = {v.name: v.start for v in unit.parameters} | {"extensible": float(elastic), "segments": SEGMENTS}
    # 0: a cable that keeps its length has no stretched equilibrium either
    values["axial_stiffness"] = CASE["axial_stiffness"] if elastic else 0.0
    return (tow_elastic if elastic else tow_rigid)(tow_of(unit.model.Parameters(**values)), int(SEGMENTS))


@pytest.mark.parametrize("tolerance", [0.3, 0.1, 0.03])
def test_reduction_is_that_of_the_python_flavour(tolerance: float, tow: tuple[Library, bool]) -> None:
    library, elastic = tow
    full = NativeInstance(*library, reduced=0.0, tolerance=tolerance, **CASE)
    small = NativeInstance(*library, reduced=1.0, tolerance=tolerance, **CASE)
    (spent,), (states, error) = full.get("model_error"), small.get("states", "model_error")
    allowed = max(0.25 * tolerance, tolerance - spent)
    wanted = reduce(python_model(elastic), allowed, 2.0, elastic, 2)
    assert error - spent <= allowed
    assert abs(states - len(wanted.model.a)) <= 1
    if states == len(wanted.model.a):
        # the error of the same candidate; coordinates differ by what rounding leaves of the weak ones
        assert error - spent == pytest.approx(wanted.error, rel=1e-6, abs=1e-9)
    assert full.get("states") == [4.0 * SEGMENTS if elastic else 2.0 * SEGMENTS]


def test_a_reduced_model_behaves_as_the_full_one(tow: tuple[Library, bool]) -> None:
    library, _ = tow
    tolerance, h = 0.2, 0.1
    both = [NativeInstance(*library, reduced=r, tolerance=tolerance, **CASE) for r in (0.0, 1.0)]
    spent = both[0].get("model_error")[0]
    found: list[list[list[float]]] = [[], []]
    for k in range(2500):
        t = k * h
        for it, each in zip(both, found):
            it.set(velocity_heave=0.4 * math.sin(1.1 * t), velocity_heave_d1=0.44 * math.cos(1.1 * t),
                   velocity_heave_d2=-0.484 * math.sin(1.1 * t))  # fmt: skip
            assert it.step(t, h) == DONE
            if k >= 2000:  # the slowest mode, -0.045/s, has decayed to 1e-4
                each.append(it.get("reaction_surge", "reaction_heave"))
    full, small = np.array(found)
    # the measure is of amplitudes, largest component over largest component
    assert np.abs(full - small).max() <= (tolerance - spent) * np.abs(full).max()


def test_the_state_shown_is_that_of_the_full_model(tow: tuple[Library, bool]) -> None:
    """A reduced model replaces what it leaves out by its response to v and v': the full model in the state that is shown
    has the same outputs."""
    library, _ = tow
    small, full = NativeInstance(*library, **CASE), NativeInstance(*library, kind=MODEL_EXCHANGE, **CASE)
    assert small.get("states")[0] < full.get("states")[0]
    interface = library[1].interface
    states = [f"state.{v.name}" for v in interface.states]
    # the margin of the error knows of the reduction
    outputs = [v.name for v in interface.unit.observed if v.causality == "output" and v.name != "margin_resolution"]
    assert small.get(*states) == [0.0] * len(states)

    def motion(t: float) -> dict[str, float]:
        return {"velocity_heave": 0.5 * t + 0.2 * t * t, "velocity_heave_d1": 0.5 + 0.4 * t, "velocity_heave_d2": 0.4}

    h, count, path = 1e-3, 400, []
    for k in range(count):
        small.set(**motion(k * h))
        assert small.step(k * h, h) == DONE
        path.append(np.array(small.get(*states)))
    rates = np.array(small.get(*(f"der({name})" for name in states)))
    assert full.library.instance_enter_continuous(full.handle) == DONE
    full.set_states(path[-1].tolist())
    full.set(**motion(count * h))
    found, wanted = np.array(small.get(*outputs)), np.array(full.get(*outputs))
    # rounding, of products with forces that cancel
    assert np.abs(found - wanted).max() <= 1e-9 * np.abs(wanted).max()
    # one-sided difference, to h^2 times the third derivative; the second derivatives among the states have no rate
    n = int(full.get("states")[0])
    slope = (1.5 * path[-1] - 2.0 * path[-2] + 0.5 * path[-3])[:n] / h
    assert np.abs(slope - rates[:n]).max() <= 1e-3 * np.abs(rates[:n]).max()


def test_the_apparent_mass_is_that_of_the_full_model(tow: tuple[Library, bool]) -> None:
    """In both flavours, reduced or not: E of a reduced elastic model holds the inertia of other modes too."""
    library, elastic = tow
    names = ("port_mass", "apparent_mass_surge", "apparent_mass_coupling", "apparent_mass_heave")
    unit = load("tow_system")
    start = {v.name: v.start for v in unit.parameters} | CASE | {"extensible": float(elastic), "segments": SEGMENTS}
    full = NativeInstance(*library, reduced=0.0, **CASE).get(*names)
    assert full[0] > 0.0
    for reduced in (0.0, 1.0):
        python = unit.model.calculated(unit.model.Parameters(**start | {"reduced": reduced}), FLOATS)
        assert [getattr(python, name) for name in names] == pytest.approx(full, rel=1e-9)
        assert NativeInstance(*library, reduced=reduced, **CASE).get(*names) == full


def test_only_an_unreduced_model_can_be_tuned(tow: tuple[Library, bool]) -> None:
    library, _ = tow
    for reduced, outcome in ((0.0, DONE), (1.0, REFUSED)):
        it = NativeInstance(*library, reduced=reduced, **CASE)
        assert it.step(0.0, 0.1) == DONE
        assert it.set(body_mass=950.0) == outcome
    assert it.message == (
        "body_mass may not be set: the states of another reduced model mean something else, this needs reduced = 0"
    )
    assert it.step(0.1, 0.1) == DONE


def test_no_equilibrium_is_refused(tow: tuple[Library, bool]) -> None:
    library, _ = tow
    it = NativeInstance(*library, **CASE | {"body_weight_in_water": -1e5})
    assert it.initialized == REFUSED and it.message


def test_error_of_the_segments_is_that_of_the_frequency_response(tow: tuple[Library, bool]) -> None:
    library, elastic = tow
    unit = load("tow_system")
    values = {v.name: v.start for v in unit.parameters} | CASE
    values |= {"extensible": float(elastic), "segments": SEGMENTS, "reduced": 0.0}
    measured = unit.model.calculated(unit.model.Parameters(**values), FLOATS)
    it = NativeInstance(*library, reduced=0.0, **CASE)
    estimated, lost = it.get("model_error", "inextensible_error")
    # extrapolation from two meshes; another grid of frequencies
    assert 0.5 < estimated / measured.model_error < 1.5
    # the same quantity between lumped models; 0 where the cable is elastic
    assert lost == pytest.approx(measured.inextensible_error, rel=0.1, abs=1e-3)


# ---- tow_cable: reduced for its ends moving together and for their offset -------------------------------------------


@pytest.fixture(scope="module")
def cable(tmp_path_factory: pytest.TempPathFactory) -> Library:
    traced = trace(load("tow_cable"), {"segments": 20.0})
    return unit_library(traced, tmp_path_factory.mktemp("cable")), traced


def started(**values: float) -> Instance:
    """The Python flavour of the cable."""
    unit = load("tow_cable")
    found = Instance(unit)
    values = {**unit.start, **values}
    found.set_values([unit.index[name] for name in values], list(values.values()))
    found.enter_initialization()
    found.exit_initialization()
    return found


@pytest.mark.parametrize("tolerance", [0.05, 0.1])
def test_both_flavours_reduce_the_cable_alike(tolerance: float, cable: Library) -> None:
    python = started(segments=20.0, tolerance=tolerance, **CASE)
    native = NativeInstance(*cable, tolerance=tolerance, **CASE)
    index = python.unit.index
    states, stiffness = python.get_values([index["states"], index["port_stiffness"]])
    # the error of the segments, which leaves more or less to the reduction, is estimated in one and measured in the other
    assert abs(native.get("states")[0] - states) <= 1
    if native.get("states") == [states]:
        assert native.get("port_stiffness")[0] == pytest.approx(stiffness, rel=1e-6)
    outputs = ["reaction_surge", "reaction_heave", "body_force_surge", "body_force_heave"]
    h, omega, found = 0.1, 1.1, []
    for k in range(600):
        s, c = math.sin(omega * k * h), omega * math.cos(omega * k * h)
        given = {
            f"{name}{end}": size * value
            for name, size in (("top_velocity_heave", 0.4), ("body_velocity_heave", 0.36), ("body_velocity_surge", 0.05))
            for end, value in (("", s), ("_d1", c), ("_d2", -omega * omega * s), ("_d3", -omega * omega * c))
        }
        python.set_values([index[name] for name in given], list(given.values()))
        python.do_step(k * h, h)
        assert native.set(**given) == DONE and native.step(k * h, h) == DONE
        found.append((python.get_values([index[name] for name in outputs]), native.get(*outputs)))
    both = np.array(found)[300:]  # the start has decayed
    assert np.abs(both[:, 0] - both[:, 1]).max() <= tolerance * np.abs(both[:, 0]).max()
