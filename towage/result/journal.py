"""The journal of a run: what it is of, then every communication point and event, on disk at once.

A line (`towage.files.sealed`) tells names and all that a result says before its rows. Then frames follow: a tag, the
content, its CRC-32. ``R``: a row (time in s, then a double a name) that the scene records, ``r``: one that serves
comparisons alone, ``E``: an event, ``M``: what a unit said, ``T``: a time in s, a column of texts and its text from then on,
each as its length in 4 bytes and JSON. A row that is recorded is handed to the operating
system at once, so that a kill loses nothing before it; a loss of power may lose what the disk had not been given.
Reading ends at the first frame that is cut or damaged.
"""

from __future__ import annotations

import json
import os
import zlib
from array import array
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.errors import FileError
from towage.files import sealed, unsealed
from towage.result.records import Event
from towage.units.log import Message

FORMAT = 2
_SAID = (b"E", b"M", b"T")
"""Tags of frames of JSON."""
LONGEST_HEAD = 1 << 24
"""Bytes of the first line that are looked at."""
Array = NDArray[np.float64]


class Journal:
    """A journal that is written, at ``path``. ``names``: unit.variable, in the order of the values of a row; ``about``:
    `towage.result.result.Result.metadata`, None for a journal that is gone on with; ``interval`` between record times, s, and
    ``held``, the names that change at events only, tell how the record is read off the rows. A disk that becomes full costs the
    journal, not the run."""

    def __init__(
        self, path: Path, names: Sequence[str], about: Mapping[str, Any] | None = None, interval: float | None = None,
        held: Iterable[str] = (),
    ) -> None:  # fmt: skip
        self._waiting = bytearray()
        self._file: IO[bytes] | None = open(path, "ab" if about is None else "wb", buffering=0)  # noqa: SIM115
        if about is not None:
            head = {"journal": FORMAT, "names": list(names), "interval": interval, "held": sorted(held), "about": about}
            self._put(sealed(head))

    def row(self, row: bytes, recorded: bool) -> None:
        """Keep a row; one that is not recorded waits for the next that is."""
        frame = b"".join((b"R" if recorded else b"r", row, zlib.crc32(row).to_bytes(4, "little")))
        if not recorded:
            self._waiting += frame
            return
        if self._waiting:
            frame = bytes(self._waiting) + frame
            self._waiting.clear()
        self._put(frame)

    def event(self, event: Event) -> None:
        """Keep an event."""
        self._said(b"E", vars(event))

    def message(self, message: Message) -> None:
        """Keep what a unit said."""
        self._said(b"M", list(message))

    def text(self, time: float, name: str, text: str) -> None:
        """Keep that the column ``name`` has this text from ``time`` (s) on."""
        self._said(b"T", [time, name, text])

    def _said(self, tag: bytes, value: Any) -> None:
        text = json.dumps(value).encode()
        head = len(text).to_bytes(4, "little")
        self._waiting += b"".join((tag, head, text, zlib.crc32(text).to_bytes(4, "little")))
        self._put(bytes(self._waiting))
        self._waiting.clear()

    def size(self) -> int:
        """Bytes of the file, with all rows until now in it."""
        if self._waiting:
            self._put(bytes(self._waiting))
            self._waiting.clear()
        return os.fstat(self._file.fileno()).st_size if self._file else 0

    def _put(self, data: bytes) -> None:
        """Hand to the operating system; a frame that is cut would make the rest unreadable, so that it is the last."""
        if self._file:
            try:
                if self._file.write(data) == len(data):
                    return
            except OSError:
                pass
            self.close()

    def close(self) -> None:
        """Close the file, with all that waits."""
        if self._file:
            with suppress(OSError):
                if self._waiting:
                    self._file.write(self._waiting)
            self._file.close()
            self._file = None


@dataclass(frozen=True)
class Kept:
    """What a journal holds: its head, as `Journal`, and ``rows``, shape (n, 1 + names), time first; ``texts``: of every
    column of texts, from when (s) it has which; ``lost``: bytes that are no whole frames."""

    names: list[str]
    about: dict[str, Any]
    interval: float | None
    held: frozenset[str]
    rows: Array
    events: list[Event]
    messages: list[Message]
    texts: dict[str, list[tuple[float, str]]]
    lost: int


def read(file: IO[bytes]) -> Kept | None:
    """What the journal in an open file holds; None if it was never begun, or is none."""
    try:
        file.seek(0)
        head = unsealed(file.readline(LONGEST_HEAD))
        names, about, interval, held = head["names"], head["about"], head["interval"], frozenset(head["held"])
        if head["journal"] != FORMAT or not isinstance(about, dict) or not all(isinstance(n, str) for n in names):
            return None
        if interval is not None and not float(interval) > 0.0:
            return None
    except (OSError, ValueError, KeyError, TypeError):
        return None
    begin, size = file.tell(), os.fstat(file.fileno()).st_size
    rows, place = array("d"), begin
    kept = Kept(names, about, interval, held, np.empty(0), [], [], {}, 0)
    while frame := _frame(file, 8 * (1 + len(names))):
        tag, content = frame
        if tag in _SAID:
            try:
                _take(kept, tag, json.loads(content))
            except (ValueError, TypeError, RecursionError):
                break
        else:
            rows.frombytes(content)
        place = file.tell()
    shaped = np.array(rows).reshape(-1, 1 + len(names))
    return replace(kept, rows=shaped, lost=size - place)


def _take(kept: Kept, tag: bytes, said: Any) -> None:
    """What a frame of JSON says. Raises ValueError and TypeError where it is none of towage's."""
    if tag == b"E":
        kept.events.append(msgspec.convert(said, Event))
    elif tag == b"M":
        kept.messages.append(msgspec.convert(said, Message))
    else:
        time, name, text = msgspec.convert(said, tuple[float, str, str])
        kept.texts.setdefault(name, []).append((time, text))


def _frame(file: IO[bytes], width: int) -> tuple[bytes, bytes] | None:
    """(tag, content) of the next frame; None at the end, or where it is damaged."""
    tag = file.read(1)
    if tag in _SAID:
        width = int.from_bytes(file.read(4), "little")
    elif tag not in (b"R", b"r"):
        return None
    content = file.read(width) if width <= LONGEST_HEAD else b""
    if len(content) != width or file.read(4) != zlib.crc32(content).to_bytes(4, "little"):
        return None
    return tag, content


def read_at(path: Path) -> Kept:
    """What the journal at ``path`` holds. Raises `FileError` where there is none."""
    try:
        reading.checked_file(path, reading.MAX_RESULT)
        with open(path, "rb") as file:
            kept = read(file)
    except OSError as error:
        raise FileError(f"cannot read {path}: {error.strerror}") from error
    except reading.Refused as refused:
        raise FileError(f"cannot read {path}: {refused}") from refused
    if kept is None:
        raise FileError(f"{path} is no journal of a run, or one that was never begun")
    return kept
