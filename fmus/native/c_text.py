"""Pieces of C text that the writers of ``unit.c`` share."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import casadi as ca


def entry(function: ca.Function) -> str:
    """Initializer of a ``Function``."""
    sizes = function.sz_arg(), function.sz_res(), function.sz_iw(), function.sz_w()
    return f"{{{function.name()}, {', '.join(map(str, sizes))}}}"


def declaration(function: ca.Function) -> str:
    """Prototype of a function of ``model.c``."""
    return f"int {function.name()}(const double **, double **, Integer *, double *, int);\n"


def initializer(fields: Mapping[str, str]) -> str:
    """Designated initializers, one a line; fields that are not named are zero, a function without ``call``."""
    return "".join(f"    .{name} = {value},\n" for name, value in fields.items())


def array(kind: str, name: str, values: Iterable[str]) -> str:
    """A constant array, one value a line."""
    return f"static const {kind} {name}[] = {{\n" + "".join(f"    {value},\n" for value in values) + "};"


def text(value: str) -> str:
    """A string literal."""
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'


def number(value: float | None, absent: str) -> str:
    """A double, to the last bit; ``absent`` where there is none."""
    if value is None:
        return absent
    if not math.isfinite(value):
        raise ValueError(f"{value} in a declaration: expected a finite number")
    return repr(float(value))
