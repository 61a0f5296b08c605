"""The signals that end a job, heard and not obeyed at once: what was recorded is worth more than a quick end.

Between `heeded` and its end such a signal only leaves a note. Who waits for a run looks at the note and stops there; who
writes files does not look, so that no second signal, however soon, costs a file.
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator

NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU", "SIGUSR1", "SIGUSR2", "SIGBREAK")
"""Ctrl-C; the end of a job, of its terminal, of its processor time; what batch systems send some time before they kill."""
_heard: list[int] = []


def asked() -> str:
    """The name of the signal that asked for the end, or ""."""
    return signal.Signals(_heard[0]).name if _heard else ""


def look() -> None:
    """Raises KeyboardInterrupt where the end was asked for."""
    if _heard:
        raise KeyboardInterrupt


@contextlib.contextmanager
def heeded(at_once: bool = False) -> Iterator[None]:
    """Signals that end a job leave a note meanwhile; ``at_once``: the first raises KeyboardInterrupt too, for work that looks
    at no note. Only in the main thread may they be caught; elsewhere nothing changes.
    A signal that this process was started to ignore, as SIGHUP by nohup, stays ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def note(number: int, frame: object) -> None:
        """The handler."""
        _heard.append(number)
        if at_once and len(_heard) == 1:
            raise KeyboardInterrupt

    before = {}
    try:
        for number in (getattr(signal, name) for name in NAMES if hasattr(signal, name)):
            if signal.getsignal(number) is not signal.SIG_IGN:
                before[number] = signal.signal(number, note)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _heard.clear()
