"""Every fault has the outcome that is wanted of it, and this process, which runs the master, goes on."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from .kills import WRITERS
from .survival import Case, problem, run, scene
from .table import CASES, KILLS

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="injects faults by ELF files, signals and limits")
ROOT = Path(__file__).parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
SLOW = ("exit:hang", "step:spin", "terminate:hang", "torrent")
"""Others of their kind are in the quick tier."""
PRINTED = 100_000
"""What a unit prints without end must not fill the memory of the process that runs the master, characters."""


def _tier(case: Case) -> object:
    slow = any(word in case.fault for word in SLOW)
    return pytest.param(case, id=case.name, marks=[pytest.mark.slow] if slow else [])


@pytest.mark.parametrize("case", [_tier(case) for case in CASES])
def test_fault(case: Case, tmp_path: Path) -> None:
    outcome = run(case, tmp_path)
    assert not problem(case, outcome)
    assert len(outcome.printed) < PRINTED
    assert "Traceback" not in outcome.printed


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("kills", [20, pytest.param(KILLS, marks=pytest.mark.slow)])
def test_writer_killed(writer: str, kills: int) -> None:
    """What is there is the old or the new, and some of both were met: the kills came in the middle."""
    command = [sys.executable, "-m", "tests.faults.kills", writer, str(kills), str(kills)]
    done = subprocess.run(command, cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, timeout=120)
    assert not done.returncode, done.stderr
    counts = json.loads(done.stdout)
    assert counts["killed"] == kills
    assert counts.get("content 0", 0) + counts.get("content 1", 0) == kills, counts
    assert counts["content 1"]


@pytest.mark.parametrize("amount", [["--count", "650"], pytest.param(["--seconds", "60"], marks=pytest.mark.slow)])
def test_mutated_inputs_are_taken_or_refused(amount: list[str]) -> None:
    command = [sys.executable, "-m", "tests.faults.fuzz", "--seed", "18", *amount]
    done = subprocess.run(command, cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
    assert not done.returncode, done.stdout + done.stderr
    rows = re.findall(r"^\| (\w+) \| (\d+) \| (\d+) \| 0 \| (\d+) \|$", done.stdout, re.M)
    assert len(rows) == 23
    few = {"forecast_started", "forecast_grib"}  # slow doors: one input in so few
    assert all(int(taken) and (int(refused) or door in few) for door, taken, refused, _ in rows)


def test_processes_that_build_and_unpack_at_once_all_succeed(tmp_path: Path) -> None:
    path = scene(tmp_path, {"ship": Path("ship"), "second": Path("ship")}, [])
    environment = {**ENVIRONMENT, "TOWAGE_CACHE": str(tmp_path / "cache")}
    command = [sys.executable, "-m", "towage", "run", str(path), "--no-report", "--progress", "none", "--out"]
    runs = [
        subprocess.Popen([*command, str(tmp_path / str(k))], env=environment, stdout=subprocess.DEVNULL)
        for k in range(3)
    ]
    assert [one.wait(100) for one in runs] == [0, 0, 0]
    texts = {(tmp_path / str(k) / "scene.csv").read_bytes() for k in range(3)}
    assert len(texts) == 1
    entries = [*(tmp_path / "cache" / "fmus").glob("*/*"), *(tmp_path / "cache" / "unpacked").iterdir()]
    assert sorted(entry.suffix for entry in entries) == ["", ".fmu"], "one FMU, unpacked once, nothing left behind"


def test_page_quotes_the_table() -> None:
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    quoted = {group: int(count) for group, count in re.findall(r"^\| (\w+) \| (\d+) \| \d+ \|", page, re.M)}
    assert quoted == Counter(case.group for case in CASES), "run python -m tests.faults.table"
