"""What a data file holds: variables with their dimensions and attributes, missing values as nan.

netCDF of every kind, and with the extra ``grib`` (cfgrib, eccodes) GRIB, are read by libraries in C, in a process of their own
(`towage.routing.forecast.library`): what a file makes of them, a crash, an endless loop, memory without end, is a fault of the
file. The process serves the files of a run one after another; one that refused a file or ended is not used again.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.errors import SceneError
from towage.files import scratch
from towage.process.child import Child, Died

Array = NDArray[np.float64]
PATIENCE = 300.0
"""Longest wait for an answer, s: the process has limits of its own (`library`)."""
_serving: dict[int, Child] = {}
"""The process that reads, by the id of this one, which a fork changes."""


@dataclass(frozen=True)
class Variable:
    """``load()`` gives its values as floats, nan where there are none, of shape ``shape`` over the dimensions ``dims``."""

    file: Path
    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attributes: dict[str, Any]
    load: Callable[[], Array]

    def text(self, attribute: str) -> str:
        """An attribute as text without spaces around it; empty if there is none."""
        return str(self.attributes.get(attribute, "")).strip()

    def fault(self, attribute: str, message: str) -> SceneError:
        """The fault of an attribute of this variable, or of its values."""
        place = f"{self.name}: {attribute}" if attribute else self.name
        return SceneError(f"{place}: {message}", file=self.file)


Contents = dict[str, Variable]


@contextmanager
def opened(path: Path, notes: list[str]) -> Iterator[list[Contents]]:
    """Variables of a file, numeric ones alone: one group for netCDF, one for every kind of message for GRIB. What the
    reader warns of goes into ``notes``. Nobody holds the file afterwards, so that the next forecast can be written in its place.
    Raises `SceneError` for a file that cannot be read."""
    try:
        reading.checked_file(path)
        with open(path, "rb") as stream:
            start = stream.read(8)
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", file=path) from error
    except reading.Refused as refused:
        raise SceneError(str(refused), file=path) from refused
    if not start.startswith((b"CDF", b"\x89HDF", b"GRIB")):
        raise SceneError("is neither a netCDF nor a GRIB file: expected it to begin with 'CDF', '\\x89HDF' or 'GRIB', "
                         f"found {start[:4]!r}", file=path)  # fmt: skip
    found = _asked(path, notes, {})
    groups: list[Contents] = [
        {
            each["name"]: Variable(path, each["name"], tuple(each["dims"]), tuple(each["shape"]), each["attributes"],
                                   partial(_values, path, notes, k, each["name"], tuple(each["shape"])))
            for each in group
        } for k, group in enumerate(found["groups"])
    ]  # fmt: skip
    try:
        yield groups
    finally:
        if os.getpid() in _serving:  # else the process has ended, and with it what it held
            _asked(path, notes, {"done": True})


def _values(path: Path, notes: list[str], group: int, name: str, shape: tuple[int, ...]) -> Array:
    with scratch() as folder:
        into = folder / "values"
        _asked(path, notes, {"group": group, "name": name, "into": str(into)}, f"{name}: ")
        return np.fromfile(into).reshape(shape)


def _asked(path: Path, notes: list[str], question: dict[str, Any], what: str = "") -> dict[str, Any]:
    """The answer to a question about a file. Raises `SceneError` where there is none."""
    child = _serving.get(os.getpid()) or _started()
    try:
        answer = child.ask((json.dumps({"file": str(path.absolute()), **question}) + "\n").encode(), None, PATIENCE)
    except Died as death:
        _end()
        raise SceneError(f"{what}cannot be read: the library that reads it {_fate(death)}", file=path) from None
    except BaseException:  # its answer is yet to come
        _end()
        raise
    notes += [note for said in answer["notes"] if (note := f"{path.name}: {said}") not in notes]
    if "refused" in answer:
        _end()
        raise SceneError(f"{what}{answer['refused']}", file=path)
    return answer


def _started() -> Child:
    _serving.clear()  # a process of the parent of this one is not its own
    _serving[os.getpid()] = Child("towage.routing.forecast.library")
    return _serving[os.getpid()]


@atexit.register
def _end() -> None:
    """End the process that reads."""
    if child := _serving.pop(os.getpid(), None):
        with child:
            child.end()


def _fate(death: Died) -> str:
    """How a process ended."""
    if death.code is None:
        return "made no progress and was stopped"
    with contextlib.suppress(ValueError):
        name = signal.Signals(-death.code).name if death.code < 0 else ""
        hint = {"SIGXCPU": " (used up its processor time)", "SIGKILL": " (perhaps the machine ran out of memory)"}.get(name, "")
        return f"crashed ({name}){hint}" if name else f"ended with exit code {death.code}"
    return f"crashed (signal {-death.code})"
