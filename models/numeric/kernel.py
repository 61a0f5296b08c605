"""Kernels: functions of arrays and loops, written twice, in Python here and in C for compiled code.

A trace follows scalars. What sums over hundreds of wave components or looks up a row of a table is a kernel instead: model
functions call ``ops.kernel(kernel, t, ...)``, floats run its Python text, and compiled code (native units, ensembles) calls the
C function of its name (``fmus/native/runtime/kernel``) with the same arguments and tables. Results depend on the arguments
alone; what a kernel remembers between calls saves time and changes nothing.

The first argument is the time. The others do not change with it: parameters, modes, positions in a table.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .ops import Value


@dataclass(frozen=True, eq=False, repr=False)
class Kernel:
    """``name`` of the C function, ``kernel_<name>``; ``run(t, ...)``, the same in Python; ``rates``: for every result the
    position of the result that is its time derivative, -1 where it is none of them; ``tables``: numbers that the C function
    reads beside its arguments, as it says itself."""

    name: str
    run: Callable[..., tuple[float, ...]]
    rates: tuple[int, ...]
    tables: tuple[float, ...] = ()

    def slopes(self, results: tuple[Value, ...]) -> tuple[Value, ...]:
        """Time derivatives of ``results``; 0 of those that have none among them."""
        return tuple(results[k] if k >= 0 else 0.0 for k in self.rates)
