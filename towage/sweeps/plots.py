"""The diagrams of a sweep's report: curves over one parameter, maps over two, points over more, and operability."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from towage.report.format import scale
from towage.report.plots import BLUE, CYCLE, GREEN, GREY, RED
from towage.report.svg import canvas, thin
from towage.sweeps.attractor import APERIODIC, LONGEST
from towage.sweeps.table import Array, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH = 9.6
_POINTS = 4000
"""Points drawn of a larger sequence, the first: a Sobol sequence is as even from its beginning."""
_STEPS = 800
"""Of a curve with more runs."""


class Quantity(NamedTuple):
    """A measure to draw: its name, what to call it, and a limit in its own unit (None: none), an upper or a lower one."""

    name: str
    label: str
    limit: float | None = None
    upper: bool = True


def over_one(table: Table, quantities: list[Quantity], key: str) -> str:
    """Measures over the one parameter that is varied; the limit dashed, runs that were not done as ticks below."""
    order = np.argsort(table.design.points[:, 0], kind="stable")
    x = table.design.points[order, 0]
    lost = x[~table.done[order]]
    lost = lost[:: len(lost) // _STEPS + 1]
    with canvas("Measures over the parameter", key, _WIDTH, [2.4] * len(quantities)) as (axes, svg):
        for axis, quantity in zip(axes, quantities):
            factor, label = _scaled(table, quantity)
            values = table.measures[quantity.name][order] * factor
            drawn = thin(values, _STEPS)
            axis.plot(x[drawn], values[drawn], color=BLUE, marker="o" if len(x) < 60 else "", ms=3)
            if quantity.limit is not None:
                axis.axhline(quantity.limit * factor, color=RED, ls="--", lw=1.0)
            if len(lost):
                axis.plot(lost, np.zeros_like(lost), "x", color=GREY, ms=5, transform=axis.get_xaxis_transform(),
                          clip_on=False, label="not done")  # fmt: skip
                axis.legend(loc="best")
            axis.set_ylabel(label)
        axes[-1].set_xlabel(_target(table, 0))
    return svg[0]


def over_two(table: Table, quantity: Quantity, key: str) -> str:
    """A measure over two parameters: cells of a grid, with the limit as a white contour, or points of a sequence."""
    factor, label = _scaled(table, quantity)
    values = table.measures[quantity.name] * factor
    with canvas(f"{quantity.label} over two parameters", key, _WIDTH, [4.4]) as ((axis,), svg):
        drawn = _cells(axis, table, values, cmap="viridis")
        bar = axis.figure.colorbar(drawn, ax=axis, label=label)
        if quantity.limit is not None:
            bar.ax.axhline(quantity.limit * factor, color="white", lw=1.5)
            if table.design.shape and min(table.design.shape) > 1:
                _contour(axis, table, values, quantity.limit * factor)
        _finish(axis, table)
    return svg[0]


def attractor_map(table: Table, key: str) -> str:
    """Periods after which the motion repeats, over two parameters."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    values = table.measures["attractor"].copy()
    values[values == APERIODIC] = LONGEST + 1.0
    colors = ListedColormap([*CYCLE[:7], "#cccccc", "#000000"])
    norm = BoundaryNorm(np.arange(0.5, LONGEST + 2.0), LONGEST + 1)
    with canvas("Attractors over two parameters", key, _WIDTH, [4.4]) as ((axis,), svg):
        drawn = _cells(axis, table, values, cmap=colors, norm=norm)
        bar = axis.figure.colorbar(drawn, ax=axis, ticks=range(1, LONGEST + 2))
        bar.ax.set_yticklabels([*map(str, range(1, LONGEST + 1)), "none"])
        bar.set_label("periods after which the motion repeats")
        _finish(axis, table)
    return svg[0]


def over_many(table: Table, quantity: Quantity, key: str) -> str:
    """A measure over each of the parameters, one panel each: the spread is what the others do."""
    factor, label = _scaled(table, quantity)
    values = table.measures[quantity.name][:_POINTS] * factor
    count = len(table.design.targets)
    with canvas(f"{quantity.label} over each parameter", key, _WIDTH, [2.2] * count) as (axes, svg):
        for column, axis in enumerate(axes):
            axis.plot(table.design.points[:_POINTS, column], values, ".", color=BLUE, ms=3)
            if quantity.limit is not None:
                axis.axhline(quantity.limit * factor, color=RED, ls="--", lw=1.0)
            axis.set_xlabel(_target(table, column))
            axis.set_ylabel(label)
    return svg[0]


def operability(table: Table, quantity: Quantity, key: str) -> str:
    """Share of the runs done in which the measure stays under a value (over it, for a lower limit), over that value; the limit
    dashed."""
    factor, label = _scaled(table, quantity)
    known = table.measures[quantity.name][table.done] * factor
    ordered = np.sort(known[np.isfinite(known)])
    count = max(len(ordered), 1)
    shares = (np.arange(1, len(ordered) + 1) if quantity.upper else np.arange(len(ordered), 0, -1)) / count
    kept = np.unique(np.linspace(0, len(ordered) - 1, min(len(ordered), _STEPS)).astype(int))
    with canvas(f"Operability: {quantity.label}", key, _WIDTH, [2.8]) as ((axis,), svg):
        axis.step(ordered[kept], 100.0 * shares[kept], where="post" if quantity.upper else "pre",
                  color=GREEN)  # fmt: skip
        if quantity.limit is not None:
            axis.axvline(quantity.limit * factor, color=RED, ls="--", lw=1.0)
        axis.set(
            xlabel=label, ylabel=f"share of runs {'under' if quantity.upper else 'over'} it [%]", ylim=(0.0, 102.0)
        )
    return svg[0]


def _cells(axis: Axes, table: Table, values: Array, **look: Any) -> Any:
    design = table.design
    if design.shape:
        return axis.pcolormesh(
            *_axes(table), values.reshape(design.shape).T, shading="nearest", rasterized=True, **look
        )
    points, shown = design.points[:_POINTS], values[:_POINTS]
    lost = ~np.isfinite(shown)
    axis.plot(points[lost, 0], points[lost, 1], "x", color=GREY, ms=4)
    return axis.scatter(points[~lost, 0], points[~lost, 1], c=shown[~lost], s=9, **look)


def _contour(axis: Axes, table: Table, values: Array, limit: float) -> None:
    known = values[np.isfinite(values)]
    if len(known) and known.min() < limit < known.max():
        axis.contour(*_axes(table), values.reshape(table.design.shape).T, levels=[limit], colors="white")


def _axes(table: Table) -> tuple[Array, Array]:
    """The values along both targets of a grid."""
    first, second = table.design.shape
    return table.design.points[::second, 0][:first], table.design.points[:second, 1]


def _finish(axis: Axes, table: Table) -> None:
    axis.grid(False)
    axis.set(xlabel=_target(table, 0), ylabel=_target(table, 1))


def _target(table: Table, column: int) -> str:
    return f"{table.design.targets[column]} [{table.design.units[column] or '-'}]"


def _scaled(table: Table, quantity: Quantity) -> tuple[float, str]:
    """(factor, label with unit) in which a measure reads well."""
    values = table.measures[quantity.name]
    known = np.abs(values[np.isfinite(values)])
    factor, unit = scale(table.units[quantity.name], float(known.max(initial=0.0)))
    return factor, f"{quantity.label} [{unit}]" if unit not in ("", "1") else quantity.label
