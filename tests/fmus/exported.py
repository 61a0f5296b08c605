"""Names that a library exports, read from its bytes: PE (Windows) and Mach-O (macOS, one slice or several)."""

from __future__ import annotations

import struct

MACHO, FAT = 0xFEEDFACF, 0xCAFEBABE
PRIVATE, TYPE, EXTERNAL, DEFINED = 0x10, 0x0E, 0x01, 0x0E
"""Bits of a Mach-O symbol's type; a name is exported if it is external, defined in a section and not private."""


def exports(library: bytes) -> list[set[str]]:
    """The exported names of every slice. Raises ``ValueError`` if it is neither format."""
    if library[:2] == b"MZ":
        return [_portable_executable(library)]
    if struct.unpack(">I", library[:4])[0] == FAT:
        (count,) = struct.unpack(">I", library[4:8])
        slices = [struct.unpack(">5I", library[8 + 20 * k : 28 + 20 * k]) for k in range(count)]
        return [_mach_o(library[offset : offset + size]) for _, _, offset, size, _ in slices]
    if struct.unpack("<I", library[:4])[0] == MACHO:
        return [_mach_o(library)]
    raise ValueError(f"expected a PE or a Mach-O library, found {library[:4]!r}")


def _text(data: bytes, offset: int) -> str:
    return data[offset : data.index(b"\0", offset)].decode()


def _portable_executable(data: bytes) -> set[str]:
    (header,) = struct.unpack_from("<I", data, 0x3C)
    sections, optional_size = struct.unpack_from("<H", data, header + 6)[0], struct.unpack_from("<H", data, header + 20)[0]
    optional = header + 24
    (table,) = struct.unpack_from("<I", data, optional + 112)  # PE32+: first data directory
    places = [struct.unpack_from("<4I", data, optional + optional_size + 40 * k + 8) for k in range(sections)]

    def at(address: int) -> int:
        for size, begin, raw_size, raw in places:
            if begin <= address < begin + max(size, raw_size):
                return address - begin + raw
        raise ValueError(f"address {address:#x} is in no section")

    count, names = struct.unpack_from("<I", data, at(table) + 24)[0], struct.unpack_from("<I", data, at(table) + 32)[0]
    return {_text(data, at(struct.unpack_from("<I", data, at(names) + 4 * k)[0])) for k in range(count)}


def _mach_o(data: bytes) -> set[str]:
    (commands,) = struct.unpack_from("<I", data, 16)
    place, found = 32, set()
    for _ in range(commands):
        command, size = struct.unpack_from("<2I", data, place)
        if command == 2:  # LC_SYMTAB
            symbols, count, strings, _ = struct.unpack_from("<4I", data, place + 8)
            for k in range(count):
                name, kind = struct.unpack_from("<IB", data, symbols + 16 * k)
                if kind & EXTERNAL and not kind & PRIVATE and kind & TYPE == DEFINED:
                    found.add(_text(data, strings + name).removeprefix("_"))
        place += size
    return found
