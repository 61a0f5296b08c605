"""Traces a unit's model functions to C: CasADi symbols go in, an expression of their results comes out.

Every function takes the arguments that ``native/runtime/core/unit.h`` lists, vectors as dense columns, and gets its
derivatives by forward differentiation where the runtime asks for them. The functions read nothing but their arguments, so
the C text follows from the model alone: the same model gives the same text, byte for byte.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import casadi as ca

from ..declare.interface import Interface, declared_states
from ..declare.unit import Unit
from .kernels import Kernels
from .trace_chain import trace_chain
from .trace_linear import trace_linear
from .traced import OPS, NotNative, Traced, column, dense, forward, parts

FORWARD = ("derivatives", "outputs")
"""Functions whose directional derivatives the runtime needs."""


def trace(unit: Unit, structure: Mapping[str, float] | None = None) -> Traced:
    """The unit's functions. ``structure`` overrides the start values of structural parameters. Raises `NotNative`."""
    if unit.not_native:
        raise NotNative(f"{unit.name} has no native flavour: {unit.not_native}")
    if unit.model.linear:
        return trace_linear(unit, structure or {})
    fixed = _structure(unit, structure or {})
    return trace_chain(unit) if unit.model.numbers else _trace(unit, fixed)


def _structure(unit: Unit, given: Mapping[str, float]) -> dict[str, float]:
    """Values of the structural parameters: as given, else as declared."""
    known = unit.model.structure
    for name in given:
        if name not in known:
            raise NotNative(f"{unit.name}.{name} is no structural parameter: {unit.name} has {', '.join(known) or 'none'}")
    return {v.name: float(given.get(v.name, v.start or 0.0)) for v in unit.parameters if v.name in known}


def _trace(unit: Unit, structure: Mapping[str, float]) -> Traced:
    model, kernels = unit.model.fixed(structure), Kernels()
    ops, now = kernels.ops(OPS), kernels.now
    p, c, t, h = column("p", len(unit.parameters)), column("c", 0), column("t", 1), column("h", 1)
    parameters = model.Parameters(**{v.name: p[i] for i, v in enumerate(unit.parameters)})
    x0, m0 = model.initial(parameters, ops)
    x, m = column("x", len(x0)), column("m", len(m0))
    n = len(unit.inputs)
    u, du, k = column("u", n), column("du", n), column("k", 4 * n)
    cubics = model.Inputs._make(parts(k)[4 * i : 4 * i + 4] for i in range(n))
    modes = model.Modes._make(parts(m))
    at = (t, model.State._make(parts(x)), modes, model.Inputs._make(parts(u)))
    functions: dict[str, ca.Function] = {}
    with_kernels: dict[str, ca.Function] = {}

    def add(name: str, arguments: list[Any], *results: Iterable[Any]) -> None:
        columns = [dense(each) for each in results]
        if any(ca.depends_on(each, now) for each in columns):
            with_kernels[name] = raw = ca.Function(f"model_{name}", [*arguments, now], columns)
            columns = [ca.densify(each) for each in raw.call([*arguments, t], True, False)]
        functions[name] = ca.Function(f"model_{name}", arguments, columns)

    requirements = model.requirements(parameters, ops) if model.requirements else ()
    if model.requirements:
        add("required", [p, c], [value for value, _ in requirements])
    if model.calculated:
        add("calculate", [p, c], model.calculated(parameters, ops))
    add("initial", [p, c], x0, m0)
    if model.derivatives and len(x0):
        add("derivatives", [t, x, m, u, p, c], model.derivatives(*at, parameters, ops))
    if model.indicators:
        add("indicate", [t, x, m, u, p, c], model.indicators(*at, parameters, ops))
    if model.advance and len(x0):
        add("advance", [t, h, x, m, k, p, c], model.advance(t, h, *at[1:3], cubics, parameters, ops))
    if model.transition:
        add("change", [t, x, m, u, p, c], *model.transition(*at, parameters, ops))
    if model.next_event_time:
        add("next_event", [t, m, p, c], [model.next_event_time(t, modes, parameters, ops)])
    add("outputs", [t, x, m, u, du, p, c], model.outputs(*at, model.Inputs._make(parts(du)), parameters, ops))
    for name in [name for name in FORWARD if name in functions]:
        functions[f"{name}_forward"] = forward(with_kernels.get(name, functions[name]), name in with_kernels)
    interface = Interface(
        unit,
        declared_states(unit),
        indicators=functions["indicate"].numel_out() if "indicate" in functions else 0,
        reinit=_changes(functions.get("change"), len(x0)),
        derivative_inputs=_depends(functions.get("derivatives"), 3),
        derivative_states=_depends(functions.get("derivatives"), 1),
        observed_states=_depends(functions["outputs"], 1),
        structure=structure,
    )
    texts = tuple(text for _, text in requirements)
    return Traced(interface, functions, len(m0), texts, kernels=tuple(kernels.found))


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
