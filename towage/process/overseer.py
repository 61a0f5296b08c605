"""The process between a run and its parent, which sees that nothing of the run outlives it.

It forks before anything heavy is loaded: the child goes on to the work, the overseer waits. It is the leader of a session
and the reaper of all that descends from it: whatever a unit forks or makes a daemon is ended with the run, or as soon as
the parent is gone, whatever that died of. The overseer ends as the child did. Where there is no fork (Windows), the process
itself does the work; where there is no reaper (macOS), the process group is ended.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from typing import NamedTuple

ENOUGH = 5.0
"""What the descendants are given to be gone after SIGKILL, s."""
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36


class Limits(NamedTuple):
    """Of the process of a run: ``memory``, address space in bytes; ``processor``, time in s; ``total``, time on the clock
    in s, which the parent watches. None: no limit but those of this process."""

    memory: int | None = None
    processor: float | None = None
    total: float | None = None


def oversee(life: int, limits: Limits) -> None:
    """Return in a new process that is to do the work, within the limits. ``life``: a socket to the parent, which is told the
    id of that process; its end tells that the parent is gone."""
    if not hasattr(os, "fork"):
        return
    os.setsid()
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGUSR2"):  # the parent decides
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    worker = os.fork()
    if not worker:
        os.close(life)
        os.setpgid(0, 0)
        _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        limit(limits)
        return
    code = 1
    try:
        signal.signal(signal.SIGUSR1, lambda number, frame: os.kill(worker, number))
        with contextlib.suppress(OSError):
            os.write(life, worker.to_bytes(8, "little"))
        for descriptor in (0, 1, 2):  # whose ends are the worker's to tell
            os.close(descriptor)
        code = _wait(worker, life)
    finally:
        _end(worker)
        _end_as(code)


def _wait(worker: int, life: int) -> int:
    """The exit status of the worker, as `os.waitpid` has it, or SIGKILL where the parent is gone."""
    import select

    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)
    while True:
        with contextlib.suppress(ChildProcessError):
            while True:  # orphans end here too
                pid, status = os.waitpid(-1, os.WNOHANG)
                if pid == worker:
                    return status
                if not pid:
                    break
        ready, _, _ = select.select([reading, life], [], [])
        if reading in ready:
            os.read(reading, 4096)
        if life in ready and not os.read(life, 1):
            return int(signal.SIGKILL)


def _end(worker: int) -> None:
    """Kill the worker and all that descends from it: what it left behind becomes a child of this process."""
    until = time.monotonic() + ENOUGH
    with contextlib.suppress(ChildProcessError):
        while time.monotonic() < until:
            with contextlib.suppress(OSError):
                os.killpg(worker, signal.SIGKILL)
            for pid in _children():
                with contextlib.suppress(OSError):
                    os.kill(pid, signal.SIGKILL)
            if not os.waitpid(-1, os.WNOHANG)[0]:
                time.sleep(0.002)


def _children() -> list[int]:
    """The children of this process, where the system tells them (Linux)."""
    me, found = os.getpid(), []
    for name in os.listdir("/proc") if os.path.isdir("/proc") else ():
        with contextlib.suppress(OSError, ValueError, IndexError), open(f"/proc/{name}/stat", "rb") as file:
            if int(file.read().rpartition(b")")[2].split()[1]) == me:  # the name of a program may have spaces
                found.append(int(name))
    return found


def _end_as(status: int) -> None:
    """End as a process of this status did, without another dump of memory."""
    if os.WIFEXITED(status):
        os._exit(os.WEXITSTATUS(status))
    number = os.WTERMSIG(status)
    with contextlib.suppress(Exception):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if number not in (signal.SIGKILL, signal.SIGSTOP):
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    os._exit(128 + number)


def limit(limits: Limits) -> None:
    """Set what may be used up from here on."""
    import resource

    def lower(kind: int, value: int) -> None:
        """Not above what is allowed already."""
        hard = resource.getrlimit(kind)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(kind, (value, hard))

    if limits.memory is not None:
        lower(resource.RLIMIT_AS, limits.memory)
    if limits.processor is not None:
        lower(resource.RLIMIT_CPU, max(1, round(limits.processor)))


def _prctl(option: int, value: int) -> None:
    if sys.platform != "linux":
        return
    import ctypes

    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)
