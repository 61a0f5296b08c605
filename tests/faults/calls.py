"""Random calls of the native units, of FMI 2 and 3: ``python -m tests.faults.calls --count 1e9`` (``--sanitize`` under the
address and undefined behaviour sanitizers).

A C program a unit (`tests.fmus.hostile`) makes them, the units have the same time each. What is done is noted in ``--out``,
a slice a line, and the next call of the same command goes on from there with other seeds. A slice that fails is printed with the
command that makes its calls again.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import resource
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from tests.fmus.hostile import ALL, FAST, SANITIZERS, has_sanitizers, program

FIRST = 20_000
"""Turns of the first slice of a unit, which tells how fast it is."""
SLICE = 10.0
"""Processor time of the others, s."""
SAID = re.compile(r"(\d+) turns, (\d+) calls, (\d+) accepted\n")


class Unit:
    """The program of a unit, and what of its calls was made: ``turns`` of a slice, ``slices`` done."""

    def __init__(self, name: str, folder: Path, flags: tuple[str, ...]) -> None:
        self.name, (self.program, self.digest) = name, program(name, folder, *flags)
        self.turns, self.slices, self.spent = FIRST, 0, 0.0
        self.counts: Counter[str] = Counter()

    def take(self, done: dict[str, float]) -> None:
        """Count a slice that was done."""
        self.slices += 1
        self.spent += done["seconds"]
        self.turns = max(FIRST, int(done["turns"] / max(done["seconds"], 0.01) * SLICE))
        self.counts.update({key: int(done[key]) for key in ("turns", "calls", "accepted")})

    def slice(self, seed: int, most: int) -> dict[str, float]:
        """Make the next one, of at most so many calls. Raises `RuntimeError` if the program ends otherwise than it should."""
        turns = max(1, min(self.turns, most))
        words = [str(self.program), str(seed * 1_000_003 + self.slices), str(turns)]
        begin = _spent()
        ended = subprocess.run(words, capture_output=True, text=True)
        found = SAID.fullmatch(ended.stdout)
        if ended.returncode or not found:
            raise RuntimeError(f"{self.name}: {' '.join(words)}\nexit code {ended.returncode}\n{ended.stderr[-3000:]}")
        made = dict(zip(("turns", "calls", "accepted"), map(float, found.groups())))
        return made | {"seconds": _spent() - begin}


def _spent() -> float:
    """Processor time of the programs that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """0 if all calls were made and none did what it must not."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=float, default=1e9, help="FMI calls in all, with those of earlier runs (1e9)")
    parser.add_argument("--seconds", type=float, default=1e9, help="stop earlier, after so many s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sanitize", action="store_true", help="under the sanitizers")
    parser.add_argument("--unit", action="append", default=[], choices=ALL, help="only this one (may be repeated)")
    parser.add_argument("--out", type=Path, default=Path("out/calls"), help="programs and what is done (out/calls)")
    given = parser.parse_args()
    folder = given.out.absolute() / ("sanitized" if given.sanitize else "fast")
    folder.mkdir(parents=True, exist_ok=True)
    if given.sanitize and not has_sanitizers(folder):
        print("the C compiler has no address sanitizer", file=sys.stderr)
        return 2
    units = [Unit(name, folder, SANITIZERS if given.sanitize else FAST) for name in given.unit or ALL]
    journal = folder / "done.jsonl"
    for line in journal.read_text("utf-8").splitlines() if journal.exists() else ():
        done = json.loads(line)
        for unit in units:
            if (unit.name, unit.digest, given.seed) == (done["unit"], done["digest"], done["seed"]):
                unit.take(done)
    failed = play(units, given, journal)
    print("| unit | calls | accepted | turns | a second |\n|---|---|---|---|---|")
    for unit in units:
        calls, accepted, turns = (unit.counts[key] for key in ("calls", "accepted", "turns"))
        print(f"| {unit.name} | {calls} | {accepted} | {turns} | {calls / max(unit.spent, 1e-9):.2g} |")
    print(
        f"\n{sum(u.counts['calls'] for u in units):.3g} calls of {len(units)} programs, seed {given.seed}, {failed} failed"
    )
    return int(failed > 0)


def play(units: list[Unit], given: argparse.Namespace, journal: Path) -> int:
    """Give slices to the unit that had the least time, until there were enough calls; how many units failed."""
    until, failed, left = time.monotonic() + given.seconds, 0, list(units)
    while left and time.monotonic() < until:
        missing = given.count - sum(unit.counts["calls"] for unit in units)
        if missing <= 0:
            break
        unit = min(left, key=lambda u: u.spent)
        try:
            done = unit.slice(given.seed, math.ceil(missing / len(left)))
        except RuntimeError as error:
            print(error, file=sys.stderr)
            failed += 1
            left.remove(unit)
            continue
        unit.take(done)
        with open(journal, "a", encoding="utf-8") as file:
            file.write(json.dumps({"unit": unit.name, "digest": unit.digest, "seed": given.seed, **done}) + "\n")
    return failed


if __name__ == "__main__":
    sys.exit(main())
