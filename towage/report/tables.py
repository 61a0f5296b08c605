"""The tables of a report for one result; each is empty if the result has nothing to show."""

from __future__ import annotations

import math
from collections import Counter

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
    "real_time_factor": ("Speed, times real time", ""),
}


def comparison(result: Result) -> str:
    """The coupled run against the one-way run, and the thesis's own indicators with what they are worth."""
    if not (compared := result.comparison):
        return ""

    def change(value: float) -> str:
        return ("+" if value > 0.0 else "") + percent(value)

    def against(value: float) -> str:
        return "above the tolerance" if abs(value) > compared.tolerance else "within the tolerance"

    def ours(value: float | None, meaning: str) -> str:
        return "not available for this scene" if value is None else meaning

    degrees = math.degrees(compared.phase)
    bound = "upper bound of the amplitude error, from the one-way run alone"
    indicator = "reaction over dynamic stiffness of the driver, from the one-way run alone"
    rows = (
        ("Amplitude", change(compared.amplitude), against(compared.amplitude)),
        ("Phase", f"{'+' if degrees > 0.0 else ''}{number(degrees)}°", "coupled against one-way motion"),
        ("Peak tension", change(compared.peak_tension), against(compared.peak_tension)),
        ("rms of the difference", percent(compared.rms), "over the rms of the one-way motion"),
        ("Indicator ε", number(compared.indicator), ours(compared.indicator, indicator)),
        ("Bound ε/(1 − ε)", percent(compared.bound), ours(compared.bound, bound)),
        ("Closed form ε*", number(compared.estimate), ours(compared.estimate, "estimate of ε without any run")),
    )
    thesis = (
        ("Eigenvector test", percent(compared.eigenvector), "an identity, it can never fail"),
        ("Frequency shift", percent(compared.frequency_shift), "passes wrongly in known cases"),
    )
    outcome = (
        "<h3>Coupled against one-way (single degree of freedom)</h3>"
        f"<p>{badge(compared.word)} against a tolerance of {percent(compared.tolerance)}.</p>"
    )
    caption = '<p class="note">The thesis’s own two indicators, for reference; neither has a part in the verdict.</p>'
    head = ("Quantity", "Value", "Meaning")
    return outcome + table(head, rows, (1,)) + caption + table(head, thesis, (1,))


def margins(result: Result) -> str:
    """The smallest value of each margin, those that decide first."""
    if not result.margins:
        return ""
    ordered = sorted(result.margins, key=lambda margin: (not margin.decides, margin.worst))
    rows = [(m.variable, number(m.worst), moment(m.time), "decides" if m.decides else "report only") for m in ordered]
    return "<h3>Margins</h3>" + table(("Margin", "Worst", "At", "Use"), rows, (1, 2))


def checks(result: Result) -> str:
    """What was found before and after the run."""
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
