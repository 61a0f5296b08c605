"""A linear unit as a part of a composition: its matrices for given parameters are numbers, its states have rates.

    z' = A z + B v,   y = C z + D v + E v',   y' = C z' + D v' + E v''

The matrices are those that the unit itself chooses for its parameters, reduced where they ask for it, so that nothing is
left of the fast modes that make the full model stiff. The parameters are therefore fixed.

A unit remembers u'' over a step of its own; here the outputs take it from the composition, exactly.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..numeric.dependence import TRACED, Traced
from ..numeric.ops import FLOATS, Ops, Value
from ..protocol.linear_model import LinearModel, NoModes
from ..protocol.model import AnyModel, Model, Spelling
from .plan import CompositionError, named


class LinearPart:
    """A linear model, its functions spelled anew, with the parameters ``p``."""

    def __init__(self, model: AnyModel, linear: LinearModel, p: Any, spelling: Spelling) -> None:
        spelled = spelling(model).linear
        assert spelled is not None
        self._model, self.linear, self.p, self._spelled = model, linear, p, spelled
        unit = linear.prepared(p)
        self.constants, self._n = unit.constants, unit.states
        (a,), (b,), c, d, e, _ = unit.setup
        self._rates, self._seen = np.hstack([a, b]), np.hstack([c, d, e])
        # what the unit remembers from its own step has no rate and is no state here
        own = linear.Own._make(Traced({k: 1}) for k in range(len(linear.Own._fields)))
        u = linear.Inputs._make(Traced({k: 1}) for k in range(len(linear.Inputs._fields)))
        rates = linear.own_rates(own, u, u, p, self.constants, TRACED) if linear.own_rates else ()
        self._moving = [k for k, rate in enumerate(rates) if isinstance(rate, Traced)]
        self._second = {f"{name}_d2": k for k, name in enumerate(linear.Inputs._fields)}
        self.State = named(
            "State", [f"z{k + 1}" for k in range(self._n)] + [linear.Own._fields[k] for k in self._moving]
        )

    def model(self) -> AnyModel:
        """The part as a model, whose outputs take u''."""
        linear = self.linear
        return Model(
            linear.name, linear.description, linear.Parameters, self.State, NoModes, linear.Inputs, linear.Outputs,
            linear.Calculated, initial=self.initial, derivatives=self.derivatives, outputs=self.outputs,
            calculated=self.calculated, takes_second=True, by_position=True, over=self._over,
        )  # fmt: skip

    def _over(self, spelling: Spelling) -> AnyModel:
        return LinearPart(self._model, self.linear, self.p, spelling).model()

    def initial(self, p: Any, ops: Ops) -> tuple[Any, Any]:
        """The steady tow."""
        return self.State([0.0] * len(self.State._fields)), NoModes()

    def calculated(self, p: Any, ops: Ops) -> Any:
        """What was chosen and found when the part was made."""
        return self.linear.describe(self.p, self.constants, FLOATS)

    def derivatives(self, t: Value, x: Any, m: Any, u: Any, p: Any, ops: Ops) -> Any:
        """z', and the rates of the own states."""
        own, u, rest = self._named(self._own(x), u, [0.0] * len(u))
        v = self._spelled.core(own, u, rest, self.p, self.constants, ops)[0]
        own_rates = self._spelled.own_rates
        rates = own_rates(own, u, rest, self.p, self.constants, ops) if own_rates else ()
        return self.State([*self._core_rates(x, v, ops), *(rates[k] for k in self._moving)])

    def outputs(self, t: Value, x: Any, m: Any, u: Any, du: Any, ddu: Any, p: Any, ops: Ops) -> Any:
        """All observables."""
        own, z = self._own(x), x[: self._n]
        for k, name in enumerate(self.linear.Own._fields):
            if name in self._second:
                own[k] = ddu[self._second[name]]
        own, u, du = self._named(own, u, du)
        v, v1, v2 = self._spelled.core(own, u, du, self.p, self.constants, ops)
        z1 = self._core_rates(x, v, ops)
        # rates of the rows behind those, the profile along a cable, are of no use
        used = slice(self.linear.rates)
        y, y_rate = ops.product(self._seen, [*z, *v, *v1]), ops.product(self._seen[used], [*z1, *v1, *v2])
        return self._spelled.observe(t, own, y, y_rate, u, du, 0.0, self.p, self.constants, ops)[0]

    def _named(self, own: Any, u: Any, du: Any) -> tuple[Any, Any, Any]:
        """The same with names, where the functions ask for them."""
        if self._spelled.by_position:
            return own, u, du
        return self.linear.Own._make(own), self.linear.Inputs._make(u), self.linear.Inputs._make(du)

    def _own(self, x: Any) -> list[Value]:
        own: list[Value] = [0.0] * len(self.linear.Own._fields)
        for place, k in enumerate(self._moving, self._n):
            own[k] = x[place]
        return own

    def _core_rates(self, x: Any, v: Any, ops: Ops) -> tuple[Value, ...]:
        return ops.product(self._rates, [*x[: self._n], *v])


def linear_part(model: AnyModel, p: Any) -> AnyModel:
    """``model``, which is linear, with the parameters ``p``, its states having rates. Raises `CompositionError`."""
    linear = model.linear
    assert linear is not None
    if refusal := model.refused(p):
        raise CompositionError(refusal)
    return LinearPart(model, linear, p, lambda each: each).model()


def can_be_part(model: AnyModel) -> bool:
    """Whether `linear_part` can make a part of ``model``: linear, with matrices that do not change with its inputs."""
    return model.linear is not None and not model.linear.schedule
