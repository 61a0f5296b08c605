"""One spelling of the physics for floats, arrays and symbols."""

from __future__ import annotations

import ast
import inspect
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.fmus.declare.unit import load
from towage.models.heave.cradle import CRADLE
from towage.models.heave.cradle_on_line import CRADLE_ON_LINE
from towage.models.heave.ship import SHIP
from towage.models.heave.spring_line import SPRING_LINE
from towage.models.numeric.ops import FLOATS, arrays, symbols
from towage.models.protocol.model import AnyModel

MODELS = {model.name: model for model in (SHIP, SPRING_LINE, CRADLE, CRADLE_ON_LINE)}
STATES = [(0.3, -0.7), (-1.2, 0.4), (0.0, 0.0)]


def parameters(name: str) -> Any:
    unit = load(name)
    start = {v.name: v.start for v in unit.parameters} | {"mass": 5.0, "stiffness": 3.0, "breaking_load": 50.0}
    known = {"static_tension": 2.0, "weight_in_water": 2.0, "wave_speed": 9.0, "length": 4.0, "ramp_time": 3.0}
    names = [v.name for v in unit.parameters]
    return MODELS[name].Parameters(**{f: known.get(f, start.get(f)) for f in names})


def call(model: AnyModel, function: str, x: Any, u: Any, p: Any, ops: Any) -> Any:
    modes = model.Modes(*(1.0 for _ in model.Modes._fields))
    x = model.State(*x[: len(model.State._fields)])
    u = model.Inputs(*u[: len(model.Inputs._fields)])
    if function == "derivatives":
        assert model.derivatives is not None
        return model.derivatives(0.7, x, modes, u, p, ops)
    return model.outputs(0.7, x, modes, u, u, p, ops)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("function", ["derivatives", "outputs"])
def test_arrays_give_what_floats_give(name: str, function: str) -> None:
    model, p = MODELS[name], parameters(name)
    if function == "derivatives" and not model.derivatives:
        pytest.skip("a spring has no derivatives")
    single = [call(model, function, x, x, p, FLOATS) for x in STATES]
    columns = tuple(np.array(c) for c in zip(*STATES))
    batch = call(model, function, columns, columns, p, arrays())
    for k, one in enumerate(single):
        together = [float(np.broadcast_to(np.asarray(component, dtype=float), (3,))[k]) for component in batch]
        assert together == pytest.approx(list(one), rel=1e-15, abs=1e-300)  # the same operations in the same order


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("function", ["derivatives", "outputs"])
def test_symbols_give_what_floats_give(name: str, function: str) -> None:
    casadi = pytest.importorskip("casadi")
    model, p = MODELS[name], parameters(name)
    if function == "derivatives" and not model.derivatives:
        pytest.skip("a spring has no derivatives")
    v = casadi.SX.sym("v", 2)
    traced = casadi.Function(
        "f", [v], [casadi.vertcat(*call(model, function, (v[0], v[1]), (v[0], v[1]), p, symbols()))]
    )
    for x in STATES:
        expected = list(call(model, function, x, x, p, FLOATS))
        assert np.array(traced(x)).ravel().tolist() == pytest.approx(
            expected, rel=1e-14, abs=1e-14
        )  # CasADi reorders sums


def test_the_trap_that_ops_is_there_for() -> None:
    """``math.sin`` of a symbol is nan without a word."""
    casadi = pytest.importorskip("casadi")
    assert math.isnan(math.sin(casadi.SX.sym("x")))


@pytest.mark.parametrize("name", MODELS)
def test_no_traced_function_uses_math_or_branches_on_values(name: str) -> None:
    tree = ast.parse(Path(inspect.getfile(MODELS[name].outputs)).read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name not in ("parallel", "series"):
            for inner in ast.walk(node):
                where = f"{name}.{node.name}, line {getattr(inner, 'lineno', 0)}"
                assert not isinstance(inner, (ast.If, ast.IfExp, ast.While, ast.Assert)), where
                if isinstance(inner, ast.Attribute) and isinstance(inner.value, ast.Name) and inner.value.id == "math":
                    assert inner.attr == "pi", where


def test_a_large_product_is_a_loop_in_a_trace() -> None:
    """Its values and derivatives are those of the terms written out; its text does not grow with the matrix."""
    ca = pytest.importorskip("casadi")
    from towage.models.numeric.dual_ops import Dual, duals
    from towage.models.numeric.ops import LARGE, dots, symbols

    generator = np.random.default_rng(2)
    table = generator.normal(size=(40, LARGE // 40 + 1))
    x, dx = generator.normal(size=(2, table.shape[1]))
    a = ca.SX.sym("a", len(x))
    parts = [a[k] for k in range(len(x))]
    assert np.allclose(FLOATS.product(table, x.tolist()), dots(table, x.tolist()))
    for product in (symbols().product, dots):
        y = ca.vertcat(*product(table, [ca.sin(each) for each in parts]))
        traced = ca.Function("traced", [a], [y])
        assert np.allclose(traced(x).full(), table @ np.sin(x)[:, None], rtol=1e-12, atol=1e-12)
        slope = traced.forward(1)(x, traced(x), dx)
        assert np.allclose(slope.full(), table @ (np.cos(x) * dx)[:, None], rtol=1e-12, atol=1e-12)
        assert (traced.n_instructions() < len(x) * 10) == (product is not dots)
    both = duals(symbols()).product(table, [Dual(each, 2.0 * each) for each in parts])
    values = ca.Function("both", [a], [ca.vertcat(*(b.value for b in both)), ca.vertcat(*(b.slope for b in both))])(x)
    assert np.allclose(2.0 * values[0].full(), values[1].full()) and np.allclose(values[0].full(), table @ x[:, None])
