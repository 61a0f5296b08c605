"""One spelling of sin, where, ... for Python floats, numpy arrays and CasADi symbols.

Model functions take an ``Ops`` and never import ``math`` for values: ``math.sin`` of a CasADi symbol silently returns
nan. They never branch with ``if`` on a value either: ``where`` evaluates both sides and picks one, which is the only
form that a trace and a batch can follow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

Value = Any
"""A float, a numpy array or a CasADi symbol."""

NEVER = 1e300
"""The time of an event that will not happen, s: finite, so that no port ever carries an infinity."""


NEGLIGIBLE = 1e-100
"""A scale that is not larger counts as zero: what is divided by it, or by its square, could overflow."""


LARGE = 3000
"""Terms of a product of a matrix from which on a trace holds it as a loop: as text they take a compiler minutes."""


def dots(table: Any, vector: Sequence[Value]) -> tuple[Value, ...]:
    """The matrix times the vector, term by term."""
    return tuple(sum((c * v for c, v in zip(row, vector) if c != 0.0), 0.0) for row in table.tolist())


def not_spelled(*values: Value) -> Value:
    """Stands for an operation that a kind of value does not have."""
    raise NotImplementedError("this kind of value does not have this operation")


@dataclass(frozen=True)
class Ops:
    """The operations that model functions use. ``where(condition, a, b)`` is a where the condition holds, else b;
    ``kernel(kernel, t, ...)`` are the results of a `kernel.Kernel`; ``product(matrix, vector)`` is an array
    of numbers times a vector of values."""

    sin: Callable[[Value], Value]
    cos: Callable[[Value], Value]
    exp: Callable[[Value], Value]
    sqrt: Callable[[Value], Value]
    abs: Callable[[Value], Value]
    atan2: Callable[[Value, Value], Value]
    minimum: Callable[[Value, Value], Value]
    maximum: Callable[[Value, Value], Value]
    where: Callable[[Value, Value, Value], Value]
    log1p: Callable[[Value], Value] = not_spelled
    kernel: Callable[..., tuple[Value, ...]] = not_spelled
    product: Callable[[Any, Sequence[Value]], tuple[Value, ...]] = dots


FLOATS = Ops(
    sin=math.sin,
    cos=math.cos,
    exp=math.exp,
    sqrt=math.sqrt,
    abs=abs,
    atan2=math.atan2,
    minimum=lambda a, b: a if a < b else b,
    maximum=lambda a, b: a if a > b else b,
    where=lambda condition, a, b: a if condition else b,
    log1p=math.log1p,
    kernel=lambda kernel, *arguments: kernel.run(*arguments),
    product=lambda matrix, vector: tuple((matrix @ vector).tolist()),
)


def arrays() -> Ops:
    """Operations on numpy arrays (a batch of members in each component)."""
    import numpy as np

    return Ops(np.sin, np.cos, np.exp, np.sqrt, np.abs, np.arctan2, np.minimum, np.maximum, np.where, np.log1p)


def symbols() -> Ops:
    """Operations on CasADi symbols, for tracing a model to C."""
    import casadi as ca

    def product(matrix: Any, vector: Sequence[Value]) -> tuple[Value, ...]:
        if (matrix != 0.0).sum() < LARGE:
            return dots(matrix, vector)
        x = ca.MX.sym("x", len(vector))
        rows = ca.Function("rows", [x], [ca.mtimes(ca.MX(ca.DM(matrix)), x)])
        result = rows.call([ca.vertcat(*vector)], False, True)[0]
        return tuple(result[k] for k in range(len(matrix)))

    return Ops(
        ca.sin, ca.cos, ca.exp, ca.sqrt, ca.fabs, ca.atan2, ca.fmin, ca.fmax, ca.if_else, ca.log1p, product=product
    )
