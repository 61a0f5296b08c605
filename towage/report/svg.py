"""Inline SVG from matplotlib: deterministic, text kept as text, curves thinned so that peaks survive."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from towage.files import atomic_write
from towage.result.result import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SETTINGS = {
    "svg.hashsalt": "towage", "svg.fonttype": "none", "text.parse_math": False, "font.size": 9, "axes.linewidth": 0.6,
    "axes.grid": True, "grid.color": "#e3e7eb", "grid.linewidth": 0.6, "axes.edgecolor": "#8a949e",
    "axes.spines.top": False, "axes.spines.right": False, "xtick.color": "#3c4650", "ytick.color": "#3c4650",
    "legend.frameon": False, "legend.fontsize": 9, "lines.linewidth": 1.3, "axes.axisbelow": True,
    "axes.labelcolor": "#1b2430", "text.color": "#1b2430", "axes.formatter.useoffset": False,
}  # fmt: skip

STANDALONE = '<svg xmlns="http://www.w3.org/2000/svg" style="font-family:sans-serif;background:#fff" '
"""In place of "<svg ": what a picture needs that stands in a file of its own."""


def thin(values: Array, buckets: int) -> Array:
    """Indices into ``values``, shape (n,), ascending: of the smallest and largest finite value in each of ``buckets`` equal
    parts, of the first gap (not finite) in each, and of both ends."""
    count = len(values)
    if count <= 2 * buckets:
        return np.arange(count)
    edges = np.linspace(0, count, buckets + 1).astype(int)
    known = np.isfinite(values)
    low, high = np.where(known, values, np.inf), np.where(known, values, -np.inf)
    picked = {0, count - 1}
    for start, stop in pairwise(edges):
        picked |= {start + int(low[start:stop].argmin()), start + int(high[start:stop].argmax())}
        if not known[start:stop].all():
            picked.add(start + int(known[start:stop].argmin()))
    return np.array(sorted(picked))


@contextmanager
def canvas(title: str, key: str, width: float, heights: Sequence[float]) -> Iterator[tuple[list[Axes], list[str]]]:
    """Axes one above the other (``heights`` in inch) to draw into; the SVG is in the list after the block. ``key`` makes
    its identifiers unique in the page."""
    import matplotlib.style
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with matplotlib.style.context(["default", _SETTINGS]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # the reader's browser has the font
        drawing = Figure(figsize=(width, sum(heights)), layout="constrained")
        FigureCanvasSVG(drawing)
        axes = drawing.subplots(len(heights), squeeze=False, height_ratios=list(heights))
        for patch in (drawing.patch, *(axis.patch for axis in axes[:, 0])):
            patch.set_visible(False)
        svg: list[str] = []
        yield list(axes[:, 0]), svg
        drawing.align_ylabels()
        drawing.get_layout_engine().execute(drawing)  # type: ignore[union-attr]
        drawing.set_layout_engine("none")  # or it would be drawn once more, to no effect
        svg.append(_inline(drawing, title, key))


def save_figure(figure: Figure, path: Path) -> None:
    """Writes a figure, by the ending of ``path`` (.svg, .png or .pdf), with the same bytes every time. Raises
    `TowageError` where it cannot be written."""
    import matplotlib

    kind = path.suffix.lstrip(".").lower() or "svg"
    date = {"svg": "Date", "pdf": "CreationDate"}.get(kind)
    with atomic_write(path) as stream, matplotlib.rc_context({"svg.hashsalt": "towage"}):
        figure.savefig(stream, format=kind, metadata={date: None} if date else None)


def _inline(drawing: Figure, title: str, key: str) -> str:
    """SVG element for HTML: no prologue, links or unused identifiers, coordinates to 0.01 pt."""
    buffer = io.StringIO()
    drawing.savefig(buffer, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>|<!--.*?-->", "", svg, flags=re.DOTALL)
    svg = re.sub(r' (xmlns(:\w+)?|version)="[^"]*"', "", svg).replace("xlink:href", "href")
    svg = re.sub(r"<svg[^>]*?(viewBox=\"[^\"]*\")[^>]*>", rf'<svg \1 role="img" aria-label="{escape(title)}">', svg, count=1)
    used = set(re.findall(r'(?:url\(|href=")#([^")]+)', svg))
    svg = re.sub(r' id="([^"]*)"', lambda attribute: f' id="{key}-{attribute[1]}"' if attribute[1] in used else "", svg)
    svg = re.sub(r'(url\(|href=")#', rf"\1#{key}-", svg)
    svg = re.sub(r' transform="rotate\(-0 [^"]*"|font-family: [^;"]*;? ?|<defs>\s*</defs>', "", svg)
    svg = re.sub(r' (?:d|x|y)="[^"]*"', _shorter, svg)
    return re.sub(r"\n\s*", "\n", _without_plain_groups(svg)).strip()


def _shorter(attribute: re.Match[str]) -> str:
    """Coordinates rounded; the "L" left out where it is implied."""
    text = re.sub(r"-?\d+\.\d+", lambda value: f"{float(value[0]):.2f}".rstrip("0").rstrip("."), attribute[0])
    text = text.replace("\n", "").replace(' "', '"')
    return text if "C" in text or "Q" in text else text.replace(" L ", " ")


def _without_plain_groups(svg: str) -> str:
    """Groups without attributes or content have no effect."""
    plain: list[bool] = []

    def keep(tag: re.Match[str]) -> str:
        """The tag, or nothing where its group is plain."""
        if tag[0].endswith("/>"):
            return ""
        if tag[0] != "</g>":
            plain.append(tag[0] == "<g>")
            return "" if plain[-1] else tag[0]
        return "" if plain.pop() else tag[0]

    return re.sub(r"<g(?: [^>]*)?>|</g>", keep, svg)
