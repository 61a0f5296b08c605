"""Writing a file so that a reader finds the old one or the new one, never half of one."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

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
    temporary = target.with_name(f".{target.name[:64]}.{secrets.token_hex(6)}.tmp")
    try:
        if target.exists() and not target.is_file():
            raise TowageError(
                f"cannot write {os.fspath(path)}: there is something that is not a file; choose another name"
            )
        with open(temporary, "xb") as stream:
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
