"""Numbers with a derivative, a + b d with d^2 = 0, over any spelling of the operations: floats, arrays or symbols.

    (a + b d)(c + e d) = a c + (a e + b c) d,    f(a + b d) = f(a) + f'(a) b d

They give exact rates and exact Jacobians of model functions where no output states them. At a kink (``abs``,
``minimum``, ``maximum``) the derivative is that of the side that was picked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .ops import Ops, Value


class Dual:
    """``value`` and ``slope``, its derivative along the direction in use."""

    __slots__ = ("slope", "value")
    __array_ufunc__ = None  # an array leaves the operation to the dual number instead of taking it for an element

    def __init__(self, value: Value, slope: Value) -> None:
        self.value, self.slope = value, slope

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.slope)

    def __add__(self, other: Any) -> Dual:
        b = lift(other)
        return Dual(self.value + b.value, self.slope + b.slope)

    def __sub__(self, other: Any) -> Dual:
        b = lift(other)
        return Dual(self.value - b.value, self.slope - b.slope)

    def __mul__(self, other: Any) -> Dual:
        b = lift(other)
        return Dual(self.value * b.value, self.value * b.slope + self.slope * b.value)

    def __truediv__(self, other: Any) -> Dual:
        b = lift(other)
        quotient = self.value / b.value
        return Dual(quotient, (self.slope - quotient * b.slope) / b.value)

    def __radd__(self, other: Any) -> Dual:
        return lift(other) + self

    def __rsub__(self, other: Any) -> Dual:
        return lift(other) - self

    def __rmul__(self, other: Any) -> Dual:
        return lift(other) * self

    def __rtruediv__(self, other: Any) -> Dual:
        return lift(other) / self

    def __abs__(self) -> Dual:
        """For functions spelled out for floats, which do not ask ``ops``."""
        return -self if self.value < 0.0 else self

    # comparisons choose a branch, which has no slope

    def __lt__(self, other: Any) -> Any:
        return self.value < lift(other).value

    def __le__(self, other: Any) -> Any:
        return self.value <= lift(other).value

    def __gt__(self, other: Any) -> Any:
        return self.value > lift(other).value

    def __ge__(self, other: Any) -> Any:
        return self.value >= lift(other).value


def lift(value: Any) -> Dual:
    """A constant as a dual number."""
    return value if isinstance(value, Dual) else Dual(value, 0.0)


def duals(ops: Ops) -> Ops:
    """The operations on dual numbers over ``ops``."""

    def root(a: Any) -> Dual:
        value = ops.sqrt(lift(a).value)
        return Dual(value, lift(a).slope / (2.0 * ops.where(value > 0.0, value, 1.0)))

    def angle(y: Any, x: Any) -> Dual:
        a, b = lift(y), lift(x)
        square = a.value * a.value + b.value * b.value
        return Dual(ops.atan2(a.value, b.value), (b.value * a.slope - a.value * b.slope) / square)

    def where(condition: Any, a: Any, b: Any) -> Dual:
        a, b = lift(a), lift(b)
        return Dual(ops.where(condition, a.value, b.value), ops.where(condition, a.slope, b.slope))

    def exponential(a: Any) -> Dual:
        value = ops.exp(lift(a).value)
        return Dual(value, value * lift(a).slope)

    def size(a: Any) -> Dual:
        return where(lift(a).value < 0.0, -lift(a), a)

    def kernel(of: Any, t: Any, *rest: Any) -> tuple[Dual, ...]:
        results = ops.kernel(of, lift(t).value, *(lift(a).value for a in rest))
        return tuple(Dual(value, slope * lift(t).slope) for value, slope in zip(results, of.slopes(results)))

    def product(matrix: Any, vector: Any) -> tuple[Dual, ...]:
        parts = [lift(a) for a in vector]
        values, slopes = (ops.product(matrix, part) for part in ([a.value for a in parts], [a.slope for a in parts]))
        return tuple(map(Dual, values, slopes))

    return Ops(
        sin=lambda a: Dual(ops.sin(lift(a).value), ops.cos(lift(a).value) * lift(a).slope),
        cos=lambda a: Dual(ops.cos(lift(a).value), -ops.sin(lift(a).value) * lift(a).slope),
        exp=exponential,
        sqrt=root,
        abs=size,
        atan2=angle,
        minimum=lambda a, b: where(lift(a) < b, a, b),
        maximum=lambda a, b: where(lift(a) > b, a, b),
        where=where,
        kernel=kernel,
        product=product,
    )


def output_rates(
    model: Any, t: Value, x: Sequence[Value], m: Any, u: Sequence[Value], du: Sequence[Value], ddu: Sequence[Value],
    p: Any, ops: Ops,
) -> list[Value]:  # fmt: skip
    """Time derivatives of all outputs of ``model``, along its own rates, ``du`` and ``ddu``; those of outputs that depend on
    ``ddu`` themselves are wrong, since nothing tells its rate."""
    rates = model.derivatives(t, x, m, u, p, ops) if model.derivatives else ()
    x, u, du = (_like(a, [*map(Dual, a, b)]) for a, b in ((x, rates), (u, du), (du, ddu)))
    second = (_like(ddu, [*map(lift, ddu)]),) if model.takes_second else ()
    seen = model.outputs(Dual(t, 1.0), x, m, u, du, *second, p, duals(ops))
    return [lift(v).slope for v in seen]


def _like(named: Any, values: list[Dual]) -> Any:
    """``values`` with the names of ``named``, if it has any."""
    return values if type(named) in (list, tuple) else type(named)._make(values)
