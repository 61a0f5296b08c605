"""Archives that follow from their members alone: fixed order, times and permissions, so that two are byte-identical."""

from __future__ import annotations

import io
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

TIMESTAMP = (2000, 1, 1, 0, 0, 0)


def write(path: Path, members: Mapping[str, bytes]) -> None:
    """Write the FMU. It appears at once: two processes may build the same FMU."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for member in sorted(members, key=lambda m: (m != "modelDescription.xml", m)):
            info = zipfile.ZipInfo(member, TIMESTAMP)
            info.external_attr = 0o644 << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, members[member])
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.parent / f".{path.stem}.{os.getpid()}.tmp"
    try:
        temporary.write_bytes(buffer.getvalue())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def read(path: Path) -> dict[str, bytes]:
    """The members of the archive at ``path``; none if it is absent, damaged or holds a name twice."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            return {n: archive.read(n) for n in names} if len(set(names)) == len(names) else {}
    except (OSError, ValueError, EOFError, RuntimeError, zlib.error, zipfile.BadZipFile):
        return {}
