"""What a fault is, and what became of it: every case goes through ``towage run`` in this process, which must survive."""

from __future__ import annotations

import contextlib
import io
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.held_clock import hold
from towage.cli import main

SILENCE = "2"
"""What a hung unit is given, s."""
STEP = 0.1
STOP = 2.0
DUE = 1.0
"""When a misdeed during the run happens, s."""


@dataclass(frozen=True)
class Case:
    """A fault that is injected. ``scene(directory)`` writes a scene file; ``says`` is a regular expression found in what
    the command prints; ``recorded`` the last time in the results, s, None if there must be none, NaN for any; ``during``,
    given the directory, holds while the command runs."""

    group: str
    fault: str
    scene: Callable[[Path], Path]
    code: int
    says: str
    recorded: float | None = None
    during: Callable[[Path], contextlib.AbstractContextManager[object]] = contextlib.nullcontext

    @property
    def name(self) -> str:
        return f"{self.group}: {self.fault}"


class Outcome(NamedTuple):
    """Exit code, all that was printed, last recorded time (s)."""

    code: int
    printed: str
    recorded: float | None

    def message(self) -> str:
        """The line that tells what went wrong, or "" if nothing did."""
        lines = [line.strip() for line in self.printed.splitlines()]
        return next((line for line in lines if line.startswith(("towage: error:", "failure "))), "")


def run(case: Case, directory: Path) -> Outcome:
    """``towage run`` of the case's scene."""
    scene, out = case.scene(directory), directory / "out"
    printed, hung = io.StringIO(), directory / "hung"
    hung.mkdir()
    command = ["run", str(scene), "--out", str(out), "--no-report", "--progress", "none", "--timeout", SILENCE]
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(printed),
        case.during(directory),
    ):
        hold(patch, hung)
        code = main([*command, "--flavour", "python"])
        return Outcome(code, printed.getvalue(), _last_time(out))


def problem(case: Case, outcome: Outcome) -> str:
    """What differs from the outcome that was wanted, or ""."""
    if outcome.code != case.code:
        return f"exit code {outcome.code}, expected {case.code}: {outcome.printed[-1500:]}"
    if not re.search(case.says, outcome.printed):
        return f"does not say {case.says!r}: {outcome.printed[-1500:]}"
    if not _agree(case.recorded, outcome.recorded):
        return f"the record ends at {outcome.recorded}, expected {case.recorded}"
    return ""


def _agree(wanted: float | None, ended: float | None) -> bool:
    if wanted is None or ended is None:
        return wanted == ended or (wanted is not None and math.isnan(wanted))
    return math.isnan(wanted) or abs(wanted - ended) < 1e-9  # times are multiples of the step but for rounding


def scene(directory: Path, units: dict[str, Path], connections: list[str], **more: str) -> Path:
    """A scene file; ``more`` are lines of tables, as coupling='scheme = "extrapolate"'."""
    coupling = {"coupling": f"step = {STEP}\nerror_estimate = false\n" + more.pop("coupling", "")}
    tables = [f'[units.{name}]\nfmu = "{path.as_posix()}"' for name, path in units.items()]
    tables += [f"[{name}]\n{lines}" for name, lines in {**coupling, **more}.items()]
    head = f'title = "Faults"\nstop_time = {STOP}\nconnections = {connections!r}'
    path = directory / "scene.toml"
    path.write_text("\n".join([head, *tables]) + "\n", encoding="utf-8")
    return path


def _last_time(out: Path) -> float | None:
    """Of the one result in ``out``."""
    files = list(out.glob("*.csv"))
    lines = files[0].read_text(encoding="utf-8").splitlines()[1:] if files else []
    return float(lines[-1].partition(",")[0]) if lines else None
