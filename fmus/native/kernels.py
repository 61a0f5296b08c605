"""Kernels in traces: calls of C functions from traced functions (``models/numeric/kernel.py``, ``runtime/kernel``).

A trace holds a kernel as a call of a stand-in, a CasADi function of its name that is not inlined; in the C text the stand-in's
body becomes a call of the kernel. Its last argument is the kernel's number, its others are the time and what stays between
events, so that only the time has a derivative: a result v with the rate v' is written v + v' (t - now), where now takes the
value of t after differentiation.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca

from ...models.numeric.kernel import Kernel
from ...models.numeric.ops import NEGLIGIBLE, Ops
from ...models.route import playback
from ...models.sea import kernel as sea
from ...models.sea import motion
from ...models.sea.waves import GRAVITY
from .c_text import number

STAND_IN = "kernel"
CONSTANTS = {
    "GRAVITY": GRAVITY, "RESONANCE": NEGLIGIBLE, "PI": 3.141592653589793, "ORDER": motion.ORDER, "REACH": motion.REACH,
    "BLOCK": motion.BLOCK, "SIGNALS": motion.SIGNALS, "HEAVE": sea.HEAVE, "PITCH": sea.PITCH, "POINT": motion.POINT,
    "BEYOND": sea.BEYOND, "SLACK": playback.SLACK,
}  # fmt: skip
"""What kernels share with their Python text."""
SERIES = ("sea",)
"""Kernels whose values are sums of series, which an ensemble takes for many members at once."""


class Kernels:
    """The kernels that a trace meets, in the order of their numbers."""

    def __init__(self) -> None:
        self.found: list[Kernel] = []
        self.now = ca.SX.sym("now")

    def ops(self, ops: Ops) -> Ops:
        """``ops`` with calls of kernels."""
        return replace(ops, kernel=self._call)

    def _call(self, kernel: Kernel, t: Any, *arguments: Any) -> tuple[Any, ...]:
        if kernel not in self.found:
            self.found.append(kernel)
        number = self.found.index(kernel)
        raw = self._stand_in(number, len(arguments) + 2, len(kernel.rates))
        results = raw.call([ca.vertcat(self.now, *arguments, number)], False, True)[0]
        values = tuple(results[k] for k in range(len(kernel.rates)))
        return tuple(value + slope * (t - self.now) for value, slope in zip(values, kernel.slopes(values)))

    def _stand_in(self, number: int, arguments: int, results: int) -> ca.Function:
        """Depends on every argument, and has no slope."""
        a = ca.SX.sym("a", arguments)
        some = ca.sum1(ca.floor(a))
        return ca.Function(f"{STAND_IN}_{number}", [a], [ca.vertcat(*(some + k for k in range(results)))])


def called(text: str) -> str:
    """C text of traced functions in which stand-ins call their kernels."""
    arguments = "const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem"
    body = rf"\1({arguments}) {{{{\n  {{}}\n}}}}\n"
    call = body.format(r"return towage_kernel(\2, arg[0], res[0], iw);")
    found = rf"^(/\* {STAND_IN}_(\d+):[^\n]*\*/\nstatic int \w+)\([^)]*\) \{{.*?^\}}\n"
    text, count = re.subn(found, call, text, flags=re.MULTILINE | re.DOTALL)
    first = re.search(rf"^/\* {STAND_IN}_\d+:", text, re.MULTILINE)
    if not count or not first:
        raise AssertionError("this version of CasADi writes calls in another form")
    declared = (
        "int towage_kernel(int number, const casadi_real *argument, casadi_real *result, const casadi_int *iw);\n\n"
    )
    return text[: first.start()] + declared + text[first.start() :]


def constants_source() -> str:
    """``kernel_constants.h``."""
    lines = [f"#define {name} {value!r}" for name, value in CONSTANTS.items()]
    guard = "TOWAGE_KERNEL_CONSTANTS_H"
    head = ["/* Made from models/sea and models/route/playback.py. */", f"#ifndef {guard}", f"#define {guard}", ""]
    return "\n".join([*head, *lines, "", "#endif", ""])


def tables_source(kernels: Sequence[Kernel]) -> str:
    """The kernels with their tables."""
    tables = "".join(f"static const double table_{i}[] = {{{_numbers(k.tables)}}};\n" for i, k in enumerate(kernels))
    series = {k.name: f"kernel_{k.name}_series" if k.name in SERIES else "0" for k in kernels}
    rows = ",\n".join(
        f"    {{kernel_{k.name}, kernel_{k.name}_size, table_{i}, {series[k.name]}}}" for i, k in enumerate(kernels)
    )
    return f"{tables}\nstatic const Kernel kernels[] = {{\n{rows},\n}};\n"


def kernels_source(kernels: Sequence[Kernel]) -> str:
    """``kernels.c`` of a unit."""
    return f"""/* The kernels of the unit, with their tables. */
#include <stdint.h>
#include "kernel.h"

{tables_source(kernels)}
enum {{ COUNT = {len(kernels)} }};

void *kernels_make(void);
void kernels_drop(void *);
int towage_kernel(int, const double *, double *, const long long *);
const double *towage_kernel_series(int, const double *, int, double *, const long long *, double *);

void *kernels_make(void) {{ return kernels_memory(kernels, COUNT); }}
void kernels_drop(void *memory) {{ kernels_free(memory, COUNT); }}

int towage_kernel(int number, const double *argument, double *result, const long long *iw)
{{
    void **memory = (void **)(intptr_t)iw[0];
    kernels[number].call(kernels[number].table, argument, result, memory[number]);
    return 0;
}}

const double *towage_kernel_series(int number, const double *argument, int same, double *result, const long long *iw, double *tau)
{{
    const Kernel *kernel = kernels + number;
    void *memory = ((void **)(intptr_t)iw[0])[number];
    if (kernel->series) return kernel->series(kernel->table, argument, same, result, memory, tau);
    kernel->call(kernel->table, argument, result, memory);
    return 0;
}}
"""


def sources(kernels: Sequence[Kernel]) -> dict[str, bytes]:
    """What the kernels need beside the files of ``runtime/kernel``, by name."""
    return {"kernel_constants.h": constants_source().encode(), "kernels.c": kernels_source(kernels).encode()}


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(number(value, "0.0") for value in values)
