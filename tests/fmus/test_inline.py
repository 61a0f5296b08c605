"""Model functions written out for floats: the same values, the model untouched."""

from __future__ import annotations

import importlib.util
import inspect
import math
import sys
from dataclasses import fields
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from towage.fmus import UNITS
from towage.fmus.declare.unit import load
from towage.fmus.python.inline import STEPPED, floats, inlined_module
from towage.models.heave import cradle, cradle_on_line, spring_line
from towage.models.numeric.ops import FLOATS

ANY = st.floats(allow_nan=True, allow_infinity=True)

SOURCE = '''
from typing import NamedTuple

class State(NamedTuple):
    a: float
    b: float

def choices(a, b, ops):
    """Bounds of expressions, nested, each used once."""
    seen = []
    def note(x):
        seen.append(x)
        return x
    low, high = ops.minimum(note(a), b), ops.maximum(note(a), note(b))
    nested = ops.maximum(ops.minimum(a, b), ops.where(ops.abs(a) > b, ops.minimum(1.0, note(b)), -a))
    return low, high, nested, len(seen)

def derivatives(a, b, ops):
    return State(ops.abs(a), b)

def other(a, b, ops):
    return State(a, b)

def components(x: State, y: State, z):
    def inner(y):
        return y.a
    return x.a + x.b + (lambda x: x.b)(State(0.0, y.b)) + inner(z)
'''


def module(tmp_path: Any) -> ModuleType:
    """A module with `SOURCE` for its source."""
    file = tmp_path / "written.py"
    file.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("written", file)
    assert spec is not None and spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    sys.modules["written"] = made
    return made


def test_choices_are_those_of_ops(tmp_path_factory: Any) -> None:
    plain = module(tmp_path_factory.mktemp("source"))
    inlined = inlined_module(plain)

    @given(ANY, ANY)
    def same(a: float, b: float) -> None:
        def text(values: Any) -> list[str]:
            return [float(v).hex() for v in values]

        first, second = plain.choices(a, b, FLOATS), inlined.choices(a, b, None)
        assert text(first[:3]) == text(second[:3])
        # both count one use of each of three; the fourth lies in a side of `where` that may not be chosen
        assert first[3] == 4 and second[3] in (3, 4)

    same()
    assert type(inlined.derivatives(-1.0, 2.0, None)) is tuple and inlined.derivatives(-1.0, 2.0, None) == (1.0, 2.0)
    assert inlined.other(1.0, 2.0, None).b == 2.0  # names are kept where they may be used


def test_components_become_positions_where_an_annotation_names_them(tmp_path_factory: Any) -> None:
    inlined = inlined_module(module(tmp_path_factory.mktemp("source")))
    # x and y by position, the field of the same name of anything else as it is
    assert inlined.components((2.0, 3.0), (5.0, 7.0), SimpleNamespace(a=11.0)) == 2.0 + 3.0 + 7.0 + 11.0


@pytest.mark.parametrize("name", UNITS)
def test_no_function_is_left_out(name: str) -> None:
    """Every function of a model that takes states, modes or inputs takes them by position in an FMU."""
    model = load(name).model
    kinds = {"x", "m", "u", "du", "own", "cubics"}
    for record in (model, model.linear):
        for field in fields(record) if record else ():
            function = getattr(record, field.name)
            if isinstance(function, FunctionType) and kinds & set(inspect.signature(function).parameters):
                assert field.name in STEPPED, field.name


def test_models_are_left_alone() -> None:
    inlined = inlined_module(cradle_on_line)
    assert inlined.cradle is not cradle and cradle_on_line.cradle is cradle
    assert "ops" not in inlined.cradle.acceleration.__code__.co_names
    assert inlined.outputs.__code__.co_firstlineno == cradle_on_line.outputs.__code__.co_firstlineno
    assert inlined.outputs.__code__.co_filename == cradle_on_line.outputs.__code__.co_filename
    spelled = floats(cradle_on_line.CRADLE_ON_LINE)
    assert floats(cradle_on_line.CRADLE_ON_LINE) is spelled and spelled.Parameters is cradle_on_line.Parameters
    assert spelled.outputs is inlined.outputs and spelled.by_position
    x, m = spring_line.initial(None, FLOATS)  # type: ignore[arg-type]
    assert x == () and m.taut == 1.0 and math.isfinite(m.taut)
