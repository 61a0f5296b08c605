"""Numbers, tables and the style sheet of a report: HTML without scripts, for light, dark and paper."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape

_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))
_PREFIXED = ("N", "Pa", "W", "J", "N.m", "N/m")
"""Units that are shown with a decimal prefix from 10 000 on."""


class Markup(str):
    """HTML that is not escaped again."""

    __slots__ = ()


def number(value: float | None, digits: int = 3) -> str:
    """``value`` with ``digits`` significant digits, no exponent between 1e-3 and 1e6; a dash for None and NaN."""
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "−∞" if value < 0.0 else "∞"
    if value == 0.0:
        return "0"
    if 10.0**digits <= abs(value) < 1e6:
        return f"{value:.0f}".replace("-", "−")
    text = f"{value:.{digits}g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        text = f"{mantissa}e{int(exponent)}"
    return text.replace("-", "−")


def percent(value: float | None, digits: int = 3) -> str:
    """A relative number, 1 for 100 %, in percent; a dash for None and NaN."""
    return "–" if value is None or math.isnan(value) else f"{number(100.0 * value, digits)} %"


def scale(unit: str, peak: float) -> tuple[float, str]:
    """(factor, unit): values in ``unit`` up to ``peak`` are shown times the factor in that unit, 37 000 N as 37 kN."""
    if unit in _PREFIXED and math.isfinite(peak) and abs(peak) >= 1e4:
        for size, prefix in _PREFIXES:
            if abs(peak) >= size:
                return 1.0 / size, prefix + unit
    return 1.0, unit


def quantity(value: float | None, unit: str, digits: int = 3) -> str:
    """A value with its unit of measure, prefixed where that reads better."""
    if value is None or math.isnan(value):
        return "–"
    factor, shown = scale(unit, value)
    return f"{number(factor * value, digits)} {shown}".rstrip()


def moment(time: float | None) -> str:
    """A time of the run, s; a dash for None and NaN."""
    return "–" if time is None or math.isnan(time) else f"{number(time, 4)} s"


def text(value: object) -> str:
    """``value`` escaped, unless it is markup already."""
    return value if isinstance(value, Markup) else escape(str(value))


def badge(word: str) -> Markup:
    """A verdict or level as a coloured word; a sign tells the colours apart without colour."""
    kinds = {
        "valid": ("good", "✓"), "ok": ("good", "✓"),
        "marginal": ("fair", "!"), "warning": ("fair", "!"),
        "invalid": ("bad", "✕"), "refused": ("bad", "✕"), "failed": ("bad", "✕"),
    }  # fmt: skip
    kind, sign = kinds.get(word, ("plain", "i" if word == "info" else "?"))
    return Markup(f'<span class="badge {kind}"><span aria-hidden="true">{sign}</span> {escape(word)}</span>')


def table(head: Sequence[str], rows: Iterable[Sequence[object]], numeric: Sequence[int] = ()) -> Markup:
    """An HTML table; ``numeric`` are the columns set right-aligned. Cells are escaped unless they are `Markup`."""
    side = [' class="num"' if column in numeric else "" for column in range(len(head))]

    def cells(tag: str, values: Sequence[object]) -> str:
        """One row."""
        return "".join(f"<{tag}{kind}>{text(value)}</{tag}>" for kind, value in zip(side, values, strict=True))

    body = "".join(f"<tr>{cells('td', row)}</tr>\n" for row in rows)
    return Markup(
        f'<div class="scroll"><table><thead><tr>{cells("th", head)}</tr></thead>\n<tbody>{body}</tbody></table></div>'
    )


def details(title: str, content: str, shown: bool = False) -> Markup:
    """A part that can be folded away; printed in full."""
    return Markup(f"<details{' open' if shown else ''}><summary>{escape(title)}</summary>\n{content}</details>\n")


def figure(svg: str, title: str, caption: str, half: bool = False) -> Markup:
    """A diagram on its card; without a title or caption if that is empty."""
    kind = ' class="half"' if half else ""
    head = f"<h3>{escape(title)}</h3>" if title else ""
    foot = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return Markup(f'<figure{kind}>{head}<div class="scroll">{svg}</div>{foot}</figure>\n')


def page(title: str, subtitle: str, body: str, kind: str = "") -> str:
    """A whole page. ``kind`` follows the title in the browser's tab."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="generator" content="towage">\n'
        f"<title>{escape(title)}{kind and f': {kind}'}</title>\n<style>{STYLE}</style></head>\n<body><main>\n"
        f'<header><h1>{escape(title)}</h1><p class="title">{escape(subtitle)}</p></header>\n{body}</main></body></html>\n'
    )


STYLE = """
:root { color-scheme: light dark; --ink: #1b2430; --soft: #566373; --line: #d5dce4; --page: #f4f6f8; --sheet: #fff;
  --accent: #0b5c8a; --good: #0a6b3d; --good-bg: #dcf3e6; --fair: #7a4b00; --fair-bg: #fdecc8; --bad: #a3121d;
  --bad-bg: #fde1e1; --plain: #45505c; --plain-bg: #e6eaee; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e9ee; --soft: #a3afbb; --line: #37424e; --page: #12181f;
  --sheet: #1b232c; --accent: #7cc3ee; --good: #8fe0b5; --good-bg: #11402a; --fair: #f6cf87; --fair-bg: #4a3507;
  --bad: #ffb0b0; --bad-bg: #551a1f; --plain: #c5ced7; --plain-bg: #36414c; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, -apple-system, "Segoe UI",
  Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 2rem 1.25rem 4rem; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 .25rem; }
h2 { font-size: 1.3rem; margin: 0; }
h3 { font-size: 1rem; margin: 0 0 .35rem; }
p { margin: .35rem 0; }
a { color: var(--accent); }
.soft, figcaption, .note { color: var(--soft); font-size: .9rem; }
section { background: var(--sheet); border: 1px solid var(--line); border-radius: 10px; padding: 1.25rem;
  margin-top: 1.5rem; }
section > h3 { margin-top: 1.5rem; }
header .title { color: var(--soft); margin: 0; }
.headline { display: flex; flex-wrap: wrap; gap: .4rem .8rem; align-items: center; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: .75rem; margin: 1rem 0; }
.facts div { border-left: 3px solid var(--line); padding-left: .7rem; }
.facts dt { color: var(--soft); font-size: .82rem; }
.facts dd { margin: 0; font-size: 1.15rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.facts small { display: block; font-size: .8rem; font-weight: 400; color: var(--soft); overflow-wrap: anywhere; }
.badge { display: inline-block; border-radius: 999px; padding: .08rem .65rem; font-weight: 600; font-size: .9rem;
  white-space: nowrap; }
.good { color: var(--good); background: var(--good-bg); }
.fair { color: var(--fair); background: var(--fair-bg); }
.bad { color: var(--bad); background: var(--bad-bg); }
.plain { color: var(--plain); background: var(--plain-bg); }
.failure { border: 1px solid var(--bad); background: var(--bad-bg); color: var(--bad); border-radius: 8px;
  padding: .7rem 1rem; margin: 1rem 0; overflow-wrap: anywhere; white-space: pre-wrap; }
.figures { display: grid; grid-template-columns: 1fr 1fr; gap: 0 1.5rem; }
figure { margin: 1.25rem 0 0; grid-column: 1 / -1; min-width: 0; break-inside: avoid; }
figure.half { grid-column: auto; }
figure .scroll { background: #fff; border: 1px solid var(--line); border-radius: 8px; padding: .4rem; }
figure svg { display: block; width: 100%; height: auto; min-width: 560px; }
figure.half svg { min-width: 340px; }
svg text { font-family: system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif !important; }
figcaption { margin-top: .35rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .92rem; margin: .5rem 0; }
th { text-align: left; font-weight: 600; color: var(--soft); border-bottom: 2px solid var(--line); }
th, td { padding: .35rem 1.5rem .35rem 0; vertical-align: top; overflow-wrap: break-word; }
#verdicts table { width: 100%; }
#verdicts th, #verdicts td { padding-right: .9rem; }
td { border-bottom: 1px solid var(--line); font-variant-numeric: tabular-nums; }
.num { text-align: right; white-space: nowrap; }
td small { display: block; color: var(--soft); }
details { margin-top: 1rem; border-top: 1px solid var(--line); padding-top: .6rem; }
summary { cursor: pointer; font-weight: 600; }
pre { overflow-x: auto; font: .82rem/1.45 ui-monospace, SFMono-Regular, Consolas, monospace; background: var(--page);
  border: 1px solid var(--line); border-radius: 8px; padding: 1rem; }
@media (max-width: 720px) { .figures { grid-template-columns: 1fr; } main { padding: 1rem .6rem; }
  section { padding: .9rem; } }
@media print { :root { --page: #fff; --sheet: #fff; --ink: #000; --line: #bbb; --soft: #333; } body { font-size: 10pt; }
  section { border: 0; padding: 0; } main { max-width: none; padding: 0; } pre { white-space: pre-wrap; }
  figure svg, figure.half svg { min-width: 0; } tr, .facts { break-inside: avoid; }
  h2, h3 { break-after: avoid; } details::details-content { content-visibility: visible; } }
"""
