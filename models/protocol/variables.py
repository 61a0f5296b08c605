"""What a variable of a model means, written once, beside its field:

    mass: Annotated[Value, parameter("kg", 1000.0, "Mass", min=1e-9, display="lb")]

The field gives the name, the function its role, the record everything else; the FMU's interface, its documentation and the
tables of ``docs/`` are made from it. Order matters: the fields of ``Parameters``, ``Calculated``, ``Inputs`` and ``Outputs``
are the variables of the FMU in that order.

* A time derivative of an output is a field ``<output>_rate: Rate``; its unit and text follow from the output.
* A state whose name is also that of an output needs no record: it is that output.

Units are SI, written as ``fmus/declare/quantities.py`` reads them; start values and bounds are in them, ``display`` is the
unit in which a person may want to read the value.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_type_hints

from ..numeric.ops import NEVER, Value

EVERY_INPUT = ("*",)
"""For ``also``: all inputs of the model."""


@dataclass(frozen=True)
class Quantity:
    """A variable without its name. ``causality`` and ``variability`` are FMI's.

    ``also`` names inputs that act on an output without delay although its formula does not contain them: what
    `numeric.dependence` cannot find by tracing the model's functions. ``needed`` and ``unset``: see
    `input_variable` and `tunable`.
    """

    unit: str
    description: str
    start: float | None = None
    causality: str = "parameter"
    variability: str = "fixed"
    display: str | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    also: tuple[str, ...] = ()
    needed: bool = False
    unset: str = ""


def parameter(
    unit: str, start: float, description: str, *,
    display: str | None = None, min: float | None = None, max: float | None = None,
) -> Quantity:  # fmt: skip
    """A parameter that is fixed once a run has begun."""
    return Quantity(unit, description, start, "parameter", "fixed", display, min, max)


def tunable(
    unit: str, start: float, description: str, *,
    display: str | None = None, min: float | None = None, max: float | None = None, needed: bool = False,
) -> Quantity:  # fmt: skip
    """A parameter that may change between steps. ``needed``: a scene has to set it; ``start`` is an example, with which the
    unit begins in a host that sets nothing."""
    return Quantity(unit, description, start, "parameter", "tunable", display, min, max, needed=needed)


def calculated_parameter(unit: str, description: str, *, display: str | None = None, tunable: bool = False) -> Quantity:
    """A value that follows from the parameters alone; ``tunable`` where it follows from a tunable one."""
    variability = "tunable" if tunable else "fixed"
    return Quantity(unit, description, None, "calculatedParameter", variability, display)


def input_variable(
    unit: str, description: str, *,
    start: float = 0.0, display: str | None = None, min: float | None = None, needed: bool = False, unset: str = "",
) -> Quantity:  # fmt: skip
    """A continuous input; it has the value ``start`` where nothing is connected and nothing is set.

    ``needed``: the model means nothing without it, so that a scene has to connect or set it. ``unset``: what ``start``
    means, in words, where that is a case of its own; an input with neither may have been forgotten."""
    return Quantity(unit, description, start, "input", "continuous", display, min, needed=needed, unset=unset)


def output(
    unit: str, description: str, *,
    display: str | None = None, nominal: float | None = None, also: tuple[str, ...] = (),
) -> Quantity:  # fmt: skip
    """A continuous output."""
    return Quantity(unit, description, None, "output", "continuous", display, nominal=nominal, also=also)


def margin(formula: str, *, also: tuple[str, ...] = ()) -> Quantity:
    """The output ``margin_<assumption>``: 1 at rest, 0 at the limit of validity, negative beyond, always finite."""
    return output("1", f"1 at rest, 0 at the limit, negative beyond: {formula}", also=also)


def error_margin(what: str, percent: float, remedy: str, *, also: tuple[str, ...] = ()) -> Quantity:
    """A margin 1 - error / limit, the limit in ``percent``: ``what`` errs, and the ``remedy``. The verdict shows the error."""
    return margin(f"1 - error / {percent:g} %, {what}; remedy: {remedy}", also=also)


def local(unit: str, description: str, *, display: str | None = None, discrete: bool = False) -> Quantity:
    """A local variable: for the master and for people who look for a fault; ``discrete`` where it changes at events only."""
    return Quantity(unit, description, None, "local", "discrete" if discrete else "continuous", display)


state = local
"""A continuous state that no output of its name shows."""
NEXT_EVENT = local("s", f"Next time at which a communication point is wanted, {NEVER:g} if none", discrete=True)
"""What a field ``next_event_time`` of ``Outputs`` is."""
RATE = local("1", "Time derivative")
"""Stands for the time derivative of the output of the same name without ``_rate``: see `quantities`."""
Rate = Annotated[Value, RATE]
FREEZE_BRANCHES = parameter(
    "1", 0.0,
    "1: a branch (taut or slack) holds over a communication step, and the master puts communication points on the "
    "zeros of event_*; 0: the unit looks after its branches itself", min=0.0, max=1.0,
)  # fmt: skip
"""What a field ``freeze_branches`` of ``Parameters`` is."""
FreezeBranches = Annotated[Value, FREEZE_BRANCHES]
NextEvent = Annotated[Value, NEXT_EVENT]


def per_second(unit: str, order: int = 1) -> str:
    """The unit of a time derivative: m -> m/s -> m/s2."""
    base, _, power = unit.partition("/s")
    order += int(power or 1) if "/s" in unit else 0
    return f"{base}/s" + (str(order) if order > 1 else "")


def rate_of(name: str, unit: str) -> Quantity:
    """The time derivative of the output ``name``."""
    return local(per_second(unit), f"Time derivative of {name}")


@cache
def quantities(kind: Any) -> dict[str, Quantity]:
    """The variables of a ``Parameters``, ``Inputs``, ``Outputs``, ... by name, in the order of its fields; fields without
    a record are left out. Raises ``TypeError`` for a rate of an output that is not there."""
    hints = get_type_hints(kind, include_extras=True)
    order = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else kind._fields
    records = {n: next((r for r in getattr(hints[n], "__metadata__", ()) if isinstance(r, Quantity)), None) for n in order}
    for name, record in records.items():
        if record is RATE:
            of = records.get(name.removesuffix("_rate"))
            if of is None:
                raise TypeError(f"{kind.__qualname__}.{name} is a rate, but there is no output {name.removesuffix('_rate')}")
            records[name] = rate_of(name.removesuffix("_rate"), of.unit)
    return {name: record for name, record in records.items() if record is not None}
