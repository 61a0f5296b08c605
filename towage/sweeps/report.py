"""The report of a sweep: one HTML file without scripts or references, the same bytes for the same table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from towage.files import atomic_write
from towage.report.format import Markup, badge, details, figure, number, page, percent, quantity, table
from towage.scene.scene import Scene
from towage.sweeps.plots import Quantity, attractor_map, operability, over_many, over_one, over_two
from towage.sweeps.table import Table

SHOWN = 20
"""Runs listed in a table: all are in the CSV file."""
Limit = tuple[str, float]
"""A recorded variable and the value that it should stay under, in its own unit."""


def write_report(found: Table, scene: Scene, limits: Sequence[Limit], path: Path) -> Path:
    """Writes the report to ``path`` and returns it. Raises `TowageError` if it cannot be written."""
    figures = "".join(_figures(found, _quantities(found, scene, limits), limits))
    body = (
        f"{f'<p>{escape(found.note)}</p>' if found.note else ''}"
        f"<section>{_facts(found, limits)}{_shares(found)}</section>\n<section>{figures}</section>\n"
        f"{_gravest(found)}{_failures(found)}"
    )
    with atomic_write(path) as stream:
        stream.write(page(found.title, found.design.text, body, "sweep").encode(errors="backslashreplace"))
    return path


def text_summary(found: Table, limits: Sequence[Limit]) -> str:
    """What a sweep ends with on a terminal."""
    lines = [f"{found.title}: {len(found.status)} runs, {_counted(found.status)}"]
    if found.done.any():
        words = [verdict for verdict, done in zip(found.verdict, found.done) if done]
        lines.append(f"  verdicts        {_counted(words)}")
    for name, limit in limits:
        shown = quantity(limit, found.units.get(f"max:{name}", ""))
        lines.append(f"  {name} stays under {shown} in {percent(share_under(found, name, limit))} of the runs done")
    failures = [k for k, done in enumerate(found.done) if not done]
    lines += [f"  run {k} {found.status[k]}: {found.message[k]}" for k in failures[:3]]
    if len(failures) > 3:
        lines.append(f"  and {len(failures) - 3} more, see the table")
    lines += [f"  {found.note}"] if found.note else []
    return "\n".join(lines).replace("−", "-").replace("–", "-")


def share_under(found: Table, name: str, limit: float) -> float:
    """Share of the runs done in which a variable stays at or under a limit; NaN if none was done."""
    largest = found.measures.get(f"max:{name}", np.full(len(found.status), np.nan))[found.done]
    return float(np.mean(largest <= limit)) if len(largest) else float("nan")


def _counted(words: Sequence[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in Counter(words).most_common())


def _quantities(found: Table, scene: Scene, limits: Sequence[Limit]) -> list[Quantity]:
    """What is worth a diagram: the SDOF error, the worst margin, the largest tension, and what has a limit."""
    check = scene.checks.get("sdof")
    wanted = [
        Quantity("sdof:rms", "SDOF error, rms", check.tolerance if check else None),
        Quantity("worst_margin", "worst margin", 0.0),
    ]
    known = dict(limits)
    tension = check.tension if check else next((n[4:] for n in found.measures if n.endswith("tension")), "")
    wanted += [Quantity(f"max:{n}", f"largest {n}", known.get(n)) for n in dict.fromkeys([*known, tension])]
    return [q for q in wanted if np.isfinite(found.measures.get(q.name, np.nan)).any()]


def _figures(found: Table, quantities: Sequence[Quantity], limits: Sequence[Limit]) -> list[str]:
    if not found.done.any():
        return ["<p>No run was done.</p>"]
    targets = len(found.design.targets)
    drawn: list[str] = []
    if targets == 1:
        drawn.append(figure(over_one(found, list(quantities), "one"), "", "Dashed: the limit. Crosses: not done."))
    for k, one in enumerate(quantities):
        if targets == 2:
            drawn.append(figure(over_two(found, one, f"m{k}"), one.label, _caption(found, one)))
        elif targets > 2:
            drawn.append(figure(over_many(found, one, f"p{k}"), one.label, "The spread is what the others do."))
    repeats = found.measures.get("attractor")
    if targets == 2 and repeats is not None and np.isfinite(repeats).any():
        note = (
            "After how many periods of the sea the motion at the end of the run repeats to 1 %: more than one is a "
            "subharmonic; none is chaos, or a motion that has not settled, which a record cannot tell apart."
        )
        drawn.append(figure(attractor_map(found, "att"), "Attractors", note))
    named = [name for name, _ in limits]
    for k, one in enumerate(q for q in quantities if q.name[4:] in named):
        note = f"Share of the {int(found.done.sum())} runs done, all with equal weight."
        drawn.append(figure(operability(found, one, f"o{k}"), f"Operability: {one.label}", note))
    return drawn


def _caption(found: Table, one: Quantity) -> str:
    values = found.measures[one.name]
    if one.limit is None:
        return ""
    limit = quantity(one.limit, found.units[one.name].replace("1", ""))
    if not np.nanmin(values) < one.limit < np.nanmax(values):
        side = "under" if np.nanmax(values) <= one.limit else "over"
        return f"All runs are {side} the limit, {limit}."
    return f"The white line is the limit, {limit}."


def _facts(found: Table, limits: Sequence[Limit]) -> str:
    facts = [("Runs", str(len(found.status)), ""), ("Done", str(int(found.done.sum())), _counted(found.status))]
    for name, limit in limits:
        share = percent(share_under(found, name, limit))
        facts.append((f"{name} under {quantity(limit, found.units.get(f'max:{name}', ''))}", share, "of the runs done"))
    cells = "".join(
        f"<div><dt>{escape(head)}</dt><dd>{escape(value)}<small>{escape(note)}</small></dd></div>"
        for head, value, note in facts
    )
    return f'<dl class="facts">{cells}</dl>'


def _shares(found: Table) -> Markup:
    words = Counter(verdict for verdict, done in zip(found.verdict, found.done) if done)
    total = sum(words.values())
    rows = [(badge(word), str(count), percent(count / total)) for word, count in words.most_common()]
    return table(("Verdict", "Runs", "Share"), rows, (1, 2))


def _gravest(found: Table) -> str:
    """The runs with the smallest margin or largest SDOF error."""
    name, sign = ("sdof:rms", -1.0) if "sdof:rms" in found.measures else ("worst_margin", 1.0)
    values = found.measures.get(name)
    if values is None or not np.isfinite(values).any():
        return ""
    order = np.argsort(sign * values, kind="stable")
    rows = [
        (str(k), *map(number, found.design.points[k]), badge(found.verdict[k]), number(values[k]), found.message[k])
        for k in order[:SHOWN].tolist() if np.isfinite(values[k])
    ]  # fmt: skip
    head = ("Run", *_heads(found), "Verdict", name, "Reason")
    return f"<section>{details('The gravest runs', table(head, rows))}</section>\n"


def _failures(found: Table) -> str:
    lost = np.flatnonzero(~found.done)
    if not len(lost):
        return ""
    rows = [
        (str(k), *map(number, found.design.points[k]), found.status[k], found.message[k]) for k in lost[:SHOWN].tolist()
    ]
    title = f"Runs that were not done: {len(lost)}"
    return f"<section>{details(title, table(('Run', *_heads(found), 'Status', 'Reason'), rows), True)}</section>\n"


def _heads(found: Table) -> list[str]:
    return [f"{name} [{unit or '-'}]" for name, unit in zip(found.design.targets, found.design.units)]
