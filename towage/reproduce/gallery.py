"""What was reproduced, as text for a terminal, as a page of the documentation, as files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from towage.frequency_response.response import save_rows
from towage.reproduce.items import METHODS, REPORTS, Item, Reproduction, Row, items, written


def _said(row: Row) -> str:
    return "agrees" if row.agrees else row.printed.register or "differs, and no row of the register says why"


def _beside(row: Row) -> tuple[str, str, str, str]:
    unit = f" {row.printed.unit}" if row.printed.unit else ""
    return row.printed.what, f"{row.printed.text}{unit}", f"{written(row.computed)}{unit}", f"{row.difference:.1e}"


def _methods(found: Reproduction) -> str:
    if not found.answer or found.answer.methods is None:
        return ""
    return f"{found.answer.by} differ by {found.answer.methods:.1e} of the largest value at most (limit {METHODS:g})."


def text(found: Reproduction) -> str:
    """For a terminal: printed, computed and difference of every number."""
    item = found.item
    lines = [f"{item.full_name}: {item.title} ({item.place})", f"  {found.word}" + (f": {item.missing}" if item.missing else "")]
    cells = [_beside(row) for row in found.rows]
    widths = [max(len(c[k]) for c in cells) for k in range(4)] if cells else []
    for row, beside in zip(found.rows, cells):
        lines.append("  " + "  ".join(cell.ljust(width) for cell, width in zip(beside, widths)) + f"  {_said(row)}")
    lines += [f"  {said}" for said in (_methods(found), found.answer.note if found.answer else "") if said]
    return "\n".join(lines + [f"  WRONG: {fault}" for fault in found.faults])


def document(found: Reproduction) -> dict[str, Any]:
    """As plain data."""
    rows = [
        {"what": r.printed.what, "printed": r.printed.text, "unit": r.printed.unit, "agrees": r.agrees,
         "computed": [r.computed.real, r.computed.imag], "register": r.printed.register} for r in found.rows
    ]  # fmt: skip
    return {
        "name": found.item.full_name, "place": found.item.place, "title": found.item.title, "word": found.word,
        "missing": found.item.missing, "numbers": rows, "methods": found.answer and found.answer.methods, "faults": found.faults,
    }  # fmt: skip


def write_files(found: Reproduction, directory: Path) -> list[Path]:
    """``<report>.<item>.csv``, and ``.svg`` of a figure. Raises `TowageError` where one cannot be written."""
    files: list[Path] = []
    if found.answer and found.answer.columns:
        files.append(directory / f"{found.item.full_name}.csv")
        columns = found.answer.columns
        save_rows(files[-1], [dict(zip(columns, row)) for row in zip(*columns.values(), strict=True)])
    if found.answer and found.answer.draw:
        files.append(directory / f"{found.item.full_name}.svg")
        found.answer.draw(files[-1])
    return files


def page(report: str, found: Sequence[Reproduction]) -> str:
    """The page of a report, Markdown, whose files lie beside it."""
    lines = [f"# {REPORTS[report]}", "", _summary(found), "", "| table or figure | what | here |", "|---|---|---|"]
    lines += [f"| [{f.item.place}](#{_anchor(f.item)}) | {f.item.title} | {f.word} |" for f in found]
    for f in found:
        lines += ["", f"## {f.item.place}: {f.item.title} {{ #{_anchor(f.item)} }}", ""]
        if f.item.missing:
            lines += [f"**{f.word}**: {f.item.missing}."]
        elif f.item.explains:
            lines += [f"**{f.word}**: no result is in it."]
        else:
            lines += [f"**{f.word}** by `towage reproduce {f.item.full_name}`", *_body(f)]
    return "\n".join(lines) + "\n"


def _body(found: Reproduction) -> list[str]:
    lines = []
    answer, name = found.answer, found.item.full_name
    if found.rows:
        lines += ["", "| | printed | computed | difference | |", "|---|---|---|---|---|"]
        lines += ["| " + " | ".join(_beside(row)) + f" | {_said(row)} |" for row in found.rows]
    if answer and answer.draw:
        lines += ["", f"![{found.item.title}]({name}.svg)"]
    links = f"Numbers: [{name}.csv]({name}.csv)." if answer and answer.columns else ""
    said = [part for part in (_methods(found), answer.note if answer else "", links) if part]
    return [*lines, "", " ".join(said)] if said else lines


def _anchor(item: Item) -> str:
    return item.name.replace("_", "-")


def _summary(found: Sequence[Reproduction]) -> str:
    words = Counter(f.word for f in found)
    rows = [row for f in found for row in f.rows]
    agree = sum(row.agrees for row in rows)
    counted = ", ".join(f"{count} {word}" for word, count in words.items())
    return f"{len(found)} tables and figures: {counted}. Of {len(rows)} printed numbers {agree} agree to their printed digits."


def index(found: dict[str, list[Reproduction]]) -> str:
    """The page of all reports."""
    lines = ["# The four reports", "", "Every table and figure of the source reports, by a command, beside what is printed.", ""]
    lines += ["| report | |", "|---|---|"]
    lines += [f"| [{REPORTS[report]}]({report}.md) | {_summary(of)} |" for report, of in found.items()]
    return "\n".join(lines) + "\n"


def known(report: str) -> str:
    """A line an item, of a report, without computing it."""
    return "\n".join(f"  {item.full_name:28} {item.place}: {item.title}" for item in items(report))
