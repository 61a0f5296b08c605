"""Several results side by side: one HTML file without scripts or references, the same bytes for the same results.

Differences are those against the first run, at its times where both runs have samples; the other run is interpolated
linearly, so that at a jump a difference may show which is one of time.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from towage.files import atomic_write
from towage.report.format import Markup, badge, figure, moment, number, page, percent, quantity, scale, table
from towage.report.page import margin_cell, name_of, peak_tension
from towage.report.plots import CYCLE, roles
from towage.report.svg import canvas, thin
from towage.result.result import Array, Comparison, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DIAGRAMS = 12
"""Variables with a diagram; all are in the table."""
_CURVES = len(CYCLE)
"""Runs in a diagram: more could not be told apart."""
_BUCKETS = 500
_WIDTH = 9.6
_PLOTTED = 1e30
"""Larger values ("never") are left out of diagrams."""


class Run(NamedTuple):
    """A result and what it is called on the page."""

    name: str
    result: Result


class Difference(NamedTuple):
    """Of a variable against the first run, in its own unit: the largest and its time (s), the rms, and the rms over that of
    the first run's variable (NaN where that is 0); all NaN where the runs have no time in common."""

    largest: float
    time: float
    rms: float
    relative: float


def runs_of(paths: Sequence[str | os.PathLike[str]]) -> list[Run]:
    """The results in ``paths``, npz files or directories of ``towage run``, under names that differ. Raises
    `TowageError` that names the file."""
    loaded: list[tuple[Path, Result]] = []
    for path in map(Path, paths):
        files = sorted(path.glob("*.npz")) or [path / "*.npz"] if path.is_dir() else [path]
        loaded += [(file, Result.load_npz(file)) for file in files]
    one_title = len({result.title for _, result in loaded}) == 1
    short = [result.case if one_title and result.case else name_of(result) for _, result in loaded]
    counted = Counter(short)
    names = [name if counted[name] == 1 else f"{name} ({file})" for name, (file, _) in zip(short, loaded)]
    return [Run(name, result) for name, (_, result) in zip(names, loaded)]


def write_comparison(runs: Sequence[Run], path: str | os.PathLike[str]) -> Path:
    """Writes the page of ``runs`` to ``path`` and returns it. Raises ValueError without runs and `TowageError` if it
    cannot be written."""
    if not runs:
        raise ValueError("a comparison needs at least one run")
    names = common(runs)
    sections = (_runs(runs), _indicators(runs), _margins(runs), _variables(runs, names), _diagrams(runs, names))
    body = "".join(f"<section>{content}</section>\n" for content in sections if content)
    with atomic_write(path) as stream:
        text = page(f"{len(runs)} runs side by side", f"Differences are against {runs[0].name}", body)
        stream.write(text.encode(errors="backslashreplace"))
    return Path(path)


def common(runs: Sequence[Run]) -> list[str]:
    """Variables that all runs recorded in one unit of measure; motion, driver and tension of the first run first."""
    first, *others = (run.result for run in runs)
    shared = [
        name for name in first.columns
        if all(name in o.columns and o.units.get(name, "") == first.units.get(name, "") for o in others)
    ]  # fmt: skip
    role = roles(first)
    leading = [name for name in (role.motion, role.tension, role.driver) if name in shared]
    return [*leading, *(name for name in shared if name not in leading)]


def against(first: Result, other: Result, name: str) -> tuple[Array, Array]:
    """(times of ``first`` that ``other`` spans, s, the variable in ``other`` minus in ``first``, in its own unit), both of
    shape (n,)."""
    if not len(first.time) or not len(other.time):
        return np.empty(0), np.empty(0)
    inside = (first.time >= other.time[0]) & (first.time <= other.time[-1])
    time = first.time[inside]
    return time, np.interp(time, other.time, other[name]) - first[name][inside]


def difference(first: Result, other: Result, name: str) -> Difference:
    """The numbers of `against`, in the variable's own unit."""
    time, values = against(first, other, name)
    known = np.isfinite(values) & (np.abs(values) < _PLOTTED)
    if not known.any():
        return Difference(*[float("nan")] * 4)
    at = int(np.argmax(np.where(known, np.abs(values), -1.0)))
    rms = float(np.sqrt(np.mean(values[known] ** 2)))
    base = first[name][np.isin(first.time, time[known])]
    size = float(np.sqrt(np.mean(base**2)))
    return Difference(float(values[at]), float(time[at]), rms, rms / size if size > 0.0 else float("nan"))


def _runs(runs: Sequence[Run]) -> str:
    head = ("Run", "Verdict", "Deciding number", "Limit", "Worst margin", "Coupling error", "Peak tension", "Made by")
    rows = []
    for name, result in runs:
        margin, error = result.worst_margin(), result.worst_coupling_error()
        made = ", ".join(part for part in (result.scheme, result.made_of()) if part)
        rows.append(
            (
                name,
                badge("failed" if result.status == "failed" else result.verdict.word),
                number(result.verdict.number),
                number(result.verdict.limit),
                Markup(margin_cell(margin)) if margin else "–",
                percent(error[1], 2) if error else "not estimated",
                peak_tension(result)[0],
                made or "–",
            )
        )
    return f'<div id="verdicts"><h2>Verdicts</h2>{table(head, rows, (2, 3, 5, 6))}</div>'


def _indicators(runs: Sequence[Run]) -> str:
    wanted: tuple[tuple[str, Callable[[Comparison], str]], ...] = (
        ("Amplitude", lambda c: percent(c.amplitude)),
        ("Phase", lambda c: f"{number(float(np.degrees(c.phase)))}°"),
        ("Peak tension", lambda c: percent(c.peak_tension)),
        ("rms of the difference", lambda c: percent(c.rms)),
        ("Indicator ε", lambda c: number(c.indicator)),
        ("Bound ε/(1 − ε)", lambda c: percent(c.bound)),
        ("Closed form ε*", lambda c: number(c.estimate)),
    )
    if not any(run.result.comparison for run in runs):
        return ""
    rows = [(name, *(say(c) if (c := run.result.comparison) else "–" for run in runs)) for name, say in wanted]
    return "<h2>Coupled against one-way</h2>" + _side_by_side("Quantity", rows, runs)


def _margins(runs: Sequence[Run]) -> str:
    worst = [{margin.variable: margin for margin in run.result.margins} for run in runs]
    rows = [
        (name, *(f"{number(run[name].worst)} at {moment(run[name].time)}" if name in run else "–" for run in worst))
        for name in dict.fromkeys(name for run in worst for name in run)
    ]
    return "<h2>Margins</h2>" + _side_by_side("Margin", rows, runs) if rows else ""


def _side_by_side(head: str, rows: Sequence[Sequence[object]], runs: Sequence[Run]) -> str:
    return table((head, *(run.name for run in runs)), rows, tuple(range(1, len(runs) + 1)))


def _variables(runs: Sequence[Run], names: Sequence[str]) -> str:
    if not names:
        return "<h2>Differences</h2><p>The runs have no variable in common.</p>"
    first, rows = runs[0].result, []
    for name in names:
        unit = _unit(first, name)
        for run in runs[1:]:
            change = difference(first, run.result, name)
            largest, rms = quantity(change.largest, unit), quantity(change.rms, unit)
            rows.append((name, run.name, largest, moment(change.time), rms, percent(change.relative)))
    head = ("Variable", "Run", "Largest", "At", "rms", "over rms of the first")
    return f"<h2>Differences</h2>{table(head, rows, (2, 3, 4, 5))}" if rows else ""


def _diagrams(runs: Sequence[Run], names: Sequence[str]) -> str:
    drawn = [figure(_overlay(runs[:_CURVES], name, f"v{i}"), name, "") for i, name in enumerate(names[:_DIAGRAMS])]
    left = []
    if len(names) > _DIAGRAMS:
        left.append(f"Diagrams show {_DIAGRAMS} of {len(names)} common variables.")
    if len(runs) > _CURVES:
        left.append(f"They show the first {_CURVES} runs.")
    note = f'<p class="note">{escape(" ".join(left))}</p>' if left else ""
    return f'<h2>Common variables</h2>{note}<div class="figures">{"".join(drawn)}</div>' if drawn else ""


def _overlay(runs: Sequence[Run], name: str, key: str) -> str:
    """All runs in one panel, and below it what they differ by from the first."""
    first = runs[0].result
    shown = np.abs(np.concatenate([run.result[name] for run in runs]), dtype=float)
    factor, unit = scale(_unit(first, name), float(shown[shown < _PLOTTED].max(initial=0.0)))
    with canvas(f"{name} of all runs against time", key, _WIDTH, [2.6, 1.6] if len(runs) > 1 else [2.6]) as (axes, svg):
        for run, colour in zip(runs, CYCLE, strict=False):
            _curve(axes[0], run.result.time, factor * run.result[name], colour, run.name)
        for run, colour in list(zip(runs, CYCLE, strict=False))[1:]:
            time, values = against(first, run.result, name)
            _curve(axes[1], time, factor * values, colour, None)
        axes[0].legend(loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=2, borderaxespad=0.2)
        axes[0].set_ylabel(f"[{unit or '-'}]")
        if len(runs) > 1:
            axes[1].set_ylabel(f"difference [{unit or '-'}]")
            axes[1].set_xlim(axes[0].get_xlim())
        axes[-1].set_xlabel("time [s]")
    return svg[0]


def _unit(result: Result, name: str) -> str:
    """The unit of measure, empty for a number."""
    unit = result.units.get(name, "")
    return "" if unit == "1" else unit


def _curve(axis: Axes, time: Array, values: Array, colour: str, label: str | None) -> None:
    values = np.where(np.abs(values) < _PLOTTED, values, np.nan)
    picked = thin(values, _BUCKETS) if len(values) else np.empty(0, dtype=int)
    axis.plot(time[picked], values[picked], color=colour, label=label, lw=1.1)
