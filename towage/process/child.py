"""A supervised child process: it is given a request, tells of its progress, answers or dies.

Requests go to its stdin, which stays open: its end tells the child that the parent is gone. What the child says
comes back as JSON, one object a line: ``{"share", "text"}`` for progress, anything else is the answer. The child moves
its stdout to a private descriptor first, so that what a library prints goes to stderr and is not taken for an answer.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import IO, Any, Self

from towage.process import stop
from towage.process.overseer import Limits
from towage.terminal import escaped

POLL = 0.1
"""Longest wait for a line before the child is looked at, s."""
START = 30.0
"""What a child is given beyond the timeout until it first speaks, s: it loads its libraries."""
GRACE = 5.0
"""What a child that has answered, or is to write its stack, is given to end, s."""
LOOKS = 50
"""Waits of `POLL` for a last line of a child that has ended, whose pipe a process that it left behind may hold open."""
SHOWN_LINES = 20
SHOWN_BYTES = 500
"""Of what a child prints the end is kept: lines, and the bytes of each, because a unit may print without end of line."""
Report = Callable[[float, str], None]
NO_LIMITS = Limits()


class Clock:
    """Tells the time by which the silence of a child is measured. Tests put another one in the place of `CLOCK`, so that
    a slow machine makes no child late."""

    def now(self, pid: int) -> float:
        """The time in s from any origin, for the child of that process id."""
        return time.monotonic()


CLOCK = Clock()


class Died(Exception):
    """The child ended, or was ended, without an answer: what happened, ``printed``, the last it printed, and ``code``, its
    exit code or minus the signal that ended it; None if it was ended here."""

    printed: str = ""
    code: int | None = None


class Hung(Died):
    """The child made no progress and was ended."""


class Child:
    """A process that runs ``main()`` of ``module`` within ``limits``, asked one thing after another. It finds modules where
    this process does. A context manager; its end is the child's, and that of all that the child started, whatever state
    they are in (`towage.process.overseer`)."""

    def __init__(self, module: str, limits: Limits = NO_LIMITS) -> None:
        paths = [path or os.getcwd() for path in sys.path]
        self._life, theirs = socket.socketpair()
        start = (
            f"import sys; sys.path[:] = {paths!r}; from towage.process.overseer import Limits, oversee; "
            f"oversee({theirs.fileno()}, {limits!r}); from {module} import main; main()"
        )
        pipe, inherited = subprocess.PIPE, (theirs.fileno(),) if os.name == "posix" else ()
        with theirs:
            self.process = subprocess.Popen(
                [sys.executable, "-c", start], stdin=pipe, stdout=pipe, stderr=pipe, pass_fds=inherited
            )
        assert self.process.stdin and self.process.stdout and self.process.stderr
        self._limits, self._pid = limits, 0
        self._stdin, self._streams = self.process.stdin, (self.process.stdout, self.process.stderr)
        self._lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._printed: deque[bytes] = deque(maxlen=SHOWN_LINES)
        self._threads = [
            threading.Thread(target=_drain, args=(stream, *how), daemon=True)
            for stream, how in zip(self._streams, ((-1, self._lines.put), (SHOWN_BYTES, self._printed.append)))
        ]
        for thread in self._threads:
            thread.start()

    @property
    def pid(self) -> int:
        """The id of the process that does the work; its overseer tells it as soon as it has forked."""
        if not self._pid:
            with contextlib.suppress(OSError):  # a timeout is one
                self._life.settimeout(START)
                self._pid = int.from_bytes(self._life.recv(8), "little")
            self._pid = self._pid or self.process.pid
        return self._pid

    @property
    def printed(self) -> str:
        """The last it printed."""
        return b"".join(self._printed.copy()).decode(errors="replace")

    def ask(self, request: bytes, report: Report | None, timeout: float) -> dict[str, Any]:
        """Its answer. ``timeout`` is the longest silence, s; repeated progress counts as silence. Raises `Died`."""
        with contextlib.suppress(OSError):  # a child that died at once is found dead below
            self._stdin.write(request)
            self._stdin.flush()
        return self._listen(report, timeout)

    def end(self) -> None:
        """End the child, if it lives, and all that it started."""
        self._life.close()
        try:
            self.process.wait(GRACE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def _listen(self, report: Report | None, timeout: float) -> dict[str, Any]:
        """Pass progress on until the child answers. Of a wait at most `POLL` counts as silence, so that a machine or a
        terminal that was suspended kills nobody."""
        silence, looks, begin, before = 0.0, 0, time.monotonic(), CLOCK.now(self.pid)
        last: tuple[float, str] | None = None
        while True:
            stop.look()
            gone = self.process.poll() is not None
            ended = gone and not self._threads[0].is_alive()
            message, empty = _next_message(self._lines)
            now = CLOCK.now(self.pid)
            silence, before = silence + min(now - before, POLL), now
            if message is not None:
                if "share" not in message:
                    return message
                if (message["share"], message["text"]) != last:
                    silence, last = 0.0, (message["share"], message["text"])
                    if report:
                        report(message["share"], message["text"])
            looks += gone and empty
            if (ended and empty) or looks > LOOKS:
                death = Died(_fate(self.process.returncode))
                death.code = self.process.returncode
                raise death
            if silence >= (timeout if last else timeout + START):
                self._ask_for_stack()
                raise Hung(f"made no progress for {timeout:g} s and was stopped")
            if self._limits.total and time.monotonic() - begin > self._limits.total:
                raise Hung(f"took longer than its limit of {self._limits.total:g} s in all and was stopped")

    def _ask_for_stack(self) -> None:
        """Have a hung child write its stack, which it can do from a signal handler and then ends; else end it."""
        if hasattr(signal, "SIGUSR1"):
            self.process.send_signal(signal.SIGUSR1)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(GRACE)
        self.end()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.end()
        with contextlib.suppress(OSError):
            self._stdin.close()
        for thread, stream in zip(self._threads, self._streams):
            thread.join(GRACE)
            if not thread.is_alive():
                stream.close()


def converse(
    module: str, request: bytes, report: Report | None, timeout: float, limits: Limits = NO_LIMITS
) -> dict[str, Any]:
    """Ask a child one thing and see it end; returns its answer.

    Raises `Died`, with what the child printed. Whatever else ends the conversation (Ctrl-C, an error in ``report``) ends
    the child.
    """
    child = Child(module, limits)
    try:
        with child:
            answer = child.ask(request, report, timeout)
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.process.wait(GRACE)
    except Died as death:
        death.printed = child.printed.strip()
        raise
    sys.stderr.write(escaped(child.printed))
    return answer


def attend() -> tuple[IO[bytes], Callable[[dict[str, Any]], None]]:
    """In a child: (what it is asked, how it answers). From now on only the parent interrupts it, and nothing else that
    is printed is taken for an answer."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGUSR2"):  # these may reach both; the parent decides
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    requests, channel = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)

    def say(message: dict[str, Any]) -> None:
        """Send one message to the parent; without a parent the process ends."""
        try:
            print(json.dumps(message), file=channel, flush=True)
        except OSError:  # the parent is gone
            os._exit(1)

    return requests, say


def _drain(stream: IO[bytes], longest: int, keep: Callable[[bytes], None]) -> None:
    while line := stream.readline(longest):
        keep(line)


def _next_message(lines: queue.SimpleQueue[bytes]) -> tuple[dict[str, Any] | None, bool]:
    """(what the next line says, None if it is no message; whether there was no line for `POLL` s)."""
    line = b""
    with contextlib.suppress(queue.Empty):
        line = lines.get(timeout=POLL)
    with contextlib.suppress(ValueError):  # a line may be printed before the child moves its stdout
        message = json.loads(line)
        if isinstance(message, dict):
            return message, False
    return None, not line


def _fate(code: int) -> str:
    if code >= 0:
        return f"ended the process of the run (exit code {code})"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    hint = {
        "SIGKILL": ": perhaps the machine ran out of memory",
        "SIGXCPU": ": its processor time is used up (--max-cpu)",
    }.get(name, "")
    return f"crashed the process of the run ({name}, {(signal.strsignal(-code) or '').lower()}{hint})"
