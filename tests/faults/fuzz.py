"""Mutated inputs at every door: ``python -m tests.faults.fuzz --seconds 60 --seed 1`` prints what became of them.

A door reads one kind of file. Each input is one that towage wrote or that the tests have, with a few mutations of bytes, of
numbers, of nesting or of length; the first of a door are as they were and must be taken. The others must be taken or refused
with exit code 2, by a process that needs less than `MOST` memory and `LONGEST` time. Inputs are done in forks, a batch each, so
that a crash is one of its batch and memory is its own. A failure is printed with door, seed and number, and
`--only DOOR:SEED:NUMBER` makes that input again.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

MOST = 300
"""Memory of the process that reads, MB, with all that it has loaded."""
LONGEST = 10.0
"""Processor time of one input, s."""
BATCH = 200
Take = Callable[[Path], object]


class Door(NamedTuple):
    """``seeds``: sound inputs; ``take`` reads a file; ``suffix`` is its name's end; ``share``: of the inputs of other doors, for
    one that is slow."""

    name: str
    suffix: str
    seeds: list[bytes]
    take: Take
    share: float = 1.0


def mutated(data: bytes, chance: random.Random) -> bytes:
    """The input with one to four mutations."""
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        data = chance.choice(MUTATORS)(data, chance)
    return data[: 1 << 22]


def _flip(data: bytes, chance: random.Random) -> bytes:
    damaged = bytearray(data or b" ")
    for _ in range(chance.choice((1, 1, 8))):
        damaged[chance.randrange(len(damaged))] ^= 1 << chance.randrange(8)
    return bytes(damaged)


def _cut(data: bytes, chance: random.Random) -> bytes:
    return data[: chance.randrange(len(data) + 1)]


def _drop(data: bytes, chance: random.Random) -> bytes:
    place = chance.randrange(len(data) + 1)
    return data[:place] + data[place + chance.choice((1, 4, 100)) :]


def _double(data: bytes, chance: random.Random) -> bytes:
    place, size = chance.randrange(len(data) + 1), chance.choice((1, 8, 300))
    return data[:place] + data[place : place + size] * chance.choice((2, 3, 2000)) + data[place + size :]


def _word(data: bytes, chance: random.Random) -> bytes:
    place, word = chance.randrange(len(data) + 1), chance.choice(WORDS)
    return data[:place] + word + data[place + chance.choice((0, len(word))) :]


def _number(data: bytes, chance: random.Random) -> bytes:
    """A size or an offset of binary formats, in either order of bytes."""
    place = chance.randrange(max(1, len(data) - 8))
    value = chance.choice((0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 0xFFFFFFFE, 1 << 24, len(data)))
    order: list[str] = ["little", "big"]
    return data[:place] + value.to_bytes(4, chance.choice(order)) + data[place + 4 :]  # type: ignore[arg-type]


def _swap(data: bytes, chance: random.Random) -> bytes:
    a, b = sorted(chance.randrange(len(data) + 1) for _ in range(2))
    return data[:a] + data[b : b + 40] + data[a:b] + data[b + 40 :]


MUTATORS = (_flip, _flip, _cut, _drop, _double, _word, _word, _number, _swap)
WORDS = [
    b"0", b"-1", b"1e999", b"nan", b"9" * 5000, b"1e-400", b"\0", b"\xff\xfe", b"\x1b[2J", b"\xe2\x80\xae", b"[" * 3000,
    b"{" * 3000, b"]", b"}", b"<a>" * 2000, b"</a>", b"<!DOCTYPE a>", b"&lt;", b'"', b"'", b"''''", b"a" * 100_000,
    b"a." * 3000, b"= ", b"\n", b"\n[units.ship]\n", b"true", b"null", b"../../etc/passwd", b"18446744073709551616",
    b"99999999999", b"0x", b"1979-05-27T07:32:00Z",
]  # fmt: skip


def doors(folder: Path) -> list[Door]:
    """All doors, with seeds that are made in ``folder``."""
    from tests.faults import doors as made

    return made.doors(folder, Door)


def given(door: Door, seed: int, number: int) -> bytes:
    """An input of a door."""
    if number < len(door.seeds):
        return door.seeds[number]
    chance = random.Random(f"{door.name}:{seed}:{number}")
    return mutated(chance.choice(door.seeds), chance)


def one(door: Door, seed: int, number: int, folder: Path) -> str:
    """What became of an input: "taken", "refused", or what went wrong."""
    from towage.errors import TowageError

    path = folder / f"input{door.suffix}"
    path.write_bytes(given(door, seed, number))
    begin = time.process_time()
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            door.take(path)
        word = "taken"
    except TowageError as error:
        str(error)
        word = "refused" if error.exit_code == 2 else f"exit code {error.exit_code}: {error}"
        word = f"sound, and {word}: {error}" if number < len(door.seeds) else word
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        word = f"defect: {type(error).__name__} at {place.filename}:{place.lineno}"
    spent = time.process_time() - begin
    return word if spent < LONGEST else f"took {spent:.1f} s"


def batch(door: Door, seed: int, begin: int, count: int, folder: Path) -> tuple[Counter[str], int]:
    """(what became of so many inputs, the memory it took, MB), in a fork."""
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.close(reading)
        for name in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), name)
        counts: dict[str, int] = {}
        for number in range(begin, begin + count):
            os.write(writing, f"{number}\n".encode())
            resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + 3.0 * LONGEST), resource.RLIM_INFINITY))
            word = one(door, seed, number, folder)
            key = word if word in ("taken", "refused") else f"{word} [--only {door.name}:{seed}:{number}]"
            counts[key] = counts.get(key, 0) + 1
        peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) >> 10
        os.write(writing, (json.dumps([counts, peak]) + "\n").encode())
        os._exit(0)
    os.close(writing)
    with open(reading, encoding="utf-8") as file:
        lines = file.read().splitlines()
    _, status = os.waitpid(pid, 0)
    if status or not lines or not lines[-1].startswith("["):
        died = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else str(status)
        last = lines[-1] if lines else str(begin)
        return Counter({f"died of {died} [--only {door.name}:{seed}:{last}]": 1}), 0
    counted, peak = json.loads(lines[-1])
    return Counter(counted), peak


def fuzz(seconds: float, count: int, seed: int, names: list[str]) -> int:
    """Take the doors in turns until the time or the count is used up, Ctrl-C or SIGTERM; the number of failures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        chosen = [door for door in doors(folder) if not names or door.name in names]
        totals: dict[str, Counter[str]] = {door.name: Counter() for door in chosen}
        peaks, begins = dict.fromkeys(totals, 0), dict.fromkeys(totals, 0)
        size = max(1, min(BATCH, count // len(chosen)))
        until = time.monotonic() + seconds
        with contextlib.suppress(KeyboardInterrupt):
            for door in itertools.cycle(chosen):
                if time.monotonic() > until or sum(sum(counts.values()) for counts in totals.values()) >= count:
                    break
                place = Path(tempfile.mkdtemp(dir=folder))
                some = max(1, round(size * door.share))
                counts, peak = batch(door, seed, begins[door.name], some, place)
                begins[door.name] += some
                shutil.rmtree(place)
                totals[door.name] += counts
                peaks[door.name] = max(peaks[door.name], peak)
    return told(totals, peaks, seed)


def told(totals: dict[str, Counter[str]], peaks: dict[str, int], seed: int) -> int:
    """Print what became of the inputs of the doors; the number of failures."""
    bad, done = 0, sum(sum(counts.values()) for counts in totals.values())
    print(f"{done} inputs, seed {seed}\n\n| door | taken | refused | failed | most memory, MB |\n|---|---|---|---|---|")
    for name, counts in totals.items():
        failed = {word: n for word, n in counts.items() if word not in ("taken", "refused")}
        bad += sum(failed.values()) + (peaks[name] > MOST)
        print(f"| {name} | {counts['taken']} | {counts['refused']} | {sum(failed.values())} | {peaks[name]} |")
        for word, n in sorted(failed.items())[:20]:
            print(f"    {n} x {word}", file=sys.stderr)
    return bad


def main() -> int:
    """0 if every input was taken or refused."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--count", type=int, default=1 << 62)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--door", action="append", default=[], help="only this door (may be repeated)")
    parser.add_argument("--only", metavar="DOOR:SEED:NUMBER", help="make one input again, here")
    arguments = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell ignores in what it starts in the background
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    if arguments.only:
        name, seed, number = arguments.only.split(":")
        with tempfile.TemporaryDirectory() as folder:
            door = next(door for door in doors(Path(folder)) if door.name == name)
            path = Path(folder, f"input{door.suffix}")
            path.write_bytes(given(door, int(seed), int(number)))
            door.take(path)
        return 0
    return int(fuzz(arguments.seconds, arguments.count, arguments.seed, arguments.door) > 0)


if __name__ == "__main__":
    sys.exit(main())
