"""Reading what others wrote: sizes, counts and depth are looked at before memory is taken for them.

Whatever is in a file, reading it takes less than 300 MB and some seconds, or as much as the file really holds. What is
refused becomes a `Refused` whose text tells the number and the limit; the caller adds file and place.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import re
import struct
import tokenize
import tomllib
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any
from xml.etree import ElementTree
from xml.parsers import expat

if TYPE_CHECKING:
    from numpy.typing import NDArray

MB = 2**20
MAX_FILE = 512 * MB
"""Of an archive or a forecast, bytes."""
MAX_RESULT = 1 << 36
"""Of a result, bytes: as long as all of it is there."""
MAX_TEXT = MB
"""Of a TOML file, bytes."""
MAX_KEY = 50
"""Parts of a dotted key: tomllib keeps all its beginnings."""
_LONG_KEY = re.compile(rf"(?<![\w\"'.-])[\w\"'-]++(?:[ \t]*\.[ \t]*[\w\"'-]++){{{MAX_KEY}}}")
MAX_JSON = 64 * MB
MAX_ITEMS = 1_000_000
"""Of JSON: separators and brackets, each of which may cost 100 bytes."""
MAX_DEPTH = 100
"""Levels of elements of XML."""
MAX_TAG = MB
"""Of XML between < and >, bytes."""
MAX_TREE = 160 * MB
"""Of the elements and attributes of XML as they are kept, bytes: some 100 000 variables of an FMU."""
MAX_DIRECTORY = 8 * MB
"""Of the table of contents of an archive, bytes: some 50 000 entries."""
MAX_HEAD = 10_000
"""Letters of the head of an array, as in numpy."""
MAX_RATIO, RATIO_FLOOR = 200, 16 * MB
"""Of unpacked to packed bytes, and the bytes unpacked below which no ratio is a bomb."""
MAX_HOLES = 16
"""Of the bytes of a file to those on the disk, where it has more than `RATIO_FLOOR`."""
CHUNK = 1 << 16


class Refused(ValueError):
    """What a file holds is more than is read, or not what it should be."""


def limited(number: float, most: float, what: str) -> None:
    """Raises `Refused` where the ``number`` of ``what`` is above ``most``."""
    if number > most:
        raise Refused(f"{number:,.0f} {what}, more than {most:,.0f}: refused")


def checked_file(path: str | os.PathLike[str], most: int = MAX_FILE) -> int:
    """The size of a file, bytes. Raises `Refused` for one that is too large, is sparse or no file, and OSError."""
    status = os.stat(path)
    if not os.path.isfile(path):
        raise Refused("cannot be read: it is no file")
    limited(status.st_size, most, "bytes")
    held = getattr(status, "st_blocks", status.st_size) * 512
    if status.st_size > RATIO_FLOOR and status.st_size > MAX_HOLES * held:
        raise Refused(f"{status.st_size:,} bytes, of which {held:,} are on the disk: refused as a file of holes")
    return status.st_size


def memory() -> float:
    """What this process may use, bytes: all of the machine's, or its limit; infinite where that is not known."""
    most = math.inf
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        most = math.inf if limit == resource.RLIM_INFINITY else float(limit)
        most = min(most, float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    return most


@contextlib.contextmanager
def foreign(path: str | os.PathLike[str], what: str) -> Iterator[None]:
    """For a file that a library of others reads in the block, as netCDF: its size is looked at first, and whatever the library
    raises becomes a `Refused`, since nobody knows what it may be."""
    try:
        checked_file(path)
        yield
    except Refused:
        raise
    except MemoryError as error:
        raise Refused(f"is not a readable {what}: it takes more memory than a file of its size should") from error
    except Exception as error:
        raise Refused(f"is not a readable {what}: {type(error).__name__}: {error}") from error


def content(path: str | os.PathLike[str], most: int) -> bytes:
    """The bytes of a file. Raises `Refused` where there are more than ``most``, and OSError."""
    checked_file(path, most)
    with open(path, "rb") as file:
        data = file.read(most + 1)  # it may grow, or be a pipe
    limited(len(data), most, "bytes")
    return data


def digest(path: Path) -> str:
    """SHA-256 of a file, which is not taken into memory. Raises `Refused` and OSError."""
    checked_file(path)
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def toml(text: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises ValueError, of which `Refused` and TOMLDecodeError are kinds."""
    limited(len(text), MAX_TEXT, "letters")
    for line in text.splitlines():
        if line.count(".") >= MAX_KEY and (found := _LONG_KEY.search(line)):
            raise Refused(f"a key of more than {MAX_KEY} parts, {found[0][:40]}...: refused")
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise Refused("tables or lists within one another too deep") from None
    if large := next(_too_large(tables, ""), ""):
        raise Refused(f"{large} has a number beyond 64 bits")
    return tables


def _too_large(value: Any, key: str) -> Iterator[str]:
    """Keys of whole numbers that TOML does not allow."""
    left = [(key, value)]
    while left:
        key, value = left.pop()
        if isinstance(value, dict):
            left += [(f"{key}.{name}".strip("."), item) for name, item in value.items()]
        elif isinstance(value, list):
            left += [(f"{key}[{place}]", item) for place, item in enumerate(value)]
        elif isinstance(value, int) and not -(2**63) <= value < 2**63:
            yield key


def from_json(text: bytes, most: int = MAX_JSON) -> Any:
    """The value of a JSON text. Raises ValueError, of which `Refused` and JSONDecodeError are kinds."""
    limited(len(text), most, "bytes of JSON")
    limited(sum(text.count(mark) for mark in (b"[", b"{", b",", b":")), MAX_ITEMS, "items of JSON")
    try:
        return json.loads(text)
    except RecursionError:
        raise Refused("lists or tables within one another too deep") from None


def xml(stream: IO[bytes], texts: bool = False) -> ElementTree.Element:
    """The root element of an XML text; characters between elements are kept where ``texts``. A DOCTYPE is refused before any
    entity of it is looked at. Raises `Refused`, and what expat raises."""
    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    depth, kept = 0, 0

    def doctype(*_: object) -> None:
        """Called at a DOCTYPE."""
        raise Refused("contains a DOCTYPE, which FMI does not need: refused")

    def start(name: str, attributes: dict[str, str]) -> None:
        """Called at the begin of an element."""
        nonlocal depth, kept
        depth += 1
        kept += 200 + len(name) + 90 * len(attributes) + sum(map(len, attributes.values()))
        limited(depth, MAX_DEPTH, "levels of elements")
        limited(kept, MAX_TREE, "bytes of elements and attributes")
        builder.start(name, attributes)

    def end(name: str) -> None:
        """Called at the end of an element."""
        nonlocal depth
        depth -= 1
        builder.end(name)

    def between(characters: str) -> None:
        """Called for characters between elements."""
        nonlocal kept
        kept += len(characters)
        limited(kept, MAX_TREE, "bytes of elements and attributes")
        builder.data(characters)

    parser.StartDoctypeDeclHandler = doctype
    if texts:
        parser.CharacterDataHandler = between
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    given = 0
    while data := stream.read(CHUNK):
        parser.Parse(data, False)
        given += len(data)
        limited(given - max(parser.CurrentByteIndex, 0), MAX_TAG + CHUNK, "bytes of one tag")
    parser.Parse(b"", True)
    return builder.close()


def check_directory(path: str | os.PathLike[str] | IO[bytes]) -> None:
    """Look at the size of the table of contents of a zip archive, which zipfile reads at once. Raises `Refused` and
    OSError; what is no archive at all is for zipfile to tell."""
    if isinstance(path, str | os.PathLike):
        with open(path, "rb") as file:
            check_directory(file)
            return
    path.seek(0, os.SEEK_END)
    end = path.tell()
    path.seek(max(0, end - CHUNK - 100))
    tail = path.read()
    path.seek(0)
    place = tail.rfind(b"PK\5\6")
    if place < 0 or len(tail) < place + 22:
        return
    size = int.from_bytes(tail[place + 12 : place + 16], "little")
    if tail[max(0, place - 20) :].startswith(b"PK\6\7") and tail[max(0, place - 76) :].startswith(b"PK\6\6"):
        size = int.from_bytes(tail[place - 36 : place - 28], "little")
    limited(size, MAX_DIRECTORY, "bytes of the archive's table of contents")


def check_entries(archive: zipfile.ZipFile, packed: int) -> None:
    """Look at the entries of an archive of ``packed`` bytes by its table of contents alone: no bomb, none encrypted.
    Raises `Refused`."""
    unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > RATIO_FLOOR and unpacked > MAX_RATIO * packed:
        raise Refused(f"unpacks to {unpacked / packed:.0f} times its size: refused as a bomb")
    for entry in archive.infolist():
        if entry.flag_bits & 1:
            raise Refused(f"{entry.filename!r} is encrypted")
        if entry.compress_type == zipfile.ZIP_STORED and entry.file_size != entry.compress_size:
            raise Refused(f"{entry.filename!r} has {entry.file_size} bytes, of which {entry.compress_size} are there")


def npz(path: str | os.PathLike[str] | IO[bytes]) -> dict[str, NDArray[Any]]:
    """The arrays of an npz archive by name, each no larger than what is there. Raises `Refused` for anything else, and
    OSError."""
    try:
        size = checked_file(path, MAX_RESULT) if isinstance(path, str | os.PathLike) else MAX_RESULT
        check_directory(path)
        with zipfile.ZipFile(path) as archive:
            check_entries(archive, size)
            names = archive.namelist()
            if len(set(names)) < len(names):
                raise Refused("an entry occurs twice")
            return {name.removesuffix(".npy"): _array(archive, name) for name in names}
    except Refused:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError, struct.error, NotImplementedError, ValueError) as error:
        raise Refused(f"it is no npz archive, or a damaged one: {error}") from error


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """One array of an npz archive. Raises ValueError, and what zipfile raises."""
    import numpy as np  # of which the command line needs nothing to begin with

    entry = archive.getinfo(name)
    with archive.open(entry) as stream:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        try:
            shape, _, kind = read(stream, max_header_size=MAX_HEAD)
        except (SyntaxError, tokenize.TokenError, TypeError, RecursionError, MemoryError) as error:
            raise Refused(f"{name}: its head cannot be read ({type(error).__name__})") from error
        room, wanted = entry.file_size - stream.tell(), kind.itemsize * math.prod(shape)
        if kind.hasobject or kind.names or min(shape, default=0) < 0 or wanted != room:
            raise Refused(f"{name}: {shape} values of {kind} where {room} bytes are: refused")
        data = bytearray(stream.read(room))
        if len(data) != room or stream.read(1):  # to the end, where the CRC is checked
            raise Refused(f"{name} is cut")
    return np.frombuffer(data, kind).reshape(shape)
