"""Traces a unit's model functions to C: CasADi symbols go in, an expression of their results comes out.

Every function takes the arguments that ``native/runtime/unit.h`` lists, vectors as dense columns, and gets its derivatives by
forward differentiation where the runtime asks for them. The functions read nothing but their arguments, so the C text
follows from the model alone: the same model gives the same text, byte for byte.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ...models.numeric.ops import symbols
from ..declare.interface import Interface, declared_states
from ..declare.unit import BuildError, Unit

OPS = symbols()
FORWARD = ("derivatives", "outputs")
"""Functions whose directional derivatives the runtime needs."""


class NotNative(BuildError):
    """The unit has no native flavour; the message says why."""


@dataclass(frozen=True)
class Traced:
    """A unit as traced. ``functions`` by the name of their field in ``Unit`` of ``unit.h``, those of ``Linear`` with
    ``linear_`` before it; ``requirements`` are the messages, one for each result of ``required``; ``constants`` is the
    length of c; ``linear`` the C text that defines ``static const Linear linear``, empty where there is none."""

    interface: Interface
    functions: dict[str, ca.Function]
    modes: int
    requirements: tuple[str, ...] = ()
    constants: int = 0
    linear: str = ""


def trace(unit: Unit, structure: Mapping[str, float] | None = None) -> Traced:
    """The unit's functions. ``structure`` overrides the start values of structural parameters. Raises `NotNative`."""
    if unit.not_native:
        raise NotNative(f"{unit.name} has no native flavour: {unit.not_native}")
    if hasattr(unit.model, "setup"):
        from .trace_linear import trace as trace_matrices

        return trace_matrices(unit, structure or {})
    for name in structure or {}:
        raise NotNative(f"{unit.name}.{name} is no structural parameter: {unit.name} has none")
    return _trace(unit)


def column(name: str, size: int) -> Any:
    """A dense column of symbols."""
    return ca.SX.sym(name, size)


def parts(vector: Any) -> tuple[Any, ...]:
    """The components of a column."""
    return tuple(vector[i] for i in range(vector.numel()))


def parameters_of(unit: Unit, p: Any) -> Any:
    """The model's parameters with the components of the column ``p``."""
    return unit.model.Parameters(**{v.name: p[i] for i, v in enumerate(unit.parameters)})


def dense(values: Iterable[Any]) -> Any:
    """A dense column of ``values``."""
    return ca.densify(ca.vertcat(*map(ca.SX, values)))


def forward(function: ca.Function) -> ca.Function:
    """Directional derivatives: (arguments, results, one seed an argument) -> one derivative a result, all dense."""
    sizes = [function.size1_in(i) for i in range(function.n_in())]
    arguments, seeds = [column("a", n) for n in sizes], [column("s", n) for n in sizes]
    unused = [column("r", function.size1_out(i)) for i in range(function.n_out())]
    results = function.call(arguments, True, False)
    found = [ca.jtimes(r, ca.vertcat(*arguments), ca.vertcat(*seeds)) for r in results]
    return ca.Function(f"{function.name()}_forward", [*arguments, *unused, *seeds], [dense([d]) for d in found])


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
    found: list[list[int]] = [[] for _ in range(pattern.size1())]
    for row, col in zip(*pattern.get_triplet()):
        found[row].append(col)
    return tuple(map(tuple, found))


def _changes(change: ca.Function | None, states: int) -> tuple[bool, ...]:
    """Which states a transition may change."""
    if change is None or not states:
        return (False,) * states
    arguments = change.sx_in()
    after = change.call(arguments, True, False)[0]
    return tuple(not ca.is_equal(after[i], arguments[1][i]) for i in range(states))


CLEANING = tuple(
    (re.compile(pattern, re.MULTILINE | re.DOTALL), replacement)
    for pattern, replacement in (
        # what CasADi's own loader would ask for: the version, and sizes and names of each function
        (r"^/\* Configuration this file was compiled with \*/\n.*?^int model_casadi_real_size[^\n]*\n", ""),
        (r"^(int (model_\w+)\(const casadi_real\*\* arg,.*?^\}\n).*?^int \2_work_bytes.*?^\}\n", r"\1"),
        (r"^casadi_real (?=casadi_\w+\()", "static casadi_real "),
        (r"^/\* Pre-c99 compatibility \*/\n", ""),
        (r"^#if __STDC_VERSION__ < 199901L\n(  return x[<>]y \? x : y;)\n#else\n.*?\n#endif$", r"\1"),
    )
)


def model_source(functions: Mapping[str, ca.Function]) -> str:
    """Text of ``model.c``: the functions, each under its own name, and their helpers, which become static.

    ``fmax`` and ``fmin`` take the form of `models.ops.FLOATS` (the second argument where one is NaN), which is also the
    one that compilers turn into an instruction. Tables that nothing refers to are left out.
    """
    generator = ca.CodeGenerator("model.c", {"with_export": False, "casadi_int": "long long"})
    for function in functions.values():
        generator.add(function)
    text = str(generator.dump())
    for pattern, replacement in CLEANING:
        text = pattern.sub(replacement, text)
    uses = Counter(re.findall(r"\bcasadi_[a-z]+\d+\b", text))
    table = re.compile(r"static const \w+ (casadi_[a-z]+\d+)\b|#define (casadi_[a-z]+\d+) ")
    lines = []
    for line in text.splitlines():
        named = table.match(line)
        if not (named and uses[named[1] or named[2]] <= 2):  # its definition and its prefixed name
            lines.append(line)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip() + "\n"
