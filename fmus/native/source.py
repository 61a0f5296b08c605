"""Text of ``unit.c``: a traced unit's sizes, variables and functions in the form of ``native/runtime/unit.h``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import casadi as ca

from ..declare.arrays import lengths
from ..declare.unit import Variable
from .trace import Traced

CAUSALITY = {"parameter": "PARAMETER", "calculatedParameter": "CALCULATED", "input": "INPUT", "output": "OUTPUT",
             "local": "LOCAL"}  # fmt: skip
UNIT_FUNCTIONS = (
    "setup", "required", "calculate", "initial", "derivatives", "advance", "indicate", "change", "next_event",
    "outputs", "derivatives_forward", "outputs_forward",
)  # fmt: skip
"""Fields of ``Unit`` that hold a function."""


def unit_source(traced: Traced, token: str) -> str:
    """The C text. ``token`` is the guid of FMI 2 and the instantiation token of FMI 3."""
    interface, functions = traced.interface, traced.functions
    unit = interface.unit
    names, counts = [v.name for v in unit.parameters], lengths(interface.variables)
    sizes = {
        "variables": len(interface.variables),
        "parameters": len(names),
        "calculated": len(unit.calculated),
        "inputs": len(unit.inputs),
        "observed": len(unit.observed),
        "states": len(interface.states),
        "modes": traced.modes,
        "indicators": interface.indicators,
        "requirements": len(traced.requirements),
        "constants": traced.constants,
        "extras": len(interface.extras),
        "tolerance": unit.index.get("integration_tolerance", -1),
        "frozen": names.index("freeze_branches") if "freeze_branches" in names else -1,
    }
    fields = {
        "name": text(unit.name),
        "token": text(token),
        **{name: str(size) for name, size in sizes.items()},
        "variable": "variable",
        "rate": "rate",
        "length": "length" if 0 in counts else "NULL",
        "requirement": "requirement" if traced.requirements else "NULL",
        "state_names": text(", ".join(v.name for v in interface.states)),
        **{name: entry(functions[name]) for name in UNIT_FUNCTIONS if name in functions},
        "linear": "&linear" if traced.linear else "NULL",
    }
    parts = [
        "/* What the runtime needs to know of the unit: made from its declaration and its traced model. */",
        '#include <math.h>\n#include <stddef.h>\n#include "unit.h"',
        "".join(declaration(function) for function in functions.values()).rstrip(),
        array("Variable", "variable", (_variable(v) for v in interface.variables)),
        array("int", "rate", (str(k) for k in _rates(unit.observed))),
        array("int", "length", map(str, counts)) if 0 in counts else "",
        array("char *const", "requirement", map(text, traced.requirements)) if traced.requirements else "",
        traced.linear,
        "const Unit towage_unit = {\n" + initializer(fields) + "};\n",
    ]
    return "\n\n".join(part for part in parts if part)


def entry(function: ca.Function) -> str:
    """Initializer of a ``Function``."""
    sizes = function.sz_arg(), function.sz_res(), function.sz_iw(), function.sz_w()
    return f"{{{function.name()}, {', '.join(map(str, sizes))}}}"


def declaration(function: ca.Function) -> str:
    """Prototype of a function of ``model.c``."""
    return f"int {function.name()}(const double **, double **, Integer *, double *, int);\n"


def initializer(fields: Mapping[str, str]) -> str:
    """Designated initializers, one a line; fields that are not named are zero, a function without ``call``."""
    return "".join(f"    .{name} = {value},\n" for name, value in fields.items())


def array(kind: str, name: str, values: Iterable[str]) -> str:
    """A constant array, one value a line."""
    return f"static const {kind} {name}[] = {{\n" + "".join(f"    {value},\n" for value in values) + "};"


def text(value: str) -> str:
    """A string literal."""
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'


def number(value: float | None, absent: str) -> str:
    """A double, to the last bit; ``absent`` where there is none."""
    if value is None:
        return absent
    if not math.isfinite(value):
        raise ValueError(f"{value} in a declaration: expected a finite number")
    return repr(float(value))


def _variable(v: Variable) -> str:
    values = number(v.start, "0.0"), number(v.min, "-INFINITY"), number(v.max, "INFINITY")
    kinds = CAUSALITY[v.causality], v.variability.upper()
    return f"{{{text(v.name)}, {text(v.unit)}, {', '.join(values)}, {', '.join(kinds)}}}"


def _rates(observed: tuple[Variable, ...]) -> list[int]:
    """For each observed variable the position of its time derivative among them, -1 where it is none of them."""
    names = {v.name: i for i, v in enumerate(observed)}
    return [names.get(f"{v.name}_rate", -1) for v in observed]
