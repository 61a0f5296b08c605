"""Archives and descriptions: refused with exit code 2, nothing of them unpacked."""

from __future__ import annotations

import random
import stat
import struct
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

from tests.foreign.units import hostile

from . import boxes
from .survival import Case, scene

Box = Callable[[Path], object]
NOISE = random.Random(1).randbytes(5000)


def alone(make: Box) -> Callable[[Path], Path]:
    """The scene of one unit, whose file ``make`` writes."""

    def write(directory: Path) -> Path:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # zipfile warns of a duplicate name
            make(directory / "box.fmu")
        return scene(directory, {"box": directory / "box.fmu"}, [])

    return write


def _altered(change: Callable[[bytes], bytes], **more: bytes) -> Box:
    def make(path: Path) -> None:
        path.write_bytes(change(boxes.build(path, **more).read_bytes()))

    return make


def _special(kind: int = 0, method: int = zipfile.ZIP_STORED) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo("resources/special")
    entry.external_attr, entry.compress_type = (kind | 0o777) << 16 if kind else 0, method
    return entry


def _encrypted(data: bytes) -> bytes:
    changed = bytearray(data)
    changed[data.index(b"PK\x01\x02") + 8] |= 1
    return bytes(changed)


def _declaring(size: int, zeros: int) -> Box:
    return lambda path: boxes.declare_size(boxes.build(path, resources__zeros=bytes(zeros)), b"resources/zeros", size)


def _with_doctype(encoding: str) -> Box:
    head, rest = boxes.xml().replace("UTF-8", encoding).split("?>", 1)
    return lambda path: boxes.build(path, (head + "?>" + boxes.DOCTYPE + rest).encode(encoding))


def _described(text: str, repeated: str = "", times: int = 0) -> Box:
    return lambda path: boxes.build(path, text + times * repeated, resources__noise=random.Random(2).randbytes(1 << 20))


def _library(data: bytes) -> Box:
    return lambda path: boxes.build(path, library=data)


def _behind_a_hole(path: Path) -> None:
    boxes.build(path)
    data = path.read_bytes()
    with open(path, "wb") as file:
        file.seek(8 << 30)
        file.write(data)


def _long_contents(path: Path) -> None:
    """32 MB of nothing that the end of the archive calls its table of contents."""
    end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, 65535, 65535, 32 << 20, 0, 0)
    path.write_bytes(bytes(32 << 20) + end)


def _without_description(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as fmu:
        fmu.writestr("sub/modelDescription.xml", boxes.xml())


def _without_platform(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as fmu:
        fmu.writestr("modelDescription.xml", boxes.xml())
        fmu.writestr("binaries/vax/box.exe", b"x")


def _entry(*entries: zipfile.ZipInfo | str) -> Box:
    return lambda path: boxes.with_entry(path, *entries)


ARCHIVES: list[tuple[str, Box, str]] = [
    *((f"entry {name!r}", _entry(name), says) for name, says in boxes.HOSTILE_NAMES),
    ("names that differ in Unicode form only", _entry("resources/\u00e9", "resources/e\u0301"), "collides"),
    ("one name twice", _entry("resources/a", "resources/a"), "occurs twice"),
    ("symbolic link", _entry(_special(stat.S_IFLNK)), "symbolic link"),
    ("named pipe", _entry(_special(stat.S_IFIFO)), "regular file"),
    ("LZMA compression", _entry(_special(method=zipfile.ZIP_LZMA)), "method 14"),
    ("encrypted entry", _altered(_encrypted), "encrypted"),
    ("10,002 entries", _entry(*(f"resources/{k}" for k in range(10_000))), "more than 10000"),
    ("600 MB declared", _declaring(600 * 2**20, 1000), "over 512: refused as a bomb"),
    ("20 MB of zeros", _declaring(20 * 2**20, 20 * 2**20), "times its size: refused as a bomb"),
    ("a hole of 8 GB before it", _behind_a_hole, "bytes, more than 536,870,912"),
    ("a table of contents of 32 MB", _long_contents, "bytes of the archive's table of contents"),
    ("no zip archive", lambda path: path.write_bytes(b"#!/bin/sh\n"), "damaged or truncated"),
    ("empty file", lambda path: path.touch(), "damaged or truncated"),
    *((f"cut at byte {cut}", _altered(lambda data, n=cut: data[:n]), "damaged or truncated") for cut in (100, 400, -1, -30)),
    ("no such file", lambda path: None, "there is no file"),
    ("a directory", lambda path: path.mkdir(), "there is no file"),
]  # fmt: skip
DESCRIPTIONS: list[tuple[str, Box, str]] = [
    ("no modelDescription.xml", _without_description, r"no modelDescription\.xml"),
    ("DOCTYPE with entities, UTF-8", _with_doctype("utf-8"), "DOCTYPE"),
    ("DOCTYPE with entities, UTF-16", _with_doctype("utf-16"), "DOCTYPE"),
    ("100,000 nested elements", _described("<a>" * 100_000 + "</a>" * 100_000), "101 levels of elements, more than 100"),
    ("3,000,000 empty elements", _described("<a>", "<b/>", 3_000_000), "of elements and attributes, more than"),
    ("60 MB of one element", _described("<a ", "b='' ", 12_000_000), "bytes of one tag, more than"),
    ("a name of 100,000 letters", _described(boxes.xml().replace('"depth"', f'"{"d" * 100_000}"')), "has 100000 letters"),
    *((says, _described(text), says) for text, says in boxes.INVALID_DESCRIPTIONS),
]
BINARIES: list[tuple[str, Box, str]] = [
    ("none for this platform", _without_platform, r"no binary for linux64 .*present: "),
    *((says, _library(data), says) for data, says in boxes.BROKEN_LIBRARIES),
    ("header sound, nothing behind it", _library(boxes.elf()), "cannot be loaded"),
    ("a function of the standard is missing", lambda path: hostile(path, flags=("-DNO_STRING_STATUS",)), "GetStringStatus"),
    ("a library that it needs is missing", lambda path: hostile(path, flags=("-DNEEDS_MORE",)), "undefined symbol: a_func"),
]  # fmt: skip
DAMAGED: list[tuple[str, Box, str]] = [
    ("checksum error", _altered(lambda data: data.replace(NOISE[2000:2010], bytes(10)), resources__noise=NOISE), "CRC"),
    ("understated size", _declaring(1000, 20 * 2**20), "damaged or truncated"),
]
CASES = [
    Case(group, fault, alone(make), 2, says)
    for group, cases in (
        ("archive", ARCHIVES),
        ("description", DESCRIPTIONS),
        ("binary", BINARIES),
        ("content", DAMAGED),
    )
    for fault, make, says in cases
]
