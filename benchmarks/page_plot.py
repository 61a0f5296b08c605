"""Diagrams of error over cost for the page of benchmarks: one SVG a benchmark, one panel a table."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from page_tables import Series

SETTINGS = {"svg.hashsalt": "towage", "svg.fonttype": "none", "font.size": 9}
WIDTH, HEIGHT = 9.6, 3.4
"""Inch, of a row of two panels."""
MARKERS = "os^Dv<>Pphd*X"


def draw(panels: list[tuple[str, Series]], path: Path) -> None:
    """Writes the panels to ``path``; methods have one colour in all of them."""
    methods = list(dict.fromkeys(method for _, series in panels for method in series))
    rows = (len(panels) + 1) // 2
    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(WIDTH, HEIGHT * rows), layout="constrained")
        FigureCanvasSVG(figure)
        for index, (title, series) in enumerate(panels):
            axis = figure.add_subplot(rows, min(2, len(panels)), index + 1)
            for method, points in series.items():
                style = methods.index(method)
                cost, error = zip(*points)
                # a method refined in one direction makes a curve; variants of a method are points
                line = "-" if list(error) == sorted(error, reverse=True) else ""
                axis.loglog(
                    cost, error, color=f"C{style % 10}", marker=MARKERS[style % len(MARKERS)], ms=4, lw=0.9, ls=line, label=method
                )
            axis.set(title=title, xlabel="cost", ylabel="error")
            axis.xaxis.set_major_formatter(_plain)
            axis.xaxis.set_minor_formatter(NullFormatter())
            axis.grid(True, color="#e3e7eb", lw=0.6)
            axis.legend(fontsize=7, frameon=False)
        figure.savefig(path, format="svg", metadata={"Date": None, "Creator": "towage"})


def _plain(value: float, _: int) -> str:
    """Costs without exponents."""
    return f"{value:g}"
