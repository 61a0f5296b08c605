"""Where FMUs are: shipped units are built on demand into a cache, every FMU is unpacked once.

The cache is addressed by content (the package version and the guid), so nothing in it is ever stale. It lives in
``$TOWAGE_CACHE``, else in the user's cache directory.
"""

from __future__ import annotations

import os
from pathlib import Path

from .scene import Locate


def cache() -> Path:
    """The cache directory."""
    chosen = os.environ.get("TOWAGE_CACHE")
    return Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "towage"


def locator(directory: Path | None = None) -> Locate:
    """Finds the FMU of a shipped unit: in ``directory`` if given, else built into the cache."""

    def locate(name: str) -> Path:
        from .fmus import UNITS

        if directory is not None:
            path = directory / f"{name}.fmu"
            if path.is_file():
                return path
            raise LookupError(f"there is no {path}; build it with: python build_fmus.py {name} --out {directory}")
        if name not in UNITS:
            raise LookupError(f"the shipped units are {', '.join(UNITS)}")
        from .fmus.python_fmu import build

        return build(name, cache() / "fmus")[0]

    return locate
