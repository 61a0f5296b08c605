"""What all units of a process share, and one of them could change for the others: working directory, mask of signals, mask of
new files, floating-point mode, locale (one with decimal commas reads the numbers of all units otherwise).

Units of other makes are looked at after every call (`towage.units.library`), some microseconds each; what one changed is
set back at once, before another unit or the master computes with it, and the unit is named. Our own units change none of it.
"""

from __future__ import annotations

import contextlib
import ctypes
import locale
import os
import signal
from collections.abc import Callable
from typing import Any

_HALF = 2.0**-54
"""1 plus or minus this is 1, unless sums are rounded up, down or to zero."""
_SMALL = 2.0**-1022
"""Half of it is no normal number: 0 where these are flushed."""
_ROOM = 512
"""More than fenv_t has, bytes."""


class Surroundings:
    """The state of the process when this is made, which `restore` brings back."""

    def __init__(self) -> None:
        self._one, self._half, self._small = 1.0, _HALF, _SMALL
        self._process = os.getpid()
        self._directory = _directory()
        self._mask = _mask()
        self._umask = _umask()
        self._locale = locale.setlocale(locale.LC_ALL)
        self._numbers = ctypes.create_string_buffer(_ROOM)
        self._set_numbers: Any = None
        if os.name == "posix" and hasattr(library := ctypes.CDLL(None), "fesetenv") and not library.fegetenv(self._numbers):
            self._set_numbers = library.fesetenv

    def restore(self) -> list[str]:
        """Bring back what differs; what it was, in words. In a copy of the process that a unit made and that returned from
        it this does not return: the run goes on in the one that began it."""
        if os.getpid() != self._process:
            os._exit(0)
        one, half, said = self._one, self._half, []
        if one + half != one or one - half != one or not self._small * 0.5:
            if self._set_numbers:
                self._set_numbers(self._numbers)
            said.append("the floating-point mode")
        if (directory := _directory()) != self._directory:
            with contextlib.suppress(OSError):
                os.chdir(self._directory)
            said.append(f"the working directory, to {directory or 'one that is gone'}")
        if _mask() != self._mask:
            signal.pthread_sigmask(signal.SIG_SETMASK, self._mask)
            said.append("the mask of signals")
        if (umask := _umask()) != self._umask:
            os.umask(self._umask)
            said.append(f"the mask of new files, to {umask:03o}")
        if (now := locale.setlocale(locale.LC_ALL)) != self._locale:
            with contextlib.suppress(locale.Error):
                locale.setlocale(locale.LC_ALL, self._locale)
            said.append(f"the locale, to {now}")
        return said

    def guarded(self, function: Callable[..., int], tell: Callable[[list[str]], None]) -> Callable[..., int]:
        """The function, after whose calls ``tell`` hears what was brought back."""
        restore = self.restore

        def call(*arguments: Any) -> int:
            """As ``function``."""
            status = function(*arguments)
            if said := restore():
                tell(said)
            return status

        return call


def _directory() -> str:
    try:
        return os.getcwd()
    except OSError:
        return ""


def _mask() -> set[Any]:
    return set(signal.pthread_sigmask(signal.SIG_BLOCK, ())) if hasattr(signal, "pthread_sigmask") else set()


def _umask() -> int:
    before = os.umask(0o077)
    os.umask(before)
    return before
