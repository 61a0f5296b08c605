"""The tables of a report for one result; each is empty if the result has nothing to show."""

from __future__ import annotations

from collections import Counter
from html import escape

from towage.checks.check import Cell, Part, every_check
from towage.report.format import Markup, badge, details, moment, number, percent, quantity, table
from towage.result.result import Result

_FEW = 12
"""Tables longer than this are folded."""
_STATISTICS = {
    "steps": ("Communication steps", ""),
    "rejected": ("Rejected steps", ""),
    "step_calls": ("Steps of all units", ""),
    "wall_s": ("Wall time", "s"),
    "cpu_s": ("Processor time", "s"),
    "start_cpu_s": ("Processor time of the start", "s"),
    "real_time_factor": ("Speed, times real time", ""),
}


def of_checks(result: Result) -> str:
    """What the checks show of the run, each its own tables."""
    return "".join(_part(part) for check in every_check() for part in check.report(result))


def _part(part: Part) -> str:
    """A table of a check, numbers set right."""
    title = f"<h3>{escape(part.title)}</h3>" if part.title else ""
    against = "" if part.limit is None else f" against a tolerance of {percent(part.limit)}"
    word = f"<p>{badge(part.word)}{against}.</p>" if part.word else ""
    note = f'<p class="note">{escape(part.note)}</p>' if part.note else ""
    numeric = sorted({column for row in part.rows for column, cell in enumerate(row) if isinstance(cell, Cell)})
    rows = [[_cell(cell) if isinstance(cell, Cell) else cell for cell in row] for row in part.rows]
    return title + word + note + table(part.head, rows, numeric)


def _cell(cell: Cell) -> str:
    value, unit, signed = cell
    plus = "+" if signed and value is not None and value > 0.0 else ""
    if unit == "%":
        return plus + percent(value)
    if unit == "s":
        return plus + moment(value)
    return f"{plus}{number(value)}{unit if unit in ('', '°') else f' {unit}'}"


def card(result: Result) -> str:
    """The items that the verdict is put together from, with what can be done about each."""
    rows = [
        (
            item.name, badge(item.word), item.reason + ("" if item.decides else " (does not decide)"), number(item.number),
            number(item.limit), "–" if item.time is None else moment(item.time), item.remedy or "–",
        )
        for item in result.verdict.items
    ]  # fmt: skip
    head = ("Asked", "Word", "Why", "Number", "Limit", "At", "What to do")
    return str(table(head, rows, (3, 4, 5))) if rows else ""


def checks(result: Result) -> str:
    """What the checks said before and after the run."""
    if not result.checks:
        return ""
    rows = [(c.name, badge(c.level), number(c.value), number(c.limit), c.message) for c in result.checks]
    return "<h3>Checks</h3>" + table(("Check", "Outcome", "Value", "Limit", "Message"), rows, (2, 3))


def accuracy(result: Result) -> str:
    """Estimated coupling errors and energy residuals of the bonds."""
    names = dict.fromkeys((*result.coupling_error, *result.power_residual))
    if not names:
        return ""
    rows = [
        (name, percent(result.coupling_error.get(name), 2), percent(result.power_residual.get(name), 2))
        for name in names
    ]
    head = ("Variable or bond", "Coupling error", "Energy residual")
    return "<h3>Accuracy of the coupling</h3>" + table(head, rows, (1, 2))


def events(result: Result, most: int) -> str:
    """The first ``most`` events, folded away if they are many."""
    if not result.events:
        return ""
    directions = {1: "rising", -1: "falling"}
    rows = [(moment(e.time), e.unit, e.name, directions.get(e.direction, "in time")) for e in result.events[:most]]
    content = table(("Time", "Unit", "Event", "Direction"), rows, (0,))
    if len(result.events) > len(rows):
        content = Markup(content + f'<p class="note">The first {len(rows)}; all are in the result file.</p>')
    counted = Counter(f"{event.unit}.{event.name}" for event in result.events)
    title = "Events: " + ", ".join(f"{name} {count}" for name, count in sorted(counted.items()))
    return details(title, content) if len(rows) > _FEW else f"<h3>Events</h3>{content}"


def statistics(result: Result) -> str:
    """What the run cost, folded away."""
    if not result.statistics:
        return ""
    known = [name for name in _STATISTICS if name in result.statistics]
    rows = [("Units", result.made_of())] if result.flavours else []
    for name in (*known, *(name for name in result.statistics if name not in _STATISTICS)):
        label, unit = _STATISTICS.get(name, (name.replace("_", " "), ""))
        value = result.statistics[name]
        whole = float(value).is_integer() and abs(value) < 1e9
        rows.append((label, f"{value:.0f} {unit}".rstrip() if whole else quantity(value, unit)))
    return details("Run statistics", table(("Quantity", "Value"), rows, (1,)))
