"""Random scenes that try to fool the verdict: ``python -m tests.verdict.fool heave --count 5000 --jobs 2 --out out/fool``.

Every scene is run and judged by the program, and its truth is found by other means (`family.Family`). *False valid*: called
valid, and an error above the tolerance. *False invalid*: called invalid, and below half the tolerance. Scene ``index`` of a
``--seed`` is the same in every run; finished ones are kept in a journal, and the same command continues it.

A family is a `Family` of its own module, named in `FAMILIES`: to add one is to write that module and its line.
"""

from __future__ import annotations

import argparse
import importlib
import math
import sys
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import towage
from tests.verdict.family import Family
from towage.result.result import Result
from towage.sweeps.journal import Journal
from towage.sweeps.row import Row

FAMILIES = {"heave": "tests.verdict.heave", "tows": "tests.verdict.tows"}
"""Name to module, which holds the family as ``FAMILY``."""
WORDS = ("valid", "marginal", "invalid", "not judged")
HALF = 0.5
"""Share of the tolerance below which invalid is false."""
CHUNK = 4


def family(name: str) -> Family:
    """The family of that name."""
    found: Family = importlib.import_module(FAMILIES[name]).FAMILY
    return found


def judged(name: str, seed: int, index: int) -> Row:
    """One scene: the program's word with the item that decided, and the truth. ``note`` is the kind of the scene."""
    own = family(name)
    drawn = own.draw(seed, index)
    begin = time.process_time()
    result = towage.run(own.scene(drawn), flavour=own.flavour)
    between = time.process_time()
    if result.status != "done":
        return Row(index, "failed", message=result.message, note=own.kind(drawn))
    true = own.truth(drawn, result)
    numbers: dict[str, float | None] = {
        "error": true.error, "motion": true.motion, "noise": true.noise, "chaotic": float(true.chaotic), **measured(result),
        "cpu_run": between - begin, "cpu_truth": time.process_time() - between,
    }  # fmt: skip
    verdict = result.verdict
    decided = next((item.name for item in verdict.items if (item.word, item.reason) == (verdict.word, verdict.reason)), "")
    measures = {key: value for key, value in numbers.items() if value is not None}
    return Row(index, "done", verdict.word, f"{decided}: {verdict.reason}", measures, own.kind(drawn))


def measured(result: Result) -> dict[str, float | None]:
    """What the program measured itself, to look into a scene."""
    numbers = {f"item:{item.name}": item.number for item in result.verdict.items}
    if c := result.comparison:
        own = {"amplitude": c.amplitude, "peak": c.peak_tension, "rms": c.rms, "tension_rms": c.tension_rms}
        return {**numbers, **own, "bound": c.bound, "said_chaotic": float(c.chaotic)}
    bounds = [m.limit * (1.0 - m.worst) for m in result.margins if m.decides and m.limit]
    if bounds:
        numbers["bound"] = max(bounds)
    return numbers


def fault(row: Row, tolerance: float) -> str:
    """What is false about the word, if anything. The interval of a truth by statistics is to its favour."""
    error, noise = row.measures.get("error", 0.0), row.measures.get("noise", 0.0)
    if row.verdict == "valid" and error - noise > tolerance:
        return "false valid"
    if row.verdict == "invalid" and error + noise < HALF * tolerance:
        return "false invalid"
    return ""


def table(rows: Sequence[Row], tolerance: float) -> str:
    """Counts by kind of scene, and every false word with its reason, as Markdown."""
    kinds = sorted({row.note for row in rows})
    head = ("scenes", "number", *WORDS, "not judged outside chaos", "false valid", "false invalid", "bound / error")
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for kind in [*kinds, ""]:
        chosen = [row for row in rows if kind in ("", row.note)]
        said = [sum(row.verdict == word for row in chosen) for word in WORDS]
        silent = sum(row.verdict == "not judged" and not row.measures.get("chaotic") for row in chosen)
        false = [sum(fault(row, tolerance) == what for row in chosen) for what in ("false valid", "false invalid")]
        cells = (kind or "**all**", len(chosen), *said, silent, *false, f"{sharpness(chosen):.2f}")
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    lines.append("")
    for row in sorted(rows, key=lambda row: row.index):
        if (what := fault(row, tolerance)) or row.status != "done":
            lines.append(f"* {row.index} ({row.note}), {what or row.status}, true error "
                         f"{row.measures.get('error', math.nan):.3g}: {row.message}")  # fmt: skip
    return "\n".join(lines)


def sharpness(rows: Iterable[Row]) -> float:
    """Median of the program's bound over the true error of the motion, where both are known and the motion is not chaotic."""
    ratios = sorted(
        row.measures["bound"] / row.measures["motion"] for row in rows
        if row.measures.get("motion") and "bound" in row.measures and not row.measures.get("chaotic")
    )  # fmt: skip
    return ratios[len(ratios) // 2] if ratios else math.nan


def run(name: str, count: int, seed: int, jobs: int, out: Path, indices: Iterable[int] | None = None) -> list[Row]:
    """The rows of the first ``count`` scenes, those of the journal in ``out`` included. Raises `JournalError`."""
    out.mkdir(parents=True, exist_ok=True)
    identity = {"family": name, "seed": seed, "version": towage.__version__}
    with Journal(out / f"{name}.jsonl", identity, resume=True) as journal, ProcessPoolExecutor(jobs) as pool:
        wanted = [index for index in (range(count) if indices is None else indices) if index not in journal.rows]
        for row in pool.map(judged, *zip(*((name, seed, index) for index in wanted)), chunksize=CHUNK) if wanted else ():
            journal.append(row)
            journal.sync()
        return [row for index, row in sorted(journal.rows.items()) if index < count]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; 1 if a word is false valid."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("family", choices=FAMILIES)
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1969)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--out", type=Path, default=Path("out/fool"), help="folder of the journal and the table")
    asked = parser.parse_args(arguments)
    rows = run(asked.family, asked.count, asked.seed, asked.jobs, asked.out)
    text = table(rows, family(asked.family).tolerance)
    (asked.out / f"{asked.family}.md").write_text(text + "\n", "utf-8")
    print(text)
    return int(any(fault(row, family(asked.family).tolerance) == "false valid" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
