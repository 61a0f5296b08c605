"""The report of a sweep: one HTML file without scripts or references, the same bytes for the same table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from towage.files import atomic_write
from towage.report.format import Markup, badge, details, figure, number, page, percent, quantity
from towage.report.format import table as html_table
from towage.scene.scene import Scene
from towage.sweeps.criteria import Criterion
from towage.sweeps.plots import Quantity, attractor_map, operability, over_many, over_one, over_two
from towage.sweeps.table import Table

SHOWN = 20
"""Runs listed in a table: all are in the CSV file."""
MOST = 6
"""Diagrams of variables that nothing tells to be of more interest than others."""


def write_report(table: Table, scene: Scene, limits: Sequence[Criterion], path: Path) -> Path:
    """Writes the report of a sweep to ``path`` and returns it. ``limits``: what recorded variables should stay under or over.
    Raises `TowageError` if it cannot be written."""
    figures = "".join(_figures(table, _quantities(table, scene, limits), limits))
    body = (
        f"{f'<p>{escape(table.note)}</p>' if table.note else ''}"
        f"<section>{_facts(table, limits)}{_shares(table)}</section>\n<section>{figures}</section>\n"
        f"{_gravest(table)}{_failures(table)}"
    )
    with atomic_write(path) as stream:
        stream.write(page(table.title, table.design.text, body, "sweep").encode(errors="backslashreplace"))
    return path


def text_summary(table: Table, limits: Sequence[Criterion]) -> str:
    """The lines that a sweep ends with on a terminal: counts, verdicts, shares under the limits, the first failures."""
    lines = [f"{table.title}: {len(table.status)} runs, {_counted(table.status)}"]
    if table.done.any():
        words = [verdict for verdict, done in zip(table.verdict, table.done) if done]
        lines.append(f"  verdicts        {_counted(words)}")
    for one in limits:
        lines.append(f"  {_in_words(one, 'stays ')} in {percent(share_within(table, one))} of the runs done")
    failures = [k for k, done in enumerate(table.done) if not done]
    lines += [f"  run {k} {table.status[k]}: {table.message[k]}" for k in failures[:3]]
    if len(failures) > 3:
        lines.append(f"  and {len(failures) - 3} more, see the table")
    lines += [f"  {table.note}"] if table.note else []
    return "\n".join(lines).replace("−", "-").replace("–", "-")


def share_within(table: Table, one: Criterion) -> float:
    """Share of the runs done in which a criterion holds; NaN if none was done."""
    extremes = table.measures.get(one.measure(table.measures), np.full(len(table.status), np.nan))[table.done]
    return float(np.mean([one.holds(value) for value in extremes])) if len(extremes) else float("nan")


def _in_words(one: Criterion, verb: str = "") -> str:
    return f"{one.name} {verb}{one.side} {quantity(one.limit, '' if one.unit == '1' else one.unit)}"


def _counted(words: Sequence[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in Counter(words).most_common())


def _quantities(table: Table, scene: Scene, limits: Sequence[Criterion]) -> list[Quantity]:
    """What is worth a diagram: the SDOF error, the worst margin, the largest tension, and what has a limit; where there is
    none of these, as with units of other makes, the largest value of the first variables that are recorded."""
    check = scene.checks.get("sdof")
    wanted = [
        Quantity("sdof:rms", "SDOF error, rms", check.tolerance if check else None),
        Quantity("worst_margin", "worst margin", 0.0),
    ]
    named = {one.measure(table.measures): one for one in limits}
    tension = check.tension if check else next((n[4:] for n in table.measures if n.endswith("tension")), "")
    wanted += [Quantity(measure, f"{'largest' if one.upper else 'smallest'} {one.name}", one.limit, one.upper)
               for measure, one in named.items()]  # fmt: skip
    wanted += [Quantity(f"max:{tension}", f"largest {tension}")] if f"max:{tension}" not in named else []
    drawn = [q for q in wanted if np.isfinite(table.measures.get(q.name, np.nan)).any()]
    rest = (n for n, values in table.measures.items() if n.startswith("max:") and np.isfinite(values).any())
    return drawn or [Quantity(name, f"largest {name[4:]}") for name in list(rest)[:MOST]]


def _figures(table: Table, quantities: Sequence[Quantity], limits: Sequence[Criterion]) -> list[str]:
    if not table.done.any():
        return ["<p>No run was done.</p>"]
    targets = len(table.design.targets)
    drawn: list[str] = []
    if not quantities:
        return ["<p>Nothing that is recorded has a number to draw.</p>"]
    if targets == 1:
        drawn.append(figure(over_one(table, list(quantities), "one"), "", "Dashed: the limit. Crosses: not done."))
    for k, one in enumerate(quantities):
        if targets == 2:
            drawn.append(figure(over_two(table, one, f"m{k}"), one.label, _caption(table, one)))
        elif targets > 2:
            drawn.append(figure(over_many(table, one, f"p{k}"), one.label, "The spread is what the others do."))
    repeats = table.measures.get("attractor")
    if targets == 2 and repeats is not None and np.isfinite(repeats).any():
        note = (
            "After how many periods of the sea the motion at the end of the run repeats to 1 %: more than one is a "
            "subharmonic; none is chaos, or a motion that has not settled, which a record cannot tell apart."
        )
        drawn.append(figure(attractor_map(table, "att"), "Attractors", note))
    named = [one.measure(table.measures) for one in limits]
    for k, one in enumerate(q for q in quantities if q.name in named):
        note = f"Share of the {int(table.done.sum())} runs done, all with equal weight."
        drawn.append(figure(operability(table, one, f"o{k}"), f"Operability: {one.label}", note))
    return drawn


def _caption(table: Table, one: Quantity) -> str:
    values = table.measures[one.name]
    if one.limit is None:
        return ""
    limit = quantity(one.limit, table.units[one.name].replace("1", ""))
    if not np.nanmin(values) < one.limit < np.nanmax(values):
        side = "under" if np.nanmax(values) <= one.limit else "over"
        return f"All runs are {side} the limit, {limit}."
    return f"The white line is the limit, {limit}."


def _facts(table: Table, limits: Sequence[Criterion]) -> str:
    facts = [("Runs", str(len(table.status)), ""), ("Done", str(int(table.done.sum())), _counted(table.status))]
    facts += [(_in_words(one), percent(share_within(table, one)), "of the runs done") for one in limits]
    cells = "".join(
        f"<div><dt>{escape(head)}</dt><dd>{escape(value)}<small>{escape(note)}</small></dd></div>"
        for head, value, note in facts
    )
    return f'<dl class="facts">{cells}</dl>'


def _shares(table: Table) -> Markup:
    words = Counter(verdict for verdict, done in zip(table.verdict, table.done) if done)
    total = sum(words.values())
    rows = [(badge(word), str(count), percent(count / total)) for word, count in words.most_common()]
    return html_table(("Verdict", "Runs", "Share"), rows, (1, 2))


def _gravest(table: Table) -> str:
    """The runs with the smallest margin or largest SDOF error."""
    name, sign = ("sdof:rms", -1.0) if "sdof:rms" in table.measures else ("worst_margin", 1.0)
    values = table.measures.get(name)
    if values is None or not np.isfinite(values).any():
        return ""
    order = np.argsort(sign * values, kind="stable")
    rows = [
        (str(k), *map(number, table.design.points[k]), badge(table.verdict[k]), number(values[k]), table.message[k])
        for k in order[:SHOWN].tolist() if np.isfinite(values[k])
    ]  # fmt: skip
    head = ("Run", *_heads(table), "Verdict", name, "Reason")
    return f"<section>{details('The gravest runs', html_table(head, rows))}</section>\n"


def _failures(table: Table) -> str:
    lost = np.flatnonzero(~table.done)
    if not len(lost):
        return ""
    rows = [
        (str(k), *map(number, table.design.points[k]), table.status[k], table.message[k]) for k in lost[:SHOWN].tolist()
    ]
    title = f"Runs that were not done: {len(lost)}"
    return f"<section>{details(title, html_table(('Run', *_heads(table), 'Status', 'Reason'), rows), True)}</section>\n"


def _heads(table: Table) -> list[str]:
    return [f"{name} [{unit or '-'}]" for name, unit in zip(table.design.targets, table.design.units)]
