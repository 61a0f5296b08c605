"""The buffers of a unit: where its connected inputs and its outputs live, and what the calls for them take.

A communication step costs one set, one step and one get, whatever the number of variables. A derivative of an input is
the variable ``<input>_d1``, ``_d2`` or ``_d3`` if there is one, else it goes through fmi2SetRealInputDerivatives: up to
order 3 into units that have the variables too, the slope alone into others, whose limit FMI 2.0 does not tell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import Array, addressof, c_double, c_int, c_uint, sizeof
from dataclasses import dataclass
from typing import Any, NamedTuple

from towage.fmus.declare.unit import INPUT_ORDERS
from towage.units.conventions import rate_of, takes_derivatives
from towage.units.description import Description, Value, Variable
from towage.units.kinds import DOUBLES, TEXTS, Group, Others, groups, references_of


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
    from ``derivatives`` on. ``feedthrough``: it acts on a source without delay; ``late``: it does so on other outputs that
    are read, alone."""

    name: str
    slot: int
    derivatives: int
    orders: int
    feedthrough: bool
    late: bool = False


Arguments = tuple[int, ...]
"""What a call takes after the component; empty if there is nothing to call for."""


class Wiring:
    """The buffers of one unit.

    ``inputs`` tells the places in ``input_buffer``: values of inputs first, then derivatives that are variables, then
    those that the function takes, then numbers that are no doubles. ``outputs`` names the values that are read: those of
    ``output_buffer``, which are those wanted and rates of sources that the unit computes by function, as
    ``<source>_rate``; then numbers that are no doubles. ``others`` are the calls for these and for texts. An array is set and
    read whole: all its elements are there if one is wanted. ``slopes`` are the places of the derivatives that the function takes.
    """

    def __init__(self, description: Description, wanted: Wanted) -> None:
        self.variables = description.by_name()
        self._description = description
        self._lengths = description.fmi_version.startswith("3")
        self._alive: list[Any] = []
        typed_in, texts_in = self._wire_inputs(description, wanted)
        typed_out, texts_out = self._wire_outputs(description, wanted)
        self.others = Others(typed_in, typed_out, texts_in, texts_out)

    def _split(self, names: Sequence[str]) -> tuple[list[str], list[Variable], list[Variable]]:
        """(doubles, other numbers, texts), each with all elements of the arrays that it touches."""
        whole = dict.fromkeys(n for name in names for n in self._description.siblings(name))
        known = [self.variables[n] for n in whole]
        doubles = [v.name for v in known if v.kind in DOUBLES]
        return doubles, [v for v in known if v.kind not in (*DOUBLES, *TEXTS)], [v for v in known if v.kind in TEXTS]

    def _wire_inputs(self, description: Description, wanted: Wanted) -> tuple[list[Group], list[Group]]:
        doubles, typed, texts = self._split(wanted.connected)
        by_function, by_variable = self._derivatives(description, wanted, doubles)
        orders = {i: 3 if takes_derivatives(description, i) else 1 for i in by_function} | dict.fromkeys(by_variable, 3)
        names = [*doubles, *(f"{i}_d{k}" for i in by_variable for k in INPUT_ORDERS)]
        passed = [(i, k) for i in by_function for k in range(1, orders[i] + 1)]
        first = {i: len(doubles) + 3 * n for n, i in enumerate(by_variable)}
        first |= {i: len(names) + passed.index((i, 1)) for i in by_function}
        typed_at = range(len(names) + len(passed), len(names) + len(passed) + len(typed))
        places = {n: k for k, n in enumerate(doubles)} | {v.name: k for v, k in zip(typed, typed_at)}
        rest = [n for n in wanted.outputs if n not in wanted.sources]
        self.inputs = {}
        for i in (n for n in wanted.connected if n in places):
            through = _feeds(description, i, wanted.sources)
            late = not through and _feeds(description, i, rest)
            self.inputs[i] = Input(i, places[i], first.get(i, 0), orders.get(i, 0), through, late)
        self.input_buffer = (c_double * (len(names) + len(passed) + len(typed)))()
        self._places = places
        self.fill({})
        self.set_values = self.arguments(names, self.input_buffer, 0)
        self.slopes = slice(len(names), len(names) + len(passed))
        self.set_derivatives = self.arguments(
            [i for i, _ in passed], self.input_buffer, len(names), [k for _, k in passed]
        )
        return groups(typed, list(typed_at)), groups(texts, [0] * len(texts))

    def fill(self, given: Mapping[str, Value]) -> None:
        """Put what the inputs begin with into the buffer: ``given``, else their start values."""
        for name, k in self._places.items():
            value = given.get(name, self.variables[name].start)
            self.input_buffer[k] = 0.0 if value is None else float(value)

    def _derivatives(
        self, description: Description, wanted: Wanted, doubles: Sequence[str]
    ) -> tuple[list[str], list[str]]:
        """Inputs whose derivatives go through the function, and those whose derivatives are variables."""
        if not wanted.cubic:
            return [], []
        smooth = [i for i in doubles if i in wanted.connected and self.variables[i].variability == "continuous"]
        declared = [i for i in smooth if takes_derivatives(description, i)]
        if not description.can_interpolate_inputs:
            return [], declared
        by_function = [i for i in smooth if wanted.by_function or i not in declared]
        return by_function, [i for i in declared if i not in by_function]

    def _wire_outputs(self, description: Description, wanted: Wanted) -> tuple[list[Group], list[Group]]:
        doubles, typed, texts = self._split(wanted.outputs)
        computes = wanted.cubic and description.max_output_derivative_order
        smooth = (n for n in wanted.sources if n in doubles and self.variables[n].variability == "continuous")
        known = {n: rate_of(description, n) for n in doubles}
        rated = [n for n in smooth if not ((rate := known[n]) and rate[0] in doubles)] if computes else []
        self.by_function = len(doubles), len(doubles) + len(rated)
        self.outputs = [*doubles, *(f"{n}_rate" for n in rated), *(v.name for v in typed)]
        self.output_buffer = (c_double * (len(doubles) + len(rated)))()
        self.get_values = self.arguments(doubles, self.output_buffer, 0)
        self.get_derivatives = self.arguments(rated, self.output_buffer, len(doubles), [1] * len(rated))
        self.typed = len(typed)
        return groups(typed, list(range(len(typed)))), groups(texts, [0] * len(texts))

    def arguments(
        self, names: Sequence[str], buffer: Array[c_double], first: int, orders: Sequence[int] | None = None
    ) -> Arguments:
        """What a call for these variables takes: addresses of the references, their number, the addresses of the orders
        of derivatives if there are any, and of the values, in ``buffer`` from ``first`` on; FMI 3 wants their number too."""
        known = [self.variables[n] for n in names]
        numbers = [v.value_reference for v in known] if orders else references_of(known)
        references = (c_uint * len(numbers))(*numbers)
        kinds = (c_int * len(names))(*(orders or ()))
        self._alive += [references, kinds]
        middle = () if orders is None else (addressof(kinds),)
        values = addressof(buffer) + first * sizeof(c_double)
        length = (len(names),) if self._lengths else ()
        return (addressof(references), len(numbers), *middle, values, *length) if names else ()


def _feeds(description: Description, name: str, sources: Sequence[str]) -> bool:
    """Whether an input acts on a source without delay, which it does unless the unit declares otherwise."""
    return any(d is None or name in d for output, d in description.dependencies.items() if output in sources)
