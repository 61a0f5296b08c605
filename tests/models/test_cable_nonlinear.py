"""The nonlinear tow cable against its linearisation, itself at smaller steps, published-size cases and MoorDyn."""

from __future__ import annotations

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.models.cable.case import Body, Cable, CableError, Tow
from towage.models.cable.loading import eames
from towage.models.cable.lumped.linear import tow_elastic
from towage.models.cable.lumped.lumped import equilibrium, steady_towpoint_force
from towage.models.cable.lumped.nonlinear import NonlinearCable, nonlinear_cable


def moordyn_tow() -> Any:
    """The benchmark's module with the common case."""
    name = "benchmark_moordyn_tow"
    if name not in sys.modules:
        path = Path(__file__).resolve().parents[2] / "benchmarks" / "moordyn_tow.py"
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec and spec.loader
        sys.modules[name] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return sys.modules[name]


OMEGA = 0.4 * math.pi


def float_tow() -> Tow:
    """Float above a submarine, SI."""
    cable = Cable(90.0, 0.83, 6.3, 0.015, 1.5, eames(0.03), 1.0, True, 4e6)
    return Tow(cable, Body(300.0, 70.0, 200.0, 2800.0, 6200.0, 900.0, 0.0, 0.0), 3.0867, 1025.0, 2)


def ramp(t: float, duration: float = 8.0) -> tuple[float, float]:
    s = min(t / duration, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s * s * (1.0 - s) ** 2 / duration


def heave(amplitude: float, t: float) -> np.ndarray:
    r, rate = ramp(t)
    v = amplitude * (r * OMEGA * math.cos(OMEGA * t) + rate * math.sin(OMEGA * t))
    return np.array([0.0, v, 0.0, 0.0])


def run(cable: NonlinearCable, amplitude: float, step: float, settle: float = 20.0) -> dict[str, np.ndarray]:
    """Two periods after ``settle``, s."""
    state, rows = cable.start(), []
    count = round((settle + 10.0) / step)
    for k in range(count):
        state = cable.step(k * step, step, state, lambda t: heave(amplitude, t))
        t = (k + 1) * step
        if t > settle + 1e-9:
            acceleration = np.array([0.0, -amplitude * OMEGA**2 * math.sin(OMEGA * t)])
            tension = cable.tensions(state)
            force = cable.towpoint_force(state, heave(amplitude, t), acceleration)
            rows.append([t, tension[0], tension[-1], tension.min(), *force, state[1, 0, 0], state[1, 1, 0]])
    names = ("time", "bottom", "top", "least", "fx", "fy", "vx", "vy")
    return dict(zip(names, np.array(rows).T))


def harmonic(run: dict[str, np.ndarray], name: str, order: int = 1) -> complex:
    return complex(2.0 * np.mean(run[name] * np.exp(1j * order * OMEGA * run["time"])))


def test_steady_tow_is_a_fixed_point() -> None:
    for tow in (moordyn_tow().tow_case(), float_tow()):
        cable = nonlinear_cable(tow, 8)
        state = cable.start()
        for k in range(20):
            state = cable.step(k * 0.5, 0.5, state, lambda t: np.zeros(4))
        # rounding of EA over the stiffness of the chain
        assert np.abs(state - cable.start()).max() < 1e-7
        force = cable.towpoint_force(state, np.zeros(4), np.zeros(2))
        assert force == pytest.approx(steady_towpoint_force(cable.chain), rel=1e-6)


def test_small_heave_agrees_with_the_linear_model() -> None:
    tow = moordyn_tow().tow_case()
    cable, linear = nonlinear_cable(tow, 5), tow_elastic(tow, 5)
    found = run(cable, 0.01, 0.05)
    expected = linear.response(OMEGA, np.array([0.0, -1j * OMEGA, 0.0, 0.0])) * 0.01
    # a sine: Re(i a exp(-i omega t)), the gain's phase turned by pi/2; error of the step (omega h)^2 = 0.4 %
    for name, row in (("fx", 0), ("fy", 1), ("vx", 2), ("vy", 3), ("bottom", 8), ("top", 12)):
        assert harmonic(found, name) == pytest.approx(1j * expected[row], rel=6e-3), name


def test_small_lift_agrees_with_the_linear_model_in_quadrant_two() -> None:
    tow = float_tow()
    cable, linear = nonlinear_cable(tow, 5, quadratic_drag=False), tow_elastic(tow, 5)

    def lift(t: float) -> np.ndarray:
        return np.array([0.0, 0.0, 0.0, 5.0 * ramp(t)[0] * math.sin(OMEGA * t)])

    state, rows = cable.start(), []
    for k in range(700):
        state = cable.step(k * 0.05, 0.05, state, lift)
        if k >= 500:
            rows.append(
                [0.05 * (k + 1), *cable.towpoint_force(state, lift(0.05 * (k + 1)), np.zeros(2)), state[1, 1, 0]]
            )
    found = dict(zip(("time", "fx", "fy", "vy"), np.array(rows).T))
    expected = linear.response(OMEGA, np.array([0.0, 0.0, 0.0, 5.0j]))
    for name, row in (("fx", 0), ("fy", 1), ("vy", 3)):
        assert harmonic(found, name) == pytest.approx(complex(expected[row]), rel=1e-2), name


def test_steps_are_of_second_order() -> None:
    cable = nonlinear_cable(moordyn_tow().tow_case(), 3)

    def end(step: float) -> np.ndarray:
        state = cable.start()
        for k in range(round(4.0 / step)):
            state = cable.step(k * step, step, state, lambda t: heave(1.0, t))
        return state

    fine = end(0.0125)
    errors = [np.abs(end(h) - fine)[0].max() for h in (0.2, 0.1, 0.05)]
    order = np.diff(-np.log2(errors))
    # axial modes of the segments are beyond the step and damped; the rest is of order 2
    assert order == pytest.approx([2.0, 2.0], abs=0.35)


def test_slack_needs_no_small_steps() -> None:
    cable = nonlinear_cable(moordyn_tow().tow_case(), 6)
    found = run(cable, 8.0, 0.05, settle=10.0)
    # beyond 6.3 m the cable goes slack; it never pushes
    assert found["least"].min() == 0.0
    assert np.all(np.isfinite(found["top"])) and found["top"].max() > 8000.0


def test_body_may_pass_the_stream_and_come_back() -> None:
    # a float that loses its lift sinks below the towpoint's stream: out of its quadrant, still a solution
    tow = float_tow()
    cable = nonlinear_cable(tow, 6)
    state = cable.start()
    for k in range(200):
        state = cable.step(0.1 * k, 0.1, state, lambda t: np.array([0.0, 0.0, 0.0, -4200.0 * ramp(t)[0]]))
    assert cable.angles(state).max() > 3.0 or cable.angles(state).min() < 0.0
    assert np.all(np.isfinite(state))


def test_refuses_an_inextensible_cable() -> None:
    tow = moordyn_tow().tow_case()
    rigid = replace(tow, cable=replace(tow.cable, axial_stiffness=math.inf))
    with pytest.raises(CableError, match="finite axial stiffness"):
        NonlinearCable(equilibrium(rigid, 4))


def test_gives_up_with_a_message() -> None:
    cable = nonlinear_cable(moordyn_tow().tow_case(), 4)
    with pytest.raises(CableError, match="not found at t"):
        cable.step(0.0, 0.1, cable.start(), lambda t: np.array([math.nan, 0.0, 0.0, 0.0]))


@pytest.mark.slow
@pytest.mark.parametrize("amplitude, least, second", [(1.0, 5432.0, 0.068), (2.0, 4352.0, 0.136)])
def test_large_heave_as_measured_before(amplitude: float, least: float, second: float) -> None:
    found = run(nonlinear_cable(moordyn_tow().tow_case(), 20), amplitude, 0.05, settle=40.0)
    # an independent program's least tension, N, and share of the second harmonic
    assert found["least"].min() == pytest.approx(least, rel=2e-3)
    assert abs(harmonic(found, "top", 2)) / abs(harmonic(found, "top")) == pytest.approx(second, rel=0.02)


@pytest.mark.slow
def test_consistency_with_moordyn() -> None:
    pytest.importorskip("moordyn")
    case = moordyn_tow()
    theirs = case.run(1.0, 20, 0.002, 0.01, 150.0, 10.0)
    cable = nonlinear_cable(case.tow_case(), 20)
    ours = run(cable, 1.0, 0.05, settle=40.0)
    # the body of a heaving tow hangs within centimetres of the steady one
    assert theirs.body.mean(axis=0) == pytest.approx(-cable.chain.nodes[-1], abs=0.1)
    for name, values in (("bottom", theirs.bottom), ("top", theirs.top)):
        # asked: 1 % per metre of heave; both discretise with 20 segments
        assert abs(case.harmonic(theirs.time, values)) == pytest.approx(abs(harmonic(ours, name)), rel=0.01)
    second = abs(case.harmonic(theirs.time, theirs.top, 2))
    # asked: 5 %
    assert second == pytest.approx(abs(harmonic(ours, "top", 2)), rel=0.05)
