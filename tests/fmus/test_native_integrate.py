"""The integrator in C against `models/numeric/integrate.py`: the same steps, events and states to the last bit."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest

from towage.models.numeric.integrate import IntegrationError, Vector, integrate

from .native_instance import OnEvent, Rates, System, compile_library, doubles

Double = ctypes.c_double


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    return compile_library(["integrate.c"], tmp_path_factory.mktemp("integrate") / "integrate.so")


@dataclass
class Case:
    """x' = rates(t, x, branch); at events the branch becomes ``turn(x)``."""

    start: Vector
    end: float
    rates: Callable[[float, Any, bool], Vector]
    indicators: Callable[[float, Any], Vector]
    turn: Callable[[Any], bool] = lambda x: True
    first_step: float = 0.0
    tolerance: float = 1e-9
    branch: bool = True
    calls: list[float] = field(default_factory=list)
    """Times of all evaluations of the rates, and of events."""

    def rate(self, t: float, x: Any) -> Vector:
        self.calls.append(t)
        return self.rates(t, x, self.branch)

    def event(self, t: float, x: Any) -> Any:
        self.calls.append(-t)
        self.branch = self.turn(x)
        return x


def line(t: float, x: Any) -> Vector:
    """Velocity, and stretch of a line under a body that hangs from a moving end."""
    return x[1], 0.4 + math.sin(0.7 * t) - x[0]


CASES: dict[str, Callable[[], Case]] = {
    "smooth": lambda: Case((1.0, 0.0), 20.0, lambda t, x, b: (x[1], -x[0]), lambda t, x: (1.0,), first_step=0.1),
    "slack": lambda: Case(
        (-2.0, 0.0), 40.0, lambda t, x, b: (x[1], max(line(t, x)[1], 0.0) - 0.4 - 0.3 * abs(x[1]) * x[1]), line,
        first_step=0.1,
    ),
    "dip": lambda: Case(
        (0.0,), 1.0, lambda t, x, b: (1.0,), lambda t, x: (x[0] - 0.9, (x[0] - 0.2) * (x[0] - 0.25)),
        first_step=1.0,
    ),
    "dip in rounding": lambda: Case(
        (0.0,), 1.0, lambda t, x, b: (1.0,), lambda t, x: (1.0 + 1e-5 * (x[0] - 0.3) * (x[0] - 0.31) - 1.0,),
        first_step=1.0,
    ),
    "sliding": lambda: Case(
        (0.005,), 0.05, lambda t, x, b: (-1.0 if b else 1.0,), lambda t, x: (x[0],), lambda x: bool(x[0] > 0.0),
        first_step=0.1,
    ),
    "smallest": lambda: Case((2.2e-311, 0.0), 1.0, lambda t, x, b: (x[1], -x[0]), lambda t, x: (x[1],), tolerance=1e-13),
    "underflow": lambda: Case((0.0,), 1.0, lambda t, x, b: (1.0,), lambda t, x: (5e-324 if x[0] < 0.3 else 0.0,)),
    "double zero": lambda: Case((0.0, 0.0), 1.0, lambda t, x, b: (x[1], 1.0), lambda t, x: (x[0],), first_step=1.0),
    "pole": lambda: Case((1.0,), 2.0, lambda t, x, b: (x[0] * x[0],), lambda t, x: (1.0,), first_step=0.1),
}  # fmt: skip


EVENTLESS = {"smooth", "smallest", "pole"}


def in_python(case: Case) -> tuple[Any, ...]:
    try:
        x, step = integrate(
            case.rate, 0.0, case.start, case.end, rtol=case.tolerance, atol=(case.tolerance,) * len(case.start),
            indicators=case.indicators, on_event=case.event, first_step=case.first_step,
        )  # fmt: skip
    except IntegrationError:
        return ("refused", case.calls)
    return ([v.hex() for v in x], step.hex(), case.calls)


def in_c(library: ctypes.CDLL, case: Case) -> tuple[Any, ...]:
    states, indicators = len(case.start), len(case.indicators(0.0, case.start))

    def fill(to: Any, values: Vector) -> None:
        for i, value in enumerate(values):
            to[i] = value

    system = System(
        None, states, indicators, Rates(lambda _, t, x, f: fill(f, case.rate(t, x[:states]))),
        Rates(lambda _, t, x, g: fill(g, case.indicators(t, x[:states]))),
        OnEvent(lambda _, t, x: fill(x, case.event(t, x[:states]))),
    )  # fmt: skip
    t, x, step = Double(0.0), doubles(case.start), Double(case.first_step)
    work = doubles(library.integrate_work(states, indicators))
    reason = library.integrate(
        ctypes.byref(system), ctypes.byref(t), x, Double(case.end), Double(case.tolerance), Double(case.tolerance),
        ctypes.byref(step), work,
    )  # fmt: skip
    return ("refused", case.calls) if reason else ([v.hex() for v in x], step.value.hex(), case.calls)


@pytest.mark.parametrize("name", CASES)
def test_consistency_with_the_integrator_in_python(library: ctypes.CDLL, name: str) -> None:
    cases = CASES[name](), CASES[name]()
    here, there = in_python(cases[0]), in_c(library, cases[1])
    assert here == there
    assert any(call < 0.0 for call in cases[0].calls) == (name not in EVENTLESS)
