"""A library for each instance of a unit of another make.

Instances made from one library share its static variables, which some units keep their state in: they disturb one another, in
silence, and so do a run and the other run that it is compared with. A library that is in use is therefore loaded from a copy.
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from towage.errors import FmuError
from towage.files import reason, scratch

_LOADED: Counter[Path] = Counter()
"""Instances of this process, by the directory of their unit."""
BINARIES = "binaries"


@contextmanager
def own_library(directory: Path) -> Iterator[Path]:
    """``directory`` of an unpacked unit, or, while an instance uses that, one with a copy of the libraries."""
    used = _LOADED[directory] > 0
    _LOADED[directory] += 1
    try:
        if not used:
            yield directory
            return
        with scratch() as folder:
            try:
                for entry in directory.iterdir():
                    _take(entry, folder / entry.name)
            except (OSError, shutil.Error) as error:
                what = "the libraries that a second instance needs for itself cannot be copied"
                raise FmuError(f"{what}: {reason(error)}", file=directory) from None
            yield folder
    finally:
        _LOADED[directory] -= 1


def _take(entry: Path, place: Path) -> None:
    """A link, where the system has them and it is not about libraries, which are known by their file."""
    if entry.name != BINARIES:
        try:
            place.symlink_to(entry, entry.is_dir())
            return
        except OSError:  # as Windows without the right to
            pass
    shutil.copytree(entry, place) if entry.is_dir() else shutil.copy(entry, place)
