"""Model functions for Python floats alone: what they spell through ``ops`` written out.

An FMU computes with floats only, and there a call of ``ops.where`` costs more than the choice it makes. `floats` reads
the source of a model and returns the same functions with

    ops.where(c, a, b) -> a if c else b,    ops.maximum(a, b) -> a if a > b else b,    return State(a, b) -> return a, b

the last in the functions of `BY_POSITION` alone. They take half the time. Values are those of `models.ops.FLOATS` to
the last bit; only a side of ``where`` that is not chosen is no longer evaluated. Line numbers are kept, so that
tracebacks point into the model.
"""

from __future__ import annotations

import ast
import inspect
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any

from ...models.numeric import ops

MODELS = ops.__name__.removesuffix("numeric.ops")
BY_POSITION = ("derivatives", "outputs", "transition", "advance")
"""Functions whose results are read by position."""


@cache
def floats(model: ModuleType) -> Any:
    """The names of ``model``, with its functions (and those of the models it imports) for floats."""
    if hasattr(model, "over"):  # a composition has no source of its own, its parts have
        return model.over(floats)
    names = dict(vars(model))
    for name, value in vars(model).items():
        if isinstance(value, ModuleType) and value.__name__.startswith(MODELS) and hasattr(value, "Ops"):
            names[name] = floats(value)
    tree = ast.parse(inspect.getsource(model))
    tree.body = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    inlined = ast.fix_missing_locations(_Inline(names).visit(tree))
    exec(compile(inlined, str(model.__file__), "exec", dont_inherit=True), names)
    return SimpleNamespace(**{name: value for name, value in names.items() if not name.startswith("__")})


class _Inline(ast.NodeTransformer):
    """Replaces calls; ``names`` is what they may refer to."""

    def __init__(self, names: dict[str, Any]) -> None:
        self.names = names
        self.count = 0

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        for each in (*node.posonlyargs, *node.args, *node.kwonlyargs):
            each.annotation = None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns = None
        self.generic_visit(node)
        for statement in node.body if node.name in BY_POSITION else ():
            if isinstance(statement, ast.Return) and statement.value is not None:
                statement.value = self._plain(statement.value)
        return node

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
