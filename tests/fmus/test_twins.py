"""Steps, event rules and reductions that exist in Python and in C replay the same vectors, made by neither.

``vectors/make.py`` works them out in 50 digits. Tolerances are those of the arithmetic in doubles; where an algorithm ends by
a criterion of its own they are that of the criterion.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.fmus.native.build import runtime_sources
from towage.fmus.native.trace import trace
from towage.fmus.python.instance import Instance
from towage.models.cable.lumped.linear import StateSpace
from towage.models.cable.lumped.reduction import band_frequencies, reduce, transfer
from towage.models.heave import ship
from towage.models.numeric.exact_step import exact_step
from towage.models.numeric.integrate import EVENT_WIDTH, integrate, unrolled
from towage.models.numeric.ops import FLOATS
from towage.models.numeric.tableaus import DORMAND_PRINCE_5
from towage.models.slender.damping import exponential

from . import linear_example as example
from .compiled import Compiled
from .conftest import compiler_found
from .native_instance import (
    DONE,
    Library,
    NativeInstance,
    OnEvent,
    Pointer,
    Rates,
    System,
    compile_library,
    doubles,
    unit_library,
)

HERE = Path(__file__).parent
EPS = 2.0**-52


def vectors(name: str) -> Any:
    """One file of ``vectors``."""
    return json.loads((HERE / "vectors" / f"{name}.json").read_text())


@pytest.fixture(scope="module")
def runtime(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The runtime below FMI with what ``host/twins.c`` adds."""
    if not compiler_found():
        pytest.skip("no C compiler")
    names = [name for name in runtime_sources(2) if name.endswith(".c") and not name.startswith("fmi")]
    twins = (HERE / "host" / "twins.c").read_text()
    unit = '#include "unit.h"\nconst Unit towage_unit;\n'
    library = compile_library(names, tmp_path_factory.mktemp("twins") / "twins.so", twins=twins, unit=unit)
    for function in (library.exponential, library.eigenvalues):
        function.restype = ctypes.c_bool
    return library


def test_vectors_follow_from_their_script() -> None:
    """Each file is what its script writes today."""
    spec = importlib.util.spec_from_file_location("make_vectors", HERE / "vectors" / "make.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for vector in module.VECTORS:
        assert module.text(vector) == (HERE / "vectors" / f"{vector.__name__}.json").read_text(), vector.__name__


def callback(function: Callable[[float, Any], Any], states: int) -> Any:
    """A function of C that puts the results of ``function`` where it is told."""

    def call(context: Any, t: float, x: Any, result: Any) -> None:
        for i, value in enumerate(function(t, tuple(x[:states]))):
            result[i] = value

    return Rates(call)


def pendulum(t: float, x: Any) -> tuple[float, float]:
    """The right-hand side of ``runge_kutta.json``."""
    return x[1], -x[0] / (1.0 + x[0] * x[0]) - 0.3 * x[1] + t * t


@pytest.mark.parametrize("case", vectors("runge_kutta")["cases"])
def test_runge_kutta_step(case: dict[str, Any], runtime: ctypes.CDLL) -> None:
    t, x, h = case["t"], tuple(case["x"]), case["h"]
    y, _, (error,) = unrolled(DORMAND_PRINCE_5, 2)(pendulum, t, x, pendulum(t, x), h)
    system = System(None, 2, 0, callback(pendulum, 2), Rates(), OnEvent())
    c_y, c_error = doubles(2), doubles(2)
    step = (ctypes.byref(system), ctypes.c_double(t), doubles(x), ctypes.c_double(h), c_y, c_error)
    assert runtime.twin_step(*step) == 0
    assert (list(y), list(error)) == (list(c_y), list(c_error)), "the same operations in the same order"
    # weights add up to some 30, rates are below the largest value of the case
    size = max(map(abs, (*case["end"], *x, t * t)))
    assert y == pytest.approx(case["end"], rel=0.0, abs=30.0 * EPS * size)
    assert error == pytest.approx(case["error"], rel=0.0, abs=30.0 * EPS * h * size)


@pytest.mark.parametrize("case", vectors("events")["cases"], ids=lambda case: case["name"])
def test_events(case: dict[str, Any], runtime: ctypes.CDLL) -> None:
    x0, end = tuple(case["x"]), case["end"]
    seen: dict[str, list[tuple[float, float, float]]] = {"Python": [], "C": []}

    def rates(t: float, x: Any) -> tuple[float, float]:
        return x[1], case["acceleration"]

    def indicators(t: float, x: Any) -> tuple[float, ...]:
        return tuple(x[0] - level for level in case["levels"])

    def python_event(t: float, x: Any) -> tuple[float, float]:
        seen["Python"].append((t, x[0], case["factor"] * x[1]))
        return seen["Python"][-1][1:]

    def c_event(context: Any, t: float, x: Any) -> None:
        x[1] *= case["factor"]
        seen["C"].append((t, x[0], x[1]))

    final = {"Python": integrate(
        rates, 0.0, x0, end, rtol=1e-6, atol=(1e-6, 1e-6), indicators=indicators, on_event=python_event
    )[0]}  # fmt: skip
    system = System(None, 2, len(case["levels"]), callback(rates, 2), callback(indicators, 2), OnEvent(c_event))
    x, t, step = doubles(x0), ctypes.c_double(0.0), ctypes.c_double(0.0)
    work = doubles(runtime.integrate_work(2, len(case["levels"])))
    numbers_ = (ctypes.c_double(end), ctypes.c_double(1e-6), ctypes.c_double(1e-6))
    assert runtime.integrate(ctypes.byref(system), ctypes.byref(t), x, *numbers_, ctypes.byref(step), work) == 0
    final["C"] = tuple(x)
    assert seen["C"] == seen["Python"] and final["C"] == final["Python"], "the same decisions"
    # motions of degree 2 are stepped without error; an event is met within the width of its bracket, and what it is late is
    # carried on by velocities below 10 m/s
    width = 4.0 * EVENT_WIDTH * end
    assert [e[0] for e in seen["C"]] == pytest.approx(case["times"], rel=0.0, abs=width)
    assert np.array([e[1:] for e in seen["C"]]).ravel() == pytest.approx(
        np.ravel(case["states"]), rel=0.0, abs=10.0 * width
    )
    assert final["C"] == pytest.approx(case["final"], rel=0.0, abs=20.0 * width)


def column_major(a: Any) -> Any:
    return doubles(np.asarray(a, dtype=float).ravel(order="F").tolist())


@pytest.mark.parametrize("case", vectors("dense")["cases"], ids=lambda case: case["name"])
def test_eigenvalues_and_exponentials(case: dict[str, Any], runtime: ctypes.CDLL) -> None:
    a = np.array(case["a"], dtype=float)
    n = len(a)
    exact = np.array([complex(*value) for value in case["eigenvalues"]])
    values, t, work = doubles(2 * n), doubles(2 * n * n), doubles(2 * n)
    assert runtime.eigenvalues(n, column_major(a), values, t, work)
    both = (np.linalg.eigvals(a), np.array(values).view(complex))
    for eigenvalues in both:
        # conditions of these eigenvalues are below 1e3, relative to the norm after balancing, which is near them
        nearest = np.abs(eigenvalues[:, None] - exact).min(axis=0)
        assert nearest.max() < 1e3 * EPS * np.abs(exact).max()
    for each in case["exponentials"]:
        wanted = np.array(each["exp"])
        at = column_major(each["t"] * a)
        assert runtime.exponential(n, at, doubles(6 * n * n), (ctypes.c_int * n)())
        norm = max(1.0, np.abs(each["t"] * a).sum(axis=0).max())
        for result in (exponential(each["t"] * a), np.array(at).reshape(n, n, order="F")):
            # squarings double an error of rounding until it has grown by the norm
            assert np.abs(result - wanted).max() < 4.0 * norm * EPS * np.abs(wanted).max()


def test_exact_steps() -> None:
    """The operators of `exact_step`, whose twin in C takes part in ``scheduled.json``."""
    file = vectors("exact_step")
    a, b = np.array(file["a"], dtype=float), np.array(file["b"], dtype=float)
    for case in file["cases"]:
        step = exact_step(a, b, case["h"], case["order"])
        wanted = np.hstack([np.array(g) for g in case["gains"]])
        # rows by their own size; A h is up to 2e3 before balancing and 10 after it, four squarings of some 1e-13 each
        for result, exact in ((step.transition, np.array(case["transition"])), (step.gains, wanted)):
            size = np.abs(exact).max(axis=1, keepdims=True)
            assert (np.abs(result - exact) / size).max() < 1e-11


@pytest.fixture(scope="module")
def masses(tmp_path_factory: pytest.TempPathFactory) -> Library:
    if not compiler_found():
        pytest.skip("no C compiler")
    traced = trace(example.UNIT, {})
    return unit_library(traced, tmp_path_factory.mktemp("masses")), traced


def test_steps_with_a_schedule(masses: Library) -> None:
    """Cubic inputs, a schedule that is frozen in the middle of a step, an own state and its degree 4."""
    file = vectors("scheduled")
    p = example.Parameters(**file["parameters"], masses=2.0, band=3.0)
    unit = example.LINEAR.prepared(p)
    native = NativeInstance(*masses, **file["parameters"])
    x: tuple[float, ...] = (file["parameters"]["start"], 0.0, 0.0, 0.0, 0.0)
    for step in file["steps"]:
        wanted = [*step["z"], step["impulse"]]
        inputs = {
            name + (f"_d{k}" if k else ""): value
            for name in ("force", "pace") for k, value in enumerate(step[name])
        }  # fmt: skip
        cubics = [[value / math.factorial(k) for k, value in enumerate(step[name])] for name in ("force", "pace")]
        x = unit.advance(step["h"], x, cubics)
        assert native.set(**inputs) == DONE and native.step(step["t"], step["h"]) == DONE
        # some ten products of numbers of order 1
        assert x == pytest.approx(wanted, rel=0.0, abs=20.0 * EPS)
        names = [*(f"state.z[{i + 1}]" for i in range(4)), "state.impulse"]
        assert native.get(*names) == pytest.approx(wanted, rel=0.0, abs=20.0 * EPS)


def test_ship_in_closed_form(tmp_path: Path) -> None:
    """Under-, critically and overdamped, a reaction that is a cubic."""
    file = vectors("oscillator")
    compiled = Compiled(trace(load("ship")), tmp_path) if compiler_found() else None
    for case in file["cases"]:
        values = {v.name: v.start for v in load("ship").parameters}
        values |= {"mass": file["mass"], "stiffness": file["stiffness"], "damping": case["damping"]}
        p, h, x, reaction = ship.Parameters(**values), case["h"], ship.State(*case["x"]), case["reaction"]
        results = [list(ship.advance(0.0, h, x, ship.Modes(), ship.Inputs(reaction), p, FLOATS))]
        if compiled:
            results += compiled("advance", [0.0], [h], x, [], reaction, list(values.values()), [])
        # near critical damping the formula takes what rounding leaves of a difference, and its root
        near = abs(file["stiffness"] / file["mass"] - (0.5 * case["damping"] / file["mass"]) ** 2) < 1e-12
        for end in results:
            assert end == pytest.approx(case["end"], rel=math.sqrt(EPS) if near else 1e-12, abs=1e-15), case


@pytest.mark.parametrize("case", vectors("cradle")["cases"])
def test_cradle_without_drag(case: dict[str, Any], tmp_path: Path) -> None:
    """A motion of degree 5, which a method of order 5 follows without error."""
    start = vectors("cradle")["start"]
    inputs = {"line_tension" + (f"_d{k}" if k else ""): value for k, value in enumerate(case["tension"])}
    python = Instance(load("cradle"))
    index = python.unit.index
    python.set_values([index[n] for n in start], list(start.values()))
    python.set_up(0.0, None)
    python.enter_initialization()
    python.exit_initialization()
    python.set_values([index[n] for n in inputs], list(inputs.values()))
    python.do_step(0.0, case["h"])
    results = [python.get_values([index["heave"], index["velocity"]])]
    if compiler_found():
        traced = trace(load("cradle"))
        native = NativeInstance(unit_library(traced, tmp_path), traced, **start)
        assert native.set(**inputs) == DONE and native.step(0.0, case["h"]) == DONE
        results.append(native.get("heave", "velocity"))
    for values in results:
        assert values == pytest.approx([case["heave"], case["velocity"]], rel=20.0 * EPS)  # of sums of some ten terms


def complex_gains(values: Any) -> Any:
    """(frequencies, rows, inputs) from pairs."""
    return np.array(values)[..., 0] + 1j * np.array(values)[..., 1]


@pytest.mark.parametrize("case", vectors("reduction")["cases"], ids=lambda case: f"{case['method']}-{case['states']}")
def test_reduction(case: dict[str, Any], runtime: ctypes.CDLL) -> None:
    file = vectors("reduction")
    matrices = {name: np.array(rows, dtype=float) for name, rows in file["system"].items()}
    full = StateSpace(None, **matrices)  # type: ignore[arg-type]
    places, band, modal = file["places"], file["band"], case["method"] == "modal"
    frequencies = band_frequencies(band)
    assert frequencies[places] == pytest.approx(file["frequencies"], rel=1e-14)
    assert np.abs(transfer(full, frequencies)[places] - complex_gains(file["gains"])).max() < 1e-12
    # the smallest model within the tolerance is this one, unless one with fewer states is better still
    others = [c for c in file["cases"] if c["method"] == case["method"] and c["states"] <= case["states"]]
    wanted = next(c for c in others if c["error"] <= case["error"] * (1.0 + 1e-9))
    tolerance = case["error"] * (1.0 + 1e-9)
    python = reduce(full, tolerance, band, modal, 4)
    gains = complex_gains(wanted["gains"])
    n, k, r = len(full.a), full.b.shape[1], len(full.c)
    held = [column_major(matrices[name]) for name in "abcde"]
    pointers = (Pointer * 5)(*(ctypes.cast(a, Pointer) for a in held))
    error, values = doubles(1), doubles(2 * len(frequencies) * k * 4)
    numbers_ = (ctypes.c_double(band), ctypes.c_double(tolerance))
    states = runtime.twin_reduce(ctypes.c_bool(modal), (ctypes.c_int * 3)(n, k, r), pointers, *numbers_, error, values)
    assert (len(python.model.a), states) == (wanted["states"],) * 2
    c_gains = np.array(values).view(complex).reshape(len(frequencies), k, 4).transpose(0, 2, 1)
    # gramians and eigenvectors cost some digits: conditions of the order of 1e3
    assert (python.error, error[0]) == pytest.approx((wanted["error"],) * 2, rel=1e-9)
    for small in (transfer(python.model, frequencies), c_gains):
        assert np.abs(small[places] - gains).max() < 1e-10 * np.abs(gains).max()
