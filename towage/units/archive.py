"""FMI 2.0 and 3.0 co-simulation archives, read and unpacked without running or trusting anything in them.

``read_description`` answers what a scene needs to be checked; ``extract`` unpacks after every check. What is refused:
names that leave the directory or collide, links, decompression bombs, truncated or damaged data, a DOCTYPE (entities),
other FMI versions and interfaces, duplicate variables, and a binary that the loader of this platform would choke on.
"""

from __future__ import annotations

import functools
import mmap
import re
import shutil
import stat
import struct
import sys
import tempfile
import unicodedata
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from msgspec.structs import replace

from towage import reading
from towage.errors import FmuError
from towage.files import scratch
from towage.units import binary
from towage.units.description import Description
from towage.units.reader import DescriptionReader, InvalidDescription

MAX_ENTRIES = 10_000
MAX_UNPACKED = 512 * 2**20
MAX_XML = 64 * 2**20
MAX_HELD = 64 * 2**20
"""Of a library that is looked at in memory, bytes."""
_DESCRIPTION = "modelDescription.xml"


def read_description(path: Path) -> Description:
    """Describe the FMU at ``path``; a binary for this platform is not required. Raises ``FmuError``.

    A file that does not change is read once a process, because a sweep asks for it in every run."""
    return _read(path, *_stamp(path))


def unpacked(path: Path, root: Path) -> Path:
    """The directory below ``root``, named by the file's content, into which the FMU is unpacked by `extract`; a file that
    does not change is looked at once a process. Raises ``FmuError``."""
    return _unpacked_once(path, root, *_stamp(path))


def _stamp(path: Path) -> tuple[int, int]:
    """What changes with the file's content: (time of modification, size); zeros where there is no file."""
    try:
        status = path.stat()
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


@functools.lru_cache(maxsize=64)
def _read(path: Path, *stamp: int) -> Description:
    with opened(path) as archive:
        return _describe(path, archive)


@functools.lru_cache(maxsize=64)
def _unpacked_once(path: Path, root: Path, *stamp: int) -> Path:
    directory = root / reading.digest(path)[:32]
    extract(path, directory, replace=True)  # what is there under this name is the same or was damaged
    return directory


def check_platform(description: Description) -> str:
    """The directory in ``binaries`` with the library for this platform. Raises ``FmuError`` if the FMU has none."""
    folders = binary.folders(description.fmi_version)
    if found := next((folder for folder in folders if folder in description.platforms), None):
        return found
    member = f"{description.model_identifier}{binary.platform_name()[1]}"
    raise FmuError(
        f"no binary for {folders[0]} ({' or '.join(f'binaries/{folder}/{member}' for folder in folders)}); "
        f"present: {', '.join(description.platforms) or 'none'}. Ask the supplier for a build for {folders[0]}",
        file=description.path,
    )


def library_of(description: Description, directory: Path) -> Path:
    """The library for this platform of an FMU that is unpacked in ``directory``. Raises as `check_platform`."""
    name = description.model_identifier + binary.platform_name()[1]
    return directory.absolute() / "binaries" / check_platform(description) / name


def extract(path: Path, directory: Path, replace: bool = False) -> None:
    """Unpack the FMU at ``path`` into ``directory``, which appears complete or not at all.

    A directory that already holds the same files is left alone, so processes that unpack one FMU at the same time all
    succeed. One that holds something else is replaced if ``replace``. Raises ``FmuError``, also if it is not.
    """
    with opened(path) as archive:
        platform = check_platform(description := _describe(path, archive))
        entry = f"binaries/{platform}/{description.model_identifier}{binary.platform_name()[1]}"
        if problem := _library_problem(archive, entry):
            raise FmuError(
                f"not a loadable library: {problem}. Rebuild or download the FMU again", file=path, entry=entry
            )
        if _holds(directory, archive):
            return
        directory.parent.mkdir(parents=True, exist_ok=True)
        with scratch(f".{directory.name}-", directory.parent) as folder:
            _unpack(archive, folder)
            if not _placed(folder, directory, archive, replace):
                raise FmuError(f"{directory} exists and holds something else: remove it", file=path)


def _library_problem(archive: zipfile.ZipFile, entry: str) -> str:
    """What `binary.problem` says of an entry; a large one is looked at on disk, not in memory."""
    if archive.getinfo(entry).file_size <= MAX_HELD:
        return binary.problem(archive.read(entry))
    with archive.open(entry) as packed, tempfile.TemporaryFile() as library:
        shutil.copyfileobj(packed, library)
        library.flush()
        with mmap.mmap(library.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return binary.problem(data)  # type: ignore[arg-type]


def _placed(folder: Path, directory: Path, archive: zipfile.ZipFile, replace: bool) -> bool:
    """Whether ``directory`` holds the archive now: ``folder`` under that name, or what another process put there."""
    for _ in range(1 + replace):
        with suppress(OSError):
            folder.rename(directory)
            return True
        if _holds(directory, archive):
            return True
        if replace:
            with tempfile.TemporaryDirectory(prefix=folder.name, dir=directory.parent) as aside, suppress(OSError):
                directory.rename(Path(aside, "old"))
    return False


@contextmanager
def opened(path: Path) -> Iterator[zipfile.ZipFile]:
    """The archive, its names and sizes checked; whatever goes wrong while it is open becomes a ``FmuError``."""
    try:
        reading.checked_file(path)
        reading.check_directory(path)
        with zipfile.ZipFile(path) as archive:
            _check_entries(path, archive)
            yield archive
    except reading.Refused as refused:
        raise FmuError(str(refused), file=path) from None
    except FileNotFoundError:
        raise FmuError("there is no such file", file=path) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, struct.error, NotImplementedError, ValueError) as error:
        raise FmuError(f"damaged or truncated archive ({error}): download or build it again", file=path) from error
    except OSError as error:
        raise FmuError(f"cannot be read or unpacked: {error}", file=path) from error


def _check_entries(path: Path, archive: zipfile.ZipFile) -> None:
    """Refuse an archive by its directory alone."""
    entries = archive.infolist()
    unpacked, packed = sum(entry.file_size for entry in entries), path.stat().st_size
    if len(entries) > MAX_ENTRIES:
        raise FmuError(f"{len(entries)} entries, more than {MAX_ENTRIES}: refused as a bomb", file=path)
    if unpacked > MAX_UNPACKED:
        raise FmuError(f"{unpacked / 2**20:.0f} MB unpacked, over {MAX_UNPACKED >> 20}: refused as a bomb", file=path)
    if unpacked > reading.RATIO_FLOOR and unpacked > reading.MAX_RATIO * packed:
        raise FmuError(f"unpacks to {unpacked / packed:.0f} times its size: refused as a bomb", file=path)
    spelled: dict[str, tuple[str, bool]] = {}
    listed: dict[str, tuple[int, int]] = {}
    for entry in entries:
        name = entry.orig_filename
        parts = name.rstrip("/").split("/")
        if problem := _entry_problem(entry, parts):
            raise FmuError(problem, file=path, entry=repr(name))
        for depth in range(1, len(parts) + 1):
            here = ("/".join(parts[:depth]), depth < len(parts) or entry.is_dir())
            there = spelled.setdefault(unicodedata.normalize("NFC", here[0]).casefold(), here)
            if there != here:
                raise FmuError(f"collides with {there[0]!r} where case is ignored", file=path, entry=repr(name))
        content = entry.CRC, entry.file_size
        if listed.setdefault(here[0], content) != content:
            raise FmuError("occurs twice in the archive, with two contents", file=path, entry=repr(name))


def _entry_problem(entry: zipfile.ZipInfo, parts: list[str]) -> str:
    """Why one entry is refused, or ""."""
    name, mode = entry.orig_filename, entry.external_attr >> 16
    if name.startswith("/") or re.match("[A-Za-z]:", name):
        return "is an absolute path"
    if ".." in parts:
        return "leaves the archive's directory"
    if re.search(r"[\\:\x00-\x1f]", name) or any(part.strip() in ("", ".") or _ending(part) for part in parts):
        return "is not a portable name: expected words separated by '/'"
    if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        return "is a symbolic link" if stat.S_ISLNK(mode) else "is not a regular file"
    if entry.flag_bits & 1:
        return "is encrypted"
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        return f"is compressed by method {entry.compress_type}: FMI allows stored and deflated"
    return ""


def _ending(part: str) -> bool:
    """Whether a name ends in what this platform does not keep: Windows drops full stops and blanks."""
    return part[-1] in ". " if sys.platform == "win32" else part[-1] == " "


def _unportable(names: list[str]) -> tuple[str, ...]:
    """What to say of entries that end in a full stop, which Windows does not keep, and of those that are there twice."""
    odd = [name for name in names if any(part.endswith(".") for part in name.rstrip("/").split("/"))]
    twice = [name for name, count in Counter(names).items() if count > 1 and not name.endswith("/")]
    said = [f"the archive has {', '.join(odd[:3])}, which Windows cannot unpack: taken here"] if odd else []
    said += [f"the archive has {', '.join(twice[:3])} twice, with the same content: taken once"] if twice else []
    return tuple(said)


def _unpack(archive: zipfile.ZipFile, target: Path) -> None:
    """Write every entry below ``target``; reading to the end checks length and CRC."""
    for entry in {entry.orig_filename: entry for entry in archive.infolist()}.values():
        place = target.joinpath(*entry.orig_filename.split("/"))
        if entry.is_dir():
            place.mkdir(parents=True, exist_ok=True)
            continue
        place.parent.mkdir(parents=True, exist_ok=True)
        with archive.open(entry) as packed, open(place, "xb") as unpacked:
            shutil.copyfileobj(packed, unpacked)


def _holds(directory: Path, archive: zipfile.ZipFile) -> bool:
    """Whether the directory has every file of the archive, unchanged; what a unit adds at run time is no matter."""
    for entry in archive.infolist():
        place = directory.joinpath(*entry.orig_filename.split("/"))
        if entry.is_dir():
            continue
        if place.is_symlink() or not place.is_file() or place.stat().st_size != entry.file_size:
            return False
        if crc(place) != entry.CRC:
            return False
    return True


def crc(path: Path) -> int:
    """CRC-32 of a file, which is not taken into memory."""
    code = 0
    with open(path, "rb") as file:
        while data := file.read(1 << 20):
            code = zlib.crc32(data, code)
    return code


def _describe(path: Path, archive: zipfile.ZipFile) -> Description:
    """Read modelDescription.xml and the list of binaries."""
    names = archive.namelist()
    if _DESCRIPTION not in names:
        raise FmuError(f"no {_DESCRIPTION} at the top of the archive: is it an FMU?", file=path)
    if archive.getinfo(_DESCRIPTION).file_size > MAX_XML:
        raise FmuError(f"larger than {MAX_XML >> 20} MB", file=path, entry=_DESCRIPTION)
    try:
        with archive.open(_DESCRIPTION) as stream:
            root = reading.xml(stream)
        description = _reader(root).description(path, names)
        return replace(description, warnings=description.warnings + _unportable(names))
    except (InvalidDescription, reading.Refused) as error:
        raise FmuError(str(error), file=path, entry=_DESCRIPTION) from None
    except (expat.ExpatError, ValueError, LookupError, AssertionError) as error:
        raise FmuError(f"is not well-formed XML: {error}", file=path, entry=_DESCRIPTION) from error


def _reader(root: ElementTree.Element) -> DescriptionReader:
    """What reads this version. Raises `InvalidDescription` for one that is not supported."""
    if root.tag != "fmiModelDescription":
        raise InvalidDescription(f"root element is {root.tag!r}, expected 'fmiModelDescription'")
    version = root.get("fmiVersion", "")
    if version == "2.0":
        return DescriptionReader(root)
    if re.match(r"3\.[0-9]", version):
        from towage.units.reader3 import DescriptionReader3

        return DescriptionReader3(root)
    raise InvalidDescription(
        f"FMI version {version!r} is not supported, expected '2.0' or '3.0': export the model as FMI 2.0 or 3.0"
    )
