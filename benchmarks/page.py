"""The page of ``docs/benchmarks.json``: tables, diagrams of error over cost, ratios beside the last ones. ``make docs``.

What the columns of a benchmark's tables mean is said once, in `BENCHMARKS`.
"""

from __future__ import annotations

import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from page_plot import draw
from page_tables import Column, Curves, Ratio, curves, ratios, tables

ROOT = Path(__file__).resolve().parents[1]
FALLEN = 1.5
"""Ratios of one machine differ by a third from run to run when it is loaded; what is more than this is looked into."""
RED = "#b00020"


@dataclass(frozen=True)
class Benchmark:
    """A program of this directory that prints Markdown; with ``quick``, its arguments, it is part of a quick run."""

    name: str
    title: str
    columns: tuple[Column, ...]
    curves: tuple[Curves, ...] = ()
    quick: tuple[str, ...] | None = None


MOORDYN = Column("^MoorDyn .* over it$", "more")
BENCHMARKS = (
    Benchmark(
        "coupling", "Coupling, beside libcosim",
        (Column("^over raw FMI", "less"), Column("^us$", "more", over="libcosim")), (Curves("^cost", r"^\d+ steps$"),),
        ("step",),
    ),
    Benchmark("cable", "Tow cable, beside MoorDyn", (MOORDYN,), (Curves("^(CPU )?ms per", "^error"),)),
    Benchmark("wire", "The nonlinear wire, beside MoorDyn", (MOORDYN,), (Curves("^ms a", "^error of the pull"),)),
    Benchmark(
        "native", "Native units",
        (Column("^over (Python|bare)", "less"), MOORDYN, Column("^ratio$", "more")), (Curves("^(CPU )?ms per", "^error"),),
        ("cradle",),
    ),
    Benchmark("card", "The verdict", (Column("over the coupled run$", "less"),)),
    Benchmark("ensemble", "Ensembles", (Column("times faster$", "more"),)),
    Benchmark("native_scene", "A scene as one FMU", (Column("^times faster", "more"),), (Curves("^CPU ms", "^error"),)),
    Benchmark(
        "slender_body", "Slender body, beside scipy's integrators", (Column("^s$", "more", over="RK45"),),
        (Curves("^ms a speed", "^u = 4$"), Curves("^s$", "^error$")),
    ),
    Benchmark(
        "route", "Routes, beside weatherrouting", (Column("^CPU s", "more", over="weatherrouting"),),
        (Curves("^CPU s", "error h$"),),
    ),
)  # fmt: skip


def write_page(document: dict[str, Any], out: Path) -> Path:
    """Writes ``benchmarks.md`` and its diagrams into ``out``; returns the page's path."""
    sections = []
    for benchmark in BENCHMARKS:
        if benchmark.name not in document["texts"]:
            continue
        text = "\n".join(document["texts"][benchmark.name])
        printed, diagram = tables(text), ""
        if panels := [panel for wanted in benchmark.curves for panel in curves(printed, wanted)]:
            draw(panels, out / f"benchmarks_{benchmark.name}.svg")
            diagram = f"![error over cost](benchmarks_{benchmark.name}.svg)\n\n"
        sections.append(f"## {benchmark.title}\n\n`python benchmarks/{benchmark.name}.py`\n\n{diagram}{below(text)}")
    page = out / "benchmarks.md"
    last = document["last"]
    page.write_text("\n\n".join([front(document), *sections, comparison(ratios_of(document), last)]) + "\n", encoding="utf-8")
    return page


def ratios_of(document: dict[str, Any]) -> dict[str, Ratio]:
    """The ratios in what the benchmarks printed, by ``benchmark: heading / row / column``."""
    return {
        f"{benchmark.name}: {key}": ratio
        for benchmark in BENCHMARKS
        if benchmark.name in document["texts"]
        for key, ratio in ratios(tables("\n".join(document["texts"][benchmark.name])), benchmark.columns).items()
    }


def fallen(now: dict[str, Ratio], last: dict[str, Any] | None) -> dict[str, float]:
    """Gain, below 1/1.5, of the ratios that are so much worse than the last; the worst first."""
    before = last["ratios"] if last else {}
    gains = {key: ratio.gain(before[key]) for key, ratio in now.items() if key in before}
    return {key: gain for key, gain in sorted(gains.items(), key=lambda item: item[1]) if gain < 1.0 / FALLEN}


def front(document: dict[str, Any]) -> str:
    """How to read the page, and where the numbers were measured."""
    load = "" if document["load"] is None else f", load {document['load']} at the start"
    versions = ", ".join(f"{name} {version}" for name, version in document["versions"].items())
    last = document["last"]
    text = (
        "# Benchmarks\n\nMeasured by `make bench`, drawn from [benchmarks.json](benchmarks.json) by `make docs`; numbers are "
        "not edited by hand. Times on a shared machine mean little by themselves: read the ratios, which are taken in one "
        "run, peers (MoorDyn, libcosim, scipy, weatherrouting) included, and [compared](#ratios) with the last run.\n\n"
        f"{document['date']}, {document['cpu']}{load}, {document['system']}. {versions}."
    )
    other = last and last["cpu"] != document["cpu"]
    return text + (f"\n\nThe last run was on another machine ({last['cpu']})." if other else "")


def comparison(now: dict[str, Ratio], last: dict[str, Any] | None) -> str:
    """The table of all ratios beside those of the last run."""
    before, worse = last["ratios"] if last else {}, fallen(now, last)
    lines = ["## Ratios", ""]
    lines += [f"Beside the last committed run; red: more than {FALLEN} times worse.", ""]
    lines += ["| ratio | better is | now | last | times better |", "|---|---|---|---|---|"]
    for key, ratio in now.items():
        gain = f"{ratio.gain(before[key]):.2f}" if key in before else ""
        value = f"{ratio.value:.3g}"
        if key in worse:
            value, gain = (f'<span style="color:{RED}">**{text}**</span>' for text in (value, gain))
        was = f"{before[key]:.3g}" if key in before else "new"
        lines.append(f"| {key} | {ratio.better} | {value} | {was} | {gain} |")
    gone = [key for key in before if key not in now]
    return "\n".join(lines) + (f"\n\nNot measured this time: {'; '.join(gone)}." if gone and now else "")


def below(markdown: str) -> str:
    """The text with its headings from level 3 on."""
    levels = [len(hashes) for hashes in re.findall(r"^(#+) ", markdown, re.MULTILINE)]
    shift = "#" * max(0, 3 - min(levels, default=3))
    return re.sub(r"^#", f"{shift}#", markdown, flags=re.MULTILINE).strip()


if __name__ == "__main__":
    docs = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs"
    write_page(json.loads((ROOT / "docs" / "benchmarks.json").read_text(encoding="utf-8")), docs)
