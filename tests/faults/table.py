"""The table of docs/faults.md: ``python -m tests.faults.table [FILE]`` injects every fault and tells what became of it.

Ends with exit code 1 if an outcome is not the wanted one.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.faults import archive_cases, disk_cases, unit_cases
from tests.faults.kills import WRITERS
from tests.faults.kills import main as kill
from tests.faults.survival import Case, problem, run

CASES: list[Case] = [*archive_cases.CASES, *unit_cases.CASES, *disk_cases.CASES]
KILLS = 100
LONGEST = 110
"""Characters of a message that are shown."""


def rows() -> Iterator[tuple[Case, str, str, str]]:
    """(case, exit code, what was said, what is wrong with the outcome) of every case."""
    for case in CASES:
        with tempfile.TemporaryDirectory() as directory:
            try:
                outcome = run(case, Path(directory))
            except pytest.skip.Exception as why:
                yield case, "", f"skipped: {why}", ""
                continue
            wrong = problem(case, outcome)
            said = outcome.message().replace(directory, "").replace("|", "\\|")
        said = re.sub(r"^(towage: error: |failure +)?(/scene.toml: |/box.fmu: )?", "", said)
        yield case, str(outcome.code), said[:LONGEST] + ("..." if len(said) > LONGEST else ""), wrong


def main() -> int:
    """Print the table as Markdown."""
    begin, bad = time.monotonic(), 0
    injected: Counter[str] = Counter()
    survived: Counter[str] = Counter()
    lines = ["| fault | exit code | what is said |", "|---|---|---|"]
    for case, code, said, wrong in rows():
        bad += bool(wrong)
        injected[case.group] += bool(code)
        survived[case.group] += bool(code) and not wrong
        told = f"**WRONG** {' '.join(wrong[:200].split())}" if wrong else said
        lines.append(f"| {case.name.replace('|', '/')} | {code} | {told} |")
    print("| faults | injected | with the outcome wanted |\n|---|---|---|")
    for group, count in injected.items():
        print(f"| {group} | {count} | {survived[group]} |")
    for name in WRITERS:
        counts = kill(name, KILLS, 1)
        whole = counts["content 0"] + counts["content 1"]
        bad += whole != KILLS
        print(f"| kill -9 while writing {name} | {KILLS} | {whole} |")
    print(f"\n{time.monotonic() - begin:.0f} s; the process that ran them is {os.getpid()}, as at the start.\n")
    print("\n".join(lines))
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
