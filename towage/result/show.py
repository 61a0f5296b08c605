"""A result in a notebook: a figure of its columns, and HTML with the verdict and that figure as inline SVG."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from html import escape
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Series = Mapping[str, NDArray[Any]]
WIDTH, HEIGHT = 8.0, 2.2
"""Size of a panel, inches."""
COLOURS = {"valid": "#0a6b3d", "marginal": "#7a4b00", "invalid": "#a3121d", "failed": "#a3121d"}


def usual(names: Iterable[str]) -> list[str]:
    """The columns that are shown unless others are asked for: neither margins nor rates nor event indicators."""
    return [
        name for name in names
        if not name.partition(".")[2].startswith(("margin_", "event_")) and not name.endswith("_rate")
    ]  # fmt: skip


def figure(time: NDArray[Any], columns: Series, one_way: Series, units: Mapping[str, str]) -> Figure:
    """Columns, shape (n,), over time (s), one panel a unit of measure; ``one_way`` dashed in the same colour."""
    from matplotlib.figure import Figure

    panels: dict[str, list[str]] = {}
    for name in columns:
        panels.setdefault(units.get(name, ""), []).append(name)
    drawn = Figure(figsize=(WIDTH, HEIGHT * max(1, len(panels))), layout="constrained")
    axes = drawn.subplots(max(1, len(panels)), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (unit, names) in zip(axes, panels.items()):
        for name in names:
            (line,) = axis.plot(time, columns[name], linewidth=1.0, label=name)
            if name in one_way:
                axis.plot(time[: len(one_way[name])], one_way[name], "--", linewidth=0.8, color=line.get_color())
        axis.set_ylabel(unit or "-")
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
    axes[-1].set_xlabel("time, s")
    return drawn


def html(about: Mapping[str, str], drawn: Figure | None) -> str:
    """The verdict in words, and the figure as inline SVG, the same text for the same figure."""
    word = about["verdict"]
    name = ", ".join(about[key] for key in ("title", "case") if about[key])
    reason = f" {escape(about['reason'])}" if about["reason"] else ""
    colour = COLOURS.get(word, "#45505c")
    head = f'<p><strong>{escape(name)}</strong>: <strong style="color:{colour}">{escape(word)}</strong>{reason}</p>'
    return f"<div>{head}{_svg(drawn) if drawn else ''}</div>"


def _svg(drawn: Figure) -> str:
    import matplotlib

    stream = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "towage", "svg.fonttype": "none"}):
        drawn.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]
