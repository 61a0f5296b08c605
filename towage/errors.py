"""Everything towage raises on purpose. A message says what, where, what was expected and what to try."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

LONGEST_WORD = 200
"""Letters of a word for which others are looked up."""


def suggest(word: str, known: Iterable[str]) -> str:
    """The question "did you mean", with names in ``known`` that are like ``word``; empty if none is."""
    import difflib  # takes 3 ms, and is needed for messages only

    if len(word) > LONGEST_WORD:  # which takes the square of its length
        return ""
    close = difflib.get_close_matches(word, list(known), n=2, cutoff=0.6)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


class TowageError(Exception):
    """Root of the hierarchy; ``exit_code`` is what the command line returns for it.

    The arguments of every class survive pickling, because a run reports its failure from a worker process.
    """

    exit_code = 3

    def _where(self) -> str:
        return ""

    def __str__(self) -> str:
        where = self._where()
        message = super().__str__()
        return f"{where}: {message}" if where else message


class SceneError(TowageError):
    """A scene that cannot be read or does not fit its units. ``key`` is the path in the file, as ``units.ship.fmu``."""

    exit_code = 2

    def __init__(self, message: str, *, file: Path | None = None, key: str = "") -> None:
        super().__init__(message)
        self.file = file
        self.key = key

    def _where(self) -> str:
        return ": ".join(part for part in (str(self.file or ""), self.key) if part)


class FmuError(TowageError):
    """An FMU that is refused before any of its code runs. ``entry`` is the name inside the archive, where known."""

    exit_code = 2

    def __init__(self, message: str, *, file: Path | None = None, entry: str = "") -> None:
        super().__init__(message)
        self.file = file
        self.entry = entry

    def _where(self) -> str:
        return ": ".join(part for part in (str(self.file or ""), self.entry) if part)


class FileError(TowageError):
    """A file, as of results, that is given and cannot be read; its message begins with the file."""

    exit_code = 2


class RunError(TowageError):
    """A run that failed at ``time`` (s) in ``variable`` of ``unit``, as far as these are known."""

    exit_code = 3

    def __init__(self, message: str, *, unit: str = "", variable: str = "", time: float | None = None) -> None:
        super().__init__(message)
        self.unit = unit
        self.variable = variable
        self.time = time

    def _where(self) -> str:
        name = ".".join(part for part in (self.unit, self.variable) if part)
        at = "" if self.time is None else f"t = {self.time:.9g} s"
        return ", ".join(part for part in (name, at) if part)
