"""The process in which the libraries of netCDF and GRIB read a file: what a file does to them ends that process alone.

Asked by `towage.routing.forecast.contents`, a line of JSON a question: ``{"file"}`` is answered by ``{"groups"}``, its numeric
variables; ``{"file", "group", "name", "into"}`` leaves the values of a variable in the file ``into``, as floats with nan where
there are none; ``{"file", "done"}`` closes it. Every answer has ``notes``, what the library warned of, and ``refused`` where it
could not. netCDF4 applies
``_FillValue``, ``missing_value``, ``valid_range``, ``scale_factor`` and ``add_offset``.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from towage import reading
from towage.process.child import attend

MOST_VALUES = 64_000_000
"""Of a variable, unpacked."""
MOST_LETTERS = 10_000
"""Of an attribute: a longer one is no unit and no name."""
ROOM = {"netCDF file": 150 * reading.MB, "GRIB file": 300 * reading.MB}
"""Addresses beyond those of the libraries and of what is read, bytes: with fewer ecCodes waits for ever."""
COPIES = 5
"""Of the values while they are read: as stored, as floats, masked, unpacked, filled."""
LONGEST, PER_MB = 10.0, 1.0
"""Processor time for a file, s, and for each MB that it holds or unpacks to."""
Groups = list[dict[str, Any]]


class File:
    """An open file: ``groups`` of variables by name, one for netCDF, one for every kind of message for GRIB."""

    def __init__(self, path: Path) -> None:
        self.held = reading.checked_file(path)
        with open(path, "rb") as stream:
            self.kind, read = ("GRIB file", _grib) if stream.read(4) == b"GRIB" else ("netCDF file", _netcdf)
        self._allow(None)  # libraries are yet to be loaded
        self.path, self.close = path, contextlib.ExitStack()
        with reading.foreign(path, self.kind):
            self.groups: Groups = read(path, self.close, lambda: self._allow(self.held))

    def described(self) -> list[list[dict[str, Any]]]:
        """Its variables, without their values."""
        with reading.foreign(self.path, self.kind):
            return [[_described(name, *variable) for name, variable in group.items()] for group in self.groups]

    def values(self, group: int, name: str) -> Any:
        """Those of a variable. Raises `reading.Refused` where they are too many, or where the file is too small for them."""
        with reading.foreign(self.path, self.kind):
            variable = self.groups[group][name][0]
            number = int(np.prod(variable.shape, dtype=float))
            reading.limited(number, MOST_VALUES, "values")
            stored = number * variable.dtype.itemsize
            if stored > reading.RATIO_FLOOR and stored > reading.MAX_RATIO * self.held:
                raise reading.Refused(f"{stored:,} bytes of values in a file of {self.held:,}: refused as a bomb")
            self._allow(self.held + COPIES * 8 * number)
            return np.asarray(np.ma.filled(np.ma.asarray(variable[...], dtype=float), np.nan))

    def _allow(self, size: int | None) -> None:
        """Bound memory and processor time from here on by what is to be read, bytes; None: no bound."""
        with contextlib.suppress(ImportError, OSError):
            import resource

            limits = dict.fromkeys((resource.RLIMIT_CPU, resource.RLIMIT_AS), resource.RLIM_INFINITY)
            if size is not None:
                pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
                limits[resource.RLIMIT_AS] = pages * resource.getpagesize() + ROOM[self.kind] + size
                limits[resource.RLIMIT_CPU] = int(time.process_time() + LONGEST + PER_MB * size / reading.MB)
            for kind, most in limits.items():
                hard = resource.getrlimit(kind)[1]
                most = hard if most == resource.RLIM_INFINITY else most
                resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _netcdf(path: Path, close: contextlib.ExitStack, loaded: Callable[[], None]) -> Groups:
    from netCDF4 import Dataset

    loaded()
    data = close.enter_context(Dataset(path))
    group = {
        name: (each, each.dimensions, {key: each.getncattr(key) for key in each.ncattrs()})
        for name, each in data.variables.items() if _numeric(each.dtype)
    }  # fmt: skip
    if not group:
        inner = f"; its groups ({', '.join(data.groups)}) are not looked into" if data.groups else ""
        raise reading.Refused(f"has no numeric variables{inner}")
    return [group]


def _grib(path: Path, close: contextlib.ExitStack, loaded: Callable[[], None]) -> Groups:
    """All messages. Nothing is written beside the file."""
    try:
        import cfgrib  # type: ignore[import-untyped,unused-ignore]
    except (ImportError, RuntimeError) as error:
        raise reading.Refused(f"is a GRIB file; to read it: pip install 'towage[grib]' ({error})") from error
    loaded()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of xarray's future defaults, which cfgrib relies on
        sets = cfgrib.open_datasets(str(path), backend_kwargs={"indexpath": ""}, decode_times=False)
    if not sets:
        raise reading.Refused("has no messages")
    return [
        {str(name): (each, each.dims, each.attrs) for name, each in data.variables.items() if _numeric(each.dtype)}
        for data in sets
    ]


def _numeric(dtype: Any) -> bool:
    return isinstance(dtype, np.dtype) and np.issubdtype(dtype, np.number)


def _described(name: str, variable: Any, dims: Any, attributes: dict[Any, Any]) -> dict[str, Any]:
    texts = {str(key): str(value) for key, value in attributes.items() if np.size(value) == 1}
    texts = {key: text for key, text in texts.items() if len(key) + len(text) < MOST_LETTERS}
    return {"name": name, "dims": list(map(str, dims)), "shape": list(map(int, variable.shape)), "attributes": texts}


def answers(questions: Iterator[dict[str, Any]], say: Callable[[dict[str, Any]], None]) -> None:
    """Answer one after another."""
    file: File | None = None
    for asked in questions:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                path, done = Path(asked["file"]), dict[str, Any]()
                if file and (file.path != path or "into" not in asked):
                    file.close.close()
                    file = None
                if "done" not in asked:
                    file = file or File(path)
                if file and "into" in asked:
                    file.values(asked["group"], asked["name"]).tofile(asked["into"])
                elif file:
                    done["groups"] = file.described()
            except (reading.Refused, OSError, MemoryError) as error:
                done = {"refused": str(error) or type(error).__name__}
        say(done | {"notes": list(dict.fromkeys(str(warning.message) for warning in said))})


def main() -> None:
    """The process: answers until there are no more questions, and leaves without clearing up."""
    lines, say = attend()
    answers(map(json.loads, lines), say)
    os._exit(0)
