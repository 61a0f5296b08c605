"""A clock for supervised processes that stands still, so that no test depends on the speed of the machine.

A unit of a test that hangs leaves the id of its process in the directory `HUNG` of the environment first, by
``announce`` or as ``hostile.c`` does; for that process alone time passes. ``python -m tests.held_clock`` is ``towage``
with this clock, and a dask worker that preloads this module has it too.
"""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING

from towage import cli
from towage.process import child

if TYPE_CHECKING:
    import pytest

HUNG = "TOWAGE_TEST_HUNG"
"""Environment variable: the directory in which processes that hang leave their ids."""
ANNOUNCE = f'''
def announce():
    """Tell the clock of the test that this process hangs from now on."""
    open(os.path.join(os.environ["{HUNG}"], str(os.getpid())), "w").close()
'''
"""For the script of a unit; needs ``os``."""


class HeldClock(child.Clock):
    """Moves on by `child.POLL` at each reading for a process that hangs."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self.passed: dict[int, float] = defaultdict(float)

    def now(self, pid: int) -> float:
        if (self._directory / str(pid)).exists():
            self.passed[pid] += child.POLL
        return self.passed[pid]


def hold(monkeypatch: pytest.MonkeyPatch, directory: Path) -> HeldClock:
    """Put the clock in place of the real one, here, and its directory into the environment of processes to come."""
    clock = HeldClock(directory)
    monkeypatch.setattr(child, "CLOCK", clock)
    monkeypatch.setenv(HUNG, str(directory))
    return clock


def dask_setup(worker: object) -> None:
    """Hold the clock of a dask worker."""
    child.CLOCK = HeldClock(Path(os.environ[HUNG]))


if __name__ == "__main__":
    child.CLOCK = HeldClock(Path(os.environ[HUNG]))
    sys.exit(cli.main(sys.argv[1:]))
