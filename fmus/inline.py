"""Model functions for Python floats alone: what they spell through ``ops`` written out.

An FMU computes with floats only, and there a call of ``ops.where`` costs more than the choice it makes. `floats` reads
the source of a model and returns the same functions with

    ops.where(c, a, b) -> a if c else b,    ops.maximum(a, b) -> a if a > b else b,    State(a, b) -> (a, b)

which take half the time. Values are those of `models.ops.FLOATS` to the last bit; only a side of ``where`` that is not
chosen is no longer evaluated. Line numbers are kept, so that tracebacks point into the model.
"""

from __future__ import annotations

import ast
import inspect
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any


@cache
def floats(model: ModuleType) -> SimpleNamespace:
    """The names of ``model``, with its functions (and those of the models it imports) for floats."""
    names = dict(vars(model))
    for name, value in vars(model).items():
        if isinstance(value, ModuleType) and value.__package__ == model.__package__:
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
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        called, values = node.func, node.args
        owner = called.value.id if isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name) else None
        if owner == "ops":
            operation = called.attr  # type: ignore[attr-defined]
            if operation == "where":
                return ast.IfExp(*values)
            if operation == "abs":
                return ast.Call(ast.Name("abs", ast.Load()), values, [])
            if operation in ("minimum", "maximum"):
                (first, a), (second, b) = map(self._once, values)
                order = ast.Lt() if operation == "minimum" else ast.Gt()
                return ast.IfExp(ast.Compare(first, [order], [second]), a, b)
            return node
        if isinstance(called, ast.Name):
            target = self.names.get(called.id)
        else:
            target = getattr(self.names.get(owner or ""), getattr(called, "attr", ""), None)
        fields = getattr(target, "_fields", ()) if isinstance(target, type) else ()
        plain = not node.keywords and not any(isinstance(value, ast.Starred) for value in values)
        return ast.Tuple(values, ast.Load()) if fields and plain and len(values) == len(fields) else node

    def _once(self, value: ast.expr) -> tuple[ast.expr, ast.expr]:
        """Expressions for the first and every later use of ``value``, which is computed once."""
        if isinstance(value, ast.Name | ast.Constant):
            return value, value
        self.count += 1
        name = f"_{self.count}"
        return ast.NamedExpr(ast.Name(name, ast.Store()), value), ast.Name(name, ast.Load())
