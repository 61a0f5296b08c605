"""The report of a study: one HTML file without scripts or references, and the lines for a terminal."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from towage.files import atomic_write
from towage.operability import plots
from towage.operability.extremes import CONFIDENCE, REJECTED, fitted
from towage.operability.files import fits_rejected, limit_text, nearest, shares_text
from towage.operability.outcome import Cell, Outcome
from towage.operability.study import Done
from towage.report.format import Markup, details, figure, number, page, percent, quantity
from towage.report.format import table as html_table

DEFICIT = 0.05
"""Share by which extremes may be too low, for want of components, before more of them are asked for: about what twenty records
leave open of a quantile."""
NEAR = 12
"""Cells listed that are nearest to a limit."""


def text_summary(done: Done) -> str:
    """The lines that a study ends with on a terminal."""
    one = done.outcome
    whole, own = one.whole, one.plan.headings
    lines = [
        f"{done.table.title}: {len(one.cells)} cells, {len(done.table.status)} runs of {_record(one)}, "
        f"{done.lost} not done",
        f"  operable        {shares_text(whole)} of the time",
    ]
    for k, degrees in enumerate(own.degrees):
        lines.append(f"    {degrees:5g} deg     {shares_text(one.uptime(one.plan.scatter.share, k))}")
    lines += [f"    {name:12s}  {shares_text(uptime)}" for name, uptime in one.monthly()]
    lines += [f"  {text}" for text in _words(done)]
    if done.hours:
        lines.append(f"  {done.hours:.0f} h simulated in {done.elapsed:.0f} s: {done.rate:.0f} h a second")
    return "\n".join(lines)


def _words(done: Done) -> list[str]:
    """What must be said of the numbers."""
    one = done.outcome
    whole, said = one.whole, []
    if whole.invalid:
        names: dict[str, float] = {}
        for cell in one.cells:
            if cell.word == "invalid":
                cause = cell.margin_of or cell.reason
                names[cause] = names.get(cause, 0.0) + cell.share * one.plan.headings.shares[cell.heading]
        causes = ", ".join(
            f"{name} ({percent(share)})" for name, share in sorted(names.items(), key=lambda item: -item[1])
        )
        said.append(
            f"{percent(whole.invalid)} of the time lies in cells whose runs leave the premises of their models; they are not "
            f"counted as operable, and their numbers prove nothing: {causes}"
        )
    if whole.not_done:
        reason = next(cell.reason for cell in one.cells if cell.word == "not done")
        said.append(
            f"{percent(whole.not_done)} of the time lies in cells that were not done, not counted as operable: {reason}"
        )
    for text, share in fits_rejected(one).items():
        if share > 2.0 * REJECTED:
            said.append(
                f"{text}: the fit is rejected in {percent(share)} of the cells at a level of {percent(REJECTED)}, so that its "
                "quantiles are doubtful there (column 'fit' of cells.csv)"
            )
    samples = sum(extreme.kind == "sample" for cell in one.cells for extreme in cell.extremes)
    if samples:
        said.append(
            f"in {samples} cases several runs of a cell have one and the same extreme, as at a bound; there quantiles are those "
            "of the sample, and a probability below one in so many runs is not resolved"
        )
    linear = done.screening.outcome
    if linear:
        said.append(f"linear response (simplified method): operable {percent(linear.whole.holds)} of the time")
    mean, largest = done.screening.deficit
    if mean == mean:
        said.append(
            f"the sea's components are so few that extremes of the heave of the point are lower than those of a Gaussian sea by "
            f"{percent(mean, 2)} in the mean of the time and by up to {percent(largest, 2)}"
            + ("; take more: --set UNIT.components=300" if largest > DEFICIT else "")
        )
    said += [f"simplified method not made: {text}" for text in done.screening.missing]
    return [text.replace("−", "-").replace("–", "-") for text in said]


def write_report(done: Done, path: Path) -> Path:
    """Writes the report to ``path`` and returns it. Raises `TowageError`."""
    one = done.outcome
    criteria = "; ".join(c.text for c in one.criteria)
    subtitle = f"{criteria}, each with probability {one.probability:g} in {_record(one)}"
    words = "".join(f"<p>{escape(text)}.</p>" for text in _words(done))
    body = (
        f"<section>{_facts(done)}{words}</section>\n<section>{''.join(_figures(done))}</section>\n"
        f"<section>{_limit_table(one)}{_near_table(done)}{_notes(done)}</section>\n"
    )
    with atomic_write(path) as stream:
        stream.write(
            page(f"Operability: {done.table.title}", subtitle, body, "operability").encode(errors="backslashreplace")
        )
    return path


def _facts(done: Done) -> str:
    one = done.outcome
    whole = one.whole
    facts = [
        (
            "Operable",
            percent(whole.holds),
            f"{percent(whole.sure)} to {percent(whole.most)} by {percent(CONFIDENCE)} confidence",
        ),
        ("Invalid", percent(whole.invalid), "outside the premises"),
        ("Not done", percent(whole.not_done), f"{done.lost} runs"),
        ("Cells", str(len(one.cells)), f"{one.plan.seeds} seeds of {_record(one)} each"),
    ]
    if done.screening.outcome:
        facts.append(("Linear response", percent(done.screening.outcome.whole.holds), "simplified method"))
    cells = "".join(
        f"<div><dt>{escape(head)}</dt><dd>{escape(value)}<small>{escape(note)}</small></dd></div>"
        for head, value, note in facts
    )
    return f'<dl class="facts">{cells}</dl>'


def _figures(done: Done) -> list[Markup]:
    one, plan = done.outcome, done.outcome.plan
    linear = done.screening.outcome
    note = (
        "Circles: a criterion no longer holds. Arrows: already at the lowest height (down), not up to the highest (up). Crosses: "
        "beyond, the premises end. Grey: how often the sea is."
    )
    drawn = [figure(plots.limits(one, linear, "lim"), "Limits of the significant height", note)]
    by_heading = [one.uptime(plan.scatter.share, k) for k in range(len(plan.run))]
    names = [f"{degrees:g}°" for degrees in plan.headings.degrees]
    drawn.append(figure(plots.bars(names, by_heading, "By heading", "head"), "By heading",
                        "180°: head sea. Each as if the ship lay at this heading all the time."))  # fmt: skip
    if months := one.monthly():
        drawn.append(
            figure(plots.bars([n[:3] for n, _ in months], [u for _, u in months], "By month", "mon"), "By month", "")
        )
    own = [k for k, run in enumerate(plan.run) if run == k]
    worst = min(own, key=lambda k: by_heading[k].holds)
    caption = (
        "Green holds, red fails, violet invalid, grey not done; framed: a limit lies inside the confidence interval. Numbers: "
        "share of the time, per mille."
    )
    title = f"Cells at {plan.headings.degrees[worst]:g}°, the heading with the least operable time"
    drawn.append(figure(plots.words(one, worst, "wrd"), title, caption))
    if near := _gumbel(done):
        drawn.append(near)
    return drawn


def _gumbel(done: Done) -> Markup | None:
    """The fit in the cell nearest to a limit."""
    one = done.outcome
    found = next(((c, k) for c, k in nearest(one, NEAR) if c.extremes[k].kind == "Gumbel"), None)
    if not found:
        return None
    cell, k = found
    criterion = one.criteria[k]
    row = one.plan.places.tolist().index([cell.heading, cell.height, cell.period])
    column = done.table.measures[criterion.measure(done.table.measures)]
    values = column[row * one.plan.seeds : (row + 1) * one.plan.seeds]
    values = values[np.isfinite(values)]  # without runs that were spared
    mu, beta, _ = fitted((values if criterion.upper else -values)[None, :])
    title = f"Extremes in the cell with most of the time on a limit: {', '.join(_parts(one, cell))}"
    drawn = plots.gumbel(one, np.asarray(values), k, (float(mu[0]), float(beta[0])), "gum")
    return figure(
        drawn, title, f"Gumbel's paper: its distribution is a straight line. Fit: {number(cell.extremes[k].fit)}."
    )


def _parts(one: Outcome, cell: Cell) -> tuple[str, str, str]:
    """Heading, height and period of a cell."""
    plan = one.plan
    return (
        f"{plan.headings.degrees[cell.heading]:g}°",
        f"{number(float(plan.scatter.heights[cell.height]))} m",
        f"{number(float(plan.peaks[cell.period]))} s",
    )


def _record(one: Outcome) -> str:
    """The length of a record."""
    length = one.plan.length
    return f"{length / 3600.0:.3g} h" if length >= 3600.0 else f"{length / 60.0:.3g} min"


def _limit_table(one: Outcome) -> Markup:
    plan, found = one.plan, one.limits()
    periods = sorted({lim.period for lim in found})
    by = {(lim.heading, lim.period): limit_text(lim) for lim in found}
    head = ("Heading", *(f"{plan.peaks[j]:.3g} s" for j in periods))
    rows = [(f"{plan.headings.degrees[k]:g}°", *(by.get((k, j), "") for j in periods)) for k in range(len(plan.run))]
    note = "<p class='note'>Limit of Hs, m, by peak period. ?: beyond, the premises end.</p>"
    return Markup(details("Limits", f"{note}{html_table(head, rows, range(1, len(head)))}"))


def _near_table(done: Done) -> Markup:
    one = done.outcome
    rows = []
    for cell, k in nearest(one, NEAR):
        e, criterion = cell.extremes[k], one.criteria[k]
        unit = "" if criterion.unit == "1" else criterion.unit
        probable, value, low, high = (quantity(v, unit, 4) for v in (e.probable, e.quantile, e.low, e.high))
        rows.append(
            (*_parts(one, cell), percent(cell.share * one.plan.headings.shares[cell.heading]), criterion.text, probable,
             value, f"{low} to {high}", percent(e.exceedance), f"{percent(e.least)} to {percent(e.most)}", cell.word)
        )  # fmt: skip
    head = ("Heading", "Hs", "Tp", "Share of the time", "Criterion", "Most probable", f"Quantile {one.probability:g}",
            f"{percent(CONFIDENCE)} confidence", "Probability to pass", "confidence", "Word")  # fmt: skip
    return Markup(details("Cells on which the answer hangs", html_table(head, rows, (0, 1, 2, 3, 5, 6)), True))


def _notes(done: Done) -> Markup:
    rate = f"{done.hours:.0f} h simulated in {done.elapsed:.0f} s, {done.rate:.0f} h a second" if done.hours else ""
    items = "".join(f"<p>{escape(note[0].upper() + note[1:])}.</p>" for note in (*done.notes, rate) if note)
    return Markup(details("How it was made", items, True))
