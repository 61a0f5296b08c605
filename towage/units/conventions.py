"""What the names of a unit's variables say of them, where the unit declares it.

| name | meaning | without the declaration it holds if |
|---|---|---|
| ``<output>_rate`` | time derivative of an output | its unit of measure is the output's over a time |
| ``<input>_d1``, ``_d2``, ``_d3`` | time derivatives of an input | their units are the input's over s, s2, s3 |
| ``next_event_time`` | a communication point is wanted there | its unit is s |
| ``margin_<assumption>`` | 1 at rest, 0 at the limit of validity | its unit is 1 |
| ``port_stiffness``, ``port_mass`` | what an interface loop oscillates by | its unit is N/m, kg |
| ``event_<name>``, ``freeze_branches`` | zero-crossing function of a branch, and how it is held | never |

The declaration is an annotation of the model description, ``VendorAnnotations/Tool[@name="towage"]/Interface/Conventions``;
every unit that towage builds has it. Never by name alone: ``heading_rate`` in deg/min may be a filtered sensor, ``event_count``
a count.
"""

from __future__ import annotations

from towage.fmus.declare.quantities import BASES, QuantityError, dimension, unit_definition
from towage.fmus.declare.unit import INPUT_ORDERS
from towage.units.description import Description, Variable

Definition = tuple[tuple[int, ...], float, float]
"""Exponents of the base units, factor and offset of a unit of measure."""
CLOCK = "next_event_time"
FREEZE = "freeze_branches"
INDICATORS = "event_indicator"
_UNITS = {CLOCK: "s", "port_stiffness": "N/m", "port_mass": "kg"}


def definition(description: Description, unit: str | None) -> Definition | None:
    """A unit of measure as the FMU defines it, else as towage does, else None."""
    if unit is None:
        return None
    if own := description.units.get(unit):
        return own.exponents, own.factor, own.offset
    return known(unit)


def known(unit: str) -> Definition | None:
    """A unit of measure as towage defines it."""
    try:
        return dimension(unit), unit_definition(unit)[1], 0.0
    except QuantityError:
        return None


def rate_of(description: Description, output: str) -> tuple[str, float] | None:
    """(variable, factor): factor * variable is the time derivative of ``output`` in its unit a second; None if no variable
    is."""
    variables = description.by_name()
    rate, source = variables.get(f"{output}_rate"), variables.get(output)
    if "rates" in description.distrusted or rate is None or source is None or rate.type != "Real" or source.type != "Real":
        return None
    if description.conventions:
        return rate.name, 1.0
    factor = _per_time(description, source, rate, 1)
    return (rate.name, factor) if factor else None


def takes_derivatives(description: Description, name: str) -> bool:
    """Whether the time derivatives of an input are variables."""
    variables = description.by_name()
    found = [variables.get(f"{name}_d{k}") for k in INPUT_ORDERS]
    if not all(found) or "slopes" in description.distrusted:
        return False
    return description.conventions or all(
        v is not None and _per_time(description, variables[name], v, k) == 1.0 for k, v in zip(INPUT_ORDERS, found)
    )


def indicators(description: Description) -> list[str]:
    """The zero-crossing functions of branches, and their rates; not the vector of all of them that our FMI 3 units have for
    model exchange."""
    named = (
        v.name for v in description.variables
        if v.name.startswith("event_") and v.type == "Real" and v.name.partition("[")[0] != INDICATORS
    )  # fmt: skip
    return list(named) if description.conventions else []


def has(description: Description, name: str) -> bool:
    """Whether the unit has the variable ``name`` of the table above, and means it."""
    variable = description.by_name().get(name)
    if variable is None or variable.type != "Real":
        return False
    if description.conventions:
        return True
    unit = "1" if name.startswith("margin_") else _UNITS.get(name)
    return unit is not None and definition(description, variable.unit) == known(unit)


def guessed(description: Description) -> list[str]:
    """What is taken for a convention because its unit of measure fits, in words."""
    if description.conventions:
        return []
    said = [
        f"{rate[0]} [{description.by_name()[rate[0]].unit}] is taken for the time derivative of {v.name}"
        for v in description.variables if v.causality == "output" and (rate := rate_of(description, v.name))
    ]  # fmt: skip
    inputs = (v.name for v in description.variables if v.causality == "input" and takes_derivatives(description, v.name))
    said += [f"{name}_d1, _d2 and _d3 are taken for the time derivatives of {name}" for name in inputs]
    if has(description, CLOCK):
        said.append(f"{CLOCK} is taken for the time of the unit's next event")
    margins = (v.name for v in description.variables if v.name.startswith("margin_") and has(description, v.name))
    return said + [f"{name} is taken for a margin of validity: below 0 the run is invalid" for name in margins]


def _per_time(description: Description, variable: Variable, other: Variable, order: int) -> float:
    """By what ``other`` is multiplied for the unit of ``variable`` over s^order; 0 if it does not measure that."""
    one, two = definition(description, variable.unit), definition(description, other.unit)
    if one is None or two is None:
        return 0.0
    wanted = tuple(e - order * (base == "s") for base, e in zip(BASES, one[0]))
    return two[1] / one[1] if two[0] == wanted else 0.0
