"""The diagrams of a report: what is drawn for one result, chosen by the roles its scene gives to columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from towage import reading
from towage.report.format import number, scale
from towage.report.shapes import columns
from towage.report.svg import canvas, thin
from towage.result.result import Array, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, RED, GREEN, GREY = "#0072b2", "#d55e00", "#00795c", "#5b6570"
"""Okabe and Ito's colours, which the colour-blind can tell apart; green a little darker, to be read on white."""
CYCLE = (BLUE, RED, GREEN, "#aa4499", "#9a7400", "#3f8fc4", GREY, "#000000")

_PLOTTED = 1e30
"""Larger values (divergence, "never") are left out of a diagram: its scale could not show them."""
_FULL, _HALF = 9.6, 4.8
"""Width of a diagram, inch."""
_LONG = 30
"""Cycles from which on the end of a motion is shown in a panel of its own."""


_ONE_WAY: dict[str, Any] = {"color": "#1b2430", "ls": (0, (3, 4)), "lw": 1.0}


@dataclass(frozen=True)
class Roles:
    """Which recorded columns drive, move and pull; None where there is none."""

    driver: str | None
    motion: str | None
    tension: str | None


def roles(result: Result) -> Roles:
    """As the scene's ``checks.sdof`` names them; the first column called tension where it does not."""
    try:
        named = reading.toml(result.scene_source).get("checks", {}).get("sdof", {})
    except (ValueError, AttributeError):
        named = {}
    driver, motion, tension = (
        name if isinstance(name := named.get(role), str) and name in result.columns else None
        for role in ("driver", "motion", "tension")
    )
    return Roles(driver, motion, tension or next((name for name in result.columns if name.endswith("tension")), None))


def intervals(time: Array, inside: Array) -> Array:
    """Intervals [start, stop], shape (k, 2), s, in which ``inside`` holds; edges half way to the next sample."""
    if not inside.any():
        return np.empty((0, 2))
    edges = np.concatenate((time[:1], 0.5 * (time[1:] + time[:-1]), time[-1:]))
    change = np.diff(np.concatenate(([False], inside, [False])).astype(int))
    return np.column_stack((edges[np.flatnonzero(change == 1)], edges[np.flatnonzero(change == -1)]))


def slack(result: Result, tension: str) -> Array:
    """Intervals without tension, shape (k, 2), s: from the samples, else from the events of the line."""
    spans = intervals(result.time, result.columns[tension] <= 0.0)
    unit = tension.rpartition(".")[0]
    events = [event for event in result.events if event.unit == unit and event.name == "taut" and event.direction]
    if len(spans) or not events:
        return spans
    ends = [event.time for event in events]
    ends = ends if events[0].direction < 0 else [float(result.time[0]), *ends]
    ends = ends if len(ends) % 2 == 0 else [*ends, float(result.time[-1])]
    return np.array(ends).reshape(-1, 2)


class Plotter:
    """Draws the diagrams of one result, each as the text of an SVG element. ``key`` is unique in the page; ``buckets``: parts
    into which time is divided, two samples each."""

    def __init__(self, result: Result, key: str, buckets: int) -> None:
        self.result, self.key, self.buckets = result, key, buckets
        self.time = result.time
        self.roles = roles(result)

    def motions(self) -> str | None:
        """Driver and motion, the one-way motion dashed; the last ten cycles again where there are many."""
        names = [name for name in (self.roles.driver, self.roles.motion) if name]
        if not names:
            return None
        last = self._last_cycles()
        heights = [2.9] if last is None else [2.7, 2.5]
        with canvas("Motions against time", f"{self.key}-m", _FULL, heights) as (axes, svg):
            for axis, window in zip(axes, (slice(None), last or slice(None)), strict=False):
                for name, colour in zip(names, (BLUE, RED), strict=False):
                    role = "driver" if name == self.roles.driver else "coupled"
                    self.curve(axis, self.result[name], window, color=colour, label=f"{name}, {role}")
                if (motion := self.roles.motion) and motion in self.result.one_way:
                    self.curve(axis, self.result.one_way[motion], window, label=f"{motion}, one-way", **_ONE_WAY)
                self.finish(axis, axis is axes[0])
                unit = " / ".join(dict.fromkeys(self.result.units.get(name) or "-" for name in names))
                axis.set_ylabel(_axis_label(names, unit))
            axes[-1].set_xlabel("time [s]")
        return svg[0]

    def tension(self) -> str | None:
        """Tension, the one-way tension dashed, slack shaded."""
        if not (name := self.roles.tension):
            return None
        values, spans = self.result[name], slack(self.result, name)
        factor, unit = scale(self.result.units.get(name, ""), _peak(values))
        with canvas("Tension against time", f"{self.key}-t", _FULL, [2.7]) as ((axis,), svg):
            if len(spans):
                near = (self.time[-1] - self.time[0]) / (2 * self.buckets)
                apart = np.concatenate(([True], spans[1:, 0] - spans[:-1, 1] > near, [True]))
                sides = np.column_stack((spans[apart[:-1], 0], spans[apart[1:], 1])).repeat(2, axis=1).ravel()
                heights = np.resize([0.0, 1.0, 1.0, 0.0], sides.shape)
                place = axis.get_xaxis_transform()
                axis.fill(sides, heights, color="#f3d9b1", lw=0, zorder=0.5, label="slack", transform=place)
            self.curve(axis, factor * values, color=BLUE, label=f"{name}, coupled")
            if name in self.result.one_way:
                self.curve(axis, factor * self.result.one_way[name], label=f"{name}, one-way", **_ONE_WAY)
            self.finish(axis)
            axis.set(xlabel="time [s]", ylabel=f"tension [{unit or '-'}]")
        return svg[0]

    def response(self) -> str | None:
        """Amplitude over frequency ratio, with the operating point of the run."""
        if not (curve := self.result.response) or not len(curve.get("ratio", ())):
            return None
        with canvas("Transmissibility", f"{self.key}-r", _HALF, [3.1]) as ((axis,), svg):
            ratio, amplitude = (np.asarray(curve[name], dtype=float) for name in ("ratio", "amplitude"))
            picked = thin(amplitude, self.buckets)
            axis.plot(ratio[picked], amplitude[picked], color=BLUE, label=str(curve.get("label") or "one-way response"))
            if operating := curve.get("operating"):
                label = f"this case: {number(operating[0])}, {number(operating[1])}"
                axis.plot(*([value] for value in operating[:2]), "o", color=RED, ms=7, mec="white", ls="", label=label)
            axis.set(xlabel="frequency ratio ω/ω₀ [-]", ylabel="amplitude ratio [-]", ylim=(0.0, None))
            _legend(axis, 1)
        return svg[0]

    def margins(self) -> str | None:
        """Margins that decide drawn full, the others dashed, with the limit at zero; at most eight, the worst first."""
        known = [margin for margin in self.result.margins if margin.variable in self.result]
        known.sort(key=lambda margin: (not margin.decides, np.nan_to_num(margin.worst, nan=np.inf)))
        if not known:
            return None
        with canvas("Margins against time", f"{self.key}-g", _FULL, [2.9]) as ((axis,), svg):
            for margin, colour in zip(known, CYCLE, strict=False):
                style: dict[str, Any] = {} if margin.decides else {"ls": (0, (4, 2)), "lw": 1.0}
                note = "" if margin.decides else ", report only"
                label = f"{margin.variable} (worst {number(margin.worst)}{note})"
                self.curve(axis, self.result[margin.variable], color=colour, label=label, **style)
            bottom, top = max(axis.get_ylim()[0], -1.5), max(axis.get_ylim()[1], 1.05)
            axis.axhspan(-1e3, 0.0, color="#fbe4e4", lw=0, zorder=0.4)
            axis.axhline(0.0, color="#a3121d", lw=1.2, label="limit of validity")
            self.finish(axis)
            axis.set(xlabel="time [s]", ylabel="margin [-]", ylim=(min(bottom, -0.08), min(top, 2.0)))
            _legend(axis, 2)
        return svg[0]

    def difference(self) -> str | None:
        """Coupled minus one-way, motion above and tension below."""
        names = [name for name in (self.roles.motion, self.roles.tension) if name and name in self.result.one_way]
        if not names:
            return None
        with canvas("Coupled minus one-way", f"{self.key}-d", _FULL, [1.7] * len(names)) as (axes, svg):
            for axis, name, colour in zip(axes, names, (RED, BLUE), strict=False):
                change = self.result[name] - self.result.one_way[name]
                factor, unit = scale(self.result.units.get(name, ""), _peak(self.result[name]))
                axis.axhline(0.0, color="#8a949e", lw=0.8)
                self.curve(axis, factor * change, color=colour, label=f"{name}, coupled − one-way")
                self.finish(axis)
                axis.set_ylabel(f"difference [{unit or '-'}]")
            axes[-1].set_xlabel("time [s]")
        return svg[0]

    def steps(self) -> str | None:
        """Accepted communication steps over time; a line for each kind of event marks when it occurred."""
        from matplotlib.ticker import FuncFormatter, NullFormatter

        sizes = self.result.step_sizes[np.isfinite(self.result.step_sizes) & (self.result.step_sizes > 0.0)]
        if not len(sizes) or not len(self.time):
            return None
        with canvas("Communication steps", f"{self.key}-s", _HALF, [3.1]) as ((axis,), svg):
            ends = self.time[0] + np.cumsum(sizes)
            picked = thin(sizes, self.buckets // 2)
            axis.plot(ends[picked], sizes[picked], color=BLUE, lw=0.9, marker="o" if len(sizes) < 3 else None)
            if sizes.max() > 5.0 * sizes.min():
                axis.set_yscale("log")
                axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: number(float(value))))
                axis.yaxis.set_minor_formatter(NullFormatter())
            else:
                axis.set_ylim(0.0, 1.05 * sizes.max())
            kinds = sorted({(event.unit, event.name) for event in self.result.events})
            for row, (unit, name) in enumerate(kinds[:5]):
                times = np.array(
                    [event.time for event in self.result.events if (event.unit, event.name) == (unit, name)]
                )
                marked = times[np.unique(np.linspace(0, len(times) - 1, self.buckets // 2).astype(int))]
                place, colour = np.full(len(marked), 0.03 + 0.05 * row), CYCLE[1 + row]
                axis.plot(
                    marked, place, "|", ms=7, color=colour, transform=axis.get_xaxis_transform(),
                    label=f"event {unit}.{name} ({len(times)})",
                )  # fmt: skip
            axis.set(xlabel="time [s]", ylabel="communication step [s]")
            if kinds:
                _legend(axis, 1)
        return svg[0]

    def others(self) -> tuple[list[str], int]:
        """What is not shown elsewhere, one diagram a unit of measure, and how many columns did not fit."""
        shown = {self.roles.driver, self.roles.motion, self.roles.tension, *(m.variable for m in self.result.margins)}
        shown |= set(columns(self.result))
        groups: dict[str, list[str]] = {}
        for name in self.result.columns:
            if name not in shown:
                groups.setdefault(self.result.units.get(name, ""), []).append(name)
        parts = [(unit, names[at : at + 6]) for unit, names in groups.items() for at in range(0, len(names), 6)]
        drawn = []
        for index, (unit, names) in enumerate(parts[:8]):
            with canvas(f"{', '.join(names)} against time", f"{self.key}-o{index}", _FULL, [2.5]) as ((axis,), svg):
                factor, shown_unit = scale(unit, max(_peak(self.result[name]) for name in names))
                for name, colour in zip(names, CYCLE, strict=False):
                    self.curve(axis, factor * self.result[name], color=colour, label=name, coarse=2)
                self.finish(axis)
                axis.set(xlabel="time [s]", ylabel=_axis_label(names, shown_unit))
            drawn.append(svg[0])
        return drawn, sum(len(names) for _, names in parts[8:])

    def curve(self, axis: Axes, values: Array, window: slice = slice(None), coarse: int = 1, **style: Any) -> None:
        """One curve over time, thinned to ``buckets / coarse`` parts; what could not be shown becomes a gap."""
        time, values = self.time[window], np.asarray(values[window], dtype=float)
        values = np.where(np.abs(values) < _PLOTTED, values, np.nan)
        picked = thin(values, self.buckets // coarse)
        axis.plot(time[picked], values[picked], marker="o" if len(time) < 3 else None, ms=4, **style)

    def finish(self, axis: Axes, legend: bool = True) -> None:
        """No blank before and after the run, the legend above it."""
        axis.margins(x=0.0 if len(self.time) > 1 else 0.05)
        if legend:
            _legend(axis, 3)

    def _last_cycles(self) -> slice | None:
        """The last ten upward zero crossings of the driver, if it has many."""
        if not self.roles.driver:
            return None
        values = self.result[self.roles.driver]
        upward = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
        return slice(int(upward[-11]), None) if len(upward) > _LONG else None


def _axis_label(names: Sequence[str], unit: str) -> str:
    """The name that all ``names`` share behind their units, if there is one, and the unit of measure."""
    leaves = {name.rpartition(".")[2] for name in names}
    return f"{leaves.pop().replace('_', ' ') if len(leaves) == 1 else ''} [{unit or '-'}]".strip()


def _legend(axis: Axes, columns: int) -> None:
    axis.legend(loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=columns, borderaxespad=0.2, handlelength=2.2)


def _peak(values: Array) -> float:
    known = np.abs(values[np.isfinite(values)], dtype=float)
    return float(known[known < _PLOTTED].max(initial=0.0))
