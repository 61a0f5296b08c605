"""The functions of a traced unit, compiled from its ``model.c`` alone and called as the runtime calls them."""

from __future__ import annotations

import ctypes
import random
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from towage.fmus.declare.unit import Unit
from towage.fmus.native.compiler import host, library
from towage.fmus.native.source import model_source
from towage.fmus.native.traced import Traced
from towage.models.numeric.ops import FLOATS

Vector = Sequence[float]
POINTER = ctypes.POINTER(ctypes.c_double)


class Compiled:
    """``compiled(name, *vectors)`` returns the results of ``model_<name>`` as lists."""

    def __init__(self, traced: Traced, directory: Path) -> None:
        self.functions = traced.functions
        text = model_source(traced.functions)
        exports = "".join(
            f"__attribute__((visibility(\"default\"))) int model_{name}"
            "(const double **, double **, long long *, double *, int);\n" for name in traced.functions
        )  # fmt: skip
        path = directory / f"{traced.interface.unit.name}.so"
        path.write_bytes(library({"model.c": (exports + text).encode()}, path.stem, host()))
        self.library = ctypes.CDLL(str(path))

    def __call__(self, name: str, *vectors: Vector) -> list[list[float]]:
        function = self.functions[name]
        assert [len(v) for v in vectors] == [function.numel_in(i) for i in range(function.n_in())]
        given = [(ctypes.c_double * max(1, len(v)))(*v) for v in vectors]
        found = [(ctypes.c_double * max(1, function.numel_out(i)))() for i in range(function.n_out())]
        work = (ctypes.c_double * (function.sz_w() + 1))()
        integers = (ctypes.c_longlong * (function.sz_iw() + 1))()

        def pointers(arrays: list[Any], size: int) -> Any:
            cast = [ctypes.cast(a, POINTER) for a in arrays]
            return (POINTER * (size + 1))(*cast)

        call = getattr(self.library, f"model_{name}")
        assert call(pointers(given, function.sz_arg()), pointers(found, function.sz_res()), integers, work, 0) == 0
        return [list(a)[: function.numel_out(i)] for i, a in enumerate(found)]


def point(unit: Unit, modes: int, states: int, chance: random.Random) -> SimpleNamespace:
    """Random arguments of the functions. Parameters make sense, and are zero now and then, where guards act."""

    def parameter(start: float, low: float | None, high: float | None) -> float:
        value = chance.choice((start, start * chance.uniform(0.5, 1.5), chance.uniform(0.0, 10.0), 0.0))
        return min(max(value, -1e300 if low is None else low), 1e300 if high is None else high)

    while True:
        start = {v.name: unit.start.get(v.name, v.start or 0.0) for v in unit.parameters}
        values = [parameter(start[v.name], v.min, v.max) for v in unit.parameters]
        p = unit.model.Parameters(**{v.name: value for v, value in zip(unit.parameters, values)})
        required = unit.model.requirements(p, FLOATS) if unit.model.requirements else ()
        if all(value > 0.0 for value, _ in required):
            break

    def column(size: int) -> list[float]:
        return [chance.uniform(-5.0, 5.0) for _ in range(size)]

    n = len(unit.inputs)
    return SimpleNamespace(
        t=[chance.uniform(0.0, 20.0)], h=[chance.uniform(1e-3, 2.0)], x=column(states),
        m=[float(chance.randrange(2)) for _ in range(modes)], u=column(n), du=column(n), k=column(4 * n), p=values,
        parameters=p,
    )  # fmt: skip
