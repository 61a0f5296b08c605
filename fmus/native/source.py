"""C text of a traced unit: ``unit.c``, its sizes, variables and functions in the form of ``native/runtime/core/unit.h``, and
``model.c``, the functions themselves."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping

import casadi as ca

from ..declare.arrays import lengths
from ..declare.unit import Variable
from .c_text import array, declaration, entry, initializer, number, text
from .constants import CAUSALITIES
from .kernels import STAND_IN, called
from .source_linear import linear_text
from .traced import Traced

CAUSALITY = {causality: name for name, causality in CAUSALITIES.items()}
UNIT_FUNCTIONS = (
    "setup", "required", "calculate", "initial", "derivatives", "advance", "indicate", "change", "next_event",
    "outputs", "derivatives_forward", "outputs_forward",
)  # fmt: skip
"""Fields of ``Unit`` that hold a function."""


def unit_source(traced: Traced, token: str) -> str:
    """The C text. ``token`` is the guid of FMI 2 and the instantiation token of FMI 3."""
    interface, functions = traced.interface, traced.functions
    unit, layout = interface.unit, interface.layout
    names, counts = [v.name for v in unit.parameters], lengths(interface.variables)
    sizes = {
        "variables": len(interface.variables),
        "parameters": len(names),
        "calculated": len(layout.calculated),
        "inputs": len(layout.inputs),
        "observed": len(layout.observed),
        "states": len(layout.states),
        "modes": traced.modes,
        "indicators": interface.indicators,
        "requirements": len(traced.requirements),
        "constants": traced.constants,
        "extras": len(layout.extras),
        "tolerance": unit.index.get("integration_tolerance", -1),
        "frozen": names.index("freeze_branches") if "freeze_branches" in names else -1,
    }
    fields = {
        "name": text(unit.name),
        "token": text(token),
        "first": "{" + ", ".join(f".{kind} = {place.start}" for kind, place in interface.layout._asdict().items()) + "}",
        **{name: str(size) for name, size in sizes.items()},
        "variable": "variable",
        "rate": "rate",
        "length": "length" if 0 in counts else "NULL",
        "requirement": "requirement" if traced.requirements else "NULL",
        "state_names": text(", ".join(v.name for v in interface.states)),
        **{name: entry(functions[name]) for name in UNIT_FUNCTIONS if name in functions},
        "linear": "&linear" if traced.linear else "NULL",
        **({"memory_make": "kernels_make", "memory_drop": "kernels_drop"} if traced.kernels else {}),
        "steps": "&wire_steps" if traced.headers else "NULL",
        **({"point": "{" + ", ".join(entry(f) for name, f in functions.items() if name.startswith("point_")) + "}"}
           if traced.headers else {}),
    }
    parts = [
        "/* What the runtime needs to know of the unit: made from its declaration and its traced model. */",
        '#include <math.h>\n#include <stddef.h>\n#include "unit.h"' + ('\n#include "wire.h"' if traced.headers else ""),
        "".join(declaration(function) for function in functions.values()).rstrip(),
        "void *kernels_make(void);\nvoid kernels_drop(void *);" if traced.kernels else "",
        array("Variable", "variable", (_variable(v) for v in interface.variables)),
        array("int", "rate", (str(k) for k in _rates(unit.observed))),
        array("int", "length", map(str, counts)) if 0 in counts else "",
        array("char *const", "requirement", map(text, traced.requirements)) if traced.requirements else "",
        linear_text(traced.linear, functions, names) if traced.linear else "",
        "const Unit towage_unit = {\n" + initializer(fields) + "};\n",
    ]
    return "\n\n".join(part for part in parts if part)


def _variable(v: Variable) -> str:
    values = number(v.start, "0.0"), number(v.min, "-INFINITY"), number(v.max, "INFINITY")
    kinds = CAUSALITY[v.causality], v.variability.upper()
    return f"{{{text(v.name)}, {text(v.unit)}, {', '.join(values)}, {', '.join(kinds)}}}"


def _rates(observed: tuple[Variable, ...]) -> list[int]:
    """For each observed variable the position of its time derivative among them, -1 where it is none of them."""
    names = {v.name: i for i, v in enumerate(observed)}
    return [names.get(f"{v.name}_rate", -1) for v in observed]


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
    if f"/* {STAND_IN}_0:" in text:
        text = called(text)
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
