"""What a program that runs a host has in common: it reads a job, prints its answer as the last line, and imports nothing of
towage, because it runs in the Python that the host is installed in."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

Job = dict[str, Any]
"""`tests.hosts.jobs` says what is in it."""
Series = dict[str, list[float]]
"""The watched outputs, called ``unit.name``, at the end of every step."""


def answer(run: Callable[[Job], Series], version: str) -> None:
    """Runs the job of the standard input and prints the version of the host and what it gave."""
    values = run(json.load(sys.stdin))
    sys.stdout.flush()
    print("\n" + json.dumps({"version": version, "values": values}), flush=True)
