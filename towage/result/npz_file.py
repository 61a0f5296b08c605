"""npz: the working store of results, bit-exact.

``np.load("run.npz")["line.tension"]`` is a column, ``["one_way:line.tension"]`` that of the one-way run; ``time`` and
``step_sizes`` are arrays too, all else is JSON in ``metadata``. Format 1, which is read too, numbers the columns.
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.errors import TowageError
from towage.files import atomic_write

Columns = Mapping[str, NDArray[Any]]
_FORMAT = 2
_PREFIXES = {"columns": ("column", ""), "one_way": ("one_way", "one_way:"), "texts": ("text", "text:")}
"""Kind of series: prefix of the numbered keys, prefix of names."""


def write_npz(
    path: str | os.PathLike[str], metadata: Mapping[str, Any], arrays: Columns, series: Mapping[str, Columns]
) -> None:
    """Write ``metadata`` (JSON), ``arrays`` under their names, and the ``series`` "columns" and "one_way". Raises
    `TowageError` and keeps the earlier file if it cannot be written."""
    keyed: dict[str, Any] = dict(arrays)
    described = {**metadata, "format": _FORMAT}
    for kind, (numbered, prefix) in _PREFIXES.items():
        keys = described[f"{kind}_keys"] = {}
        for k, (name, values) in enumerate(series[kind].items()):
            key = f"{prefix}{name}"
            keys[name] = key if _can_be_key(key) and key not in keyed else f"{numbered}_{k}"
            keyed[keys[name]] = values
    text = json.dumps(described)
    with atomic_write(path) as stream:
        np.savez(stream, metadata=np.frombuffer(text.encode(), np.uint8), **keyed)


def read_npz(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Metadata, series and arrays as written, by name. Raises `TowageError` if the file cannot be read, and ``ValueError`` or
    ``KeyError`` if it is no such store."""
    try:
        if not zipfile.is_zipfile(path):
            with open(path, "rb"):  # a missing file is an OSError
                raise ValueError("it is not an npz archive")
        with np.load(path, allow_pickle=False) as store:
            metadata: dict[str, Any] = json.loads(store["metadata"].tobytes())
            if metadata.pop("format") > _FORMAT:
                raise ValueError("it was written by a newer version")
            for kind, (numbered, _) in _PREFIXES.items():
                if f"{numbered}_names" in metadata:  # format 1
                    keys = {name: f"{numbered}_{k}" for k, name in enumerate(metadata.pop(f"{numbered}_names"))}
                else:
                    keys = metadata.pop(f"{kind}_keys", {})
                metadata[kind] = {name: store[key] for name, key in keys.items()}
            return {**metadata, "time": store["time"], "step_sizes": store["step_sizes"]}
    except OSError as error:
        raise TowageError(f"cannot read {os.fspath(path)}: {error.strerror or error}") from error


def _can_be_key(name: str) -> bool:
    """Whether numpy gives an array back under this name: not one of its own arguments, which have no dot, nor one that it
    takes for the suffix of a file."""
    return "." in name and name.isprintable() and not name.endswith(".npy")
