"""What one run leaves behind: time series, events, findings, the verdict, and how they are kept and shown.

A result holds SI values on one time grid. npz is the working store (bit-exact), CSV, MAT 5 and netCDF are for other programs.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from towage.errors import FileError, suggest
from towage.result import frames, show
from towage.result.csv_file import write_csv
from towage.result.mat_file import write_mat
from towage.result.netcdf_file import write_netcdf
from towage.result.npz_file import Place, read_npz, shown, write_npz
from towage.result.records import NOT_JUDGED, Comparison, Event, Finding, Item, Margin, Statistic, Verdict
from towage.units.log import Message

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

__all__ = ["Array", "Comparison", "Event", "Finding", "Item", "Margin", "Result", "Statistic", "Verdict"]

Array = NDArray[Any]


@dataclass
class Result:
    """One case of one scene. Arrays have shape (n,) on ``time`` (s); ``units`` names the unit of measure of a column.

    ``one_way``: the same variables with the back reaction left out, on the same grid. ``coupling_error``: variable to
    estimated relative error. ``power_residual``: bond to relative energy residual. ``step_sizes``: accepted
    communication steps, s. ``flavours``: unit to ``python``, ``native`` or the tool that made its FMU.
    ``provenance``: what it was computed from (`towage.scene.provenance`). ``texts``: columns of texts. ``messages``: what the
    units logged. ``response``: curve ``ratio``, ``amplitude``, point ``operating`` and ``label``.
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
    checks: list[Finding] = field(default_factory=list)
    margins: list[Margin] = field(default_factory=list)
    comparison: Comparison | None = None
    verdict: Verdict = NOT_JUDGED
    coupling_error: dict[str, float] = field(default_factory=dict)
    power_residual: dict[str, float] = field(default_factory=dict)
    statistics: dict[str, float] = field(default_factory=dict)
    step_sizes: Array = field(default_factory=lambda: np.empty(0))
    scene_source: str = ""
    flavours: dict[str, str] = field(default_factory=dict)
    response: dict[str, Any] | None = None
    texts: dict[str, Array] = field(default_factory=dict)
    messages: list[Message] = field(default_factory=list)
    provenance: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        """A column, shape (n,), SI, or ``time``. Raises KeyError with the nearest name."""
        if name == "time":
            return self.time
        columns = {**self.columns, **self.texts}
        if name not in columns:
            raise KeyError(f"no column {name!r}{suggest(name, columns)}")
        return columns[name]

    def __contains__(self, name: object) -> bool:
        return name == "time" or name in self.columns or name in self.texts

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
        plain = {name: value for name, value in self._metadata().items() if name not in _LONG}
        plain["events"] = dict(Counter(f"{event.unit}.{event.name}" for event in self.events))
        plain["samples"] = len(self.time)
        plain["start_time"], plain["end_time"] = (self.time[0], self.time[-1]) if len(self.time) else (None, None)
        plain["extremes"] = {name: _extremes(self.time, values) for name, values in self.columns.items()}
        finite: dict[str, Any] = _plain(plain, finite=True)
        return finite

    def series(self, one_way: str = "one_way:") -> tuple[dict[str, Array], dict[str, str]]:
        """(arrays, units of measure) of everything on the time grid, shape (n,), SI: ``time``, the columns, and those of
        the one-way run with the prefix ``one_way``."""
        second = {f"{one_way}{name}": name for name in self.one_way}
        arrays = {"time": self.time, **self.columns, **self.texts, **{key: self.one_way[name] for key, name in second.items()}}
        units = {"time": "s", **self.units, **{key: self.units.get(name, "") for key, name in second.items()}}
        return arrays, units

    def save_npz(self, path: Place) -> None:
        """Everything, bit-exact; `load_npz` reads it back; ``path`` may be an open stream. Raises TowageError and keeps the
        earlier file if it cannot be written (this holds for every writer here)."""
        arrays = {"time": self.time, "step_sizes": self.step_sizes}
        series = {"columns": self.columns, "one_way": self.one_way, "texts": self.texts}
        write_npz(path, self.metadata(), arrays, series)

    @classmethod
    def load_npz(cls, path: Place) -> Result:
        """Result written by `save_npz`. Raises `FileError` if ``path`` is not one."""
        try:
            return cls._of(read_npz(path))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise FileError(f"{shown(path)} is not a result of towage: {error}") from error

    @classmethod
    def from_metadata(cls, values: Mapping[str, Any]) -> Result:
        """A result without rows, of what `metadata` gave. Raises `FileError` for anything else."""
        try:
            return cls._of({**values, "time": np.empty(0), "columns": {}})
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise FileError(f"what is said of the run cannot be read: {error}") from error

    @classmethod
    def _of(cls, values: dict[str, Any]) -> Result:
        """Of plain values, whose types are looked at. Raises ValueError, KeyError, TypeError and AttributeError."""
        said = {name: value for name, value in values.items() if name not in _ARRAYS}
        for name in said:
            if name not in _SAID:
                raise ValueError(f"{name!r} is nothing that a result says")
        typed = {name: msgspec.convert(value, _SAID[name]) for name, value in said.items()}
        typed |= {name: said[name] for name, value in typed.items() if isinstance(value, dict)}  # whole numbers stay such
        return cls(**typed, **{name: values[name] for name in _ARRAYS if name in values})

    def save_csv(self, path: str | os.PathLike[str]) -> None:
        """Header ``name [unit]``, one row a sample, shortest digits that read back exactly; UTF-8. Columns of the
        one-way run are called ``one_way:name``."""
        write_csv(path, *self.series())

    def save_mat(self, path: str | os.PathLike[str]) -> None:
        """MAT 5: column vectors under valid MATLAB names (``line.tension`` becomes ``line_tension``), and the cell
        array ``variables`` with rows {MATLAB name, name, unit}. Columns of the one-way run are called ``one_way_name``."""
        write_mat(path, *self.series("one_way."))

    def save_netcdf(self, path: str | os.PathLike[str]) -> None:
        """netCDF 4: a variable a column (SI) over ``time`` (s) with attribute ``units``, those of the one-way run as
        ``one_way:name``; attributes of the file say where it comes from: what `about` says, the version of towage, the scene,
        the flavours of its units and the coupling errors."""
        from towage import __version__

        provenance = {"source": f"towage {__version__}", "scene": self.scene_source, "flavours": self.flavours,
                      "coupling_error": _plain(self.coupling_error, finite=True), "Conventions": "CF-1.8"}  # fmt: skip
        write_netcdf(path, *self.series(), {**self.about(), **provenance})

    def to_dataframe(self) -> pandas.DataFrame:
        """A pandas table indexed by ``time`` (s), a column a variable (SI), those of the one-way run as ``one_way:name``;
        ``attrs["units"]`` has their units of measure. Raises TowageError without pandas."""
        return frames.dataframe(*self.series(), self.about())

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset over ``time`` (s), a variable a column (SI) with attribute ``units``, those of the one-way
        run as ``one_way:name``. Raises TowageError without xarray."""
        return frames.dataset(*self.series(), self.about())

    def plot(self, *names: str) -> Figure:
        """A matplotlib figure of the columns ``names`` (default: all that are no margins and no rates) over time, one
        panel a unit of measure; the one-way run is dashed. Raises KeyError for an unknown column."""
        chosen = {name: self[name] for name in names or show.usual(self.columns)}
        one_way = {name: values for name, values in self.one_way.items() if name in chosen}
        return show.figure(self.time, chosen, one_way, self.units)

    def about(self) -> dict[str, str]:
        """What the result is of: title, case, scheme, status, verdict and why."""
        word = "failed" if self.status == "failed" else self.verdict.word
        reason = self.message or self.verdict.reason
        return {"title": self.title, "case": self.case, "scheme": self.scheme, "verdict": word, "reason": reason}

    def __repr__(self) -> str:
        """One line: what was run, how it ended, how much is recorded."""
        about = self.about()
        name = ", ".join(text for text in (about["title"], about["case"]) if text)
        end = f" to t = {self.time[-1]:.6g} s" if len(self.time) else ""
        return f"<Result of {name!r}: {about['verdict']}; {len(self.columns)} variables, {len(self.time)} samples{end}>"

    def _repr_html_(self) -> str:
        """For notebooks: the verdict and the plots."""
        return show.html(self.about(), self.plot() if len(self.time) else None)

    def metadata(self) -> dict[str, Any]:
        """Everything but the arrays in terms of JSON, from which `from_metadata` makes a result without rows."""
        plain: dict[str, Any] = _plain(self._metadata(), finite=False)
        return plain

    def _metadata(self) -> dict[str, Any]:
        records = {"events", "checks", "margins"}
        values = {name: value for name, value in vars(self).items() if name not in _ARRAYS}
        values |= {name: [vars(record) for record in values[name]] for name in records}
        values["messages"] = [list(message) for message in self.messages]
        return values | {"verdict": asdict(self.verdict), "comparison": self.comparison and asdict(self.comparison)}


_LONG = ("scene_source", "response", "provenance", "messages")
"""What a summary leaves out."""
_ARRAYS = ("time", "columns", "one_way", "step_sizes", "texts")
_SAID = {name: kind for name, kind in get_type_hints(Result).items() if name not in _ARRAYS}
"""Everything but the arrays, with its type."""


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
