"""A linear model: matrices, and the functions that join them to inputs and outputs; and how it runs on numbers.

    z' = A(s) z + B(s) v,   y = C z + D v + E v',   y' = C A z + C B v + D v' + E v'',   A(s) = A0 + s A1 + s^2 A2

x = (z, own): own states are integrals of inputs and what is remembered of the step before. s is frozen in the middle of a
step, which is then exact for v polynomials of time: one product with the operators of ``numeric/exact_step.py``, kept for a
step length and s. y and y' come from one product too. ``docs/native.md`` tells how the same functions become C.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..numeric.exact_step import exact_step
from ..numeric.matrix_ops import MatrixOps
from ..numeric.ops import FLOATS, Ops, Value
from .model import AnyModel, Cubics, Model, Record, Requirement, remembered
from .state_space import Setup, Study
from .variables import Quantity

KEPT = 64
"""Operators kept for each of steps, outputs and growth."""
Numbers = Sequence[float]


class NoModes(NamedTuple):
    """A linear model has no branches."""


class NoOwn(NamedTuple):
    """No states but z."""


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel(Record):
    """The functions of a linear model. What is None it does not have. In all of them own, u, du are named (``Own``,
    ``Inputs``), c are the ``constants`` of the set-up, and ``cubics`` has for every input the coefficients of 1, t, t^2, t^3.

    * ``Size``: the parameters that fix the number of states, a named tuple with the defaults of native builds.
    * ``size(p) -> Size``: the structure that the parameters ask for, where that is not what they say literally.
    * ``setup(p, size, matrices) -> Setup``: the full model, for numbers and symbols alike.
    * ``prepare(p) -> Setup``: the model that the parameters ask for, chosen and reduced, of numbers.
    * ``drive(own, cubics, p, c, ops)``: polynomials of the core inputs v over a step, one sequence of coefficients each.
    * ``core(own, u, du, p, c, ops) -> (v, v', v'')``.
    * ``observe(t, own, y, y_rate, u, du, growth, p, c, ops) -> (Outputs, extras)``.
    * ``own_after(h, own, cubics, p, c, ops)``: own states after a step; ``own_rates(own, u, du, p, c, ops)``: their rates.
    * ``start(p, c, ops) -> (z, own)``: at the start of a run, else all zero.
    * ``describe(p, c, ops) -> Calculated``.
    * ``schedule(u, p, c, ops)``: s, else 0.
    * ``study(size) -> Study``: what is found out at the start.
    * ``requirements(p, ops)`` of the parameters, ``setup_requirements(p, c, ops)`` of what followed from them.
    * ``refusal(p)``, ``tuning_refusal(p)``: as of `Model`.
    * ``check_step(h, cubics)``: raises ``ValueError`` for a step that makes no sense.
    * ``operator(a, b, h)``: another exponential, taking z and the coefficients of each of v in turn to z after h.

    ``order``: degree of v over a step; ``rates``: how many of the first y' `observe` reads; ``extra``: name and meaning of an
    element of the extras, which the native flavour shows.
    """

    name: str
    description: str
    Parameters: Callable[..., Any]
    Inputs: Any
    Outputs: Any
    Calculated: Any
    Size: Any
    Own: Any = NoOwn
    _: KW_ONLY
    setup: Callable[[Any, Any, MatrixOps], Setup]
    prepare: Callable[[Any], Setup]
    drive: Callable[[Any, Any, Any, Any, Ops], Sequence[Sequence[Value]]]
    core: Callable[[Any, Any, Any, Any, Any, Ops], tuple[Sequence[Value], Sequence[Value], Sequence[Value]]]
    observe: Callable[..., tuple[Any, Sequence[Value]]]
    describe: Callable[[Any, Any, Ops], Any]
    own_after: Callable[[Value, Any, Any, Any, Any, Ops], tuple[Value, ...]] | None = None
    own_rates: Callable[[Any, Any, Any, Any, Any, Ops], tuple[Value, ...]] | None = None
    size: Callable[[Any], Any] | None = None
    start: Callable[[Any, Any, Ops], tuple[Sequence[Value], Sequence[Value]]] | None = None
    schedule: Callable[[Any, Any, Any, Ops], Value] | None = None
    study: Callable[[Any], Study] | None = None
    requirements: Callable[[Any, Ops], Sequence[Requirement]] | None = None
    setup_requirements: Callable[[Any, Any, Ops], Sequence[Requirement]] | None = None
    refusal: Callable[[Any], str] | None = None
    tuning_refusal: Callable[[Any], str] | None = None
    check_step: Callable[[float, Any], None] | None = None
    operator: Callable[[Any, Any, float], Any] | None = None
    order: int = 3
    rates: int | None = None
    extra: tuple[str, Quantity] | None = None
    by_position: bool = False

    def __post_init__(self) -> None:
        self.check_against(self.observe.__module__)

    def size_of(self, p: Any) -> Any:
        """The structure that the parameters ask for."""
        if self.size:
            return self.size(p)
        return self.Size(*(getattr(p, name) for name in self.Size._fields))

    def studied(self, size: Any) -> Study:
        """`study`, or nothing to study."""
        return self.study(size) if self.study else Study()

    @cached_property
    def prepared(self) -> Callable[[Any], LinearUnit]:
        """The unit of a set of parameters, made once. Raises ``ValueError`` where there is none."""
        return remembered(self._prepared)

    def _prepared(self, p: Any) -> LinearUnit:
        return LinearUnit(self, self.prepare(p), p)

    def as_model(self) -> AnyModel:
        """What a unit, an instance and a composition know of it: a model that makes its own steps."""
        prepared, describe, states = self.prepared, self.describe, len(self.Own._fields)

        def initial(p: Any, ops: Ops) -> tuple[tuple[Value, ...], NoModes]:
            unit = prepared(p)
            if self.start:
                z, own = self.start(p, unit.constants, ops)
                return (*z, *own), NoModes()
            return (0.0,) * (unit.states + states), NoModes()

        def advance(t: Value, h: Value, x: Numbers, m: Any, cubics: Any, p: Any, ops: Ops) -> tuple[float, ...]:
            return prepared(p).advance(h, x, cubics)

        def outputs(t: Value, x: Numbers, m: Any, u: Any, du: Any, p: Any, ops: Ops) -> Any:
            return prepared(p).outputs(t, x, u, du)[0]

        def calculated(p: Any, ops: Ops) -> Any:
            return describe(p, prepared(p).constants, ops)

        return Model(
            self.name, self.description, self.Parameters, None, NoModes, self.Inputs, self.Outputs, self.Calculated,
            initial=initial, advance=advance, outputs=outputs, calculated=calculated, requirements=self.requirements,
            refusal=self.refusal, tuning_refusal=self.tuning_refusal, by_position=self.by_position, linear=self,
        )  # fmt: skip


class LinearUnit:
    """A linear model at work on numbers: ``setup`` for ``parameters``. Compared by identity.

    With a growth in its `Study` it watches the largest real part of the modes that are slower than the constant named
    there, 1/s."""

    def __init__(self, model: LinearModel, setup: Setup, parameters: Any) -> None:
        self.model, self.setup, self.parameters = model, setup, parameters
        self.constants = setup.constants
        self.states = len(setup.a[0])
        below = model.studied(model.size_of(parameters)).growth_below
        self._growth_below: float = getattr(self.constants, below) if below else 0.0
        self._drive, self._core, self._observe, self._schedule = model.drive, model.core, model.observe, model.schedule
        self._own_after, self._check_step, self._named = model.own_after, model.check_step, not model.by_position
        # per object: matrices of a run that is over must not stay
        kept = lru_cache(maxsize=KEPT)
        self._operator, self._rows, self._growth = kept(self._new_operator), kept(self._new_rows), kept(self._new_growth)

    def matrices(self, s: float) -> tuple[Any, Any]:
        """(A, B) at s."""
        a, b = (sum(part * s**k for k, part in enumerate(parts)) for parts in (self.setup.a, self.setup.b))
        return a, b

    def _new_operator(self, h: float, s: float) -> Any:
        """(n, n + k (order+1)): takes z and the coefficients of each of v in turn to z after ``h``, s."""
        if self.model.operator:
            return self.model.operator(*self.matrices(s), h)
        step = exact_step(*self.matrices(s), h, self.model.order)
        n = self.states
        powers = step.gains.reshape(n, self.model.order + 1, -1)
        return np.hstack([step.transition, powers.transpose(0, 2, 1).reshape(n, step.gains.shape[1])])

    def _new_rows(self, s: float) -> Any:
        """Takes (z, v, v', v'') to y and the first y'."""
        (a, b), (_, _, c, d, e, _) = self.matrices(s), self.setup
        values = np.hstack([c, d, e, np.zeros_like(e)])
        return np.vstack([values, np.hstack([c @ a, c @ b, d, e])[: self.model.rates]])

    def _new_growth(self, s: float) -> float:
        values = np.linalg.eigvals(self.matrices(s)[0])
        return float(values.real[np.abs(values) < self._growth_below].max())

    def advance(self, h: float, x: Numbers, cubics: Cubics) -> tuple[float, ...]:
        """x = (z, own) after ``h``, s, for inputs with the coefficients ``cubics`` of 1, t, t^2, t^3."""
        n, p, constants = self.states, self.parameters, self.constants
        own, s, model = x[n:], 0.0, self.model
        if self._named:
            own, cubics = model.Own._make(own), model.Inputs._make(cubics)
        if self._check_step:
            self._check_step(h, cubics)
        if self._schedule:
            half = 0.5 * h
            middle = [a0 + half * (a1 + half * (a2 + half * a3)) for a0, a1, a2, a3 in cubics]
            s = self._schedule(model.Inputs._make(middle) if self._named else middle, p, constants, FLOATS)
        z = list(x[:n])
        for polynomial in self._drive(own, cubics, p, constants, FLOATS):
            z += polynomial
        after = (self._operator(h, s) @ np.array(z)).tolist()
        return (*after, *self._own_after(h, own, cubics, p, constants, FLOATS)) if self._own_after else tuple(after)

    def outputs(self, t: float, x: Numbers, u: Numbers, du: Numbers) -> Any:
        """The model's outputs and extras."""
        n, p, constants = self.states, self.parameters, self.constants
        own, s, model = x[n:], 0.0, self.model
        if self._named:
            own, u, du = model.Own._make(own), model.Inputs._make(u), model.Inputs._make(du)
        if self._schedule:
            s = self._schedule(u, p, constants, FLOATS)
        v, dv, ddv = self._core(own, u, du, p, constants, FLOATS)
        both = (self._rows(s) @ np.array((*x[:n], *v, *dv, *ddv))).tolist()
        r = len(self.setup.c)
        growth = self._growth(s) if self._growth_below else 0.0
        return self._observe(t, own, both[:r], both[r:], u, du, growth, p, constants, FLOATS)
