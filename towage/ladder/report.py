"""What is shown of a ladder: lines for a terminal, JSON, a page, and a table in Markdown for the page of a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from towage.checks.statistics import deciding
from towage.files import atomic_write
from towage.ladder.measure import word
from towage.ladder.rungs import Rung
from towage.ladder.simplest import Ladder, scene_of
from towage.report.format import Markup, badge, details, figure, number, page, percent, table
from towage.report.page import ASCII
from towage.report.plots import BLUE, GREEN, RED
from towage.report.svg import canvas
from towage.result.records import Statistic
from towage.scene.scene_file import toml

LEAST = 1e-6
"""Errors below this are drawn as this."""
CAPTION = "Numbers as in the table. Green: recommended. Red: beyond the tolerance."
HEAD = ("Model", "Largest error", "of", "Cost", "of the fullest", "Enough")


def name_of(ladder: Ladder) -> str:
    """Title and case."""
    return ", ".join(part for part in (ladder.title, ladder.case) if part)


def conclusion(ladder: Ladder) -> str:
    """The recommendation in a sentence."""
    if not (rung := ladder.enough):
        return ladder.note
    return (
        f"enough is: {rung.name} (largest error {percent(rung.error)}, tolerance {percent(ladder.tolerance)}; "
        f"{number(rung.ratio)} of the cost of the fullest)"
    )


def decided_by(ladder: Ladder, rung: Rung) -> str:
    """What the largest error is of."""
    return deciding(rung.errors, ladder.tolerance)[0] if rung.errors and rung.error else ""


def error_of(ladder: Ladder, rung: Rung) -> str:
    """The error that decides, with its interval."""
    if not rung.errors:
        return percent(math.nan)
    one = deciding(rung.errors, ladder.tolerance)[1]
    return percent(abs(one.error)) + (f" ± {percent(one.half_width, 2)}" if one.half_width else "")


def rows(ladder: Ladder) -> list[tuple[str, str, str, str, str, str]]:
    """A row a rung, under `HEAD`; one that was not made or not run has dashes and its reason in the last column."""
    told = []
    for k, rung in enumerate(ladder.rungs, 1):
        judged = {"valid": "yes", "invalid": "no"}.get(word(rung.errors, ladder.tolerance) if rung.errors else "", "not judged")
        said = rung.reason or ("not judged" if ladder.enough is None else judged)
        said += ", recommended" if rung is ladder.enough else ""
        marks = [what for what, here in (("as given", rung.given), ("fullest", rung is ladder.fullest)) if here]
        name = f"{k}. {rung.name}" + (f" ({', '.join(marks)})" if marks else "")
        cost = "–" if math.isnan(rung.cost) else f"{number(rung.cost, 2)} s"
        told.append((name, error_of(ladder, rung), decided_by(ladder, rung), cost, number(rung.ratio, 2), said))
    return told


def text(ladder: Ladder) -> str:
    """For a terminal: the recommendation, then a line a rung."""
    lines = [f"{name_of(ladder)}: {conclusion(ladder)}"]
    told = [HEAD[:5], *(row[:5] for row in rows(ladder))]
    widths = [max(len(row[k]) for row in told) for k in range(5)]
    last = [HEAD[5], *(row[5] for row in rows(ladder))]
    for row, said in zip(told, last, strict=True):
        lines.append("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + f"  {said}")
    lines += [f"  not asked: {question} ({why})" for question, why in ladder.absent.items()]
    lines.append(f"  {compared(ladder)}; {own(ladder)}")
    return "\n".join(lines).translate(ASCII)


def compared(ladder: Ladder) -> str:
    """What was compared."""
    kind = "compared by statistics" if ladder.statistical else "compared"
    return f"{kind}: {', '.join(ladder.signals)} from {number(ladder.settle)} s on"


def own(ladder: Ladder) -> str:
    """How sure the fullest model is of itself."""
    return f"the fullest model itself changes by {percent(ladder.own_error)} with doubled step (tenfold tolerance)"


def document(ladder: Ladder) -> dict[str, Any]:
    """As JSON: numbers that are not finite are null."""

    def plain(value: float) -> float | None:
        return value if math.isfinite(value) else None

    rungs = [
        {
            "name": rung.name, "levels": rung.levels, "leaves_out": rung.leaves_out, "reason": rung.reason, "given": rung.given,
            "error": plain(rung.error), "cost_s": plain(rung.cost), "ratio": plain(rung.ratio),
            "errors": {n: {"error": plain(e.error), "half_width": plain(e.half_width)} for n, e in (rung.errors or {}).items()},
        }
        for rung in ladder.rungs
    ]  # fmt: skip
    return {
        "title": ladder.title, "case": ladder.case, "tolerance": ladder.tolerance, "signals": ladder.signals,
        "settle": ladder.settle, "statistical": ladder.statistical,
        "fullest": ladder.fullest.name, "own_error": plain(ladder.own_error),
        "enough": ladder.enough and ladder.enough.name, "note": ladder.note, "absent": dict(ladder.absent), "rungs": rungs,
    }  # fmt: skip


def ladder_of(told: Mapping[str, Any]) -> Ladder:
    """The ladder that a `document` tells of, without the scenes of its rungs."""

    def number_of(value: Any, absent: float) -> float:
        return absent if value is None else float(value)

    rungs = []
    for one in told["rungs"]:
        found = {
            name: Statistic(number_of(error["error"], math.inf), number_of(error["half_width"], math.inf))
            for name, error in one["errors"].items()
        }
        rungs.append(
            Rung(
                tuple(one["levels"]), tuple(one["leaves_out"]), None, one["reason"], one["given"], found or None,
                number_of(one["cost_s"], math.nan), number_of(one["ratio"], math.nan),
            )
        )  # fmt: skip
    by_name = {rung.name: rung for rung in rungs}
    return Ladder(
        told["title"], told["case"], told["tolerance"], tuple(told["signals"]), told["settle"], told["statistical"], tuple(rungs),
        by_name[told["fullest"]], number_of(told["own_error"], math.inf), by_name.get(told["enough"]), told["note"],
        told["absent"],
    )  # fmt: skip


def markdown(ladder: Ladder) -> str:
    """A table for the page of a scene, with the recommendation above it."""
    said = conclusion(ladder)
    lines = [f"{said[0].upper()}{said[1:]}.", "", f"| {' | '.join(HEAD)} |", "|---|--:|---|--:|--:|---|"]
    lines += [f"| {' | '.join(row)} |" for row in rows(ladder)]
    return "\n".join([*lines, "", f"{compared(ladder).capitalize()}; {own(ladder)}."])


def picture(ladder: Ladder, key: str) -> str:
    """SVG of error over cost, rungs by their numbers, the tolerance as a line; empty where nothing was run. ``key`` is unique
    in the page."""
    run = [(k, rung) for k, rung in enumerate(ladder.rungs, 1) if rung.errors and math.isfinite(rung.error)]
    if not run:
        return ""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    with canvas("Error over cost", key, 9.6, [3.4]) as ((axis,), svg):
        for k, rung in run:
            colour = GREEN if rung is ladder.enough else BLUE if rung.error <= ladder.tolerance else RED
            place = rung.ratio, 100.0 * max(rung.error, LEAST)
            axis.plot(*place, "o", color=colour, ms=7, mec="white")
            axis.annotate(str(k), place, xytext=(5, 3), textcoords="offset points", fontsize=8)
        axis.axhline(100.0 * ladder.tolerance, color="#a3121d", lw=1.0, label="tolerance")
        axis.set(xscale="log", yscale="log", xlabel="processor time over that of the fullest [-]", ylabel="largest error [%]")
        axis.legend(loc="lower left")
        axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        for side in (axis.xaxis, axis.yaxis):
            side.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            side.set_minor_formatter(NullFormatter())
    return svg[0]


def write_report(ladders: Sequence[Ladder], path: Path) -> Path:
    """Writes the page of one ladder a case and returns its path. Raises `TowageError` where it cannot be written."""
    sections = "".join(_section(ladder, f"l{k}") for k, ladder in enumerate(ladders))
    titles = list(dict.fromkeys(ladder.title for ladder in ladders))
    with atomic_write(path) as stream:
        stream.write(page(", ".join(titles), "The simplest model that is enough", sections).encode())
    return path


def _section(ladder: Ladder, key: str) -> str:
    """One case."""
    said = conclusion(ladder)
    body = [
        (Markup(f"{escape(row[0])}<small>{escape(_without(rung))}</small>"), *row[1:])
        for row, rung in zip(rows(ladder), ladder.rungs, strict=True)
    ]
    sign = badge("ok" if ladder.enough else "not judged")
    head = f'<div class="headline"><h2>{escape(ladder.case or "Base case")}</h2>{sign}</div>'
    drawn = picture(ladder, key)
    file = ""
    if ladder.enough:
        source = toml(scene_of(ladder, ladder.enough))
        file = details("Scene file of the recommended model", f"<pre>{escape(source)}</pre>")
    note = f"{compared(ladder).capitalize()}; {own(ladder)}."
    note += "".join(f" Not asked: {question} ({why})." for question, why in ladder.absent.items())
    return (
        f"<section>{head}<p>{escape(said[0].upper() + said[1:])}.</p>{table(HEAD, body, (1, 3, 4))}"
        f"{figure(drawn, 'Error over cost', CAPTION) if drawn else ''}"
        f"{_every(ladder)}<p class=\"note\">{escape(note)}</p>{file}</section>\n"
    )


def _without(rung: Rung) -> str:
    """What a rung does not know."""
    return f"without {'; '.join(rung.leaves_out)}" if rung.leaves_out else ""


def _every(ladder: Ladder) -> str:
    """All errors, folded."""
    names = list(ladder.fullest.errors or {})
    head = ("Model", *names)
    body = [
        (rung.name, *(percent(one.error) if (one := rung.errors.get(name)) else "–" for name in names))
        for rung in ladder.rungs if rung.errors
    ]  # fmt: skip
    return details("All errors", table(head, body, range(1, len(head))))
