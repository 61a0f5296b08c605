"""Progress of long work on stderr: a bar on a terminal, a rare line in a log, JSON for another program.

    with progress(stop_time, "8 s wave") as bar:
        bar.update(time)

Nothing here can end the work it reports on: once stderr cannot be written, nothing more is shown.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Literal, Self

from towage.terminal import escaped

LONGEST_LABEL = 200
"""Letters of what is shown of a label."""
Mode = Literal["auto", "json", "none"]

CLOCK: Callable[[], float] = time.monotonic
"""The time in s; tests put another one here."""
_TERMINAL_INTERVAL = 0.1
_LOG_INTERVAL = 5.0
_JSON_INTERVAL = 0.2


def progress(total: float, label: str, mode: Mode = "auto") -> Bar:
    """Context manager that reports work of size ``total`` (any unit; 0 or NaN: not known).

    ``auto``: a rich bar on a terminal if rich is installed, else one stderr line, refreshed on a terminal and otherwise
    repeated at most every 5 s. ``json``: one object a line on stderr, at most every 0.2 s, and one at the end, with keys
    label, done, total, fraction, elapsed_s, rate, left_s, text, state (running, done, stopped); unknown is null.
    """
    if mode == "none":
        return Bar(total, label, math.inf)
    if mode == "json":
        return _JsonBar(total, label, _JSON_INTERVAL)
    if mode != "auto":
        raise ValueError(f"progress mode {mode!r}: expected 'auto', 'json' or 'none'")
    if not _on_terminal():
        return _LogBar(total, label, _LOG_INTERVAL)
    try:
        import rich.progress  # noqa: F401
    except ImportError:
        return _LineBar(total, label, _TERMINAL_INTERVAL)
    return _RichBar(total, label, _TERMINAL_INTERVAL)


class Bar:
    """Where the work stands; shows nothing. ``interval`` is the least time between two displays, s."""

    def __init__(self, total: float, label: str, interval: float) -> None:
        self.total = total if math.isfinite(total) and total > 0.0 else 0.0
        self.label = escaped(label, "", LONGEST_LABEL)
        self.done = 0.0
        self.text = ""
        self._interval = interval
        self._start = CLOCK()
        self._next = self._start + (interval if interval > _TERMINAL_INTERVAL else 0.0)

    def update(self, done: float, text: str = "") -> None:
        """``done`` of ``total`` is finished. Cheap enough (a clock reading) for every step; an empty ``text`` keeps the
        last one."""
        self.done = done
        if text:
            self.text = escaped(text, "", LONGEST_LABEL)
        now = CLOCK()
        if now >= self._next:
            self._next = now + self._interval
            self._guarded("running")

    def status(self) -> dict[str, float | str | None]:
        """Done, total, fraction, elapsed time and time left in s, rate per s; None where not known."""
        elapsed = CLOCK() - self._start
        rate = self.done / elapsed if elapsed > 0.0 and math.isfinite(self.done) else None
        left = max(self.total - self.done, 0.0) / rate if rate and self.total else None
        return {
            "label": self.label,
            "done": self.done if math.isfinite(self.done) else None,
            "total": self.total or None,
            "fraction": min(max(self.done / self.total, 0.0), 1.0) if self.total and math.isfinite(self.done) else None,
            "elapsed_s": elapsed,
            "rate": rate,
            "left_s": left,
            "text": self.text,
        }

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._guarded("done" if kind is None else "stopped")

    def _guarded(self, state: str) -> None:
        try:
            self._show(state)
        except (OSError, ValueError):  # ValueError: stderr is closed
            self._next = math.inf

    def _show(self, state: str) -> None:
        pass

    def _line(self) -> str:
        status = self.status()
        parts = [self.label]
        if isinstance(fraction := status["fraction"], float):
            parts.append(f"{100.0 * fraction:3.0f} %")
        parts.append(f"{self.done:.6g}" + (f" of {self.total:.6g}" if self.total else ""))
        if isinstance(rate := status["rate"], float):
            parts.append(f"{rate:.3g}/s")
        if isinstance(left := status["left_s"], float):
            parts.append(f"{duration(left)} left")
        return "  ".join([*parts, self.text] if self.text else parts)


class _JsonBar(Bar):
    """For another program: one JSON object a line."""

    def _show(self, state: str) -> None:
        print(json.dumps({**self.status(), "state": state}, allow_nan=False), file=sys.stderr, flush=True)


class _LogBar(Bar):
    """For a file or a pipe: silent on work shorter than one interval."""

    _shown = False

    def _show(self, state: str) -> None:
        if state == "running" or self._shown:
            self._shown = True
            print(self._line(), file=sys.stderr, flush=True)


class _LineBar(Bar):
    """One line of a terminal, written over itself."""

    _erase = "\r\x1b[K"

    def _show(self, state: str) -> None:
        end = "" if state == "running" else "\n"
        sys.stderr.write(f"{self._erase}{self._line()[: _columns() - 1]}{end}")
        sys.stderr.flush()


class _RichBar(Bar):
    """A rich progress bar without its refresh thread, which would compete with the run."""

    def __enter__(self) -> Self:
        from rich.console import Console
        from rich.markup import escape
        from rich.progress import BarColumn, Progress, TextColumn

        columns = (
            TextColumn("{task.description}"),
            BarColumn(bar_width=28),
            TextColumn("{task.fields[state]}", style="dim", markup=False),
        )
        self._bar: Progress = Progress(*columns, console=Console(stderr=True), auto_refresh=False)
        self._task: Any = self._bar.add_task(escape(self.label), total=self.total or None, state="")
        self._bar.start()
        return self

    def _show(self, state: str) -> None:
        line = self._line()[len(self.label) :].strip()
        self._bar.update(self._task, completed=self.done, state=line)
        self._bar.refresh()
        if state != "running":
            self._bar.stop()


def duration(seconds: float) -> str:
    """``42 s``, ``3 min 20 s`` or ``2 h 05 min``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def _on_terminal() -> bool:
    try:
        return sys.stderr is not None and sys.stderr.isatty()
    except ValueError:  # closed
        return False


def _columns() -> int:
    import shutil

    return max(shutil.get_terminal_size().columns, 20)
