"""Traces a unit's model functions to C: CasADi symbols go in, an expression of their results comes out.

Every function takes the arguments that ``native/runtime/core/unit.h`` lists, vectors as dense columns, and gets its
derivatives by forward differentiation where the runtime asks for them. The functions read nothing but their arguments, so
the C text follows from the model alone: the same model gives the same text, byte for byte.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import casadi as ca

from ..declare.interface import Interface, declared_states
from ..declare.unit import Unit
from .trace_linear import trace_linear
from .traced import OPS, NotNative, Traced, column, dense, forward, parts

FORWARD = ("derivatives", "outputs")
"""Functions whose directional derivatives the runtime needs."""


def trace(unit: Unit, structure: Mapping[str, float] | None = None) -> Traced:
    """The unit's functions. ``structure`` overrides the start values of structural parameters. Raises `NotNative`."""
    if unit.not_native:
        raise NotNative(f"{unit.name} has no native flavour: {unit.not_native}")
    if hasattr(unit.model, "setup"):
        return trace_linear(unit, structure or {})
    for name in structure or {}:
        raise NotNative(f"{unit.name}.{name} is no structural parameter: {unit.name} has none")
    return _trace(unit)


def parameters_of(unit: Unit, p: Any) -> Any:
    """The model's parameters with the components of the column ``p``."""
    return unit.model.Parameters(**{v.name: p[i] for i, v in enumerate(unit.parameters)})


def _trace(unit: Unit) -> Traced:
    model = unit.model
    p, c, t, h = column("p", len(unit.parameters)), column("c", 0), column("t", 1), column("h", 1)
    parameters = parameters_of(unit, p)
    x0, m0 = model.initial(parameters, OPS)
    x, m = column("x", len(x0)), column("m", len(m0))
    n = len(unit.inputs)
    u, du, k = column("u", n), column("du", n), column("k", 4 * n)
    cubics = [parts(k)[4 * i : 4 * i + 4] for i in range(n)]
    at = (t, parts(x), parts(m), parts(u))
    functions: dict[str, ca.Function] = {}

    def add(field: str, name: str, arguments: list[Any], call: Callable[[Any], Iterable[Iterable[Any]]]) -> None:
        if hasattr(model, name):
            results = [dense(each) for each in call(getattr(model, name))]
            functions[field] = ca.Function(f"model_{field}", arguments, results)

    requirements = model.requirements(parameters, OPS) if hasattr(model, "requirements") else ()
    add("required", "requirements", [p, c], lambda f: [[value for value, _ in requirements]])
    add("calculate", "calculated", [p, c], lambda f: [f(parameters, OPS)])
    add("initial", "initial", [p, c], lambda f: f(parameters, OPS))
    if len(x0):
        add("derivatives", "derivatives", [t, x, m, u, p, c], lambda f: [f(*at, parameters, OPS)])
        add("indicate", "indicators", [t, x, m, u, p, c], lambda f: [f(*at, parameters, OPS)])
        add("advance", "advance", [t, h, x, m, k, p, c], lambda f: [f(t, h, *at[1:3], cubics, parameters, OPS)])
    add("change", "transition", [t, x, m, u, p, c], lambda f: f(*at, parameters, OPS))
    add("next_event", "next_event_time", [t, m, p, c], lambda f: [[f(t, parts(m), parameters, OPS)]])
    add("outputs", "outputs", [t, x, m, u, du, p, c], lambda f: [f(*at, parts(du), parameters, OPS)])
    functions |= {f"{name}_forward": forward(functions[name]) for name in FORWARD if name in functions}
    interface = Interface(
        unit,
        declared_states(unit),
        indicators=functions["indicate"].numel_out() if "indicate" in functions else 0,
        reinit=_changes(functions.get("change"), len(x0)),
        derivative_inputs=_depends(functions.get("derivatives"), 3),
        derivative_states=_depends(functions.get("derivatives"), 1),
        observed_states=_depends(functions["outputs"], 1),
    )
    return Traced(interface, functions, len(m0), tuple(text for _, text in requirements))


def _depends(function: ca.Function | None, argument: int) -> tuple[tuple[int, ...], ...]:
    """Positions in an argument on which each component of the (only) result depends."""
    if function is None:
        return ()
    pattern = function.jac_sparsity(0, argument)
    rows: list[list[int]] = [[] for _ in range(pattern.size1())]
    for row, col in zip(*pattern.get_triplet()):
        rows[row].append(col)
    return tuple(map(tuple, rows))


def _changes(change: ca.Function | None, states: int) -> tuple[bool, ...]:
    """Which states a transition may change."""
    if change is None or not states:
        return (False,) * states
    arguments = change.sx_in()
    after = change.call(arguments, True, False)[0]
    return tuple(not ca.is_equal(after[i], arguments[1][i]) for i in range(states))
