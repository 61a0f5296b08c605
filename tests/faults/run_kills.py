"""Runs and sweeps that are ended at random moments: ``python -m tests.faults.run_kills COUNT SEED`` prints what was found.

Each time ``towage run`` or ``towage sweep`` is started, and ended by SIGKILL, or by one or two of the signals that end jobs. Then
the record up to the end must be there, equal to that of the run that was left alone; the run, resumed, must give its files
to the last bit; and neither a process nor a folder may be left.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import psutil

from towage.checks.track import SAME_TIME
from towage.result.result import Result

SCENE = """title = "Killed"
stop_time = 60.0
connections = ["ship.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension",
  "line.reaction -> ship.reaction"]
[units.ship]
fmu = "ship"
[units.line]
fmu = "spring_line"
[units.line.parameters]
static_tension = "= cradle.weight_in_water"
[units.cradle]
fmu = "cradle"
[coupling]
step = 0.02
error_estimate = false
[record]
interval = 0.1
"""
STOPS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU", "SIGUSR1", "SIGUSR2")
CLOSE = 1e-6
"""Of values (m, m/s, N) at two points not more than 1e-9 s apart; 3e-8 N are seen at the event of this scene at 1e-12 s."""
GONE = 10.0
"""Longest wait for processes to end, s."""


def towage(*words: str) -> list[str]:
    return [sys.executable, "-m", "towage", *words]


def aged(folder: Path, prefix: str = "") -> None:
    """What is in the folder under such names, as if some time had passed."""
    for entry in folder.iterdir():
        if entry.name.startswith(prefix):
            os.utime(entry, (0, 0))


class Field:
    """A directory with a scene, the results of runs that were left alone, and how long these took."""

    def __init__(self, place: Path) -> None:
        self.place = place
        self.scene = place / "scene.toml"
        self.scene.write_text(SCENE, "utf-8")
        self.temporary = place / "temporary"
        self.temporary.mkdir()
        self.environment = {**os.environ, "TMPDIR": str(self.temporary)}
        begin = time.monotonic()
        self.run(*self.runs(place / "alone"))
        self.length = time.monotonic() - begin
        self.alone = Result.load_npz(place / "alone" / "scene.npz")
        self.run(*self.sweeps(place / "alone_sweep"))
        self.table = (place / "alone_sweep" / "table.csv").read_bytes()

    def runs(self, out: Path) -> list[str]:
        return ["run", str(self.scene), "--out", str(out), "--progress", "none", "--no-report", "--flavour", "python"]

    def sweeps(self, out: Path) -> list[str]:
        vary = ["--vary", "ship.heave_amplitude=0.5:2:4", "--set", "stop_time=6.0", "--workers", "2"]
        return ["sweep", str(self.scene), "--out", str(out), "--progress", "none", "--flavour", "python", *vary]

    def run(self, *words: str) -> None:
        done = subprocess.run(towage(*words), env=self.environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr

    def ended(self, words: list[str], chance: random.Random) -> str:
        """Start and end it at a random moment; how."""
        process = subprocess.Popen(
            towage(*words), env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip
        time.sleep(chance.uniform(0.05, 1.1) * self.length)
        family = [p for p in [psutil.Process(process.pid)] if p.is_running()]
        family += [child for parent in family for child in parent.children(recursive=True)]
        if chance.random() < 0.6:
            process.kill()
            how = "killed"
        else:
            how = "stopped"
            for _ in range(chance.choice((1, 2))):
                process.send_signal(getattr(signal, chance.choice(STOPS)))
                time.sleep(chance.uniform(0.0, 0.08))
        process.wait(60)
        _, left = psutil.wait_procs(family, timeout=GONE)
        assert not left, f"left: {left}"
        return how

    def one_run(self, out: Path, chance: random.Random) -> str:
        how = self.ended(self.runs(out), chance)
        folders = list(out.glob("*.unfinished")) if out.exists() else []
        if folders and (folders[0] / "journal").exists():
            copy = out.with_name("copy")
            shutil.copytree(out, copy)
            subprocess.run(towage("recover", str(copy)), env=self.environment, capture_output=True)
            for file in copy.glob("*.recovered.npz"):
                self.compare(file, prefix=True)
            assert not list(copy.glob("*.unfinished"))
            shutil.rmtree(copy)
        elif out.exists() and (out / "scene.npz").exists():
            self.compare(out / "scene.npz", prefix=True)
            how += ", with its files"
        if out.exists():
            aged(out, ".")  # a temporary file is cleared once its maker cannot be about to lock it
        self.run(*self.runs(out), "--resume")
        self.compare(out / "scene.npz", prefix=False)
        assert (out / "scene.csv").read_bytes() == (self.place / "alone" / "scene.csv").read_bytes()
        there = sorted(entry.name for entry in out.iterdir())
        assert there == ["scene.csv", "scene.npz"], there
        return how

    def compare(self, file: Path, prefix: bool) -> None:
        """``prefix``: of a run that was ended. Its last row may be the point before an event at the same time, whose own point
        the run that was left alone records: the scene is continuous there, so that only `CLOSE` tells them apart."""
        found = Result.load_npz(file)
        rows = len(found.time)
        assert prefix or rows == len(self.alone.time)
        at_event = prefix and any(abs(event.time - found.time[-1]) <= SAME_TIME for event in self.alone.events if rows)
        whole = rows - at_event
        for name, values in found.columns.items():
            expected = self.alone.columns[name][:rows]
            assert np.array_equal(values[:whole], expected[:whole]), name
            assert np.allclose(values[whole:], expected[whole:], rtol=0.0, atol=CLOSE), name

    def one_sweep(self, out: Path, chance: random.Random) -> str:
        how = self.ended(self.sweeps(out), chance)
        self.run(*self.sweeps(out), "--resume")
        assert (out / "table.csv").read_bytes() == self.table
        return f"sweep {how}"

    def left(self) -> list[str]:
        """Folders that the next run would not clear away."""
        aged(self.temporary)
        self.run(*self.runs(self.place / "last"))
        self.run("check", str(self.scene), "--flavour", "python")
        return [entry.name for entry in self.temporary.iterdir()]


def main(count: int, seed: int, seconds: float = 1e9) -> Counter[str]:
    """What became of ``count`` runs and sweeps, or as many as go into ``seconds``."""
    chance, counts = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        field = Field(Path(name))
        until = time.monotonic() + seconds
        for k in range(count):
            if time.monotonic() > until:
                break
            out = field.place / "out"
            counts[field.one_sweep(out, chance) if k % 4 == 3 else field.one_run(out, chance)] += 1
            shutil.rmtree(out)
        left = field.left()
        assert not left, left
    return counts


if __name__ == "__main__":
    print(json.dumps(main(int(sys.argv[1]), int(sys.argv[2]), *map(float, sys.argv[3:]))))
