"""Pictures of what is computed: curves over one quantity, points of several kinds, shapes over a period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from towage.files import atomic_write
from towage.report.plots import CYCLE
from towage.report.svg import STANDALONE, canvas
from towage.reproduce.items import Column

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
SIZE = 7.2, 3.8
"""Width and height, inch."""
PHASES = 8
MARKS = "o^vsDx"


def curves(
    path: Path, *, title: str, across: str, up: str, columns: Mapping[str, Column], log: tuple[bool, bool] = (False, False)
) -> None:
    """The first column along the axis, the others over it."""
    first, *others = columns
    data = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
    with canvas(title, path.stem, SIZE[0], [SIZE[1]]) as ((axes,), drawn):
        for k, name in enumerate(others):
            axes.plot(data[first], data[name], color=CYCLE[k % len(CYCLE)], label=name, ls="-" if k < len(CYCLE) else "--")
        _dress(axes, title, across, up, log, len(others) > 1)
    _write(path, drawn)


def points(
    path: Path, *, title: str, across: str, up: str, series: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    log: tuple[bool, bool] = (False, False),
) -> None:
    """A mark a point, another for each of ``series``."""
    with canvas(title, path.stem, SIZE[0], [SIZE[1]]) as ((axes,), drawn):
        for k, (name, (x, y)) in enumerate(series.items()):
            axes.plot(x, y, MARKS[k % len(MARKS)], ms=3.5, color=CYCLE[k % len(CYCLE)], label=name)
        _dress(axes, title, across, up, log, True)
    _write(path, drawn)


def loops(path: Path, *, title: str, across: str, up: str, series: Mapping[str, tuple[Array, Array]]) -> None:
    """Closed curves, both axes of one scale."""
    with canvas(title, path.stem, SIZE[0], [1.4 * SIZE[1]]) as ((axes,), drawn):
        for k, (name, (x, y)) in enumerate(series.items()):
            axes.plot(x, y, color=CYCLE[k % len(CYCLE)], label=name)
        axes.plot(0.0, 0.0, "k+")
        axes.set_aspect("equal")
        _dress(axes, title, across, up, (False, False), True)
    _write(path, drawn)


def shapes(path: Path, *, title: str, across: str, x: Array, modes: Mapping[str, NDArray[np.complex128]]) -> None:
    """Complex shapes over ``x``, a panel each, at `PHASES` phases of a period, the first one drawn strongly."""
    with canvas(title, path.stem, SIZE[0], [1.3] * len(modes)) as (panels, drawn):
        for axes, (name, y) in zip(panels, modes.items()):
            for k in range(PHASES):
                turned = (y * np.exp(2j * np.pi * k / PHASES)).real
                axes.plot(x, turned, color=CYCLE[0], lw=1.6 if k == 0 else 0.7, alpha=1.0 if k == 0 else 0.45)
            axes.set_ylabel(name, fontsize=7)
        panels[0].set_title(title)
        panels[-1].set_xlabel(across)
    _write(path, drawn)


def _dress(axes: Axes, title: str, across: str, up: str, log: tuple[bool, bool], legend: bool) -> None:
    axes.set(title=title, xlabel=across, ylabel=up)
    for axis, scale, logarithmic in ((axes.xaxis, axes.set_xscale, log[0]), (axes.yaxis, axes.set_yscale, log[1])):
        if logarithmic:
            scale("log")
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter("")
    if legend:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _write(path: Path, drawn: list[str]) -> None:
    with atomic_write(path) as stream:
        stream.write(drawn[0].replace("<svg ", STANDALONE, 1).encode())
