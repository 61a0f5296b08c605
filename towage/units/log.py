"""What the FMUs of a run say: every message with its unit and time, bounded, and the one that explains a failure."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal")
DISCARD, ERROR = 2, 3
MOST = 1000
"""Messages of one unit that are kept."""


class Message(NamedTuple):
    """What a unit logged: the time of the run that was reached, s (None before the start), its status and category."""

    time: float | None
    unit: str
    status: str
    category: str
    text: str

    def line(self) -> str:
        """As a line of a log file."""
        when = "start" if self.time is None else f"t = {self.time:.9g} s"
        about = ", ".join(part for part in (self.status, self.category) if part)
        return f"{when}, {self.unit}, {about}: {self.text}"


class Log:
    """The messages of one unit, and how often it returned Warning, first at ``warned_at`` (s)."""

    def __init__(self, unit: str) -> None:
        self.unit = unit
        self.messages: list[Message] = []
        self.lost = 0
        self.warnings = 0
        self.warned_at: float | None = None
        self._marked = 0
        self._now: Callable[[], float | None] = lambda: None
        self._write: Callable[[Message], None] = lambda message: None

    def take_up(self, messages: list[Message]) -> None:
        """What an earlier part of the run said, in the place of all until now."""
        self.messages[:] = messages
        self.mark()

    def follow(
        self, now: Callable[[], float | None], write: Callable[[Message], None] | None = None, past: bool = True
    ) -> None:
        """From now on messages carry the time that ``now`` tells, and go to ``write`` too, with ``past`` those before first."""
        self._now = now
        if write:
            self._write = write
            for message in self.messages if past else ():
                write(message)

    def add(self, status: int, category: str, text: str) -> None:
        """Keep a message, as long as there is room."""
        if len(self.messages) >= MOST:
            self.lost += 1
            return
        word = STATUS[status] if 0 <= status < len(STATUS) else f"status {status}"
        message = Message(self._now(), self.unit, word, category, text)
        self.messages.append(message)
        self._write(message)

    def warn(self, time: float | None) -> None:
        """A call returned Warning."""
        self.warned_at = self.warned_at if self.warnings else time
        self.warnings += 1

    def mark(self) -> None:
        """What was said until now explains nothing that comes later."""
        self._marked = len(self.messages)

    @property
    def said(self) -> str:
        """What explains a failure: the first message of a refusal or error since `mark`, else the last one."""
        fresh = self.messages[self._marked :]
        grave = (m.text for m in fresh if m.status in STATUS[DISCARD:])
        return next(grave, self.messages[-1].text if self.messages else "")
