"""Trials of what a unit does to its process: surroundings, memory, threads."""

from __future__ import annotations

import ctypes
import os
import resource
import threading
import time
from pathlib import Path
from typing import Any

from towage.master.trust import REPEATED
from towage.units.fmu import StepRefused
from towage.vet.bench import STEPS, Bench, Trial

LEAK_STEPS = 100_000
LEAK_TIME = 60.0
"""Longest time for them, s of the clock on the wall: a slow unit does fewer, which the trial says."""
LEAK = 16.0
"""Bytes a step beyond which memory leaks."""


def environment(bench: Bench) -> list[Trial]:
    """Does it leave the process as it was: directory, files, threads, children, floating-point mode?"""
    before = _state()
    with bench.unit() as unit:
        bench.run(unit, STEPS)
        during = _state()
    after = _state()
    found = [
        Trial("environment", "fault", f"changes {what}; towage sets it back after each call") for what in unit.instance.meddled
    ]
    for key, what in (("directory", "changes the working directory"), ("rounding", "changes the floating-point mode"),
                      ("umask", "changes the umask"), ("children", "starts processes")):  # fmt: skip
        if during[key] != before[key] or after[key] != before[key]:
            found.append(Trial("environment", "fault", what))
    for key, what in (("files", "file descriptors are left open"), ("threads", "threads are left running")):
        more = after["counts"][key] - before["counts"][key]
        if more > 2:
            found.append(Trial("environment", "warning", f"{more} {what}"))
    return found or [Trial("environment", "ok", "the process is left as it was")]


def _state() -> dict[str, Any]:
    mask = os.umask(0)
    os.umask(mask)
    libc = ctypes.CDLL(None)
    proc = Path("/proc/self")
    children = sorted(proc.glob("task/*/children")) if proc.exists() else []
    return {
        "directory": os.getcwd(),
        "umask": mask,
        "rounding": libc.fegetround() if hasattr(libc, "fegetround") else 0,
        "counts": {
            "files": len(list((proc / "fd").iterdir())) if proc.exists() else 0,
            "threads": len(list((proc / "task").iterdir())) if proc.exists() else threading.active_count(),
        },
        "children": "".join(file.read_text() for file in children),
    }


def leaks(bench: Bench) -> list[Trial]:
    """Does memory grow with the number of steps?"""
    with bench.unit() as unit:
        bench.run(unit, LEAK_STEPS // 10)
        begin, until = _memory(), time.monotonic() + LEAK_TIME
        done = 0
        for k in range(LEAK_STEPS // 10, LEAK_STEPS):
            if k % 10 == 0:
                bench.excite(unit, k * bench.step)
            try:
                unit.advance(k * bench.step, bench.step)
            except StepRefused:
                break
            done += 1
            if time.monotonic() > until:
                break
        grown = (_memory() - begin) / max(done, 1)
    if done < LEAK_STEPS // 100:
        return [Trial("leaks", "note", f"not told: it did {done} steps")]
    level = "warning" if grown > LEAK else "ok"
    return [Trial("leaks", level, f"memory grows by {grown:.1f} bytes a step over {done} steps", grown)]


def _memory() -> float:
    """Bytes that this process has in memory; the most that it ever had where the system does not tell."""
    try:
        return float(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
    except OSError:
        return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def threads(bench: Bench) -> list[Trial]:
    """Does an instance work in another thread than the one that made it?"""
    with bench.unit() as unit:
        here = bench.run(unit, STEPS)
    there: list[list[float]] = []
    with bench.unit() as unit:
        worker = threading.Thread(target=lambda: there.extend(bench.run(unit, STEPS)))
        worker.start()
        worker.join()
    gap, name = bench.worst(here, there)
    if len(here) != len(there) or gap > REPEATED:
        return [Trial("threads", "warning", f"differs in another thread, most in {name}", gap)]
    return [Trial("threads", "ok", "may be stepped in another thread")]
