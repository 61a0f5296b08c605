"""A linear unit as a part of a composition: its matrices for given parameters are numbers, its states have rates.

    z' = A z + B v,   y = C z + D v + E v',   y' = C z' + D v' + E v''

The matrices are those that the unit itself chooses for its parameters, reduced where they ask for it, so that nothing is
left of the fast modes that make the full model stiff. The parameters are therefore fixed.

A unit remembers u'' over a step of its own; here the outputs take it from the composition, exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from types import ModuleType
from typing import Any

from ..numeric.dependence import TRACED, Traced
from ..numeric.ops import FLOATS, Ops, Value
from ..protocol.linear_model import LinearUnit
from .plan import CompositionError, named

Row = Sequence[tuple[int, float]]
"""(column, value) of what is not zero in a row of a matrix."""


class LinearPart(ModuleType):
    """``model`` with the parameters ``p``: the interface of a model module, but that ``outputs`` takes ``ddu``. Raises
    `CompositionError`."""

    takes_second = True

    def __init__(self, model: ModuleType, p: Any, spelling: Callable[[ModuleType], Any] = lambda model: model) -> None:
        super().__init__(model.__name__, __doc__)
        self.model, self.p, self._spelled = model, p, spelling(model)
        unmet = (text for value, text in model.requirements(p, FLOATS) if not value > 0.0)
        if problem := next(unmet, "") or model.problem(p):
            raise CompositionError(problem)
        made: LinearUnit = model.prepare(p)
        self.constants, self._n = made.constants, made.states
        self.Parameters, self.Inputs, self.Outputs = model.Parameters, model.Inputs, model.Outputs
        self.Modes, self.Calculated = model.Modes, model.Calculated
        (a,), (b,), c, d, e, _ = made.setup
        self._a, self._b, self._c, self._d, self._e = ([*map(_row, matrix.tolist())] for matrix in (a, b, c, d, e))
        # what the unit remembers from its own step has no rate and is no state here
        own, u = ([Traced({k: 1}) for k in range(len(kind._fields))] for kind in (model.Own, model.Inputs))
        rates = model.own_rates(own, u, u, p, self.constants, TRACED)
        self._moving = [k for k, rate in enumerate(rates) if isinstance(rate, Traced)]
        self._second = {f"{name}_d2": k for k, name in enumerate(model.Inputs._fields)}
        self.State = named(
            "State", [f"z{k + 1}" for k in range(self._n)] + [model.Own._fields[k] for k in self._moving]
        )

    def over(self, spelling: Callable[[ModuleType], Any]) -> LinearPart:
        """The same with the functions of the model in another spelling."""
        return LinearPart(self.model, self.p, spelling)

    def initial(self, p: Any, ops: Ops) -> tuple[Any, Any]:
        """The steady tow."""
        return self.State([0.0] * len(self.State._fields)), self.Modes()

    def calculated(self, p: Any, ops: Ops) -> Any:
        """What was chosen and found when the part was made."""
        return self.model.describe(self.p, self.constants, FLOATS)

    def derivatives(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> Any:
        """z', and the rates of the own states."""
        own, rest = self._own(x), [0.0] * len(u)
        v = self._spelled.core(own, u, rest, self.p, self.constants, ops)[0]
        rates = self._spelled.own_rates(own, u, rest, self.p, self.constants, ops)
        return self.State([*self._core_rates(x, v), *(rates[k] for k in self._moving)])

    def outputs(self, t: Value, x: Any, m: Any, u: Any, du: Any, ddu: Any, p: Any, ops: Ops) -> Any:
        """All observables."""
        own, z = self._own(x), x[: self._n]
        for k, name in enumerate(self.model.Own._fields):
            if name in self._second:
                own[k] = ddu[self._second[name]]
        v, v1, v2 = self._spelled.core(own, u, du, self.p, self.constants, ops)
        z1 = self._core_rates(x, v)
        y, y_rate = (
            [_dot(c, a0) + _dot(d, a1) + _dot(e, a2) for c, d, e in zip(self._c, self._d, self._e)]
            for a0, a1, a2 in ((z, v, v1), (z1, v1, v2))
        )
        return self._spelled.observe(t, own, y, y_rate, u, du, 0.0, self.p, self.constants, ops)[0]

    def _own(self, x: Any) -> list[Value]:
        own: list[Value] = [0.0] * len(self.model.Own._fields)
        for place, k in enumerate(self._moving, self._n):
            own[k] = x[place]
        return own

    def _core_rates(self, x: Any, v: Any) -> list[Value]:
        return [_dot(a, x) + _dot(b, v) for a, b in zip(self._a, self._b)]


def is_linear(model: Any) -> bool:
    """Whether `LinearPart` can make a part of ``model``: matrices that do not change with its inputs."""
    return hasattr(model, "core") and hasattr(model, "prepare") and not hasattr(model, "schedule")


def _row(values: Iterable[float]) -> Row:
    return [(k, value) for k, value in enumerate(values) if value != 0.0]


def _dot(row: Row, x: Sequence[Value]) -> Value:
    found: Value = 0.0
    for k, value in row:
        found = found + value * x[k]
    return found
