"""The report of one or more runs: a single HTML file without scripts or references, the same bytes for the same results.

The verdicts come first, then for each case its diagrams, the comparison with the one-way run, checks and events, and at
the end the scene files.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from towage.checks.check import every_check
from towage.checks.verdict import GRAVITY
from towage.files import atomic_write
from towage.report.format import Markup, badge, details, figure, moment, number, page, percent, quantity, table
from towage.report.plots import Plotter, roles
from towage.report.shapes import shapes, wires
from towage.report.tables import accuracy, card, checks, events, of_checks, statistics
from towage.result.result import Item, Margin, Result
from towage.terminal import escaped

_PLOTTED_CASES = 10
"""Cases with diagrams, the gravest first: more would make the file too large to send."""
_DETAILED_CASES = 40
"""Cases with tables of their own; the others have their line in the overview."""
_OPEN_CASES = 4
"""With more cases than this the sections are folded."""
_RESOLUTION = 800
"""Parts into which time is divided for a curve, two samples each; fewer if there are many cases."""
TOLD = ("process", "scheme", "grid")
"""Findings that a summary shows where they are warnings: of a unit's manners, and of what the master did about them."""
LONGEST_LINE = 1000
"""Letters of a line for a terminal."""
ASCII = str.maketrans({"−": "-", "–": "-", "∞": "inf"})
"""For terminals that show nothing else."""


def write_report(results: Result | Sequence[Result], path: str | os.PathLike[str]) -> Path:
    """Writes the report of a result, or of several (the cases of one or more scenes), to ``path`` and returns it.

        towage.write_report(towage.run_all("sea_cliff"), "sea_cliff.html")

    One HTML file without scripts or references. All cases are in the overview; tables follow for the 40 gravest and
    diagrams for the 10 gravest, thinned so that the file stays under 1.5 MB. Raises ``ValueError`` without results and
    `TowageError` if the file cannot be written; an earlier report is then kept.
    """
    results = [results] if isinstance(results, Result) else results
    if not results:
        raise ValueError("a report needs at least one result")
    with atomic_write(path) as stream:
        stream.write(escaped(_page(results), longest=sys.maxsize).encode(errors="backslashreplace"))
    return Path(path)


def text_summary(result: Result) -> str:
    """What a run ends with on a terminal, a few lines: verdict and the number that decided, worst margin and when,
    estimate of the coupling error, speed."""
    word = "failed" if result.status == "failed" else result.verdict.word
    lines = [f"{name_of(result)}: {word}"]
    if result.status == "failed":
        lines.append(f"  failure         {result.message or 'no reason was given'}")
    if result.verdict.reason or result.verdict.number is not None:
        lines.append(f"  verdict         {_reason(result)}")
    lines += [f"  {item.name:15} {_item_text(item)}" for item in result.verdict.items]
    lines += [f"  {label:15} {text}" for check in every_check() for label, text in check.summary(result)]
    warnings = [finding.message for finding in result.checks if finding.level == "warning" and finding.name in TOLD]
    lines += [f"  {'warning':15} {message}" for message in warnings]
    margin = result.worst_margin()
    lines.append(f"  worst margin    {_margin_text(margin) if margin else 'none recorded'}")
    error = result.worst_coupling_error()
    lines.append(f"  coupling error  {f'{percent(error[1], 2)} ({error[0]})' if error else 'not estimated'}")
    speed, wall = result.statistics.get("real_time_factor"), result.statistics.get("wall_s")
    if speed is not None:
        took = "" if wall is None else f", {number(wall)} s for {number(_duration(result))} s"
        lines.append(f"  speed           {number(speed)} x real time{took}")
    if result.flavours:
        lines.append(f"  units           {result.made_of()}")
    return "\n".join(escaped(line, "", LONGEST_LINE) for line in lines).translate(ASCII)


def _page(results: Sequence[Result]) -> str:
    titles = list(dict.fromkeys(result.title for result in results))
    title = titles[0] if len(titles) == 1 else f"{titles[0]} and {len(titles) - 1} more"
    gravest = sorted(range(len(results)), key=lambda index: _gravity(results[index]))
    plotted, detailed = gravest[:_PLOTTED_CASES], sorted(gravest[:_DETAILED_CASES])
    buckets = max(80, min(_RESOLUTION, 3 * _RESOLUTION // len(plotted)))
    sections = []
    for index in detailed:
        result = results[index]
        body = _case(result, f"c{index + 1}", buckets if index in plotted else 0, max(20, 600 // len(results)))
        if len(results) > _OPEN_CASES:
            body = details("Details", body)
        sections.append(f'<section id="case-{index + 1}">{_case_head(result, len(titles) > 1)}{body}</section>\n')
    body = f"{_overview(results, len(plotted), detailed)}{''.join(sections)}{_scenes(results)}"
    return page(title, "Coupled simulation and the validity of its assumptions", body)


def _overview(results: Sequence[Result], plotted: int, detailed: Sequence[int]) -> str:
    head = ("Case", "Verdict", "Deciding number", "Limit", "Worst margin", "Coupling error", "Peak tension")
    rows = []
    for index, result in enumerate(results):
        margin, error = result.worst_margin(), result.worst_coupling_error()
        name = result.case or "Base case"
        rows.append(
            (
                Markup(f'<a href="#case-{index + 1}">{escape(name)}</a>') if index in detailed else name,
                badge("failed") if result.status == "failed" else badge(result.verdict.word),
                number(result.verdict.number),
                number(result.verdict.limit),
                Markup(margin_cell(margin)) if margin else "–",
                percent(error[1], 2) if error else "not estimated",
                peak_tension(result)[0],
            )
        )
    counted = Counter("failed" if result.status == "failed" else result.verdict.word for result in results)
    count = ", ".join(f"{counted[word]} {word}" for word in ("failed", *GRAVITY) if counted[word])
    note = f"{len(results)} case{'s' if len(results) > 1 else ''}: {count}. A margin is 1 at rest, 0 at the limit of "
    note += "validity and negative beyond."
    if plotted < len(results):
        note += f" Diagrams are drawn for the {plotted} gravest cases; more are in the result files."
    return f'<section id="verdicts"><h2>Verdicts</h2>{table(head, rows, (2, 3, 5, 6))}<p class="note">{note}</p></section>\n'


def _case_head(result: Result, titled: bool) -> str:
    failed = result.status == "failed"
    name = name_of(result) if titled else result.case or "Base case"
    head = f'<div class="headline"><h2>{escape(name)}</h2>{badge("failed" if failed else result.verdict.word)}</div>'
    if failed:
        reason = result.message or "The run failed and gave no reason."
        partial = f"\nWhat follows covers the part up to {moment(float(result.time[-1]))}." if len(result.time) else ""
        head += f'<div class="failure" role="alert"><strong>The run failed.</strong> {escape(reason + partial)}</div>'
    reason = _reason(result)
    return head + (f"<p>{escape(reason[0].upper() + reason[1:])}</p>" if reason else "") + card(result) + _facts(result)


def _facts(result: Result) -> str:
    margin, error = result.worst_margin(), result.worst_coupling_error()
    facts: list[tuple[str, str, str]] = []
    if result.verdict.number is not None:
        facts.append(("Deciding number", number(result.verdict.number), f"limit {number(result.verdict.limit)}"))
    if margin:
        when = f"{margin.variable} at {moment(margin.time)}" + ("" if margin.decides else ", report only")
        facts.append(("Worst margin", number(margin.worst), when))
    peak, where = peak_tension(result)
    if where:
        facts.append(("Peak tension", peak, where))
    facts.append(
        ("Coupling error, estimated", percent(error[1], 2) if error else "–", error[0] if error else "not estimated")
    )
    steps = result.statistics.get("steps")
    facts.append(("Scheme", result.scheme or "–", "" if steps is None else f"{int(steps)} communication steps"))
    cells = "".join(f"<div><dt>{a}</dt><dd>{escape(b)}<small>{escape(c)}</small></dd></div>" for a, b, c in facts)
    return f'<dl class="facts">{cells}</dl>\n'


def _case(result: Result, key: str, buckets: int, event_rows: int) -> str:
    parts = [_figures(result, key, buckets)] if buckets else []
    if not len(result.time):
        parts = ['<p class="note">No samples were recorded.</p>']
    parts += [of_checks(result), checks(result), accuracy(result)]
    parts += [events(result, event_rows), statistics(result)]
    return "".join(parts)


def _figures(result: Result, key: str, buckets: int) -> str:
    if not len(result.time):
        return ""
    plot = Plotter(result, key, buckets)
    response, steps = plot.response(), plot.steps()
    drawn = (
        (plot.motions(), "Motions", "Dashed: the one-way run, in which nothing acts back on the driver.", False),
        (plot.tension(), "Tension", "Shaded: the line is slack.", False),
        (
            plot.margins(),
            "Margins",
            "Full lines decide on the verdict, dashed lines are reported only. The scale ends at −1.5.",
            False,
        ),
        (plot.difference(), "Coupled minus one-way", "What the single degree of freedom leaves out.", False),
        (response, "Transmissibility", "One-way response and where this case lies on it.", steps is not None),
        (steps, "Communication steps", "Accepted steps; marks at the bottom are events.", response is not None),
    )
    shown = "".join(figure(svg, title, caption, half) for svg, title, caption, half in drawn if svg)
    for unit in wires(result):
        shape = shapes(result, unit, f"{key}-{unit}")
        shown += figure(shape, f"Shape of {unit}", "Relative to the towpoint, light to dark from start to end.") if shape else ""
    others, omitted = plot.others()
    more = "".join(figure(svg, "", "") for svg in others)
    if omitted:
        more += f'<p class="note">{omitted} more columns are in the result file.</p>'
    if more and not (plot.roles.motion or plot.roles.tension):
        shown, more = f"{shown}{more}", ""
    folded = details("Other recorded variables", f'<div class="figures">{more}</div>') if more else ""
    return f'<div class="figures">{shown}</div>{folded}'


def _scenes(results: Sequence[Result]) -> str:
    sources = [source for source in dict.fromkeys(result.scene_source for result in results) if source]
    if not sources:
        return ""
    return "<section><h2>Scene</h2>" + "".join(f"<pre>{escape(source)}</pre>" for source in sources) + "</section>\n"


def name_of(result: Result) -> str:
    """Title and case."""
    return ", ".join(part for part in (result.title, result.case) if part) or "run"


def _reason(result: Result) -> str:
    verdict = result.verdict
    if verdict.number is None:
        return verdict.reason
    limit = "" if verdict.limit is None else f", limit {number(verdict.limit)}"
    return f"{verdict.reason} ({number(verdict.number)}{limit})".strip()


def _item_text(item: Item) -> str:
    """An item of the verdict in a line: its word, number and limit, and what can be done; its reason stands in the report."""
    value = "" if item.number is None else f" ({number(item.number)}, limit {number(item.limit)})"
    shown = "" if item.decides else ", does not decide"
    remedy = f": {item.remedy}" if item.remedy else ""
    return f"{item.word}{value}{shown}{remedy}"


def _margin_text(margin: Margin) -> str:
    use = "" if margin.decides else ", report only"
    return f"{number(margin.worst)} ({margin.variable} at {moment(margin.time)}{use})"


def margin_cell(margin: Margin) -> str:
    """The worst value, and below it which and when."""
    use = "" if margin.decides else ", report only"
    return f"{number(margin.worst)}<small>{escape(margin.variable)} at {moment(margin.time)}{use}</small>"


def peak_tension(result: Result) -> tuple[str, str]:
    """(largest tension with its unit, its variable and time); a dash without a column of tension."""
    name = roles(result).tension
    if name is None or not np.isfinite(result[name]).any():
        return "–", ""
    at = int(np.nanargmax(np.where(np.isfinite(result[name]), result[name], np.nan)))
    return quantity(float(result[name][at]), result.units.get(name, "")), f"{name} at {moment(float(result.time[at]))}"


def _duration(result: Result) -> float:
    return float(result.time[-1] - result.time[0]) if len(result.time) else 0.0


def _gravity(result: Result) -> int:
    return -1 if result.status == "failed" else GRAVITY.index(result.verdict.word)
