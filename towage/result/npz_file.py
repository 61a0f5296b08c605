"""npz: the working store of results, bit-exact.

``np.load("run.npz")["line.tension"]`` is a column, ``["one_way:line.tension"]`` that of the one-way run; ``time`` and
``step_sizes`` are arrays too, all else is JSON in ``metadata``. Format 1, which is read too, numbers the columns.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.errors import FileError
from towage.files import atomic_write

Place = str | os.PathLike[str] | IO[bytes]
"""A path, or an open stream."""
Columns = Mapping[str, NDArray[Any]]
_FORMAT = 2
_PREFIXES = {"columns": ("column", ""), "one_way": ("one_way", "one_way:"), "texts": ("text", "text:")}
"""Kind of series: prefix of the numbered keys, prefix of names."""


def write_npz(
    path: Place, metadata: Mapping[str, Any], arrays: Columns, series: Mapping[str, Columns]
) -> None:
    """Write ``metadata`` (JSON), ``arrays`` under their names, and the ``series`` "columns", "one_way" and "texts". Raises
    `TowageError` and keeps the earlier file if it cannot be written."""
    keyed: dict[str, Any] = dict(arrays)
    described = {**metadata, "format": _FORMAT}
    for kind, (numbered, prefix) in _PREFIXES.items():
        keys = described[f"{kind}_keys"] = {}
        for k, (name, values) in enumerate(series[kind].items()):
            key = f"{prefix}{name}"
            keys[name] = key if _can_be_key(key) and key not in keyed else f"{numbered}_{k}"
            keyed[keys[name]] = values
    described["checksum"] = _checksum(described, keyed)
    keyed["metadata"] = np.frombuffer(json.dumps(described).encode(), np.uint8)
    if isinstance(path, str | os.PathLike):
        with atomic_write(path) as stream:
            np.savez(stream, **keyed)
    else:
        np.savez(path, **keyed)


def read_npz(path: Place) -> dict[str, Any]:
    """Metadata, series and arrays as written, by name. Raises `FileError` if the file cannot be read or its checksum does
    not fit, and ``ValueError``, ``TypeError`` or ``KeyError`` if it is no such store."""
    try:
        store = reading.npz(path)
    except OSError as error:
        raise FileError(f"cannot read {shown(path)}: {error.strerror or error}") from error
    metadata: dict[str, Any] = reading.from_json(store.pop("metadata").tobytes())
    written = metadata.pop("checksum", None)
    if metadata["format"] > _FORMAT:
        raise ValueError("it was written by a newer version")
    if written is not None and written != _checksum(metadata, store):
        raise ValueError("its checksum does not fit: it was changed or damaged after it was written")
    metadata.pop("format")
    for kind, (numbered, _) in _PREFIXES.items():
        if f"{numbered}_names" in metadata:  # format 1
            keys = {name: f"{numbered}_{k}" for k, name in enumerate(metadata.pop(f"{numbered}_names"))}
        else:
            keys = metadata.pop(f"{kind}_keys", {})
        letters = "U" if kind == "texts" else "fiub"
        metadata[kind] = {name: _column(store, key, letters) for name, key in keys.items()}
    return {**metadata, "time": _column(store, "time"), "step_sizes": _column(store, "step_sizes")}


def _column(store: Columns, key: str, letters: str = "fiub") -> NDArray[Any]:
    """An array of numbers in one row, or of texts (``letters`` of numpy's kinds)."""
    if store[key].ndim != 1 or store[key].dtype.kind not in letters:
        raise ValueError(f"{key} is no row of {'texts' if letters == 'U' else 'numbers'}")
    return store[key]


def _checksum(described: Mapping[str, Any], arrays: Columns) -> str:
    """SHA-256 of the metadata and of all arrays, in the order of their names."""
    digest = hashlib.sha256(json.dumps(described, sort_keys=True).encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        digest.update(f"\0{name}\0{values.dtype.str}{values.shape}\0".encode())
        digest.update(values.data)
    return digest.hexdigest()


def shown(path: Place) -> str:
    """The path, for messages."""
    return os.fspath(path) if isinstance(path, str | os.PathLike) else "a stream"


def _can_be_key(name: str) -> bool:
    """Whether numpy gives an array back under this name: not one of its own arguments, which have no dot, nor one that it
    takes for the suffix of a file."""
    return "." in name and name.isprintable() and not name.endswith(".npy")
