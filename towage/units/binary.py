"""Whether the loader of this platform can take a library: looked at before anything is loaded."""

from __future__ import annotations

import struct
import sys

_SUFFIXES = {".so": "linux", ".dll": "win", ".dylib": "darwin"}
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
_SYSTEMS = {".so": "linux", ".dll": "windows", ".dylib": "darwin"}


def platform_name() -> tuple[str, str]:
    """FMI 2.0's name of this platform and the suffix of its libraries."""
    suffix = {"win32": ".dll", "cygwin": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    return f"{_SUFFIXES[suffix]}{64 if sys.maxsize > 2**32 else 32}", suffix


def platform_tuple() -> tuple[str, str]:
    """FMI 3.0's name of this platform and the suffix of its libraries."""
    import platform  # of the host: costs 3 ms

    machine, suffix = platform.machine().lower(), platform_name()[1]
    return f"{_MACHINES.get(machine, machine)}-{_SYSTEMS[suffix]}", suffix


def folders(fmi_version: str) -> tuple[str, ...]:
    """The folders of ``binaries`` that may hold a library for this platform, the likeliest first.

    FMI 3.0 has one name. FMI 2.0 has none for processors other than x86; its revision 2.0.5 says to take FMI 3.0's. Tools such as
    OpenModelica and FMPy write ``linux64`` and ``darwin64`` there all the same: the name of the folder tells nothing of the
    processor, the header of the library does (`problem`).
    """
    name, tuple_ = platform_name()[0], platform_tuple()[0]
    if fmi_version != "2.0":
        return (tuple_,)
    return (name, tuple_) if tuple_.startswith("x86") else (tuple_, name)


def problem(data: bytes) -> str:
    """Why the loader of this platform cannot take the library, or "".

    Only headers and extents are looked at: a segment that ends beyond the file would be SIGBUS, not an error.
    """
    import platform  # of the host, looked at here only: costs 3 ms to import

    arm = platform.machine().lower() in ("arm64", "aarch64")
    check = {".so": _elf_problem, ".dll": _pe_problem, ".dylib": _macho_problem}[platform_name()[1]]
    try:
        return check(data, arm)
    except struct.error:
        return "truncated header"


def _elf_problem(data: bytes, arm: bool) -> str:
    if data[:4] != b"\x7fELF":
        return "no ELF header"
    if data[4:6] != b"\x02\x01":
        return "not 64-bit little-endian ELF"
    kind, machine = struct.unpack_from("<HH", data, 16)
    programs, sections = struct.unpack_from("<QQ", data, 32)
    program_size, program_count, section_size, section_count = struct.unpack_from("<HHHH", data, 54)
    if machine != (183 if arm else 62):
        return f"ELF for another processor (e_machine {machine})"
    if kind != 3:
        return f"ELF, but no shared object (e_type {kind})"
    tables = max(programs + program_size * program_count, sections + section_size * section_count)
    if tables > len(data) or not program_count or program_size < 56:
        return "truncated: header tables lie beyond the end of the file"
    for index in range(program_count):
        offset, _, _, size = struct.unpack_from("<QQQQ", data, programs + program_size * index + 8)
        if size and offset + size > len(data):
            return "truncated: a segment ends beyond the end of the file"
    return ""


def _pe_problem(data: bytes, arm: bool) -> str:
    (start,) = struct.unpack_from("<I", data, 60)
    if data[:2] != b"MZ" or data[start : start + 4] != b"PE\0\0":
        return "no PE header"
    machine, sections = struct.unpack_from("<HH", data, start + 4)
    (optional,) = struct.unpack_from("<H", data, start + 20)
    if machine != (0xAA64 if arm else 0x8664):
        return f"PE for another processor (machine {machine:#x})"
    for index in range(sections):
        size, offset = struct.unpack_from("<II", data, start + 24 + optional + 40 * index + 16)
        if offset + size > len(data):
            return "truncated: a section ends beyond the end of the file"
    return ""


def _macho_problem(data: bytes, arm: bool) -> str:
    processor = 0x0100000C if arm else 0x01000007
    if data[:4] == b"\xca\xfe\xba\xbe":
        for index in range(min(struct.unpack_from(">I", data, 4)[0], 64)):
            kind, _, offset, size = struct.unpack_from(">IIII", data, 8 + 20 * index)
            if kind == processor:
                return _macho_problem(data[offset : offset + size], arm) if offset + size <= len(data) else "truncated"
        return "no slice for this processor"
    if data[:4] != b"\xcf\xfa\xed\xfe":
        return "no 64-bit Mach-O header"
    (kind,) = struct.unpack_from("<I", data, 4)
    commands, size = struct.unpack_from("<II", data, 16)
    if kind != processor:
        return f"Mach-O for another processor (type {kind:#x})"
    if 32 + size > len(data):
        return "truncated: load commands end beyond the end of the file"
    place = 32
    for _ in range(commands):
        command, length = struct.unpack_from("<II", data, place)
        if command == 0x19 and sum(struct.unpack_from("<QQ", data, place + 40)) > len(data):
            return "truncated: a segment ends beyond the end of the file"
        place += max(length, 8)
    return ""
