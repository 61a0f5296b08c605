"""Files that a scene gives to a unit (``[units.NAME.files]``): read, and carried by the unit that is built for them.

    [units.ship.files]
    responses = "vessel.nc"
    spectrum = { file = "buoy.csv", direction = "clockwise" }

A unit says which kinds of file it takes (`Unit.files`). What was read becomes numbers in a module of the unit's Python FMU, and
tables in the C text of its native one, so that neither looks for a file when it runs. FMUs with data lie in the cache under the
digest of their data.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from towage.errors import SceneError, suggest
from towage.fmus.declare.unit import Unit, load
from towage.reading import Refused
from towage.units.store import cache, python_given, sources_digest

READERS = {"responses": "responses", "spectrum": "spectra", "series": "series"}
"""Kind of file to the module here whose ``read(path, options, notes)`` gives its numbers; they take long to load."""


class Given(NamedTuple):
    """Data of a unit: its name, the text of the module that holds them, and what is to be said of them."""

    name: str
    text: str
    notes: tuple[str, ...]

    @property
    def digest(self) -> str:
        """Of the data."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:16]

    @property
    def unit(self) -> Unit:
        """The unit with its data."""
        return _unit(self.name, self.text)

    def python(self) -> Path:
        """Its Python FMU, built where it is not in the cache. Raises `FmuError`."""
        return python_given(self.name, self.text, self.unit)

    def native_folder(self) -> Path:
        """Where its native FMUs are, a folder a structure."""
        return cache() / "native" / sources_digest() / f"given-{self.digest}"


@functools.lru_cache(maxsize=16)
def _unit(name: str, text: str) -> Unit:
    names: dict[str, Any] = {}
    exec(compile(text.partition("\nUNIT = ")[0].partition("as EMPTY\n")[2], name, "exec"), names)
    declared = load(name)
    assert declared.given
    return declared.given(names["DATA"])


def given(name: str, files: Mapping[str, Any], folder: Path, fail: Callable[[str, str], SceneError]) -> Given:
    """The data of ``files`` for the unit ``name``, paths relative to ``folder``. ``fail(message, kind)`` makes the errors that
    are raised."""
    kinds = load(name).files
    data, notes = {}, []
    for kind, entry in files.items():
        if kind not in kinds:
            takes = ", ".join(kinds) or "none"
            raise fail(f"{name} takes no file {kind!r}: it takes {takes}{suggest(kind, kinds)}", kind)
        options = dict(entry) if isinstance(entry, Mapping) else {"file": entry}
        file = options.pop("file", None)
        if not isinstance(file, str) or not file:
            raise fail("expected the path of a file, or a table with file = 'path' and options", kind)
        path, own = folder / file, list[str]()
        try:
            data[kind] = _read(kind, path, options, own)
        except Refused as error:
            raise fail(f"{path}: {error}", kind) from None
        except OSError as error:
            raise fail(f"{path}: {error.strerror or error}", kind) from None
        notes += [f"{path.name}: {note}" for note in own]
    text = f'"""Data of this unit."""\n\nfrom .{name} import UNIT as EMPTY\n\nDATA = {data!r}\n\nUNIT = EMPTY.given(DATA)\n'
    return Given(name, text, tuple(notes))


def _read(kind: str, path: Path, options: Mapping[str, Any], notes: list[str]) -> dict[str, Any]:
    status = path.stat()
    data, said = _kept(kind, path, json.dumps(options, sort_keys=True, default=str), status.st_mtime_ns, status.st_size)
    notes += said
    return data


@functools.lru_cache(maxsize=16)
def _kept(
    kind: str, path: Path, options: str, *stamp: int
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """What a file holds, read with ``options``, JSON; once a process where it does not change, because every run of a sweep
    asks."""
    reader, notes = importlib.import_module(f"towage.data.{READERS[kind]}"), list[str]()
    return reader.read(path, json.loads(options), notes), tuple(notes)
