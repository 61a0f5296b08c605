"""Which inputs act on an output without delay, found by tracing the model's functions.

    y = g(t, x, m, u, u'),   (x, m) = transition(t, x, m, u):   y depends on what is in u, u' and, through an event, in x and m

A linear model, y = C z + D v + E v', depends through its core inputs v as far as D and E have entries, and on the inputs of
its schedule where it looks at its growth. D and E are those of the full model at the values of the reference run.

What no trace finds the model declares (``also``): functions that work on floats alone, matrices that a reduction fills.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ...models.numeric.dependence import TRACED, Traced, degrees_of, joined
from ...models.numeric.matrix_ops import numbers
from ...models.protocol.model import AnyModel
from ...models.protocol.variables import EVERY_INPUT, Quantity, quantities
from .unit import Unit

if TYPE_CHECKING:
    from ...models.protocol.linear_model import LinearModel


def dependencies(unit: Unit) -> Mapping[str, tuple[str, ...]]:
    """For every observed variable the inputs that act on it without delay, in the order of the inputs."""
    if unit.depends is not None:
        return unit.depends
    order = [v.name for v in unit.inputs]
    declared = {name: declared_inputs(unit, q) for name, q in quantities(unit.model.Outputs).items()}
    return {n: tuple(k for k in order if k in traced | declared[n]) for n, traced in derived(unit).items()}


def declared_inputs(unit: Unit, quantity: Quantity) -> set[str]:
    """What the model declares of an output beyond what the trace finds."""
    return {v.name for v in unit.inputs} if quantity.also == EVERY_INPUT else set(quantity.also)


def derived(unit: Unit) -> dict[str, set[str]]:
    """What the trace finds, by observed variable; nothing for a model of floats alone."""
    model = unit.model
    names = model.Outputs._fields
    if model.floats_only:
        return {name: set() for name in names}
    if model.linear:
        start = {v.name: unit.start.get(v.name, v.start) for v in unit.parameters}
        values = _linear(model.linear, start)
    else:
        values = _plain(model)
    return {name: {str(k) for k in degrees_of(value)} for name, value in zip(names, values)}


def _inputs(model: AnyModel | LinearModel) -> Any:
    return model.Inputs(*(Traced({name: 1}) for name in model.Inputs._fields))


def _unknown(kind: Any) -> Any:
    return kind(*(Traced() for _ in kind._fields))


def _plain(model: AnyModel) -> tuple[Any, ...]:
    """The traced outputs after the transition of a communication point."""
    known = quantities(model.Parameters) if model.structure else {}
    model = model.fixed({name: known[name].start or 0.0 for name in model.structure})
    t, u, p = Traced(), _inputs(model), model.Parameters(**{name: Traced() for name in quantities(model.Parameters)})
    x, m = _unknown(model.State), _unknown(model.Modes)
    if model.transition:
        x, m = model.transition(t, x, m, u, p, TRACED)
    return tuple(model.outputs(t, x, m, u, u, p, TRACED))


def _linear(linear: LinearModel, start: Mapping[str, float | None]) -> tuple[Any, ...]:
    """The traced outputs of a linear model with matrices at the parameters ``start``."""
    p, traced = linear.Parameters(**start), linear.Parameters(**{name: Traced() for name in start})
    setup = linear.setup(p, linear.size_of(p), numbers())
    u, own = _inputs(linear), _unknown(linear.Own)
    constants = type(setup.constants)(*(
        tuple(Traced() for _ in value) if isinstance(value, tuple) else Traced() for value in setup.constants
    ))  # fmt: skip
    v, v_rate, _ = linear.core(own, u, u, traced, constants, TRACED)
    y = [
        joined(*(a for a, entry in zip(v, d) if entry != 0.0), *(b for b, entry in zip(v_rate, e) if entry != 0.0))
        for d, e in zip(setup.d.tolist(), setup.e.tolist())
    ]
    growth = linear.schedule(u, traced, constants, TRACED) if linear.schedule else Traced()
    rates = [Traced() for _ in y]
    return tuple(linear.observe(Traced(), own, y, rates, u, u, growth, traced, constants, TRACED)[0])
