"""A unit as a block: what goes in on the left, what comes out on the right (SVG)."""

from __future__ import annotations

from html import escape

from ..declare.unit import Unit

ROW, HEAD, WIDTH, EDGE = 22, 34, 620, 210
"""Pixels: height of a row and of the title, width of the drawing and of the space beside the block."""


def block(unit: Unit) -> str:
    """Inputs and outputs without margins; an input that must be connected or set is drawn full."""
    outputs = [v for v in unit.observed if v.causality == "output" and not v.name.rpartition(".")[2].startswith("margin_")]
    rows = max(len(unit.inputs), len(outputs), 1)
    height = HEAD + ROW * rows + 10
    needed = {v.name for v in unit.inputs if v.needed}
    drawn = "".join(
        _port(left, HEAD + ROW * k + ROW / 2, f"{v.name} [{v.unit}]", v.name in needed or not left)
        for left, ports in ((True, unit.inputs), (False, outputs)) for k, v in enumerate(ports)
    )  # fmt: skip
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {height}' width='{WIDTH}' role='img' "
        f"aria-label='Inputs and outputs of {escape(unit.name)}' font-family='system-ui,sans-serif' font-size='13'>"
        f"<rect x='{EDGE}' y='2' width='{WIDTH - 2 * EDGE}' height='{height - 4}' rx='4' fill='#eef3f8' stroke='#345'/>"
        f"<text x='{WIDTH / 2}' y='22' text-anchor='middle' font-weight='600'>{escape(unit.name)}</text>{drawn}</svg>"
    )


def _port(left: bool, y: float, text: str, full: bool) -> str:
    """An arrow at the edge of the block with its text outside."""
    edge, out = (EDGE, EDGE - 12) if left else (WIDTH - EDGE, WIDTH - EDGE + 12)
    tip, back = (edge, out) if left else (out, edge)
    anchor, x = ("end", out - 5) if left else ("start", out + 5)
    fill = "#345" if full else "#fff"
    return (
        f"<path d='M{back} {y - 5}L{tip} {y}L{back} {y + 5}Z' fill='{fill}' stroke='#345'/>"
        f"<text x='{x}' y='{y + 4}' text-anchor='{anchor}'>{escape(text)}</text>"
    )
