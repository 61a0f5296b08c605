"""What one run leaves behind: time series, events, checks, the verdict, and the files they are kept in.

A result holds SI values on one time grid. npz is the working store (bit-exact), CSV and MAT 5 are for other programs.
"""

from __future__ import annotations

import codecs
import csv
import json
import math
import os
import re
import zipfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from towage.errors import TowageError
from towage.process.files import atomic_write

Array = NDArray[Any]

_FORMAT = 1
_MATLAB_NAME = 63
"""Longest name of a MATLAB variable."""


@dataclass(frozen=True)
class Event:
    """A change of branch at ``time``, s: ``name`` as in ``event_<name>``; ``direction`` is the sign after the zero
    crossing (+1 rising, -1 falling), 0 for an event in time."""

    time: float
    unit: str
    name: str
    direction: int


@dataclass(frozen=True)
class Check:
    """One finding before or after a run; ``value`` and ``limit`` where there are any, in the unit ``message`` names."""

    name: str
    level: Literal["ok", "warning", "refused", "info"]
    value: float | None
    limit: float | None
    message: str


@dataclass(frozen=True)
class Margin:
    """Smallest value of a margin and when, s; 1 at rest, 0 at the limit of validity. ``decides``: it can make a run
    invalid, otherwise it is shown only."""

    variable: str
    worst: float
    time: float
    decides: bool


@dataclass(frozen=True)
class Comparison:
    """The coupled run against the one-way run, which is the assumption of a single degree of freedom.

    ``amplitude``, ``peak_tension``: relative change. ``phase``: change, rad. ``rms`` of the difference over rms of the
    one-way motion. ``indicator`` eps = |D2/D1|, ``bound`` eps/(1 - eps) and the closed form ``estimate`` eps* need no
    coupled run. ``eigenvector`` and ``frequency_shift`` are the thesis's own indicators, which pass wrongly.
    """

    tolerance: float
    amplitude: float
    phase: float
    peak_tension: float
    rms: float
    indicator: float | None
    bound: float | None
    estimate: float | None
    eigenvector: float | None
    frequency_shift: float | None
    word: str


@dataclass(frozen=True)
class Verdict:
    """The judgement on a run, with the number that decided and its limit."""

    word: Literal["valid", "marginal", "invalid", "not judged"]
    reason: str
    number: float | None
    limit: float | None


@dataclass
class Result:
    """One case of one scene. Arrays have shape (n,) on ``time`` (s); ``units`` names the unit of measure of a column.

    ``one_way``: the same variables with the back reaction left out, on the same grid. ``coupling_error``: variable to
    estimated relative error. ``power_residual``: bond to relative energy residual. ``step_sizes``: accepted
    communication steps, s. ``flavours``: unit to ``python``, ``native`` or the tool that made its FMU.
    ``response``: curve ``ratio``, ``amplitude``, point ``operating`` and ``label``.
    """

    title: str
    case: str
    scheme: str
    status: Literal["done", "failed"]
    message: str
    time: Array
    columns: dict[str, Array]
    units: dict[str, str]
    one_way: dict[str, Array] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    margins: list[Margin] = field(default_factory=list)
    comparison: Comparison | None = None
    verdict: Verdict = Verdict("not judged", "", None, None)
    coupling_error: dict[str, float] = field(default_factory=dict)
    power_residual: dict[str, float] = field(default_factory=dict)
    statistics: dict[str, float] = field(default_factory=dict)
    step_sizes: Array = field(default_factory=lambda: np.empty(0))
    scene_source: str = ""
    flavours: dict[str, str] = field(default_factory=dict)
    response: dict[str, Any] | None = None

    def __getitem__(self, name: str) -> Array:
        """A column, shape (n,), SI, or ``time``. Raises KeyError with the nearest name."""
        if name == "time":
            return self.time
        if name not in self.columns:
            near = get_close_matches(name, self.columns, 1)
            raise KeyError(f"no column {name!r}" + (f"; did you mean {near[0]!r}?" if near else ""))
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name == "time" or name in self.columns

    def worst_margin(self) -> Margin | None:
        """The smallest margin that decides; of those that are shown only if none decides; None if there are none."""
        known = [margin for margin in self.margins if not math.isnan(margin.worst)]
        return min([m for m in known if m.decides] or known, key=lambda margin: margin.worst, default=None)

    def worst_coupling_error(self) -> tuple[str, float] | None:
        """Variable and relative error of the largest estimate; None if nothing was estimated."""
        known = [(name, error) for name, error in self.coupling_error.items() if not math.isnan(error)]
        return max(known, key=lambda item: item[1], default=None)

    def made_of(self) -> str:
        """Units by the flavour of their FMU, as ``native: cradle, line; python: ship``; empty if not known."""
        units: dict[str, list[str]] = {}
        for name, flavour in self.flavours.items():
            units.setdefault(flavour, []).append(name)
        return "; ".join(f"{flavour}: {', '.join(names)}" for flavour, names in sorted(units.items()))

    def summary(self) -> dict[str, Any]:
        """Everything but the arrays, as finite JSON (NaN and infinity become null): events as counts per
        ``unit.name``, columns as their extremes with the times of these."""
        plain = {name: value for name, value in self._metadata().items() if name not in ("scene_source", "response")}
        plain["events"] = dict(Counter(f"{event.unit}.{event.name}" for event in self.events))
        plain["samples"] = len(self.time)
        plain["start_time"], plain["end_time"] = (self.time[0], self.time[-1]) if len(self.time) else (None, None)
        plain["extremes"] = {name: _extremes(self.time, values) for name, values in self.columns.items()}
        finite: dict[str, Any] = _plain(plain, finite=True)
        return finite

    def save_npz(self, path: str | os.PathLike[str]) -> None:
        """Everything, bit-exact; `load_npz` reads it back. Raises TowageError and keeps the earlier file if it cannot
        be written (this holds for every writer here)."""
        metadata = {**self._metadata(), "format": _FORMAT, "column_names": list(self.columns)}
        metadata["one_way_names"] = list(self.one_way)
        arrays: dict[str, Any] = {"time": self.time, "step_sizes": self.step_sizes}
        arrays |= {f"column_{i}": values for i, values in enumerate(self.columns.values())}
        arrays |= {f"one_way_{i}": values for i, values in enumerate(self.one_way.values())}
        text = json.dumps(_plain(metadata, finite=False))
        with atomic_write(path) as stream:
            np.savez(stream, metadata=np.frombuffer(text.encode(), np.uint8), **arrays)

    @classmethod
    def load_npz(cls, path: str | os.PathLike[str]) -> Result:
        """Result written by `save_npz`. Raises TowageError if ``path`` is not one."""
        try:
            if not zipfile.is_zipfile(path):
                with open(path, "rb"):  # a missing file is an OSError
                    raise ValueError("it is not an npz archive")
            with np.load(path, allow_pickle=False) as store:
                metadata = json.loads(store["metadata"].tobytes())
                if metadata.pop("format") > _FORMAT:
                    raise ValueError("it was written by a newer version")
                for kind, prefix in (("columns", "column"), ("one_way", "one_way")):
                    names = metadata.pop(f"{prefix}_names")
                    metadata[kind] = {name: store[f"{prefix}_{i}"] for i, name in enumerate(names)}
                metadata["time"], metadata["step_sizes"] = store["time"], store["step_sizes"]
            for kind, record in (("events", Event), ("checks", Check), ("margins", Margin)):
                metadata[kind] = [record(**values) for values in metadata[kind]]
            metadata["verdict"] = Verdict(**metadata["verdict"])
            metadata["comparison"] = metadata["comparison"] and Comparison(**metadata["comparison"])
            return cls(**metadata)
        except OSError as error:
            raise TowageError(f"cannot read {os.fspath(path)}: {error.strerror or error}") from error
        except (ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
            raise TowageError(f"{os.fspath(path)} is not a result of towage: {error}") from error

    def save_csv(self, path: str | os.PathLike[str]) -> None:
        """Header ``name [unit]``, one row a sample, shortest digits that read back exactly; UTF-8. Columns of the
        one-way run are called ``one_way:name``."""
        columns = {"time": self.time, **self.columns}
        columns |= {f"one_way:{name}": values for name, values in self.one_way.items()}
        units = {"time": "s", **self.units, **{f"one_way:{name}": self.units.get(name, "") for name in self.one_way}}
        with atomic_write(path) as stream:
            writer = csv.writer(codecs.getwriter("utf-8")(stream, "backslashreplace"), lineterminator="\n")
            writer.writerow([f"{name} [{units.get(name) or '-'}]" for name in columns])
            writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))

    def save_mat(self, path: str | os.PathLike[str]) -> None:
        """MAT 5: column vectors under valid MATLAB names (``line.tension`` becomes ``line_tension``), and the cell
        array ``variables`` with rows {MATLAB name, name, unit}."""
        from scipy.io import savemat  # type: ignore[import-untyped, unused-ignore]

        series = {"time": self.time, **self.columns}
        series |= {f"one_way.{name}": values for name, values in self.one_way.items()}
        units = {"time": "s", **self.units, **{f"one_way.{name}": self.units.get(name, "") for name in self.one_way}}
        content: dict[str, Array] = {"variables": np.empty((len(series), 3), dtype=object)}
        for row, (name, values) in enumerate(series.items()):
            matlab = _matlab_name(name, content)
            content[matlab] = values
            content["variables"][row] = matlab, name, units.get(name) or "-"
        with atomic_write(path) as stream:
            savemat(stream, content, oned_as="column")

    def _metadata(self) -> dict[str, Any]:
        arrays = ("time", "columns", "one_way", "step_sizes")
        records = {"events", "checks", "margins"}
        values = {name: value for name, value in vars(self).items() if name not in arrays}
        values |= {name: [vars(record) for record in values[name]] for name in records}
        return values | {"verdict": vars(self.verdict), "comparison": self.comparison and vars(self.comparison)}


def _plain(value: Any, finite: bool) -> Any:
    """``value`` in terms of JSON; numpy scalars and arrays converted, with ``finite`` NaN and infinity made null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item, finite) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist(), finite)
    if isinstance(value, list | tuple):
        return [_plain(item, finite) for item in value]
    return None if finite and isinstance(value, float) and not math.isfinite(value) else value


def _extremes(time: Array, values: Array) -> dict[str, float | None]:
    """Smallest and largest finite value of a column and when, and the last value."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return dict.fromkeys(("min", "min_time", "max", "max_time", "last"))
    low, high = known[np.argmin(values[known])], known[np.argmax(values[known])]
    picked = (values[low], time[low], values[high], time[high], values[-1])
    return dict(zip(("min", "min_time", "max", "max_time", "last"), map(float, picked), strict=True))


def _matlab_name(name: str, taken: Mapping[str, Any]) -> str:
    """Letters, digits and underscores, a letter first, no keyword, at most 63 characters, not in ``taken``."""
    keywords = "break case catch classdef continue else elseif end for function global if otherwise parfor persistent"
    base = re.sub(r"[^A-Za-z0-9_]", "_", name)
    if not base[:1].isalpha() or base in f"{keywords} return spmd switch try while".split():
        base = f"v_{base}"
    candidate, count = base[:_MATLAB_NAME], 1
    while candidate in taken:
        count += 1
        candidate = f"{base[: _MATLAB_NAME - len(str(count)) - 1]}_{count}"
    return candidate
