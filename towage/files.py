"""Files that survive: a reader finds the old one or the new one, never half of one; lines that prove themselves; folders
and temporary files that are cleared by the next who passes, once whoever made them is gone."""

from __future__ import annotations

import errno
import json
import os
import secrets
import shutil
import tempfile
import time
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from towage.errors import TowageError

_REASONS = {
    errno.ENOENT: "its directory does not exist",
    errno.ENOTDIR: "a part of its path is not a directory",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "it exceeds the largest file size allowed here",
    errno.EACCES: "its directory is not writable",
    errno.EPERM: "its directory is not writable",
    errno.EROFS: "the file system is read-only",
}


_SEAL = b'{"crc32": "01234567", '
LONGEST_NAME = 100
"""Bytes of a text that go into the name of a file: file systems allow 255, and what is beside it has longer names."""
FRESH = 10.0
"""Younger than this a temporary is nobody's leftover: its maker may be about to lock it, s."""
FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS}
"""Error numbers that tell of the place, not of the program."""


def reason(error: OSError) -> str:
    """Why something could not be written, in words."""
    return _REASONS.get(error.errno or 0, error.strerror or str(error))


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """Binary stream whose content becomes ``path`` at the end of the block, at once and durably.

    The stream is a temporary file in the same directory: flushed, synced and renamed if the block ends well, removed if
    it raises. A symbolic link is followed. Raises TowageError if anything cannot be written; an earlier file is kept.
    """
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{cut(target.name)}.{secrets.token_hex(6)}.tmp")
    try:
        if target.exists() and not target.is_file():
            raise TowageError(
                f"cannot write {os.fspath(path)}: there is something that is not a file; choose another name"
            )
        clear(target.parent, f".{cut(target.name)}.", ".tmp")
        with open(temporary, "xb") as stream:
            _lock(stream.fileno())
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, target)
        _sync_directory(target.parent)
    except OSError as error:
        kept = "; the earlier file is kept" if target.is_file() else ""
        raise TowageError(f"cannot write {os.fspath(path)}: {reason(error)}{kept}") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def _sync_directory(directory: Path) -> None:
    """Makes a rename durable where directories can be synced (not on Windows)."""
    with suppress(OSError):
        descriptor = os.open(directory, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def cut(text: str, longest: int = LONGEST_NAME) -> str:
    """The first ``longest`` bytes of the text as UTF-8, in whole letters."""
    return text.encode(errors="replace")[:longest].decode(errors="ignore")


def sealed(fields: Mapping[str, Any]) -> bytes:
    """One line of JSON whose first item, ``crc32``, is that of the others as they are written; `unsealed` checks it. Numbers
    read back to the same bits. There is one field at least."""
    text = json.dumps(fields).encode()
    return b'{"crc32": "%08x", %b\n' % (zlib.crc32(text), text[1:])


def unsealed(line: bytes) -> dict[str, Any]:
    """What `sealed` wrote. Raises ValueError for anything else."""
    head, text = line[: len(_SEAL)], b"{" + line[len(_SEAL) :].rstrip(b"\n")
    if head != b'{"crc32": "%08x", ' % zlib.crc32(text):
        raise ValueError("its checksum does not fit")
    fields: dict[str, Any] = json.loads(text)
    return fields


@contextmanager
def claimed(folder: Path) -> Iterator[Path]:
    """``folder``, locked as long as the block lasts: `clear` and `in_use` see that somebody works in it."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        _lock(descriptor)
        yield folder
    finally:
        os.close(descriptor)


@contextmanager
def scratch(prefix: str = "towage-", parent: Path | None = None) -> Iterator[Path]:
    """A temporary folder, removed at the end. What others left behind under this prefix when they were killed is cleared
    first."""
    place = parent or Path(tempfile.gettempdir())
    with suppress(OSError):
        place.mkdir(parents=True, exist_ok=True)  # it may have been wiped since this process began
    clear(place, prefix)
    folder = Path(tempfile.mkdtemp(prefix=prefix, dir=place))
    try:
        with claimed(folder):
            yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def in_use(place: Path) -> bool:
    """Whether somebody holds the lock of a file or folder; False where files cannot be locked."""
    try:
        descriptor = os.open(place, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
    except OSError:
        return False
    try:
        return not _lock(descriptor)
    finally:
        os.close(descriptor)


def clear(parent: Path, prefix: str, suffix: str = "") -> None:
    """Remove what killed processes of this user left in ``parent`` under names of that form: unlocked, and not made just
    now. Nothing where files cannot be locked (Windows)."""
    if os.name == "nt":
        return
    with suppress(OSError), os.scandir(parent) as entries:
        for entry in entries:
            if not (entry.name.startswith(prefix) and entry.name.endswith(suffix)) or entry.is_symlink():
                continue
            with suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                if status.st_uid != os.getuid() or time.time() - status.st_mtime < FRESH or in_use(Path(entry.path)):
                    continue
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.path, ignore_errors=True)
                else:
                    os.unlink(entry.path)


def _lock(descriptor: int) -> bool:
    """Lock an open file or folder until it is closed, in this process or by its end; False if another has it."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True
