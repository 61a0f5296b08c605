"""A unit's equations for many members at once: C text in which every variable is a vector of lanes, one member in each.

The traced functions (`trace`) are written out operation by operation. What follows from parameters and inputs alone, which
are constant over a run, is computed once by ``model_prepare``, what follows from them and the modes whenever these change,
by ``model_branch``; a division by either becomes a product, and equal operations are written once. ``native/ensemble``
holds the operations on lanes and the integrator.

An ensemble's code is for the machine that compiles it, and so lets the compiler use all of its instructions and fuse
products with sums: numbers differ from those of an FMU by rounding.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca

from ....models.heave.system import DORMAND_PRINCE_8
from ....models.numeric.tableaus import Tableau
from ...declare.unit import Unit
from ..compiler import compiler, host, output_of
from ..constants import definitions
from ..kernels import sources as kernel_sources
from ..stages import combination, stage_lines
from ..trace import trace
from ..traced import NotNative, Traced, column

SOURCES = Path(__file__).resolve().parent
FLAGS = (
    "-std=gnu11", "-O3", "-g0", "-march=native", "-fPIC", "-shared", "-fvisibility=hidden", "-w",
    "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-fno-signed-zeros",
)  # fmt: skip
MASK, NUMBER = "I", "V"

METHOD = DORMAND_PRINCE_8
"""Outputs are wanted so often that one step of order 8 reaches from one to the next."""

UNARY = {
    ca.OP_NEG: "-{0}", ca.OP_SQ: "{0} * {0}", ca.OP_TWICE: "{0} + {0}", ca.OP_INV: "1.0 / {0}",
    ca.OP_SQRT: "root({0})", ca.OP_FABS: "size({0})", ca.OP_SIGN: "sign({0})",
} | {
    getattr(ca, f"OP_{name.upper()}"): f"lane_{name}({{0}})"
    for name in ("sin", "cos", "tan", "tanh", "atan", "exp", "log", "log1p", "expm1", "floor")
}  # fmt: skip
BINARY = {
    ca.OP_ADD: "{0} + {1}", ca.OP_SUB: "{0} - {1}", ca.OP_MUL: "{0} * {1}", ca.OP_DIV: "{0} / {1}",
    ca.OP_FMIN: "lesser({0}, {1})", ca.OP_FMAX: "greater({0}, {1})", ca.OP_ATAN2: "lane_atan2({0}, {1})",
    ca.OP_POW: "lane_pow({0}, {1})", ca.OP_CONSTPOW: "lane_pow({0}, {1})",
}  # fmt: skip
COMPARISONS = {ca.OP_LT: "<", ca.OP_LE: "<=", ca.OP_EQ: "==", ca.OP_NE: "!="}


FIXED, BRANCH, MOVING = range(3)
"""What decides a value: parameters and inputs alone, modes too, or time and states."""


class Name(NamedTuple):
    """A value in the text: what it is called, whether it is a mask, and what decides it."""

    text: str
    kind: str = NUMBER
    level: int = FIXED


@dataclass(frozen=True)
class Text:
    """C text of one unit. ``parameters`` and ``inputs`` name the columns of a row of ``q``, ``observed`` those of the
    results; ``traced`` has what is asked about parameters before a run."""

    text: str
    unit: Unit
    observed: tuple[str, ...]
    traced: Traced

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of parameters, then inputs."""
        return tuple(v.name for v in self.unit.parameters + self.unit.inputs)


@dataclass
class Writer:
    """Operations as C statements: those of ``model_prepare`` and ``model_branch``, which all functions share, and those of the
    function that is being written. ``slots`` are the places in c of the shared values."""

    lines: tuple[list[str], list[str], list[str]] = field(default_factory=lambda: ([], [], []))
    slots: dict[Name, int] = field(default_factory=dict)
    known: dict[tuple[Any, ...], Name] = field(default_factory=dict)
    count: int = 0

    def value(self, expression: str, *of: Name, kind: str = NUMBER) -> Name:
        """The value of an expression with the places {0}, {1}; one that was written before is not written again."""
        key = (expression, *of)
        if key not in self.known:
            level = max(name.level for name in of)
            places = [self.used(name, level) for name in of]
            self.count += 1
            self.known[key] = name = Name(f"v{self.count}", kind, level)
            self.lines[level].append(f"    const {kind} {name.text} = {expression.format(*places)};")
        return self.known[key]

    def used(self, name: Name, level: int = MOVING) -> str:
        """How a value is called where those of ``level`` are written."""
        if name.level == level or not name.text.startswith("v"):
            return name.text
        slot = self.slots.setdefault(name, len(self.slots))
        return f"((I)c[{slot}])" if name.kind == MASK else f"c[{slot}]"

    def shared(self, signature: str, level: int) -> str:
        """The function that fills the places of ``level``; written last, when all of them are known."""
        kept = [f"    c[{slot}] = (V){name.text};" for name, slot in self.slots.items() if name.level == level]
        return "\n".join([f"static {signature}", "{", *self.lines[level], *kept, "}", ""])

    def mask(self, a: Name) -> Name:
        """A number as a condition."""
        return a if a.kind == MASK else self.value("(I)({0} != all(0.0))", a, kind=MASK)

    def number(self, a: Name) -> Name:
        """A condition as 1 or 0."""
        return a if a.kind == NUMBER else self.value("number({0})", a)

    def operation(self, op: int, of: Sequence[Name]) -> Name:
        """One operation of CasADi's."""
        if op == ca.OP_NOT:
            return self.value("~{0}", self.mask(of[0]), kind=MASK)
        if op in (ca.OP_AND, ca.OP_OR):
            sign = "&" if op == ca.OP_AND else "|"
            return self.value(f"{{0}} {sign} {{1}}", *map(self.mask, of), kind=MASK)
        if op == ca.OP_IF_ELSE_ZERO:
            return self.value("kept({0}, {1})", self.mask(of[0]), self.number(of[1]))
        of = [self.number(a) for a in of]
        if op in COMPARISONS:
            return self.value(f"(I)({{0}} {COMPARISONS[op]} {{1}})", *of, kind=MASK)
        if op == ca.OP_DIV and of[1].level < of[0].level:
            return self.value("{0} * {1}", of[0], self.value("1.0 / {0}", of[1]))
        if op in UNARY:
            return self.value(UNARY[op], of[0])
        if op in BINARY:
            return self.value(BINARY[op], *of)
        raise NotNative(
            f"an ensemble has no operation number {op} of CasADi {ca.CasadiMeta.version()}: add it to UNARY or BINARY"
        )

    def called(self, of: Sequence[Name], results: int) -> list[Name]:
        """The results of a kernel, whose number is the last argument."""
        *arguments, number = map(self.number, of)
        key = ("kernel", number, *arguments)
        if key not in self.known:
            self.count += 1
            self.known[key] = name = Name(f"kernel_{self.count}", NUMBER, MOVING)
            places = ", ".join(self.used(argument) for argument in arguments)
            call = f"kernel_lanes((int){number.text}[0], (const V[]){{{places}}}, {len(arguments)}, {name.text}, {results});"
            self.lines[MOVING].extend([f"    V {name.text}[{results}];", f"    {call}"])
        return [Name(f"{self.known[key].text}[{k}]", NUMBER, MOVING) for k in range(results)]

    def function(self, signature: str, f: ca.Function, arguments: Sequence[str], results: Sequence[str]) -> str:
        """``f`` as a C function. ``arguments``: t, x, m or q for those of ``f``; ``results``: arrays in the text, or
        "return"."""
        self.lines[MOVING].clear()
        self.known = {key: name for key, name in self.known.items() if name.level < MOVING}
        work: dict[int, Name] = {}
        stores = []
        for k in range(f.n_instructions()):
            op, of, to = f.instruction_id(k), f.instruction_input(k), f.instruction_output(k)
            if op == ca.OP_INPUT:
                array = arguments[of[0]]
                level = {"q": FIXED, "m": BRANCH}.get(array, MOVING)
                source = Name(array if array == "t" else f"{array}[{of[1]}]", NUMBER, level)
                work[to[0]] = self.value("{0}", source) if level < MOVING else source
            elif op == ca.OP_CONST:
                work[to[0]] = Name(f"all({_literal(f.instruction_constant(k))})")
            elif op == ca.OP_CALL:
                for place, name in zip(to, self.called([work[i] for i in of], len(to))):
                    work[place] = name
            elif op == ca.OP_OUTPUT:
                value = self.used(self.number(work[of[0]]))
                target = results[to[0]]
                stores.append(f"    return {value};" if target == "return" else f"    {target}[{to[1]}] = {value};")
            else:
                work[to[0]] = self.operation(op, [work[i] for i in of])
        return "\n".join([f"static {signature}", "{", *self.lines[MOVING], *stores, "}", ""])


def text(unit: Unit, observed: Sequence[str], method: Tableau = METHOD) -> Text:
    """The unit as C text that computes the outputs ``observed``. Raises `NotNative` for a unit that cannot be traced or
    has no rates."""
    if unit.model.linear or not unit.model.derivatives:
        raise NotNative(f"{unit.name} has no rates to integrate; a scene that contains it can be composed")
    traced = trace(unit)
    functions = traced.functions
    if "derivatives" not in functions:
        raise NotNative(f"{unit.name} has no continuous states that an ensemble could integrate")
    nx, nm = functions["derivatives"].size1_in(1), traced.modes
    ni, np_ = len(unit.inputs), len(unit.parameters)
    t, x, m, q = column("t", 1), column("x", nx), column("m", nm), column("q", np_ + ni)
    p, u, none = q[:np_], q[np_:], column("c", 0)
    writer = Writer()
    vectors = "V t, const V *restrict x, const V *restrict c"

    def written(name: str, results: Sequence[Any], kind: str, more: str, targets: Sequence[str]) -> str:
        f = ca.Function(name, [t, x, m, q], [ca.densify(ca.SX(r)) for r in results])
        return writer.function(f"{kind} model_{name}({vectors}{more})", f, ("t", "x", "m", "q"), targets)

    def called(field: str, *arguments: Any) -> tuple[Any, ...]:
        return tuple(functions[field].call(list(arguments), True, False))

    seen = called("outputs", t, x, m, u, ca.SX.zeros(ni), p, none)[0]
    places = {v.name: i for i, v in enumerate(unit.observed)}
    at = (t, x, m, u, p, none)
    indicated = called("indicate", *at)[0] if "indicate" in functions else ca.SX(0, 1)
    changed = called("change", *at) if "change" in functions else (x, m)
    due = called("next_event", t, m, p, none)[0] if "next_event" in functions else ca.SX(math.inf)
    first = ca.Function("initial", [q], [ca.densify(r) for r in called("initial", p, none)])
    body = [
        writer.function(
            "void model_initial(const V *restrict c, V *restrict nx, V *restrict nm)", first, ("q",), ("nx", "nm")
        ),
        written("rates", called("derivatives", *at), "void", ", V *restrict f", ("f",)),
        written("indicators", [indicated], "void", ", V *restrict g", ("g",)),
        written("change", changed, "void", ", V *restrict nx, V *restrict nm", ("nx", "nm")),
        written("outputs", [ca.vertcat(*(seen[places[name]] for name in observed))], "void", ", V *restrict y", ("y",)),
        written("next", [due], "V", "", ("return",)),
        "static V model_next_event(V t, const V *c) { return model_next(t, 0, c); }\n",
    ]
    branch = writer.shared("void model_branch(const V *restrict m, V *restrict c)", BRANCH)
    prepare = writer.shared("void model_prepare(const V *restrict q, V *restrict c)", FIXED)
    sizes = {"NQ": np_ + ni, "NC": len(writer.slots), "NX": nx, "NM": nm, "NG": indicated.numel(), "NY": len(observed),
             "STAGES": len(method.c), "ERRORS": len(method.error), "ORDER": method.order}  # fmt: skip
    shared = definitions("SAFETY", "MOST_GROWTH", "LEAST_GROWTH", "RESCUE", "NO_NUMBER", "LANDING")
    kernels = ['#include "kernels.h"'] if traced.kernels else []
    head = [
        '#include "lanes.h"', *kernels, "", *(f"#define {name} {size}" for name, size in sizes.items()), *shared, ""
    ]  # fmt: skip
    return Text("\n".join([*head, prepare, branch, *body, _stages(method)]), unit, tuple(observed), traced)


def library(source: Text) -> bytes:
    """The shared library of ``native/ensemble`` with that text, for this machine. Raises `CompileError`."""
    files = {path.name: path.read_bytes() for path in sources_of(source)}
    if source.traced.kernels:
        files |= kernel_sources(source.traced.kernels)
    texts = sorted(name for name in files if name.endswith(".c"))
    command = [*compiler(host()), *FLAGS, *texts, "-o", "ensemble.so", "-lm"]
    return output_of(command, files | {"model.h": source.text.encode()}, "ensemble.so")


def sources_of(source: Text) -> list[Path]:
    """The files that serve all ensembles, with those of kernels where there are any."""
    folders = [SOURCES, *([SOURCES.parent / "runtime" / "kernel"] if source.traced.kernels else [])]
    return [path for folder in folders for path in sorted(folder.iterdir()) if path.suffix in (".c", ".h")]


def _literal(value: float) -> str:
    return (
        repr(value) if math.isfinite(value) else "NAN" if value != value else "INFINITY" if value > 0 else "-INFINITY"
    )


def _stages(method: Tableau) -> str:
    """The method's stages and its errors."""
    rate = "k[{}][i]"
    steps = stage_lines(
        method, rate, evaluate="model_rates({time}, {point}, c, k[{stage}]);", loop="for (int i = 0; i < NX; i++)",
        end="end",
    )  # fmt: skip
    errors = [f"    if (e == {e})\n        return {combination(w, rate)};" for e, w in enumerate(method.error)]
    return "\n".join([
        "static void model_stages(V t, V h, V end, const V *restrict x, const V *restrict c, ",
        "                         V (*restrict k)[NX], V *restrict y)",
        "{", *(f"    {line}" for line in steps), "}", "",
        "INLINE V model_error(int e, int i, V (*k)[NX])", "{", *errors, "    return all(NAN);", "}", "",
    ])  # fmt: skip
