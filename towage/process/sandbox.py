"""Landlock: from now on this process and its children write nowhere but below one folder (Linux 5.13 and newer).

The calls of the system have no functions in the C library; numbers and layouts are those of ``linux/landlock.h``, the same on
all processors.
"""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

_CREATE, _ADD, _RESTRICT = 444, 445, 446
_NO_NEW_PRIVS = 38
_WRITES = 0b1_1111_1111_0010
"""LANDLOCK_ACCESS_FS_: WRITE_FILE, REMOVE_DIR, REMOVE_FILE, MAKE_CHAR to MAKE_SYM, of the first version."""
_PATH_BENEATH = 1


class _Ruleset(ctypes.Structure):
    _fields_ = (("handled_access_fs", ctypes.c_uint64),)


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed_access", ctypes.c_uint64), ("parent_fd", ctypes.c_int32))


def writes_only_below(folder: Path) -> bool:
    """Restrict this process; False where the system does not offer it. ``/dev`` stays, for what is no file."""
    if sys.platform != "linux":
        return False
    library = ctypes.CDLL(None, use_errno=True)
    rules = _Ruleset(_WRITES)
    ruleset = library.syscall(_CREATE, ctypes.byref(rules), ctypes.c_size_t(ctypes.sizeof(rules)), 0)
    if ruleset < 0:
        return False
    try:
        for place in (folder, Path("/dev")):
            descriptor = os.open(place, os.O_PATH | os.O_CLOEXEC)
            below = _Beneath(_WRITES, descriptor)
            library.syscall(_ADD, ruleset, _PATH_BENEATH, ctypes.byref(below), 0)
            os.close(descriptor)
        library.prctl(_NO_NEW_PRIVS, 1, 0, 0, 0)
        return bool(library.syscall(_RESTRICT, ruleset, 0) == 0)
    finally:
        os.close(ruleset)
