"""The tables that the benchmarks print, read back: their ratios, and the curves of error against cost in them.

A benchmark prints Markdown and needs no other interface. What its columns mean is said once, in ``page.py``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

Better = Literal["more", "less"]
Series = dict[str, list[tuple[float, float]]]


@dataclass(frozen=True)
class Table:
    """A Markdown table below its ``heading``; the names of ``head`` and the ``labels`` of ``rows`` are unique."""

    heading: str
    head: tuple[str, ...]
    labels: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


class Column(NamedTuple):
    """Ratios in the columns whose name matches ``pattern``, and which way is better. With ``over`` the columns hold costs,
    and a ratio is the cost in the first row whose label begins so over that of the row: more is better."""

    pattern: str
    better: Better
    over: str = ""


class Ratio(NamedTuple):
    """A ratio of one run."""

    value: float
    better: Better

    def gain(self, before: float) -> float:
        """How many times better than ``before``; below 1: worse."""
        return self.value / before if self.better == "more" else before / self.value


THEIRS = re.compile("MoorDyn|libcosim|weatherrouting|Radau|BDF|RK45")
"""Rows of peers: no ratio is kept for them, since it is not for us to mend."""


class Curves(NamedTuple):
    """Costs in the columns that match ``cost``, errors in those that match ``error``; a cell may hold several numbers."""

    cost: str
    error: str


def tables(markdown: str) -> list[Table]:
    """All tables of a page."""
    parsed: list[Table] = []
    heading, block = "", []
    for line in [*markdown.splitlines(), ""]:
        if line.startswith("|"):
            block.append([cell.strip() for cell in line.strip().strip("|").split("|")])
            continue
        if len(block) > 2:
            rows = tuple(tuple(row) for row in block[2:])
            parsed.append(Table(heading, tuple(_unique(block[0])), tuple(_unique(_labels(rows))), rows))
        block = []
        if line.startswith("#"):
            heading = line.lstrip("# ").strip()
    return parsed


def ratios(parsed: list[Table], columns: tuple[Column, ...]) -> dict[str, Ratio]:
    """Ratios by ``heading / row / column``. A number printed with one digit is left out, its rounding being as large as
    what is looked for, and so are the row of 1 that the others are over and the rows of peers."""
    kept: dict[str, Ratio] = {}
    for table in parsed:
        for column in columns:
            for index in _matching(table, column.pattern):
                values = {n: v for n, row in zip(table.labels, table.rows) if (v := _measured(row[index])) is not None}
                reference = next((name for name in values if column.over and name.startswith(column.over)), None)
                if column.over and reference is None:
                    continue
                for label, value in values.items():
                    ratio = values[reference] / value if reference else value
                    if ratio != 1.0 and not THEIRS.match(label):
                        key = " / ".join(part for part in (table.heading, label, table.head[index]) if part)
                        kept[key] = Ratio(ratio, column.better)
    return kept


def curves(parsed: list[Table], wanted: Curves) -> Iterator[tuple[str, Series]]:
    """(title, error over cost by method) of every diagram that the tables hold. A method is what a row's label says
    before its first comma."""
    for table in parsed:
        costs, errors = _matching(table, wanted.cost), _matching(table, wanted.error)
        if not costs or not errors:
            continue
        panels = list(zip(costs, errors)) if len(costs) == len(errors) else [(costs[0], tuple(errors))]
        for cost, error in panels:
            series: Series = {}
            for label, row in zip(table.labels, table.rows, strict=True):
                columns = error if isinstance(error, tuple) else (error,)
                x, y = _numbers(row[cost]), [abs(v) for column in columns for v in _numbers(row[column])]
                if len(x) == len(y):
                    points = [(a, b) for a, b in zip(x, y) if a > 0.0 and b > 0.0]
                    series.setdefault(label.split(",")[0], []).extend(points)
            title = table.head[error].split(":")[0] if isinstance(error, int) and len(panels) > 1 else table.heading
            if any(series.values()):
                yield title, {name: points for name, points in series.items() if points}


def _matching(table: Table, pattern: str) -> list[int]:
    return [index for index, name in enumerate(table.head) if re.search(pattern, name)]


def _numbers(cell: str) -> list[float]:
    """The numbers of a cell like ``1.2`` or ``2.5 / 1.7``; none where it says a word."""
    numbers = []
    for part in cell.split(" / "):
        try:
            numbers.append(float(part))
        except ValueError:
            return []
    return numbers


def _measured(cell: str) -> float | None:
    """The one number of a cell, if it has two significant digits or is 1."""
    numbers = _numbers(cell)
    digits = re.sub(r"e.*|\D", "", cell.lower()).lstrip("0")
    return numbers[0] if len(numbers) == 1 and numbers[0] > 0.0 and (len(digits) > 1 or numbers[0] == 1.0) else None


def _labels(rows: tuple[tuple[str, ...], ...]) -> list[str]:
    """First cells, with the second where the first is shared."""
    counted = Counter(row[0] for row in rows)
    return [row[0] if counted[row[0]] == 1 else ", ".join(row[:2]) for row in rows]


def _unique(names: list[str]) -> list[str]:
    """Repeated names numbered from the second on."""
    seen: Counter[str] = Counter()
    unique = []
    for name in names:
        seen[name] += 1
        unique.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return unique
