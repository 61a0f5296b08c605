"""Reads the tables of a route file: numbers with units, pairs, lists, words. Every fault is a `SceneError` that names file and
key."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.scene.tables import Tables

_DATA = ("file", "variables", "units", "select", "direction_is")
KEYS = {
    "": ("title", "description", "route", "map", "ship", "sea", "wind", "current", "forbidden", "limits"),
    "route": ("start", "end", "method", "fraction", "departure"),
    "map": ("kind", "radius"),
    "ship": ("polar", "speed", "table", "wind_table", "wave_factors"),
    "ship.table": ("heights", "angles", "speeds", "ends"),
    "ship.wind_table": ("winds", "angles", "speeds", "ends"),
    "ship.wave_factors": ("heights", "angles", "factors", "ends"),
    "sea": ("kind", "height", "wave_angle", "background", "peak", "centre", "sigma", "velocity", "swirl", "storms", *_DATA),
    "sea.storms": ("peak", "centre", "sigma", "velocity", "swirl"),
    "wind": ("kind", "speed", "wind_angle", *_DATA),
    "current": ("kind", "velocity", "gradient", *_DATA),
    "forbidden": ("name", "centre", "radius", "corners"),
    "limits": ("name", "limit", "table", "value", "heights", "direction", "responses", "hull", "motion", "point", "statistic",
               "hours", "speed", "peakedness"),
    "limits.hull": ("length", "breadth", "draught", "block_coefficient"),
}
"""What may stand in which table."""


class RouteTables(Tables):
    """Tables of one route file."""

    def part(self, data: dict[str, Any], key: str, needed: bool = True) -> dict[str, Any]:
        """The table ``key``, with no unknown keys; empty if it is missing and not ``needed``."""
        name = key.rpartition(".")[2]
        if needed and name not in data:
            self.fail("this table is missing", key)
        return self.known(data.get(name, {}), key)

    def known(self, value: object, key: str, like: str = "") -> dict[str, Any]:
        """The table itself, if it has no unknown keys; those known are of ``like``."""
        table = self.table(value, key)
        for name in table:
            if name not in KEYS[like or key]:
                self.unknown(name, KEYS[like or key], key)
        return table

    def number(self, table: dict[str, Any], key: str, unit: str, default: float | None = None) -> float:
        """A number, in ``unit`` if it is a text with a unit."""
        name = key.rpartition(".")[2]
        if name not in table:
            if default is None:
                self.fail("this value is missing", key)
            return default
        return self.value(table[name], key, unit)

    def positive(self, table: dict[str, Any], key: str, unit: str, default: float | None = None) -> float:
        """A number above 0."""
        value = self.number(table, key, unit, default)
        if value <= 0.0:
            self.fail(f"{value} {unit}: expected more than 0", key)
        return value

    def value(self, value: object, key: str, unit: str) -> float:
        """A number or a text with a unit, finite."""
        if isinstance(value, str):
            try:
                return parse_quantity(value, unit)
            except QuantityError as error:
                self.fail(str(error), key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self.fail(f"expected a finite number or a text with a unit, got {value!r}", key)
        return float(value)

    def pair(self, table: dict[str, Any], key: str, unit: str) -> tuple[float, float]:
        """Two numbers."""
        value = table.get(key.rpartition(".")[2])
        if not isinstance(value, list) or len(value) != 2:
            self.fail(f"expected two numbers, got {value!r}", key)
        return self.value(value[0], key, unit), self.value(value[1], key, unit)

    def numbers(self, table: dict[str, Any], key: str, unit: str) -> list[float]:
        """A list of numbers."""
        values = table.get(key.rpartition(".")[2])
        if not isinstance(values, list):
            self.fail("expected a list", key)
        return [self.value(value, key, unit) for value in values]

    def rows(self, table: dict[str, Any], key: str, unit: str) -> list[list[float]]:
        """A list of lists of numbers."""
        rows = table.get(key.rpartition(".")[2])
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            self.fail("expected a list of lists, one a row", key)
        return [[self.value(value, key, unit) for value in row] for row in rows]

    def choice(self, table: dict[str, Any], key: str, allowed: Iterable[str], default: str | None = None) -> str:
        """One of a few words."""
        value = table.get(key.rpartition(".")[2], default)
        if value not in (names := list(allowed)):
            self.fail(f"expected one of: {', '.join(names)}; got {value!r}", key)
        return str(value)
