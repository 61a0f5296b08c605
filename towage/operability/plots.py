"""The diagrams of a study: limits of the height over the period, the scatter diagram with its words, shares of the time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from towage.operability.outcome import FAILS, HOLDS, INVALID, Limit, Outcome, Uptime
from towage.report.format import number, scale
from towage.report.plots import BLUE, GREEN, GREY, RED
from towage.report.svg import canvas
from towage.result.result import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FULL = 9.6
_FAIR = "#c98a00"
"""Of what is open."""


def limits(one: Outcome, linear: Outcome | None, key: str) -> str:
    """Limit of Hs over Tp, a line a heading, over the shares of the diagram; the linear response dashed, its smallest and largest
    limit of all headings."""
    from matplotlib import colormaps

    plan = one.plan
    with canvas("Limits of the significant height", key, _FULL, [4.6]) as ((axis,), svg):
        _shares(axis, one)
        own = [k for k, run in enumerate(plan.run) if run == k]
        palette = colormaps["viridis"]
        for place, heading in enumerate(own):
            mirrors = [f"{plan.headings.degrees[k]:g}" for k, run in enumerate(plan.run) if run == heading]
            colour = palette(place / max(1, len(own) - 1) * 0.92)
            _curve(axis, one, [lim for lim in one.limits() if lim.heading == heading], colour, f"{', '.join(mirrors)}°")
        if linear:
            found = linear.limits()
            x = sorted({lim.period for lim in found})
            for side, style in ((min, "--"), (max, ":")):
                y = [side(lim.height for lim in found if lim.period == period) for period in x]
                name = f"linear, {'lowest' if side is min else 'highest'} of all headings"
                axis.plot(plan.peaks[x], y, color=RED, ls=style, lw=1.2, label=name)
        axis.set(xlabel="peak period Tp [s]", ylabel="limit of Hs [m]")
        axis.legend(loc="upper left", ncols=2, title="heading")
    return svg[0]


def _curve(axis: Axes, one: Outcome, found: list[Limit], colour: object, label: str) -> None:
    """Crossings as a line; arrows where all heights hold; crosses where the premises end."""
    peaks = one.plan.peaks
    known = [lim for lim in found if lim.height == lim.height]
    x, y = [float(peaks[lim.period]) for lim in known], [lim.height for lim in known]
    axis.plot(x, y, color=colour, label=label, lw=1.4)
    for kind, mark in (("crossing", "o"), ("below", "v"), ("above", "^"), ("premises", "x")):
        at = [k for k, lim in enumerate(known) if lim.kind == kind]
        axis.plot([x[k] for k in at], [y[k] for k in at], mark, color=colour, ms=4)


def _shares(axis: Axes, one: Outcome) -> None:
    """The scatter diagram as a grey ground."""
    plan = one.plan
    if min(plan.scatter.share.shape) > 1:
        shown = np.where(plan.scatter.share > 0.0, np.sqrt(plan.scatter.share), np.nan)
        axis.pcolormesh(plan.peaks, plan.scatter.heights, shown, cmap="Greys", shading="nearest", rasterized=True,
                        vmin=0.0, vmax=2.5 * float(np.nanmax(shown)))  # fmt: skip
    axis.grid(False)


def words(one: Outcome, heading: int, key: str) -> str:
    """The words of all cells at a heading, with the share of the time in each, per mille."""
    plan = one.plan
    colours = {HOLDS: "#bfe3cf", FAILS: "#f6c9bd", INVALID: "#d9d2e9"}
    with canvas(f"Cells at {plan.headings.degrees[heading]:g} deg", key, _FULL, [4.4]) as ((axis,), svg):
        width = float(np.min(np.diff(plan.peaks))) if len(plan.peaks) > 1 else 1.0
        height = float(np.min(np.diff(plan.scatter.heights))) if len(plan.scatter.heights) > 1 else 1.0
        for cell in (c for c in one.cells if c.heading == heading):
            x, y = float(plan.peaks[cell.period]), float(plan.scatter.heights[cell.height])
            colour = colours.get(cell.word, "#eeeeee")
            axis.bar(x, height * 0.96, width * 0.96, bottom=y - 0.48 * height, color=colour,
                     edgecolor=_FAIR if not cell.sure else "none", linewidth=1.2)  # fmt: skip
            axis.text(
                x,
                y,
                number(1000.0 * cell.share, 2) if cell.share >= 1e-4 else "·",
                ha="center",
                va="center",
                fontsize=6,
            )
        axis.set(xlabel="peak period Tp [s]", ylabel="Hs [m]")
        axis.grid(False)
    return svg[0]


def bars(names: list[str], uptimes: list[Uptime], title: str, key: str) -> str:
    """Shares of the time by heading or by month: operable for sure, operable or not by the confidence, invalid."""
    with canvas(title, key, _FULL, [2.9]) as ((axis,), svg):
        x = np.arange(len(names))
        sure, likely, less, invalid, lost = (
            100.0 * np.array(values)
            for values in zip(*((u.sure, u.holds - u.sure, u.open, u.invalid, u.not_done) for u in uptimes))
        )
        bottom = np.zeros(len(names))
        for values, colour, label in (
            (sure, GREEN, "operable"), (likely, "#7fc4a6", "operable, inside the confidence"),
            (less, _FAIR, "not operable, inside the confidence"), (invalid, "#b9a9d9", "invalid"), (lost, GREY, "not done"),
        ):  # fmt: skip
            if values.any():
                axis.bar(x, values, 0.7, bottom=bottom, color=colour, label=label)
            bottom = bottom + values
        axis.set_xticks(x, names)
        axis.set(ylabel="share of the time [%]", ylim=(0.0, 100.0))
        axis.legend(loc="upper right", ncols=3)
    return svg[0]


def gumbel(one: Outcome, values: Array, k: int, fit: tuple[float, float], key: str) -> str:
    """The extremes of one cell for criterion ``k`` on Gumbel's paper, with the fitted line (``fit``: mu, beta of what rises) and
    the limit."""
    criterion = one.criteria[k]
    sign = 1.0 if criterion.upper else -1.0
    ordered = np.sort(sign * values)
    n = len(ordered)
    places = -np.log(-np.log((np.arange(1, n + 1) - 0.44) / (n + 0.12)))
    wanted = -np.log(-np.log(one.probability))
    line = np.array([places[0], max(places[-1], wanted) + 0.5])
    with canvas(f"Extremes of {criterion.name}", key, _FULL, [3.2]) as ((axis,), svg):
        factor, unit = scale(criterion.unit, float(np.abs(ordered).max()))
        axis.plot(places, factor * sign * ordered, "o", color=BLUE, ms=4, label="runs")
        axis.plot(line, factor * sign * (fit[0] + fit[1] * line), color=GREEN, label="fitted")
        axis.axhline(factor * criterion.limit, color=RED, ls="--", lw=1.0, label="limit")
        axis.axvline(wanted, color=GREY, ls=":", lw=1.0, label=f"probability {one.probability:g}")
        axis.set(xlabel="-ln(-ln P)", ylabel=f"{criterion.name} [{unit or '-'}]")
        axis.legend(loc="best")
    return svg[0]
