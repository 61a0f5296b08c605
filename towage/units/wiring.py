"""The buffers of a unit: where its connected inputs and its outputs live, and what the calls for them take.

A communication step costs one set, one step and one get, whatever the number of variables. A derivative of an input is
the variable ``<input>_d1``, ``_d2`` or ``_d3`` if there is one, else it goes through fmi2SetRealInputDerivatives: up to
order 3 into units that have the variables too, the slope alone into others, whose limit FMI 2.0 does not tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import Array, addressof, c_double, c_int, c_uint, sizeof
from dataclasses import dataclass
from typing import Any, NamedTuple

from towage.fmus.declare.unit import INPUT_ORDERS
from towage.units.description import Description


class Wanted(NamedTuple):
    """What a scene wants of a unit: ``connected`` inputs, outputs that are ``sources`` of connections, and all
    ``outputs`` that are read after every step.

    ``cubic``: inputs are given their derivatives too, and the rates of sources that are not among the outputs are read if
    the unit computes them. ``by_function``: input derivatives go through fmi2SetRealInputDerivatives where they may go
    with the inputs too: a second call costs more than the values it carries (``benchmarks/native.py``).
    """

    connected: Sequence[str]
    sources: Sequence[str]
    outputs: Sequence[str]
    cubic: bool = True
    by_function: bool = False


@dataclass(frozen=True)
class Input:
    """Where a connected input lives in the input buffer: its value in ``slot``, its derivatives up to order ``orders``
    from ``derivatives`` on. ``feedthrough``: it acts on a source without delay."""

    name: str
    slot: int
    derivatives: int
    orders: int
    feedthrough: bool


Arguments = tuple[int, ...]
"""What a call takes after the component; empty if there is nothing to call for."""


class Wiring:
    """The buffers of one unit.

    ``inputs`` tells the places in ``input_buffer``: values of inputs first, then derivatives that are variables, then
    those that the function takes. ``outputs`` names the values of ``output_buffer``: those wanted, then rates of sources
    that the unit computes by function, as ``<source>_rate``.
    """

    def __init__(self, description: Description, wanted: Wanted) -> None:
        self.variables = description.by_name()
        self._alive: list[Any] = []
        self._wire_inputs(description, wanted)
        self._wire_outputs(description, wanted)

    def _wire_inputs(self, description: Description, wanted: Wanted) -> None:
        by_function, by_variable = self._derivatives(description, wanted)
        connected = wanted.connected
        orders = {i: 3 if self._declared(i) else 1 for i in by_function} | dict.fromkeys(by_variable, 3)
        names = [*connected, *(f"{i}_d{k}" for i in by_variable for k in INPUT_ORDERS)]
        passed = [(i, k) for i in by_function for k in range(1, orders[i] + 1)]
        first = {i: len(connected) + 3 * n for n, i in enumerate(by_variable)}
        first |= {i: len(names) + passed.index((i, 1)) for i in by_function}
        self.inputs = {
            i: Input(i, n, first.get(i, 0), orders.get(i, 0), _feeds(description, i, wanted.sources))
            for n, i in enumerate(connected)
        }
        self.input_buffer = (c_double * (len(names) + len(passed)))()
        self.set_values = self.arguments(names, self.input_buffer, 0)
        self.set_derivatives = self.arguments(
            [i for i, _ in passed], self.input_buffer, len(names), [k for _, k in passed]
        )

    def _derivatives(self, description: Description, wanted: Wanted) -> tuple[list[str], list[str]]:
        """Inputs whose derivatives go through the function, and those whose derivatives are variables."""
        if not wanted.cubic:
            return [], []
        declared = [i for i in wanted.connected if self._declared(i)]
        if not description.can_interpolate_inputs:
            return [], declared
        by_function = [i for i in wanted.connected if wanted.by_function or i not in declared]
        return by_function, [i for i in declared if i not in by_function]

    def _declared(self, name: str) -> bool:
        """Whether all derivatives of an input are variables."""
        return all(f"{name}_d{k}" in self.variables for k in INPUT_ORDERS)

    def _wire_outputs(self, description: Description, wanted: Wanted) -> None:
        computes = wanted.cubic and description.max_output_derivative_order
        rated = [n for n in wanted.sources if f"{n}_rate" not in wanted.outputs] if computes else []
        self.outputs = [*wanted.outputs, *(f"{n}_rate" for n in rated)]
        self.output_buffer = (c_double * len(self.outputs))()
        self.get_values = self.arguments(wanted.outputs, self.output_buffer, 0)
        self.get_derivatives = self.arguments(rated, self.output_buffer, len(wanted.outputs), [1] * len(rated))

    def arguments(
        self, names: Sequence[str], buffer: Array[c_double], first: int, orders: Sequence[int] | None = None
    ) -> Arguments:
        """What a call for these variables takes: addresses of the references, their number, the addresses of the orders
        of derivatives if there are any, and of the values, in ``buffer`` from ``first`` on."""
        references = (c_uint * len(names))(*(self.variables[n].value_reference for n in names))
        kinds = (c_int * len(names))(*(orders or ()))
        self._alive += [references, kinds]
        middle = () if orders is None else (addressof(kinds),)
        values = addressof(buffer) + first * sizeof(c_double)
        return (addressof(references), len(names), *middle, values) if names else ()


def _feeds(description: Description, name: str, sources: Sequence[str]) -> bool:
    """Whether an input acts on a source without delay, which it does unless the unit declares otherwise."""
    return any(d is None or name in d for output, d in description.dependencies.items() if output in sources)
