"""From a TOML file to tables to structures: unknown keys, wrong types, times and connections, each fault with its key."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NoReturn, TypeVar, get_type_hints

import msgspec

from towage import reading
from towage.errors import SceneError, suggest
from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.scene.parts import Seconds

S = TypeVar("S", bound=msgspec.Struct)
_CONNECTION = re.compile(r"\s*([^.\s]+)\.(.+?)\s*->\s*([^.\s]+)\.(.+?)\s*")


def read_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """(text, tables) of a TOML file. Raises `SceneError` where it cannot be read or is no TOML."""
    try:
        text = reading.content(path, reading.MAX_TEXT).decode("utf-8")
        return text, reading.toml(text)
    except (OSError, UnicodeDecodeError, reading.Refused) as error:
        raise SceneError(f"cannot be read: {error}", file=path) from error
    except ValueError as error:
        raise SceneError(f"is not valid TOML: {error}", file=path) from error


def find_file(given: str | Path, directories: Iterable[Path], what: str) -> Path:
    """The path ``given``, or the TOML file of that name in one of ``directories``. Raises `SceneError` that lists what
    there is; ``what``: scene or route."""
    path, places = Path(given), tuple(directories)
    named = [directory / f"{path.name}.toml" for directory in places if path.name == str(path)]
    for candidate in (path, *named):
        if candidate.is_file():
            return candidate
    names = sorted({file.stem for directory in places for file in directory.glob("*.toml")})
    hint = suggest(path.stem, names) or f"; known {what}s: {', '.join(names) or 'none'}"
    raise SceneError(f"no such file or {what}{hint}", file=path)


class Tables:
    """Reads tables of ``file``. Every fault is a `SceneError` that names file and key."""

    def __init__(self, file: Path | None) -> None:
        self.file = file

    def fail(self, message: str, key: str) -> NoReturn:
        """Raise the fault of a key."""
        raise SceneError(message, file=self.file, key=key)

    def table(self, value: object, key: str) -> dict[str, Any]:
        """``value``, which must be a table."""
        if not isinstance(value, dict):
            self.fail(f"expected a table, got {value!r}", key)
        return value

    def structure(self, value: object, into: type[S], key: str) -> S:
        """A table as the structure ``into``; a field of type `Seconds` may be a text with a unit."""
        content = dict(self.table(value, key))
        for name in content:
            if name not in into.__struct_fields__:
                self.unknown(name, into.__struct_fields__, key)
        for name in content.keys() & _times(into):
            content[name] = self.seconds(content[name], f"{key}.{name}")
        try:
            return msgspec.convert(content, into)
        except msgspec.ValidationError as error:
            message, _, place = str(error).partition(" - at `$")
            self.fail(message, (key + place.rstrip("`")).strip("."))

    def unknown(self, name: str, known: tuple[str, ...], key: str) -> NoReturn:
        """Raise the fault of a key that does not exist."""
        hint = suggest(name, known) or f"; expected one of: {', '.join(known)}"
        self.fail(f"unknown key{hint}", f"{key}.{name}".strip("."))

    def seconds(self, value: object, key: str) -> object:
        """A text with a unit as a number of seconds; anything else as it is."""
        if not isinstance(value, str):
            return value
        try:
            return parse_quantity(value, "s")
        except QuantityError as error:
            self.fail(str(error), key)

    def connection(self, text: str, key: str) -> str:
        """A connection in its one spelling, "unit.output -> unit.input"; with more than one arrow, which names of variables
        may hold, as it is."""
        if text.count("->") > 1 and _CONNECTION.fullmatch(text):
            return text.strip()
        match = _CONNECTION.fullmatch(text)
        if match is None:
            self.fail(f"{text!r} is no connection: expected 'unit.output -> unit.input'", key)
        return "{}.{} -> {}.{}".format(*match.groups())


@functools.cache
def _times(structure: type[msgspec.Struct]) -> frozenset[str]:
    """Fields that are times."""
    hints = get_type_hints(structure, include_extras=True)
    return frozenset(name for name, kind in hints.items() if kind in (Seconds, Seconds | None))


def plain(value: Any) -> Any:
    """A copy of a table in plain Python types; numpy scalars are numbers too."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value.item() if hasattr(value, "item") else value
