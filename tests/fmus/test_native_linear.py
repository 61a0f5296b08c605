"""Linear units in C against numpy: exact steps, observation, derivatives."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from towage.fmus.native.trace import trace
from towage.models.numeric.matrix_ops import numbers

from . import linear_example as example
from .native_instance import DONE, MODEL_EXCHANGE, NO_STEP, REFUSED, Library, NativeInstance, unit_library


@pytest.fixture(scope="module")
def masses(tmp_path_factory: pytest.TempPathFactory) -> Library:
    traced = trace(example.UNIT, {})
    return unit_library(traced, tmp_path_factory.mktemp("masses")), traced


PARAMETERS = example.Parameters(4.0, 0.3, 1.5, 0.1, 2.0, 3.0)
FORCE, PACE = (0.4, -0.8, 0.6, 0.9), (0.7, 0.5, -0.4, 0.3)
"""Value and three derivatives."""


def given(force: tuple[float, ...], pace: tuple[float, ...]) -> dict[str, float]:
    names = [f"{name}{end}" for name in ("force", "pace") for end in ("", "_d1", "_d2", "_d3")]
    return dict(zip(names, force + pace))


def matrices(s: float, p: example.Parameters = PARAMETERS) -> tuple[Any, ...]:
    found = example.setup(p, example.Size(), numbers())
    a, b = (m[0] + s * m[1] + s * s * m[2] for m in (found.a, found.b))
    return a, b, found.c, found.d, found.e


def stepped(z: Any, impulse: float, force: Any, s: float, h: float, p: example.Parameters = PARAMETERS) -> Any:
    """One exponential of everything: z, impulse, and the derivatives of the force."""
    a, b, *_ = matrices(s, p)
    block = np.zeros((9, 9))
    block[:4, :4], block[:4, 4], block[:4, 5] = a, b[:, 1], b[:, 0]
    block[4, 5] = block[5, 6] = block[6, 7] = block[7, 8] = 1.0
    return (expm(block * h) @ np.array([*z, impulse, *force]))[:5]


def taylor(u: tuple[float, ...], h: float) -> tuple[float, float]:
    """Value and rate after ``h``."""
    return (
        u[0] + h * (u[1] + h * (u[2] / 2.0 + h * u[3] / 6.0)),
        u[1] + h * (u[2] + h * u[3] / 2.0),
    )


@pytest.mark.parametrize("h", [1e-3, 0.3, 7.0])
def test_steps_and_observation(h: float, masses: Library) -> None:
    it = NativeInstance(*masses)
    x = np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    for k in range(3):
        assert it.set(**given(FORCE, PACE)) == DONE
        assert it.step(k * h, h) == DONE
        x = stepped(x[:4], x[4], FORCE, taylor(PACE, 0.5 * h)[0] ** 2, h)
    scale = np.abs(x).max()
    # rounding, times the growth of an inverted spring where the pace is large
    found = it.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse")
    assert np.abs(found - x).max() <= 1e-11 * scale
    (f, df), (pace, _) = taylor(FORCE, h), taylor(PACE, h)
    a, b, c, d, e = matrices(pace**2)
    v, dv, ddv = np.array([f, x[4]]), np.array([df, f]), np.array([0.0, df])
    rate = a @ x[:4] + b @ v
    y, dy = c @ x[:4] + d @ v + e @ dv, c @ rate + d @ dv + e @ ddv
    roots = np.linalg.eigvals(a)
    growth = max(roots.real[np.abs(roots) < 20.0])
    wanted = [y[0], y[1], growth, x[4] * y[3] * math.sin(f), dy[0], dy[1], *y]
    names = [*example.Outputs._fields, *(f"row[{i}]" for i in range(1, 5))]
    size = max(np.abs(wanted))
    assert np.abs(np.array(it.get(*names)) - wanted).max() <= 1e-11 * size


def test_study_finds_what_numpy_finds(masses: Library) -> None:
    it = NativeInstance(*masses)
    own, longer = (example.setup(PARAMETERS, example.Size(n), numbers()) for n in (2.0, 3.0))
    worst = 0.0
    for omega in np.geomspace(0.02, 3.0, 40):
        s = -1j * omega
        gains = [m.c @ np.linalg.solve(s * np.eye(len(m.a[0])) - m.a[0], m.b[0]) + m.d + s * m.e for m in (own, longer)]
        for rows in (slice(0, 2), slice(2, 4)):
            difference = np.abs(gains[0][rows] - gains[1][rows]).max(axis=0)
            worst = max(worst, (difference / np.abs(gains[1][rows]).max(axis=0)).max())
    resolved = 0
    for k in range(1, 9):
        s = 0.25 * k
        found, finer = (np.linalg.eigvals(m.a[0] + s * m.a[1] + s * s * m.a[2]) for m in (own, longer))
        slowest = min(finer[finer.imag >= 0.0], key=abs)
        if np.abs(found - slowest).min() > 0.5 * abs(slowest):
            break
        resolved = k
    error, limit = it.get("error", "resolved")
    assert error == pytest.approx(0.5 * worst, rel=1e-12)  # the same arithmetic but for its order
    assert limit == max(resolved, 0.5) * 0.25
    # without damping `when` is not met
    assert NativeInstance(*masses, damping=0.04).get("error") == [0.0]


def test_prepared_steps_come_and_go_without_a_trace(masses: Library) -> None:
    """Six pairs of step and pace in turn are more than are kept: a run is bit-equal to one that makes each anew."""
    mixed = NativeInstance(*masses)
    time, results = 0.0, []
    plan = [(h, pace) for _ in range(3) for h in (0.1, 0.25, 0.7) for pace in (0.3, 1.1)]
    for h, pace in plan:
        before = mixed.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse")
        results.append((before, h, pace))
        mixed.set(**given(FORCE, (pace, 0.0, 0.0, 0.0)))
        assert mixed.step(time, h) == DONE
        time += h
    again = NativeInstance(*masses)
    time = 0.0
    for before, h, pace in results:
        assert again.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse") == before
        again.set(**given(FORCE, (2.0, 0.0, 0.0, 0.0)))
        again.set(**given(FORCE, (pace, 0.0, 0.0, 0.0)))
        again.get("growth")  # observes in between
        assert again.step(time, h) == DONE
        time += h


def test_inputs_below_their_minimum_make_no_step(masses: Library) -> None:
    it = NativeInstance(*masses)
    for pace in ((-0.1, 0.0, 0.0, 0.0), (0.1, -1.0, 0.0, 0.0)):
        it.set(**given(FORCE, pace))
        assert it.step(0.0, 0.5) == NO_STEP
        assert "pace = -0." in it.message and "expected at least 0" in it.message
    it.set(**given(FORCE, (0.1, -0.2, 0.0, 0.0)))
    assert it.step(0.0, 0.5) == DONE


def test_a_tunable_parameter_acts_from_the_next_step_on(masses: Library) -> None:
    it = NativeInstance(*masses)
    x = np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    for k, stiffness in enumerate((4.0, 9.0, 4.0)):
        it.set(stiffness=stiffness, **given(FORCE, PACE))
        assert it.step(0.2 * k, 0.2) == DONE
        p = replace(PARAMETERS, stiffness=stiffness)
        x = stepped(x[:4], x[4], FORCE, taylor(PACE, 0.1)[0] ** 2, 0.2, p)
    found = it.get(*(f"state.z[{i}]" for i in range(1, 5)), "state.impulse")
    assert np.abs(found - x).max() < 1e-13  # rounding
    assert it.set(stiffness=-1.0) == DONE and it.step(0.6, 0.2) == REFUSED
    assert it.message.endswith("stiffness must be positive")


def test_directional_derivatives(masses: Library) -> None:
    it = NativeInstance(*masses, kind=MODEL_EXCHANGE)
    assert masses[0].instance_enter_continuous(it.handle) == DONE
    states = [*(f"z[{i}]" for i in range(1, 5)), "impulse"]
    knowns = [*(f"state.{s}" for s in states), "force", "pace"]
    unknowns = [*example.Outputs._fields, *(f"der(state.{s})" for s in states)]
    at = np.array([0.3, -0.2, 0.5, 0.1, 0.7, 0.4, 0.8])

    def seen(x: Any) -> Any:
        it.set_states(x[:5].tolist())
        it.set(force=x[5], pace=x[6], force_d1=0.3, pace_d1=0.2)
        return np.array([*it.get(*example.Outputs._fields), *it.derivatives()])

    for j, name in enumerate(knowns):
        step = 1e-4 * np.eye(7)[j]
        # Richardson of central differences: h^4 = 1e-16, rounding 1e-15/h
        slope = (8.0 * (seen(at + step) - seen(at - step)) - (seen(at + 2.0 * step) - seen(at - 2.0 * step))) / 12e-4
        seen(at)
        found = it.directional(unknowns, [name], [1.0])
        assert np.abs(found - slope).max() < 1e-8, name


def test_derivatives_are_those_of_the_step(masses: Library) -> None:
    """Model exchange and co-simulation are of one model: (x(h) - x(-h))/2h of exact steps."""
    it = NativeInstance(*masses, kind=MODEL_EXCHANGE)
    assert masses[0].instance_enter_continuous(it.handle) == DONE
    x, force, pace = np.array([0.3, -0.2, 0.5, 0.1, 0.7]), (0.4, 0.0, 0.0, 0.0), 0.8
    it.set_states(x.tolist())
    it.set(force=force[0], pace=pace)
    h = 1e-4
    exact = (stepped(x[:4], x[4], force, pace**2, h) - stepped(x[:4], x[4], force, pace**2, -h)) / (2.0 * h)
    assert np.abs(np.array(it.derivatives()) - exact).max() < 1e-6  # h^2 times the third derivative
