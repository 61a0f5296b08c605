"""What is traced is the model: every function of every unit, compiled, against the same function of floats."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.fmus.native.source import model_source
from towage.fmus.native.trace import FORWARD, trace
from towage.fmus.native.traced import NotNative, Traced
from towage.models.numeric.ops import FLOATS

from .compiled import Compiled, point

TRACED = tuple(n for n in UNITS if not (load(n).model.floats_only or load(n).model.linear or load(n).files))
"""Linear units are traced from their matrices, and tested with them; units with kernels in `test_kernels`."""
POINTS = 200
ROUNDING = 1e-13
"""CasADi writes x*x*x and 2*x*0.5 in its own order: some roundings of numbers up to 20, a thousandth of an output where
terms cancel; most functions are equal to the last bit."""
ARGUMENTS = {
    "required": "pc", "calculate": "pc", "initial": "pc", "derivatives": "txmupc", "indicate": "txmupc",
    "change": "txmupc", "next_event": "tmpc", "outputs": ("t", "x", "m", "u", "du", "p", "c"), "advance": "thxmkpc",
}  # fmt: skip


@pytest.fixture(scope="module", params=TRACED)
def unit(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Traced, Compiled]:
    traced = trace(load(request.param))
    return traced, Compiled(traced, tmp_path_factory.mktemp("compiled"))


def points(traced: Traced, count: int = POINTS) -> Iterable[SimpleNamespace]:
    chance = random.Random(1)
    for _ in range(count):
        at = point(traced.interface.unit, traced.modes, len(traced.interface.states), chance)
        at.c = []
        yield at


def vectors(name: str, at: SimpleNamespace) -> list[list[float]]:
    return [getattr(at, key) for key in ARGUMENTS[name]]


def floats(name: str, model: Any, at: SimpleNamespace) -> list[list[float]]:
    """Results of the model itself."""
    inputs = model.Inputs._make
    t, x, m, u, du, p = at.t[0], model.State(*at.x), model.Modes(*at.m), inputs(at.u), inputs(at.du), at.parameters
    cubics = inputs(at.k[4 * i : 4 * i + 4] for i in range(len(u)))
    call: dict[str, Callable[[], Any]] = {
        "required": lambda: [[value for value, _ in model.requirements(p, FLOATS)]],
        "calculate": lambda: [model.calculated(p, FLOATS)],
        "initial": lambda: model.initial(p, FLOATS),
        "derivatives": lambda: [model.derivatives(t, x, m, u, p, FLOATS)],
        "indicate": lambda: [model.indicators(t, x, m, u, p, FLOATS)],
        "change": lambda: model.transition(t, x, m, u, p, FLOATS),
        "next_event": lambda: [[model.next_event_time(t, m, p, FLOATS)]],
        "outputs": lambda: [model.outputs(t, x, m, u, du, p, FLOATS)],
        "advance": lambda: [model.advance(t, at.h[0], x, m, cubics, p, FLOATS)],
    }
    return [list(map(float, result)) for result in call[name]()]


def test_functions_equal_those_of_floats(unit: tuple[Traced, Compiled]) -> None:
    traced, compiled = unit
    model, counted = traced.interface.unit.model, 0
    for at in points(traced):
        for name in traced.functions:
            if name in ARGUMENTS:
                expected = floats(name, model, at)
                found = compiled(name, *vectors(name, at))
                assert [len(r) for r in found] == [len(r) for r in expected], name
                for a, b in zip(found, expected):
                    assert a == pytest.approx(b, rel=ROUNDING, abs=ROUNDING), (name, at)
                    counted += len(a)
    assert counted > POINTS


def test_derivatives_equal_central_differences(unit: tuple[Traced, Compiled]) -> None:
    """In states, inputs, their rates and time; away from kinks by the chance of the points, but for the few where a
    difference straddles one, which show as a disagreement between two widths."""
    traced, compiled = unit
    checked = 0
    for at in points(traced, 40):
        for name in FORWARD:
            if name not in traced.functions:
                continue
            arguments = vectors(name, at)
            chance = random.Random(2)
            moved = [key in ("t", "x", "u", "du") for key in ARGUMENTS[name]]
            seeds = [[chance.uniform(-1.0, 1.0) * move for _ in v] for v, move in zip(arguments, moved)]
            (result,) = compiled(name, *arguments)
            (found,) = compiled(f"{name}_forward", *arguments, result, *seeds)

            def difference(width: float) -> list[float]:
                ends = [
                    compiled(name, *([a + s * d for a, d in zip(v, e)] for v, e in zip(arguments, seeds)))[0]  # noqa: B023
                    for s in (-width, width)
                ]
                return [(b - a) / (2.0 * width) for a, b in zip(*ends)]

            for value, derivative, wide, narrow in zip(result, found, difference(2e-5), difference(1e-5)):
                # roundings of the values over the width, and the third derivative (frequencies up to 6 rad/s)
                allowed = 1e-6 * (1.0 + abs(derivative)) + 1e-10 * abs(value)
                if math.isfinite(narrow) and abs(wide - narrow) < allowed:
                    assert derivative == pytest.approx(narrow, abs=10.0 * allowed), (name, at)
                    checked += 1
    assert checked > 100


def test_zeros_leave_everything_finite(unit: tuple[Traced, Compiled]) -> None:
    """Both sides of a choice are computed; the one not taken may divide by zero and must not get through, not even into a
    derivative. Parameters are zero but for those of the reference run, or as declared."""
    traced, compiled = unit
    declared = traced.interface.unit
    (at,) = points(traced, 1)
    for key in ("t", "x", "u", "du"):
        setattr(at, key, [0.0] * len(getattr(at, key)))
    defaults = [v.start or 0.0 for v in declared.parameters]
    zeros = [declared.start.get(v.name, max(v.min or 0.0, 0.0)) for v in declared.parameters]
    for name in (name for name in FORWARD if name in traced.functions):
        for at.p in (defaults, zeros):
            arguments = vectors(name, at)
            (result,) = compiled(name, *arguments)
            assert all(map(math.isfinite, result)), (name, result)
            for k in range(len(arguments)):
                seeds = [[float(k == i)] * len(v) for i, v in enumerate(arguments)]
                (found,) = compiled(f"{name}_forward", *arguments, result, *seeds)
                assert all(map(math.isfinite, found)), (name, ARGUMENTS[name][k], found)


def test_source_is_the_same_every_time_and_only_functions_are_visible() -> None:
    texts = {model_source(trace(load("cradle_on_line")).functions) for _ in range(2)}
    (text,) = texts
    visible = {line.split("(")[0].split()[-1] for line in text.splitlines() if line.startswith(("int ", "void ", "casadi"))}
    assert visible == {f"model_{name}" for name in trace(load("cradle_on_line")).functions}


def test_what_cannot_be_traced_is_refused_with_the_reason() -> None:
    wire = load("wire")
    with pytest.raises(NotNative, match="wire has no native flavour: its implicit steps"):
        trace(replace(wire, model=replace(wire.model, numbers=None)))
    with pytest.raises(NotNative, match="cradle.segments is no structural parameter: cradle has none"):
        trace(load("cradle"), {"segments": 3.0})
