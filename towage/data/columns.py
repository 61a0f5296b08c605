"""Tables of numbers with named columns: CSV, npz, netCDF. Sizes are looked at first (`towage.reading`).

A CSV file has a line of names, each with its unit in brackets behind it ("heave_phase [deg]", "Period (s)"), and lines of
numbers, parted by commas, semicolons, tabs or blanks. Empty lines and what follows a # are left out. An npz file has an array a
column, a netCDF file a variable of one dimension, with its unit in ``units``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.reading import Refused

Array = NDArray[np.float64]
MAX_CELLS = 4_000_000
"""Numbers of a table."""
MAX_COLUMNS = 2000
_NAME = re.compile(r"^(.*?)\s*(?:[\[(]([^\])]*)[\])])?$")


class Column(NamedTuple):
    """A column: its name as written, its unit ("" where none is written), and its values."""

    name: str
    unit: str
    values: Array


class Table(NamedTuple):
    """Columns, and where a row stands in the file ("line 12", "row 3")."""

    columns: tuple[Column, ...]
    places: tuple[str, ...]

    def place(self, row: int) -> str:
        """Where a row stands."""
        return self.places[row] if self.places else f"row {row + 1}"


def named(text: str) -> tuple[str, str]:
    """Name and unit of a column's head."""
    found = _NAME.match(text.strip().strip('"'))
    assert found
    return found[1].strip(), (found[2] or "").strip()


def read(path: Path) -> Table:
    """The table in a file. Raises `Refused` that says where in it, and OSError."""
    kind = path.suffix.lower()
    if kind == ".npz":
        return _arrays({name: np.asarray(array) for name, array in reading.npz(path).items()}, {})
    if kind in (".nc", ".nc4", ".cdf"):
        return _netcdf(path)
    return csv(reading.content(path, reading.MAX_FILE).decode("utf-8", errors="replace"))


def csv(text: str) -> Table:
    """The table in a CSV text."""
    rows: list[list[float]] = []
    places: list[str] = []
    head: list[str] | None = None
    cells = 0
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        if head is None:
            head = split(line)
            reading.limited(len(head), MAX_COLUMNS, "columns")
            if all(map(_is_number, head)):
                raise Refused(f"line {number}: expected the names of the columns, with units in brackets, got numbers")
            continue
        row = split(line)
        if len(row) != len(head):
            raise Refused(f"line {number}: {len(row)} values for {len(head)} columns")
        cells += len(row)
        reading.limited(cells, MAX_CELLS, "numbers")
        rows.append([_number(value, f"line {number}, column {name!r}") for value, name in zip(row, head)])
        places.append(f"line {number}")
    if head is None or not rows:
        raise Refused("no rows of numbers below a line of names")
    values = np.array(rows)
    return Table(tuple(Column(*named(name), values[:, k]) for k, name in enumerate(head)), tuple(places))


def split(line: str) -> list[str]:
    """The cells of a line."""
    mark = next((mark for mark in (";", "\t", ",") if mark in line), None)
    return [cell.strip() for cell in line.split(mark)]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _number(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise Refused(f"{where}: expected a number, got {text[:40]!r}") from None
    if not math.isfinite(value):
        raise Refused(f"{where}: {value} is no value")
    return value


def _netcdf(path: Path) -> Table:
    from netCDF4 import Dataset

    with reading.foreign(path, "netCDF file"), Dataset(path) as data:
        arrays: dict[str, Array] = {}
        units: dict[str, str] = {}
        for name, variable in data.variables.items():
            if variable.ndim != 1 or variable.dtype.kind not in "fiu":
                continue
            reading.limited(variable.size, MAX_CELLS, f"values of {name}")
            arrays[name] = np.ma.filled(np.ma.asarray(variable[:], float), np.nan)
            units[name] = str(getattr(variable, "units", ""))
    return _arrays(arrays, units)


def _arrays(arrays: Mapping[str, NDArray[np.generic]], units: Mapping[str, str]) -> Table:
    reading.limited(len(arrays), MAX_COLUMNS, "columns")
    reading.limited(sum(array.size for array in arrays.values()), MAX_CELLS, "numbers")
    columns = []
    for head, array in arrays.items():
        name, unit = named(head)
        if array.dtype.kind not in "fiu" or array.ndim != 1:
            raise Refused(f"{head!r}: expected one dimension of numbers, got {array.ndim} of {array.dtype}")
        values = array.astype(float)
        if bad := np.flatnonzero(~np.isfinite(values)).tolist():
            raise Refused(f"{head!r}, row {bad[0] + 1}: {values[bad[0]]} is no value")
        columns.append(Column(name, units.get(head, unit), values))
    sizes = {c.name: len(c.values) for c in columns}
    if len(set(sizes.values())) != 1:
        raise Refused(f"expected columns of one length, got {sizes}")
    return Table(tuple(columns), ())


def options(given: Mapping[str, object], known: Sequence[str]) -> None:
    """Raises `Refused` for an option that is none."""
    for name in given:
        if name not in known:
            raise Refused(f"unknown option {name!r}: there are file, {', '.join(known)}")
