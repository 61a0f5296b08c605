"""Model functions for Python floats alone: what they spell through ``ops`` written out, and names turned into positions.

An FMU computes with floats only, and there a call of ``ops.where`` costs more than the choice it makes. `floats` reads
the source of a model's functions and returns the same functions with

    ops.where(c, a, b) -> a if c else b,    ops.maximum(a, b) -> a if a > b else b,
    x.velocity -> x[1],    return State(a, b) -> return a, b

where x is a parameter whose annotation is a named tuple, and results become plain in the functions of `BY_POSITION` alone.
They take half the time. Values are those of `models.ops.FLOATS` to the last bit; only a side of ``where`` that is not chosen
is no longer evaluated. Line numbers are kept, so that tracebacks point into the model.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any

from ...models.numeric import ops
from ...models.protocol.model import AnyModel, Record

MODELS = ops.__name__.removesuffix("numeric.ops")
STEPPED = (
    "derivatives", "outputs", "advance", "indicators", "transition", "next_event_time",
    "drive", "core", "observe", "own_after", "own_rates", "schedule", "check_step",
)  # fmt: skip
"""All functions that take states, modes or inputs; the others see parameters alone, once."""
BY_POSITION = ("derivatives", "outputs", "transition", "advance", "observe")
"""Functions whose results are read by position."""


@cache
def floats(model: AnyModel) -> AnyModel:
    """The model with its functions for floats, which take plain tuples for named ones."""
    if model.over:  # made of other models, whose functions are spelled anew
        return model.over(floats)
    if model.linear:
        return replace(model.linear, **_inlined_functions(model.linear), by_position=True).as_model()
    return replace(model, **_inlined_functions(model), by_position=True)


def _inlined_functions(record: Record) -> dict[str, Any]:
    """The functions of a record that every step calls, inlined."""
    values = {field.name: getattr(record, field.name) for field in fields(record) if field.name in STEPPED}  # type: ignore[arg-type]
    return {name: _inlined(value) for name, value in values.items() if isinstance(value, FunctionType)}


def _inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function of a module, inlined with all of its module; any other as it is."""
    module = sys.modules.get(function.__module__)
    if module is None or not _of_models(module) or vars(module).get(function.__name__) is not function:
        return function
    inlined: Callable[..., Any] = getattr(inlined_module(module), function.__name__)
    return inlined


def _of_models(module: ModuleType) -> bool:
    """Whether a module holds functions of values: those of the models, and of other packages that bring units."""
    return module.__name__.startswith(MODELS) or hasattr(module, "Ops")


@cache
def inlined_module(module: ModuleType) -> Any:
    """The names of ``module``, with its functions, and those that take ``ops`` of what it imports, for floats."""
    names = dict(vars(module))
    for name, value in vars(module).items():
        if isinstance(value, ModuleType) and hasattr(value, "Ops"):
            names[name] = inlined_module(value)
        elif isinstance(value, FunctionType) and value.__annotations__.get("ops") == "Ops":
            names[name] = _inlined(value) if value.__module__ != module.__name__ else value
    tree = ast.parse(inspect.getsource(module))
    tree.body = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    inlined = ast.fix_missing_locations(_Inline(names).visit(tree))
    exec(compile(inlined, str(module.__file__), "exec", dont_inherit=True), names)
    return SimpleNamespace(**{name: value for name, value in names.items() if not name.startswith("__")})


class _Inline(ast.NodeTransformer):
    """Replaces calls and names of components; ``names`` is what the source may refer to."""

    def __init__(self, names: dict[str, Any]) -> None:
        self.names = names
        self.count = 0
        self.components: dict[str, tuple[str, ...]] = {}

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        for each in (*node.posonlyargs, *node.args, *node.kwonlyargs):
            self.components = {**self.components, each.arg: self._fields(each.annotation)}
            each.annotation = None
        return node

    def _fields(self, annotation: ast.expr | None) -> tuple[str, ...]:
        """The components of the named tuple that ``annotation`` names, none of anything else."""
        if isinstance(annotation, ast.Attribute) and isinstance(annotation.value, ast.Name):
            kind = getattr(self.names.get(annotation.value.id), annotation.attr, None)
        else:
            kind = self.names.get(annotation.id) if isinstance(annotation, ast.Name) else None
        return getattr(kind, "_fields", ())

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        outer, node.returns = self.components, None
        self.generic_visit(node)
        self.components = outer
        for statement in node.body if node.name in BY_POSITION else ():
            if isinstance(statement, ast.Return) and statement.value is not None:
                statement.value = self._plain(statement.value)
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        outer = self.components
        self.generic_visit(node)
        self.components = outer
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if isinstance(node.value, ast.Name) and node.attr in self.components.get(node.value.id, ()):
            place = self.components[node.value.id].index(node.attr)
            return ast.copy_location(ast.Subscript(node.value, ast.Constant(place), node.ctx), node)
        return self.generic_visit(node)

    def _plain(self, value: ast.expr) -> ast.expr:
        """``value`` with plain tuples for named ones."""
        if isinstance(value, ast.Tuple):
            return ast.Tuple([self._plain(each) for each in value.elts], ast.Load())
        if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and not value.keywords:
            fields = getattr(self.names.get(value.func.id), "_fields", ())
            if fields and len(fields) == len(value.args) and not any(isinstance(a, ast.Starred) for a in value.args):
                return ast.Tuple(value.args, ast.Load())
        return value

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        called, values = node.func, node.args
        if not (isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name) and called.value.id == "ops"):
            return node
        if called.attr == "where":
            return ast.IfExp(*values)
        if called.attr == "abs":
            return ast.Call(ast.Name("abs", ast.Load()), values, [])
        if called.attr in ("minimum", "maximum"):
            (first, a), (second, b) = map(self._once, values)
            order = ast.Lt() if called.attr == "minimum" else ast.Gt()
            return ast.IfExp(ast.Compare(first, [order], [second]), a, b)
        return node

    def _once(self, value: ast.expr) -> tuple[ast.expr, ast.expr]:
        """Expressions for the first and every later use of ``value``, which is computed once."""
        if isinstance(value, ast.Name | ast.Constant):
            return value, value
        self.count += 1
        name = f"_{self.count}"
        return ast.NamedExpr(ast.Name(name, ast.Store()), value), ast.Name(name, ast.Load())
