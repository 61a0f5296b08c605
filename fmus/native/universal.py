"""Joins Mach-O libraries of several processors into one universal file, which FMI 2's folder ``darwin64`` needs.

A fat header, big-endian: magic, count, then for each slice cputype, cpusubtype, offset, size and alignment as a power of
two (``mach-o/fat.h``). The slices follow unchanged, so that the signature of each stays good.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

FAT_MAGIC = 0xCAFEBABE
MACHO_MAGIC = 0xFEEDFACF
"""A 64-bit little-endian slice."""
ALIGNMENT = 14
"""16 KiB, the page of Apple's processors; more than Intel's 4 KiB."""


def universal(slices: Sequence[bytes]) -> bytes:
    """The universal file. Raises ``ValueError`` for anything that is not a 64-bit Mach-O file."""
    page = 1 << ALIGNMENT
    header = struct.pack(">II", FAT_MAGIC, len(slices))
    body = b""
    start = -(-(len(header) + 20 * len(slices)) // page) * page
    for data in slices:
        magic, cpu, kind = struct.unpack_from("<Iii", data)
        if magic != MACHO_MAGIC:
            raise ValueError(f"not a 64-bit Mach-O file: it begins with {data[:4].hex()}")
        body += b"\0" * (-len(body) % page)
        header += struct.pack(">iiIII", cpu, kind, start + len(body), len(data), ALIGNMENT)
        body += data
    return header + b"\0" * (start - len(header)) + body
