"""Writers that are killed in the middle: ``python -m tests.faults.kills WRITER COUNT SEED`` prints what was found after.

Each time a fork writes old and new content in turn, as fast as it can, until SIGKILL ends it within a random one of its
writes; then the file must be one of the two, whole. A program of its own, because a process with threads should not fork.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.faults import boxes
from towage.errors import TowageError
from towage.fmus.describe import archive as archive_writer
from towage.result.result import Result
from towage.units.archive import extract, unpacked

MOST_WRITES = 10
"""A writer begins at most so many, and one at least."""
LATEST = 0.003
"""A writer is killed up to so long after it began its last write, s: anywhere in it."""
SAMPLES = 3000
Write = Callable[[int], None]
Check = Callable[[], str]


def _result(value: int) -> Result:
    time_axis = np.arange(float(SAMPLES))
    return Result(str(value), "", "hermite", "done", "", time_axis, {"a.x": time_axis + value}, {"a.x": "m"})


def npz(directory: Path) -> tuple[Write, Check]:
    """Results, bit for bit."""
    path = directory / "result.npz"

    def check() -> str:
        result = Result.load_npz(path)
        whole = result["a.x"].tobytes() == (np.arange(float(SAMPLES)) + int(result.title)).tobytes()
        return f"content {result.title}" if whole else "torn"

    return lambda value: _result(value).save_npz(path), check


def csv(directory: Path) -> tuple[Write, Check]:
    """Results as text."""
    path, texts = directory / "result.csv", {}
    for value in (0, 1):
        _result(value).save_csv(path)
        texts[path.read_bytes()] = f"content {value}"
    return lambda value: _result(value).save_csv(path), lambda: texts.get(path.read_bytes(), "torn")


def fmu(directory: Path) -> tuple[Write, Check]:
    """FMUs in the cache."""
    path = directory / "unit.fmu"
    members = [
        {"modelDescription.xml": bytes([value]) * 200, "noise": random.Random(value).randbytes(200_000)}
        for value in (0, 1)
    ]
    return (
        lambda value: archive_writer.write(path, members[value]),
        lambda: next((f"content {k}" for k in (0, 1) if archive_writer.read(path) == members[k]), "torn"),
    )


def unpacking(directory: Path) -> tuple[Write, Check]:
    """FMUs unpacked, new ones all the time; afterwards each directory is complete or absent."""
    path = boxes.build(directory / "box.fmu", resources__noise=random.Random(1).randbytes(300_000))
    count = iter(range(10**9))

    def write(value: int) -> None:
        extract(path, directory / f"unpacked{os.getpid()}_{next(count)}")

    def check() -> str:
        places = list(directory.glob("unpacked*"))
        try:
            for place in places:
                extract(path, place)  # refuses to touch what is not whole
                shutil.rmtree(place)
        except TowageError:
            return "torn"
        unpacked(path, directory)  # and what was left behind is in nobody's way
        return "content 1" if places else "content 0"

    return write, check


WRITERS = {f.__name__: f for f in (npz, csv, fmu, unpacking)}


def main(name: str, count: int, seed: int) -> Counter[str]:
    """What was found after each of ``count`` kills."""
    chance = random.Random(seed)
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        directory = Path(folder)
        write, check = WRITERS[name](directory)
        write(0)
        for k in range(count):
            begun, tell = os.pipe()
            pid = os.fork()
            if not pid:
                try:
                    value = k
                    while True:
                        value += 1
                        os.write(tell, b".")
                        write(value % 2)
                finally:
                    os._exit(1)  # a writer that fails ends before it is killed
            os.close(tell)
            for _ in range(chance.randint(1, MOST_WRITES)):
                os.read(begun, 1)
            time.sleep(chance.uniform(0.0, LATEST))
            os.kill(pid, signal.SIGKILL)
            _, status = os.waitpid(pid, 0)
            os.close(begun)
            counts["killed" if os.WIFSIGNALED(status) else "failed"] += 1
            counts[check()] += 1
        counts["left behind"] = sum(1 for entry in directory.iterdir() if entry.name.startswith("."))
    return counts


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))
