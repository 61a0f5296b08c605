"""What a model function depends on, and whether linearly, found by running it on values that only remember that.

    1: f = a + b v with a, b free of v;    2: anything else

Nothing is sampled: a path that is never taken counts too, so that the answer errs to the safe side. The condition of
``where`` counts as a dependence of degree 2 on what it compares.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

from .ops import Ops

LINEAR, OTHERWISE = 1, 2


class Traced:
    """A value of which only ``degrees`` is known: by variable, 1 where it enters linearly, 2 otherwise."""

    __slots__ = ("degrees",)

    def __init__(self, degrees: dict[Hashable, int] | None = None) -> None:
        self.degrees = degrees or {}

    def __neg__(self) -> Traced:
        return self

    def __add__(self, other: Any) -> Any:
        return joined(self, other) if isinstance(other, _PLAIN) else NotImplemented

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, _PLAIN):
            return NotImplemented
        return bent(self, other) if self.degrees and degrees_of(other) else joined(self, other)

    def __truediv__(self, other: Any) -> Any:
        return self * bent(other) if isinstance(other, _PLAIN) else NotImplemented

    def __rtruediv__(self, other: Any) -> Any:
        return bent(self)

    def __lt__(self, other: Any) -> Any:
        return bent(self, other) if isinstance(other, _PLAIN) else NotImplemented

    __radd__ = __sub__ = __rsub__ = __add__
    __rmul__ = __mul__
    __le__ = __gt__ = __ge__ = __lt__


_PLAIN = (Traced, float, int)
"""What operators take; a dual number of traced values has operators of its own."""


def degrees_of(value: Any) -> dict[Hashable, int]:
    """What ``value`` depends on; plain numbers depend on nothing."""
    return value.degrees if isinstance(value, Traced) else {}


def joined(*values: Any) -> Traced:
    """Depends on what any of ``values`` depends on, by the higher degree."""
    degrees: dict[Hashable, int] = {}
    for value in values:
        for name, degree in degrees_of(value).items():
            degrees[name] = max(degree, degrees.get(name, LINEAR))
    return Traced(degrees)


def bent(*values: Any) -> Traced:
    """Depends on all of ``values``, not linearly."""
    return Traced(dict.fromkeys(joined(*values).degrees, OTHERWISE))


def _where(condition: Any, a: Any, b: Any) -> Any:
    if not isinstance(condition, Traced):
        return a if condition else b
    return joined(bent(condition), a, b)


def _kernel(kernel: Any, *arguments: Any) -> tuple[Any, ...]:
    return (bent(*arguments),) * len(kernel.rates)


TRACED = Ops(bent, bent, bent, bent, bent, bent, bent, bent, _where, kernel=_kernel)
"""The operations on `Traced` values."""
