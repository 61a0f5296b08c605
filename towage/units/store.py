"""Where FMUs are: shipped units are built on demand into a cache, every FMU is unpacked once.

The cache is addressed by content (the text of the sources), so nothing in it is ever stale. It lives in
``$TOWAGE_CACHE``, else in the user's cache directory.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from towage.errors import FmuError
from towage.files import reason
from towage.registry import UNITS

if TYPE_CHECKING:
    from towage.fmus.declare.unit import Unit

RETIRED = {
    "tow_cable_nonlinear": 'the wire has taken its place: write fmu = "wire"; what its parameters and inputs are called there '
    "is a table in docs/wire.md"
}
"""What became of units that were shipped once, by name."""
Locate = Callable[[str], Path]
"""From the name of a shipped unit to its FMU; raises ``LookupError`` for a name it does not know."""
Structure = Mapping[str, float]
"""Structural parameters of a native FMU: sizes that are fixed when it is built."""


def cache() -> Path:
    """The cache directory. Raises `FmuError` where none is named and there is no home directory."""
    if chosen := os.environ.get("TOWAGE_CACHE"):
        return Path(chosen).absolute()
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache").absolute() / "towage"
    except RuntimeError:
        raise FmuError("there is no home directory to build and unpack FMUs in: TOWAGE_CACHE may name a place") from None


def locator(directory: Path | None = None) -> Locate:
    """Finds the FMU of a unit that is named, by whose description scenes are checked: in ``directory`` if given, the
    native one where there is no other; else the Python flavour, built into the cache. Units of other packages
    (`towage.registry`) are always looked for in the cache too."""

    def locate(name: str) -> Path:
        """The FMU. Raises ``LookupError`` for a name that is none, `FmuError` if it cannot be built."""
        if directory is not None:
            for path in (directory / f"{name}.fmu", directory / "native" / f"{name}.fmu"):
                if path.is_file():
                    return path
            if name not in UNITS.own and name in UNITS:
                return _python(name, cache() / "fmus")
            raise LookupError(
                f"there is no {directory / name}.fmu; build it with: python build_fmus.py {name} --out {directory}"
            )
        if name in RETIRED:
            raise LookupError(RETIRED[name])
        if name not in UNITS:
            raise LookupError(f"there are the units {', '.join(UNITS.names())}")
        shipped = Path(__file__).parents[1] / "shipped" / f"{name}.fmu"  # in a wheel; never in the work tree: no stale ones
        return shipped if shipped.is_file() else _python(name, cache() / "fmus")

    return locate


@functools.cache
def _python(name: str, directory: Path) -> Path:
    """The Python flavour: that of a shipped unit in a folder of its sources, built where it is not there or damaged; that
    of another package compared with its sources once a process. Raises `FmuError`."""
    from towage.fmus.describe import archive

    place = directory / f"{sources_digest()}-{metadata.version('pythonfmu')}" / f"{name}.fmu"
    if name in UNITS.own and archive.read(place):
        return place
    from towage.fmus.declare.unit import BuildError
    from towage.fmus.python.build import build, build_unit

    try:
        if name in UNITS.own:
            return build(name, place.parent)[0]
        unit = UNITS.get(name)
        if unit.name != name:
            raise FmuError(f"is called {unit.name!r} by its declaration and {name!r} by its entry point: name both alike")
        return build_unit(unit, UNITS.place(name), directory)[0]
    except BuildError as error:
        raise FmuError(f"the unit {name!r} cannot be built: {error}") from error
    except OSError as error:
        raise FmuError(f"cannot be built: {reason(error)}. TOWAGE_CACHE may name another place", file=directory) from error


def python_given(name: str, text: str, unit: Unit) -> Path:
    """The Python FMU of the shipped unit ``name`` that carries the data in ``text``, a module of its own, built into the cache
    where it is not there or damaged. Raises `FmuError`."""
    from towage.fmus.declare.unit import BuildError
    from towage.fmus.describe import archive
    from towage.fmus.python.build import build_unit

    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    place = cache() / "fmus" / f"{sources_digest()}-{metadata.version('pythonfmu')}" / f"given-{digest}" / f"{name}.fmu"
    if archive.read(place):
        return place
    try:
        return build_unit(unit, f"fmus.{name}_data:UNIT", place.parent, {f"fmus.{name}_data": text.encode()})[0]
    except BuildError as error:
        raise FmuError(f"the unit {name!r} cannot be built with its files: {error}") from error
    except OSError as error:
        raise FmuError(f"cannot be built: {reason(error)}. TOWAGE_CACHE may name another place", file=place) from error


def native_place(name: str, structure: Structure) -> Path:
    """Where in the cache the native FMU of that structure is, or would be."""
    shape = ",".join(f"{parameter}={value:g}" for parameter, value in sorted(structure.items()))
    return cache() / "native" / sources_digest() / (shape or "plain") / f"{name}.fmu"


@functools.cache
def sources_digest() -> str:
    """Digest of all that an FMU is made of: models, declarations, runtime."""
    from towage import fmus, models

    digest = hashlib.sha256()
    for package in (fmus, models):
        folder = Path(str(package.__file__)).resolve().parent
        for path in sorted(p for p in folder.rglob("*") if p.suffix in (".py", ".c", ".h")):
            digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
