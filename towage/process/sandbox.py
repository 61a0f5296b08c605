"""What the process of a unit has no business doing, denied by the system from now on, to it and to its children (Linux).

Landlock (5.13 and newer): writing anywhere but below one folder and to devices that keep nothing; later versions also TCP and
signals to other processes. A filter of system calls (seccomp): sockets, looking into other processes, mounting, name spaces,
modules, clocks, and what would get around these. What is denied fails with EPERM or EACCES.

The calls of the system have no functions in the C library; numbers and layouts are those of ``linux/landlock.h``,
``linux/seccomp.h``, ``linux/filter.h`` and ``asm/unistd.h``.
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import struct
import sys
from pathlib import Path

_CREATE, _ADD, _RESTRICT = 444, 445, 446
_NO_NEW_PRIVS = 38
_VERSION = 1
_PATH_BENEATH = 1
_WRITE_FILE, _REFER, _TRUNCATE = 1 << 1, 1 << 13, 1 << 14
_WRITES = 0b1_1111_1111_0010
"""LANDLOCK_ACCESS_FS_: WRITE_FILE, REMOVE_DIR, REMOVE_FILE, MAKE_CHAR to MAKE_SYM, of the first version."""
_SINCE = {"REFER": 2, "TRUNCATE": 3, "TCP": 4, "SCOPES": 6}
"""Versions of landlock from which on it knows these."""
_BIND_AND_CONNECT, _SOCKETS_AND_SIGNALS = 0b11, 0b11
DEVICES = ("null", "zero", "full", "random", "urandom", "tty")
"""Of ``/dev``: writing to these is harmless."""

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW, _ERRNO = 0x7FFF0000, 0x00050000
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT = 0, 4, 16
"""Where ``struct seccomp_data`` has these."""
_NAME_SPACES = 0x7E02_0000
"""CLONE_NEW*, of clone."""
_SECCOMP = {"x86_64": 317, "aarch64": 277}
_AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_CLONE = {"x86_64": 56, "aarch64": 220}
_CLONE3 = 435
_FOREIGN = 0x4000_0000
"""Numbers from here on are of another kind of call on x86-64 (x32)."""
DENIED: dict[str, tuple[int | None, int | None]] = {
    "socket": (41, 198), "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271),
    "pidfd_getfd": (438, 438), "process_madvise": (440, 440), "kcmp": (312, 272), "perf_event_open": (298, 241),
    "mount": (165, 40), "umount2": (166, 39), "pivot_root": (155, 41), "chroot": (161, 51), "open_tree": (428, 428),
    "move_mount": (429, 429), "fsopen": (430, 430), "fsconfig": (431, 431), "fsmount": (432, 432), "fspick": (433, 433),
    "mount_setattr": (442, 442), "open_by_handle_at": (304, 265), "unshare": (272, 97), "setns": (308, 268),
    "kexec_load": (246, 104), "kexec_file_load": (320, 294), "init_module": (175, 105), "finit_module": (313, 273),
    "delete_module": (176, 106), "bpf": (321, 280), "reboot": (169, 142), "swapon": (167, 224), "swapoff": (168, 225),
    "acct": (163, 89), "quotactl": (179, 60), "settimeofday": (164, 170), "clock_settime": (227, 112),
    "adjtimex": (159, 171), "clock_adjtime": (305, 266), "sethostname": (170, 161), "setdomainname": (171, 162),
    "add_key": (248, 217), "request_key": (249, 218), "keyctl": (250, 219), "userfaultfd": (323, 282),
    "io_uring_setup": (425, 425), "io_uring_enter": (426, 426), "iopl": (172, None), "ioperm": (173, None),
}  # fmt: skip
"""Calls by name: their numbers on x86-64 and on aarch64."""


def confine(folder: str) -> list[str]:
    """Restrict this process to what a unit needs; what the system cannot deny it."""
    if sys.platform != "linux":
        return ["anything: this system has neither landlock nor seccomp"]
    library = ctypes.CDLL(None, use_errno=True)
    library.prctl(_NO_NEW_PRIVS, 1, 0, 0, 0)
    missing = _landlock(library, Path(folder))
    if not _seccomp(library):
        missing.append("sockets, tracing, mounting (no seccomp)")
    if missing or len(os.listdir("/proc/self/task")) == 1:
        return missing
    return ["writing by threads that were there before"]


def _landlock(library: ctypes.CDLL, folder: Path) -> list[str]:
    """Restrict where this process writes; what landlock cannot deny."""
    version = library.syscall(_CREATE, None, ctypes.c_size_t(0), _VERSION)
    if version < 1:
        return ["writing elsewhere, signals to other processes (no landlock)"]
    knows = {what: version >= since for what, since in _SINCE.items()}
    writes = _WRITES | _REFER * knows["REFER"] | _TRUNCATE * knows["TRUNCATE"]
    rules = struct.pack("=QQQ", writes, _BIND_AND_CONNECT * knows["TCP"], _SOCKETS_AND_SIGNALS * knows["SCOPES"])
    ruleset = library.syscall(_CREATE, rules, ctypes.c_size_t(len(rules)), 0)
    if ruleset < 0:
        return ["writing elsewhere, signals to other processes (no landlock)"]
    try:
        of_files = writes & (_WRITE_FILE | _TRUNCATE)
        for place, allowed in ((folder, writes), *((Path("/dev", name), of_files) for name in DEVICES)):
            if place.exists():
                descriptor = os.open(place, os.O_PATH | os.O_CLOEXEC)
                library.syscall(_ADD, ruleset, _PATH_BENEATH, struct.pack("=Qi", allowed, descriptor), 0)
                os.close(descriptor)
        if library.syscall(_RESTRICT, ruleset, 0):
            return ["writing elsewhere, signals to other processes (no landlock)"]
    finally:
        os.close(ruleset)
    words = {"TRUNCATE": "cutting files elsewhere", "SCOPES": "signals to other processes"}
    return [f"{what} (landlock {version} of {_SINCE[key]})" for key, what in words.items() if not knows[key]]


def _seccomp(library: ctypes.CDLL) -> bool:
    """Have `DENIED` refused in all threads of this process; whether the system does so."""
    machine = platform.machine()
    if machine not in _AUDIT or sys.maxsize < 2**32:
        return False
    filters = program(machine)
    code = ctypes.create_string_buffer(filters, len(filters))
    head = struct.pack("@HP", len(filters) // 8, ctypes.addressof(code))
    every_thread = 1
    return bool(library.syscall(_SECCOMP[machine], 1, every_thread, head) == 0)


def program(machine: str) -> bytes:
    """The filter for a machine: instructions (code, steps if true, steps if not, operand)."""
    numbers = [n for pair in DENIED.values() if (n := pair[machine == "aarch64"]) is not None]
    body: list[tuple[int, int, str, str]] = [(_EQUAL, n, "deny", "") for n in numbers]
    if machine == "x86_64":
        body.insert(0, (_AT_LEAST, _FOREIGN, "deny", ""))
    body += [(_EQUAL, _CLONE3, "unknown", ""), (_EQUAL, _CLONE[machine], "", "allow"), (_LOAD, _FIRST_ARGUMENT, "", "")]
    body += [(_ANY_BIT, _NAME_SPACES, "deny", "allow")]
    lines = [(_LOAD, _ARCHITECTURE, "", ""), (_EQUAL, _AUDIT[machine], "", "deny"), (_LOAD, _NUMBER, "", ""), *body]
    ends = {"allow": _ALLOW, "deny": _ERRNO | errno.EPERM, "unknown": _ERRNO | errno.ENOSYS}
    places = {"": 0, **{name: len(lines) + k for k, name in enumerate(ends)}}
    packed = b""
    for k, (code, operand, yes, no) in enumerate(lines):
        steps = [places[word] - k - 1 if word else 0 for word in (yes, no)]
        packed += struct.pack("=HBBI", code, *steps, operand)
    return packed + b"".join(struct.pack("=HBBI", _RETURN, 0, 0, value) for value in ends.values())
