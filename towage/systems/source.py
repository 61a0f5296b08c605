"""The files of a system: an archive or a folder, read within bounds, and never outside of it.

A source is named as the formats do, by a relative URI. What leaves the archive or the folder is refused, and so is whatever
would have to be fetched from elsewhere. FMUs of an archive are unpacked into
the cache, in a folder called by the archive's digest.
"""

from __future__ import annotations

import io
import posixpath
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn
from urllib.parse import unquote
from xml.etree import ElementTree
from xml.parsers import expat

from towage import reading
from towage.errors import FmuError, SceneError, suggest
from towage.files import atomic_write
from towage.units.archive import crc, opened, read_description
from towage.units.description import Description
from towage.units.store import cache

MAX_XML = 64 * 2**20
"""Of a description, bytes."""
LONGEST = 200
"""Letters of a part of a name."""
_SCHEME = re.compile("[A-Za-z][A-Za-z0-9+.-]*:")


class Files:
    """The files below a folder, or in an archive (`Archive`). ``beyond``: those of folders beside it too."""

    def __init__(self, root: Path, beyond: bool = False) -> None:
        self.root, self.beyond = root, beyond

    def fault(self, message: str, name: str = "") -> NoReturn:
        """Raise what is wrong with a file."""
        raise SceneError(message, file=self.root, key=name)

    def name(self, uri: str, base: str = "") -> str:
        """The file that a relative URI names in the document ``base``. Raises `SceneError` for any other URI."""
        if _SCHEME.match(uri) or uri.startswith(("/", "\\")):
            self.fault(
                f"{uri!r} is not fetched: put the file beside the description and name it by a relative path", base
            )
        path = posixpath.normpath(posixpath.join(posixpath.dirname(base), unquote(uri).replace("\\", "/")))
        if path.split("/")[0] == ".." and not self.beyond:
            self.fault(f"{uri!r} leaves the system: put the file beside the description", base)
        if any(letter < " " for letter in path) or max(map(len, path.split("/"))) > LONGEST:
            self.fault(f"{uri!r} is no name of a file", base)
        return path

    def names(self) -> list[str]:
        """The files at the top."""
        return sorted(path.name for path in self.root.iterdir() if path.is_file())

    def path(self, name: str) -> Path:
        """The file itself. Raises `SceneError` where there is none."""
        place = self.root / name
        if not place.is_file():
            there = [path.name for path in place.parent.iterdir()] if place.parent.is_dir() else []
            self.fault("there is no such file" + suggest(place.name, there), name)
        if not self.beyond and not place.resolve().is_relative_to(self.root.resolve()):
            self.fault("is a link that leaves the folder", name)
        return place

    def read(self, name: str) -> bytes:
        """The bytes of a description. Raises `SceneError`."""
        with self._reading(name):
            return reading.content(self.path(name), MAX_XML)

    def xml(self, name: str, root: str, texts: bool = False) -> ElementTree.Element:
        """The root element of a description, which must be called ``root``, in whatever namespace. Raises `SceneError`."""
        data = self.read(name)
        with self._reading(name):
            try:
                element = reading.xml(io.BytesIO(data), texts)
            except (expat.ExpatError, ValueError, LookupError, AssertionError) as error:
                if isinstance(error, reading.Refused):
                    raise
                self.fault(f"is not well-formed XML: {error}", name)
        if local(element) != root:
            self.fault(f"root element is {element.tag!r}, expected {root!r}", name)
        return element

    def description(self, name: str) -> Description:
        """Of an FMU. Raises `SceneError` that names the system and the file."""
        try:
            return read_description(self.path(name))
        except FmuError as error:
            self.fault(f"{error.entry}: {error.args[0]}" if error.entry else error.args[0], name)

    @contextmanager
    def _reading(self, name: str) -> Iterator[None]:
        """What goes wrong in the block becomes a `SceneError`."""
        try:
            yield
        except reading.Refused as error:
            self.fault(str(error), name)
        except FmuError as error:
            self.fault(error.args[0], error.entry or name)
        except OSError as error:
            self.fault(f"cannot be read: {error.strerror or error}", name)


class Archive(Files):
    """The files of a zip archive. Raises `SceneError` for one that is refused."""

    def __init__(self, root: Path) -> None:
        super().__init__(root)
        with self._reading(""), opened(root) as archive:
            self._entries = {entry.orig_filename: entry for entry in archive.infolist() if not entry.is_dir()}

    def names(self) -> list[str]:
        """The files at the top."""
        return sorted(name for name in self._entries if "/" not in name)

    def _check(self, name: str) -> None:
        if name not in self._entries:
            self.fault("there is no such file in the archive" + suggest(name, self._entries), name)

    def read(self, name: str) -> bytes:
        """The bytes of a description. Raises `SceneError`."""
        self._check(name)
        with self._reading(name), opened(self.root) as archive:
            reading.limited(self._entries[name].file_size, MAX_XML, "bytes")
            return archive.read(self._entries[name])

    def path(self, name: str) -> Path:
        """The file, unpacked into the cache. Raises `SceneError` where there is none."""
        self._check(name)
        entry = self._entries[name]
        with self._reading(name):
            place = cache() / "systems" / reading.digest(self.root)[:32] / name
            if place.is_file() and place.stat().st_size == entry.file_size and crc(place) == entry.CRC:
                return place
            place.parent.mkdir(parents=True, exist_ok=True)
            with opened(self.root) as archive, archive.open(entry) as packed, atomic_write(place) as stream:
                shutil.copyfileobj(packed, stream)
        return place


def local(element: ElementTree.Element) -> str:
    """The tag without the prefix of its namespace."""
    return element.tag.rpartition(":")[2]
