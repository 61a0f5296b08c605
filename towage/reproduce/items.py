"""What a report prints, beside what is computed.

``<report>.toml`` beside this file lists every table and figure of a report in its order, with the numbers that it prints (in
the figure, in its legend or in the text about it); the module of that name has a function for each of them that can be
computed. A number agrees where it differs by at most half a unit of the last printed digit, or one unit where the report cuts
its digits off. One that does not has a row of the discrepancy register: who is wrong, and why. An item is

    reproduced   every number agrees
    in part      some do
    refuted      none does: each has a row of the register
    computed     the report prints no number of it that can be read: what is computed stands alone
    impossible   it cannot be computed; ``missing`` says what for
    explains     a sketch, a definition or a listing, with no result in it
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from towage.errors import TowageError

REPORTS = {
    "cradle": "An analysis of the motion of a docking platform for a deep submersible (MIT thesis, 1969)",
    "cable": "Small perturbations of a tow cable: OMWAY and OMFLO (US Navy report)",
    "slender": "Hydroelastic stability of a towed slender body with tapered ends (McGill thesis)",
    "routing": "Minimal-time ship routing (Naval Postgraduate School, 1964)",
}
"""Title by name; the order of the gallery."""
Word = Literal["reproduced", "in part", "refuted", "computed", "impossible", "explains"]
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?")
Column = Sequence[float | str] | NDArray[np.float64]
METHODS = 1e-8
"""Two independent methods agree to this, relative to the largest value of the curve."""


@dataclass(frozen=True)
class Printed:
    """A number of a report: its text as printed; ``digits`` cut off instead of rounded; the row of the register that says why
    it differs, if it does; ``unit`` in which it is compared, "" where it has none; ``within``: a difference that is none, where
    the report does not print its inputs and they are known to so much only."""

    what: str
    text: str
    unit: str = ""
    cut: bool = False
    register: str = ""
    within: float = 0.0

    @property
    def value(self) -> complex:
        """The number; one that ends in i is imaginary, two are a complex one."""
        *real, last = map(float, self._parts)
        return complex(sum(real), last) if self.text.endswith("i") else complex(last)

    @property
    def allowed(self) -> float:
        """The difference that its digits allow, of the real or the imaginary part."""
        units = []
        for digits, _, exponent in (part.partition("e") for part in self._parts):
            units.append(10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])))
        return max(max(units) * (1.0 if self.cut else 0.5) * (1.0 + 1e-9), self.within)

    @property
    def _parts(self) -> list[str]:
        return NUMBER.findall(self.text.replace("i", "").replace(",", ""))


@dataclass(frozen=True)
class Answer:
    """What a function computed for an item. ``numbers`` by the names of the printed ones; ``columns``: the curves or the whole
    table, for the CSV file, all of one length; ``draw``: writes the picture, None for a table; ``methods``: largest difference of
    two independent methods relative to the largest value, and ``by`` which these are; ``note``: what has to be known."""

    numbers: Mapping[str, complex]
    columns: Mapping[str, Column] = field(default_factory=dict)
    draw: Callable[[Path], None] | None = None
    methods: float | None = None
    by: str = ""
    note: str = ""


@dataclass(frozen=True)
class Item:
    """A table or a figure of a report, in the report's order: ``place`` where it stands, ``missing`` why it is not computed."""

    report: str
    name: str
    place: str
    title: str
    printed: tuple[Printed, ...]
    missing: str = ""
    explains: bool = False

    @property
    def full_name(self) -> str:
        """As the command takes it."""
        return f"{self.report}.{self.name}"


@dataclass(frozen=True)
class Row:
    """One number beside the computed one."""

    printed: Printed
    computed: complex

    @property
    def difference(self) -> float:
        """Of the real or the imaginary part, the larger."""
        d = self.computed - self.printed.value
        return max(abs(d.real), abs(d.imag))

    @property
    def agrees(self) -> bool:
        """Whether the printed digits are right."""
        return self.difference <= self.printed.allowed


@dataclass(frozen=True)
class Reproduction:
    """An item and what was computed for it, None where nothing can be."""

    item: Item
    answer: Answer | None

    @property
    def rows(self) -> list[Row]:
        """Every printed number beside the computed one. Raises ``KeyError`` where one is not computed."""
        return [Row(printed, self.answer.numbers[printed.what]) for printed in self.item.printed] if self.answer else []

    @property
    def word(self) -> Word:
        """See the head of this module."""
        if self.item.explains:
            return "explains"
        if not self.answer:
            return "impossible"
        agree = [row.agrees for row in self.rows]
        if not agree:
            return "computed"
        return "reproduced" if all(agree) else "in part" if any(agree) else "refuted"

    @property
    def faults(self) -> list[str]:
        """What is wrong with the gallery itself: a difference without a row of the register, a row for a number that agrees,
        methods that do not agree."""
        open_rows = [row for row in self.rows if not row.agrees and not row.printed.register]
        said = [
            f"{row.printed.what}: printed {row.printed.text}, computed {written(row.computed)}, no row of the register says why"
            for row in open_rows
        ]
        idle = [row.printed.what for row in self.rows if row.agrees and row.printed.register]
        said += [f"{what} agrees, but has a row of the register" for what in idle]
        if self.answer and self.answer.methods is not None and not self.answer.methods <= METHODS:
            said.append(f"{self.answer.by} differ by {self.answer.methods:.1e}, more than {METHODS:g}")
        return said


@lru_cache
def items(report: str) -> tuple[Item, ...]:
    """The items of a report, in its order."""
    text = (resources.files("towage.reproduce") / f"{report}.toml").read_text("utf-8")
    return tuple(_item(report, entry) for entry in tomllib.loads(text)["item"])


def _item(report: str, entry: dict[str, Any]) -> Item:
    numbers = {what: given if isinstance(given, dict) else {"text": given} for what, given in entry.pop("printed", {}).items()}
    return Item(report=report, printed=tuple(Printed(what, **given) for what, given in numbers.items()), **entry)


def named(names: Sequence[str]) -> list[Item]:
    """The items of these names, ``report`` or ``report.item``; all if there is none. Raises `TowageError` for an unknown one."""
    every = [item for report in REPORTS for item in items(report)]
    found = []
    for name in names:
        chosen = [item for item in every if name in (item.report, item.full_name)]
        if not chosen:
            report = name.partition(".")[0]
            there = ", ".join(i.name for i in items(report)) if report in REPORTS else ""
            known = f"{report} has {there}" if there else f"expected {', '.join(REPORTS)}"
            raise TowageError(f"{name!r}: there is no such report, table or figure; {known}")
        found += chosen
    return found if names else every


def written(value: complex, digits: int = 7) -> str:
    """A computed number, as the printed ones are written."""
    imaginary = f"{value.imag:+.{digits}g}i" if value.imag else ""
    return f"{value.real:.{digits}g}{imaginary}" if value.real or not imaginary else imaginary.removeprefix("+")


def reproduce(item: Item) -> Reproduction:
    """Compute an item. Raises what its computation raises."""
    if item.missing or item.explains:
        return Reproduction(item, None)
    function: Callable[[], Answer] = getattr(import_module(f"towage.reproduce.{item.report}"), item.name)
    return Reproduction(item, function())
