"""Runs a linear model in Python: the functions of `docs/native.md` become `initial`, `advance` and `outputs`.

    z' = A(s) z + B(s) v,   y = C z + D v + E v',   y' = C A z + C B v + D v' + E v'',   A(s) = A0 + s A1 + s^2 A2

s is frozen in the middle of a step, which is then exact for v polynomials of time: one product with the operators of
``numeric/exact_step.py``, kept for a step length and s. y and y' come from one product too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, wraps
from typing import Any, TypeVar

import numpy as np

from ..numeric.exact_step import exact_step
from ..numeric.ops import FLOATS
from .state_space import Setup

KEPT = 64
"""Operators kept for each of steps, outputs and growth."""
Numbers = Sequence[float]
Made = TypeVar("Made")


def remembered(make: Callable[[Any], Made]) -> Callable[[Any], Made]:
    """``make(parameters)``, computed once for equal parameters and kept on the object itself, which is found at once:
    hashing dozens of fields would cost more than a step."""
    known = lru_cache(maxsize=16)(make)

    @wraps(make)
    def found(parameters: Any) -> Made:
        kept: dict[str, Made] = parameters.__dict__
        try:
            return kept["_made"]
        except KeyError:
            made = kept["_made"] = known(parameters)
            return made

    return found


@dataclass(eq=False)
class LinearUnit:
    """A set-up of numbers with the model's functions; compared by identity.

    ``order``: degree of v over a step; ``rates``: how many of the first y' `observe` reads; ``growth_below``: magnitude,
    1/s, below which modes count in the growth, the largest real part (0: not wanted).
    """

    setup: Setup
    parameters: Any
    drive: Callable[..., Any]
    own_after: Callable[..., Any]
    core: Callable[..., Any]
    observe: Callable[..., Any]
    order: int = 3
    rates: int | None = None
    schedule: Callable[..., float] | None = None
    growth_below: float = 0.0
    states: int = field(init=False)

    def __post_init__(self) -> None:
        self.states = len(self.setup.a[0])
        for name in ("_operator", "_rows", "_growth"):
            # per object: matrices of a run that is over must not stay
            setattr(self, name, lru_cache(maxsize=KEPT)(getattr(self, name)))

    @property
    def constants(self) -> Any:
        """What the functions take beside the parameters."""
        return self.setup.constants

    def matrices(self, s: float) -> tuple[Any, Any]:
        """(A, B) at s."""
        a, b = (sum(part * s**k for k, part in enumerate(parts)) for parts in (self.setup.a, self.setup.b))
        return a, b

    def _operator(self, h: float, s: float) -> Any:
        """(n, n + k (order+1)): takes z and the coefficients of each of v in turn to z after ``h``, s."""
        step = exact_step(*self.matrices(s), h, self.order)
        n = self.states
        powers = step.gains.reshape(n, self.order + 1, -1)
        return np.hstack([step.transition, powers.transpose(0, 2, 1).reshape(n, step.gains.shape[1])])

    def _rows(self, s: float) -> Any:
        """Takes (z, v, v', v'') to y and the first y'."""
        (a, b), (_, _, c, d, e, _) = self.matrices(s), self.setup
        values = np.hstack([c, d, e, np.zeros_like(e)])
        return np.vstack([values, np.hstack([c @ a, c @ b, d, e])[: self.rates]])

    def _growth(self, s: float) -> float:
        found = np.linalg.eigvals(self.matrices(s)[0])
        return float(found.real[np.abs(found) < self.growth_below].max())

    def advance(self, h: float, x: Numbers, cubics: Sequence[Numbers]) -> tuple[float, ...]:
        """x = (z, own) after ``h``, s, for inputs with the coefficients ``cubics`` of 1, t, t^2, t^3."""
        n, p, constants = self.states, self.parameters, self.setup.constants
        own, s = x[n:], 0.0
        if self.schedule:
            half = 0.5 * h
            middle = [a0 + half * (a1 + half * (a2 + half * a3)) for a0, a1, a2, a3 in cubics]
            s = self.schedule(middle, p, constants, FLOATS)
        z = list(x[:n])
        for polynomial in self.drive(own, cubics, p, constants, FLOATS):
            z += polynomial
        return (*(self._operator(h, s) @ np.array(z)).tolist(), *self.own_after(h, own, cubics, p, constants, FLOATS))

    def outputs(self, t: float, x: Numbers, u: Numbers, du: Numbers) -> Any:
        """The model's outputs and extras."""
        n, p, constants = self.states, self.parameters, self.setup.constants
        own, s = x[n:], 0.0
        if self.schedule:
            s = self.schedule(u, p, constants, FLOATS)
        v, dv, ddv = self.core(own, u, du, p, constants, FLOATS)
        both = (self._rows(s) @ np.array((*x[:n], *v, *dv, *ddv))).tolist()
        r = len(self.setup.c)
        growth = self._growth(s) if self.growth_below else 0.0
        return self.observe(t, own, both[:r], both[r:], u, du, growth, p, constants, FLOATS)
