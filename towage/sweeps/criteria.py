"""Criteria: what a recorded variable has to stay under, or over.

    line.tension < 450 kN       line.margin_taut > 0       cradle.velocity < 0.5 m/s

A number without a unit is in the variable's own. ``line.tension=450 kN``, the older form of ``towage sweep --limit``, is read
as ``<``. A criterion looks at the largest or the smallest value of a run: both directions of a motion need two of them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from towage.errors import SceneError, suggest
from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.report.format import quantity

_FORM = re.compile(r"^\s*([^<>=\s]+)\s*(<=|>=|[<>=])\s*(.+?)\s*$")


@dataclass(frozen=True)
class Criterion:
    """A recorded variable ``name`` that stays under (``upper``) or over the ``limit``, in its ``unit``."""

    name: str
    upper: bool
    limit: float
    unit: str

    @property
    def side(self) -> str:
        """In words: under or over."""
        return "under" if self.upper else "over"

    @property
    def text(self) -> str:
        """As a user would write it, with a unit that reads well."""
        shown = quantity(self.limit, "" if self.unit == "1" else self.unit, 4).replace("−", "-")
        return f"{self.name} {'<' if self.upper else '>'} {shown}"

    def measure(self, names: Mapping[str, object] | Sequence[str]) -> str:
        """The column of a table of runs that decides: the largest or the smallest value; a margin has the smallest alone."""
        smallest = f"margin:{self.name}"
        return f"max:{self.name}" if self.upper else smallest if smallest in names else f"min:{self.name}"

    def holds(self, value: float) -> bool:
        """Whether the run's extreme is within the limit."""
        return value <= self.limit if self.upper else value >= self.limit


def criterion(text: str, recorded: Mapping[str, str], key: str) -> Criterion:
    """The criterion in ``text``. ``recorded``: variables and their units of measure. Raises `SceneError`, of ``key``."""
    found = _FORM.match(text)
    if not found:
        raise SceneError(
            f"{text!r}: expected UNIT.VARIABLE < VALUE or UNIT.VARIABLE > VALUE, as in 'line.tension < 450 kN'", key=key
        )
    name, sign, value = found.groups()
    if name not in recorded:
        raise SceneError(f"{text!r}: expected UNIT.VARIABLE of a recorded variable{suggest(name, recorded)}", key=key)
    upper, unit = sign[0] != ">", recorded[name]
    if upper and name.partition(".")[2].startswith("margin_"):
        raise SceneError(f"{text!r}: a margin is 1 at rest and falls: expected {name} > VALUE", key=key)
    try:
        number = float(value)
    except ValueError:
        try:
            number = parse_quantity(value, unit or "1")
        except QuantityError as error:
            raise SceneError(f"{text!r}: {error}", key=key) from None
    if not abs(number) < float("inf"):
        raise SceneError(f"{text!r}: expected a finite number", key=key)
    return Criterion(name, upper, number, unit)
