"""The journal of a sweep: what it is of, then one line a finished run, written at once.

Every line is JSON with a checksum (`towage.files.sealed`); numbers have the shortest digits that read back to the same bits.
A kill loses the runs in flight and at most tears the last line, which the next reader drops. Of two lines of one run the
first holds.
"""

from __future__ import annotations

import contextlib
import json
import os
import time as clock
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import msgspec

from towage.errors import FileError, TowageError
from towage.files import sealed, unsealed
from towage.sweeps.row import Row

SYNC = 1.0
"""Longest time that a line may wait for the disk, s; against a loss of power, a kill loses no line."""
SHOWN = 8
"""Differences listed when a journal is refused."""


LONGEST_LINE = 1 << 24
"""Of a line that is read, bytes: each may have the printed end of a crash, and the first the whole scene."""


class JournalError(FileError):
    """A journal that cannot be continued."""


class Journal:
    """The open journal at ``path``. ``identity``: everything that rows depend on. ``runs``: of the sweep. ``rows``: finished
    runs by index.

    Raises `JournalError` if there is one already and ``resume`` is not set, if it is of another sweep (the differences
    are listed), damaged, or in use.
    """

    def __init__(self, path: Path, identity: dict[str, Any], resume: bool, runs: int = 1 << 31) -> None:
        self.rows: dict[int, Row] = {}
        self._runs = runs
        self.path = path
        if path.exists() and path.stat().st_size and not resume:
            raise JournalError(
                f"{path.parent} holds a sweep already: continue it with --resume, or choose another --out"
            )
        try:
            self._file: IO[bytes] = open(path, "a+b")  # noqa: SIM115
        except OSError as error:
            raise JournalError(f"cannot write {path}: {error.strerror}") from error
        try:
            _lock(self._file, path)
            self._begin(identity)
        except BaseException:
            self._file.close()
            raise
        self._synced = clock.monotonic()

    def _begin(self, identity: dict[str, Any]) -> None:
        self._file.seek(0)
        begun, number, end = False, 0, 0
        while line := self._file.readline(LONGEST_LINE):
            number += 1
            if not line.endswith(b"\n"):
                if len(line) == LONGEST_LINE:
                    raise self._damaged(number)
                self._file.truncate(end)  # torn by a kill
                break
            end += len(line)
            if begun:
                self._read(line, number)
            else:
                self._compare(self._parsed(line, number).get("sweep"), identity)
                begun = True
        if not begun:
            self._write({"sweep": identity})

    def _read(self, line: bytes, number: int) -> None:
        """Take a row in, if it is one of this sweep."""
        try:
            row = msgspec.convert(self._parsed(line, number), Row)
        except msgspec.ValidationError:
            raise self._damaged(number) from None
        if not 0 <= row.index < self._runs:
            raise self._damaged(number)
        if row.status != "defect":  # of towage: done again, since it may be corrected by now
            self.rows.setdefault(row.index, row)

    def _parsed(self, line: bytes, number: int) -> dict[str, Any]:
        try:
            return unsealed(line)
        except (ValueError, RecursionError):
            raise self._damaged(number) from None

    def _damaged(self, number: int) -> JournalError:
        return JournalError(f"{self.path}: line {number} is damaged; delete it and its run is done again")

    def _compare(self, theirs: Any, ours: dict[str, Any]) -> None:
        if not isinstance(theirs, dict):
            raise JournalError(f"{self.path} is no journal of a sweep")
        old, new = _flat(theirs), _flat(json.loads(json.dumps(ours)))
        differ = [
            f"  {key}: {old.get(key, 'absent')!r} there, {new.get(key, 'absent')!r} here"
            for key in dict.fromkeys([*old, *new])
            if old.get(key) != new.get(key)
        ]
        if differ:
            more = [f"  and {len(differ) - SHOWN} more"] if len(differ) > SHOWN else []
            raise JournalError(
                "\n".join([f"{self.path} is of another sweep:", *differ[:SHOWN], *more, "choose another --out"])
            )

    def append(self, row: Row) -> None:
        """Keep a finished run."""
        self._write(vars(row))
        self.rows[row.index] = row

    def _write(self, fields: dict[str, Any]) -> None:
        line = sealed(fields)
        try:
            written = self._file.raw.write(line)  # type: ignore[attr-defined]
        except OSError as error:
            raise TowageError(f"cannot write {self.path}: {error.strerror}; continue with --resume") from error
        if written != len(line):  # the disk became full in its middle: the next reader drops it
            raise TowageError(f"cannot write {self.path}: the disk is full; continue with --resume")

    def sync(self) -> None:
        """Hand lines to the disk, if that was last done more than `SYNC` seconds ago."""
        if clock.monotonic() - self._synced > SYNC:
            os.fsync(self._file.fileno())
            self._synced = clock.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with contextlib.suppress(OSError):
            os.fsync(self._file.fileno())
        self._file.close()


def _lock(file: IO[bytes], path: Path) -> None:
    """Only one sweep writes a journal; the lock ends with its process. Not on Windows."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise JournalError(f"{path} is in use by another sweep: wait for it, or choose another --out") from None
    except OSError:  # a file system without locks
        return


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """Leaves by dotted key."""
    if isinstance(value, dict) and value:
        return {k: v for name, item in value.items() for k, v in _flat(item, f"{key}.{name}" if key else name).items()}
    return {key: value}
