"""Recorded series from files, as `models.route.playback.Series`: CSV, npz or netCDF (`towage.data.columns`).

One column is the time, ``time`` or ``t``, [s] unless its unit says otherwise. Times rise from row to row; rows that do not are
refused, never sorted. Options: ``method`` = "c2" (the default: a spline with continuous second derivatives) or "monotone"
(Fritsch and Carlson: nothing between two rows lies beyond them); ``columns``: those to take, all where it is left out;
``unwrap``: columns of angles whose jumps by a whole turn are none. A unit may stand behind a name, "wave_height_m", as `towage
route --csv` writes it, which is said.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from towage import reading
from towage.data import columns
from towage.data.columns import Column, Table, options
from towage.fmus.declare.quantities import (
    DISPLAY,
    QuantityError,
    base_expression,
    convert,
    dimension,
    same_dimension,
    unit_definition,
)
from towage.reading import Refused

Array = NDArray[np.float64]
MAX_NUMBERS = 1_000_000
"""Times, values and slopes: they are carried in the FMU."""
METHODS = ("c2", "monotone")


def read(path: Path, given: Mapping[str, Any], notes: list[str]) -> dict[str, Any]:
    """The fields of a `Series`. Raises `Refused` with the place in the file, and OSError."""
    options(given, ("method", "columns", "unwrap"))
    method = given.get("method", "c2")
    if method not in METHODS:
        raise Refused(f"method = {method!r}: expected {' or '.join(map(repr, METHODS))}")
    table = _with_units(columns.read(path), notes)
    clock = [c for c in table.columns if c.name.lower() in ("time", "t")]
    if len(clock) != 1:
        raise Refused(f"expected one column time or t, got {', '.join(c.name for c in table.columns)}")
    times = _times(table, clock[0], notes)
    others = [c for c in table.columns if c is not clock[0]]
    played = _unwrapped(_chosen(others, given.get("columns")), given.get("unwrap", ()))
    reading.limited(len(times) * (1 + 2 * len(played)), MAX_NUMBERS, "numbers with their slopes")
    names = tuple(_name(column.name) for column in played)
    if twice := next((name for name in names if names.count(name) > 1), ""):
        raise Refused(f"two columns would be called {twice}")
    units, values = zip(*(_in_si(column, notes) for column in played))
    periodic = all(v[0] == v[-1] for v in values) and len(times) > 2
    slopes = tuple(tuple(_slopes(times, v, method, periodic).tolist()) for v in values)
    return {
        "times": tuple(times.tolist()), "names": names, "units": units, "values": tuple(tuple(v.tolist()) for v in values),
        "slopes": slopes, "periodic": periodic,
    }  # fmt: skip


def _with_units(table: Table, notes: list[str]) -> Table:
    """The table with the units that names end in, as "speed_kn"."""
    found, taken = [], []
    for column in table.columns:
        name, _, unit = column.name.rpartition("_")
        if column.unit or not name or not _is_unit(unit):
            found.append(column)
            continue
        taken.append(f"{column.name} for {name} in {unit}")
        found.append(Column(name, unit, column.values))
    if taken:
        notes.append(f"taken is {', '.join(taken)}")
    return Table(tuple(found), table.places)


def _is_unit(text: str) -> bool:
    try:
        unit_definition(text)
    except QuantityError:
        return False
    return True


def _unwrapped(found: list[Column], names: Any) -> list[Column]:
    """The columns, those of ``names`` without jumps by a turn."""
    if not isinstance(names, (list, tuple)) or set(names) - {c.name for c in found}:
        raise Refused(f"unwrap = {names!r}: expected a list of columns among {', '.join(c.name for c in found)}")
    try:
        return [
            Column(c.name, c.unit, np.unwrap(c.values, period=convert(2.0 * math.pi, "rad", c.unit)))
            if c.name in names
            else c
            for c in found
        ]
    except QuantityError as error:
        raise Refused(f"unwrap: {error}") from None


def _times(table: Table, clock: Column, notes: list[str]) -> Array:
    unit = clock.unit or "s"
    if not clock.unit:
        notes.append(f"{clock.name} has no unit: taken for seconds")
    try:
        times = clock.values * convert(1.0, unit, "s")
    except QuantityError as error:
        raise Refused(f"column {clock.name!r}: {error}") from None
    if len(times) < 2:
        raise Refused(f"{table.place(0)}: one row: expected two at least")
    steps = np.diff(times)
    if late := np.flatnonzero(steps <= 0.0).tolist():
        k = late[0] + 1
        how = "the same as" if steps[k - 1] == 0.0 else "before"
        other = f"{table.place(k - 1)}, {clock.values[k - 1]:g}"
        raise Refused(f"{table.place(k)}: time {clock.values[k]:g} is {how} that of {other}")
    return np.asarray(times)


def _chosen(every: list[Column], wanted: object) -> list[Column]:
    if wanted is None:
        chosen = every
    else:
        if not isinstance(wanted, (list, tuple)):
            raise Refused(f"columns = {wanted!r}: expected a list of names")
        known = {c.name: c for c in every}
        for name in wanted:
            if name not in known:
                raise Refused(f"no column {name!r}: there are {', '.join(known)}")
        chosen = [known[name] for name in wanted]
    if not chosen:
        raise Refused("no column but the time")
    return chosen


def _name(text: str) -> str:
    """The name of an output."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    if not name or name[0].isdigit() or keyword.iskeyword(name):
        raise Refused(f"column {text!r} cannot name an output: expected letters, digits and '_'")
    if name.endswith("_rate") or name.startswith(("margin_", "event_", "next_event")):
        raise Refused(f"column {text!r}: names that end in _rate or begin with margin_ or event_ mean something else")
    return name


def _in_si(column: Column, notes: list[str]) -> tuple[str, Array]:
    """Unit and values, in SI."""
    if not column.unit:
        notes.append(f"{column.name} has no unit: taken for a number without one")
        return "1", column.values
    try:
        unit = next((si for si in DISPLAY if same_dimension(si, column.unit)), "")
        unit = unit or base_expression(dimension(column.unit))
        values = column.values * convert(1.0, column.unit, unit)
    except QuantityError as error:
        raise Refused(f"column {column.name!r}: {error}") from None
    if same_dimension(unit, "rad") and (np.abs(np.diff(values)) > math.pi).any():
        k = int(np.argmax(np.abs(np.diff(values)))) + 1
        notes.append(
            f"{column.name} turns by more than half a circle from row {k} to {k + 1}, and is played so: see unwrap"
        )
    return unit, np.asarray(values)


def _slopes(times: Array, values: Array, method: str, periodic: bool) -> Array:
    """Derivatives at the rows."""
    if len(times) == 2:
        return np.full(2, (values[1] - values[0]) / (times[1] - times[0]))
    if method == "monotone":
        slopes = PchipInterpolator(times, values).derivative()(times)
        if periodic:  # the ends have one slope, by which both sides stay monotone
            ends = (values[1] - values[0]) * (values[-1] - values[-2]) > 0.0
            slopes[0] = slopes[-1] = np.sign(slopes[0]) * min(abs(slopes[0]), abs(slopes[-1])) if ends else 0.0
        return np.asarray(slopes)
    kind = "periodic" if periodic else "not-a-knot"
    return np.asarray(CubicSpline(times, values, bc_type=kind).derivative()(times))
