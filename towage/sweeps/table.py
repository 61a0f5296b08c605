"""The table of a sweep: one row a run in the order of the design, the same bytes however the sweep was interrupted."""

from __future__ import annotations

import codecs
import csv
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.files import atomic_write
from towage.sweeps.design import Design
from towage.sweeps.row import Row

Array = NDArray[np.float64]
_EVENTS = "events:"


@dataclass(frozen=True)
class Table:
    """``status``, ``verdict`` and ``message`` of every run, and ``measures``: name to values, shape (runs,), NaN where a run
    has none (events: 0 in a run that was done without any). ``words``: those of the items of the card, by their names, empty
    where a run has none. ``units``: unit of measure of each. ``note``: how the numbers
    were made, where that matters to a reader."""

    title: str
    design: Design
    status: tuple[str, ...]
    verdict: tuple[str, ...]
    message: tuple[str, ...]
    measures: dict[str, Array]
    units: dict[str, str]
    note: str = ""
    words: dict[str, tuple[str, ...]] = field(default_factory=dict)

    @classmethod
    def of(cls, title: str, design: Design, rows: Mapping[int, Row], units: Mapping[str, str]) -> Table:
        """From the rows of all runs; ``units`` of the recorded variables. Raises KeyError if a row is missing."""
        ordered = [rows[index] for index in range(len(design.points))]
        names = dict.fromkeys(name for row in ordered for name in row.measures)
        measures = {}
        for name in names:
            missing = [0.0 if name.startswith(_EVENTS) and row.status == "done" else np.nan for row in ordered]
            values = (row.measures.get(name, other) for row, other in zip(ordered, missing))
            measures[name] = np.fromiter(values, np.float64, len(ordered))
        words = zip(*((row.status, row.verdict, row.message) for row in ordered))
        items = sorted({name for row in ordered for name in row.words})
        told = {name: tuple(row.words.get(name, "") for row in ordered) for name in items}
        return replace(cls.from_columns(title, design, words, measures, units), words=told)

    @classmethod
    def from_columns(
        cls,
        title: str,
        design: Design,
        words: Iterable[Iterable[str]],
        measures: Mapping[str, Array],
        units: Mapping[str, str],
        note: str = "",
    ) -> Table:
        """From status, verdict and message of all runs (``words``), and their measures in any order."""
        status, verdict, message = (tuple(column) for column in words)
        ordered = {name: measures[name] for name in sorted(measures, key=_place)}
        measured = {name: "rad" if name == "sdof:phase" else _unit(name, units) for name in ordered}
        return cls(title, design, status, verdict, message, ordered, measured, note)

    @property
    def done(self) -> NDArray[np.bool_]:
        """Which runs came to their end, shape (runs,)."""
        return np.array([status == "done" for status in self.status])

    def save_npz(self, path: Path) -> None:
        """Arrays ``index``, ``status``, ``verdict``, ``message``, ``words`` (runs, items), ``points`` (runs, targets),
        ``measures`` (runs, measures) and the JSON ``metadata`` with the names of their columns."""
        metadata = {
            "title": self.title, "design": self.design.text, "targets": self.design.targets,
            "units": self.design.units, "shape": self.design.shape, "measures": list(self.measures),
            "measure_units": list(self.units.values()), "note": self.note, "items": list(self.words),
        }  # fmt: skip
        arrays: dict[str, Any] = {
            "index": np.arange(len(self.status)),
            "status": np.array(self.status), "verdict": np.array(self.verdict), "message": np.array(self.message),
            "words": np.array(list(self.words.values()), dtype=str).reshape(-1, len(self.status)).T,
            "points": self.design.points,
            "measures": np.array(list(self.measures.values())).reshape(-1, len(self.status)).T,
            "metadata": np.frombuffer(json.dumps(metadata).encode(), np.uint8),
        }  # fmt: skip
        with atomic_write(path) as stream:
            np.savez(stream, **arrays)

    def save_csv(self, path: Path) -> None:
        """One row a run, shortest digits that read back exactly, empty where a run has no value; UTF-8."""
        targets, measures = (
            [f"{name} [{unit or '-'}]" for name, unit in pairs]
            for pairs in (zip(self.design.targets, self.design.units), self.units.items())
        )
        with atomic_write(path) as stream:
            writer = csv.writer(codecs.getwriter("utf-8")(stream, "backslashreplace"), lineterminator="\n")
            told = [f"word:{name}" for name in self.words]
            writer.writerow(["index", *targets, "status", "verdict", *told, *measures, "message"])
            columns = [values.tolist() for values in self.measures.values()]
            for k, point in enumerate(self.design.points.tolist()):
                numbers = ["" if column[k] != column[k] else column[k] for column in columns]
                words = [column[k] for column in self.words.values()]
                writer.writerow([k, *point, self.status[k], self.verdict[k], *words, *numbers, self.message[k]])


def _unit(name: str, units: Mapping[str, str]) -> str:
    """Of a smallest or largest value that of the variable; all else is a number."""
    return units.get(name.partition(":")[2], "") if name.startswith(("max:", "min:")) else "1"


def _place(name: str) -> tuple[int, str]:
    """Judgements first, then extremes and counts; by name within each, so that the order of runs does not matter."""
    kinds = (
        "sdof:", "item:", "statistics:", "interval:", "worst_margin", "margin:", "attractor", "coupling_error", "max:", "min:",
        _EVENTS,
    )  # fmt: skip
    return next((k for k, kind in enumerate(kinds) if name.startswith(kind)), len(kinds)), name
