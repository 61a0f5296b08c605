"""What is built once for all tests of a run, whichever process asks first."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest


def shared_directory(factory: pytest.TempPathFactory) -> Path:
    """A directory of this run, the same in all processes of pytest-xdist."""
    own = factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


def once(directory: Path, make: Callable[[Path], object]) -> Path:
    """``directory``, in which ``make(directory)`` has worked once."""
    directory.parent.mkdir(parents=True, exist_ok=True)
    done = directory / ".done"
    with directory.with_name(directory.name + ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            shutil.rmtree(directory, ignore_errors=True)  # of an attempt that failed
            directory.mkdir()
            make(directory)
            done.touch()
    return directory
