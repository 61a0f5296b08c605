"""What a result depends on: the scene, the FMUs by their contents, versions, the machine."""

from __future__ import annotations

import functools
import hashlib
import platform
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

from towage import reading
from towage.scene.resolve import ResolvedScene
from towage.units.sources import brought

LIBRARIES = ("towage", "fmpy", "numpy", "scipy")


def provenance(resolved: ResolvedScene) -> dict[str, Any]:
    """All of it, in terms of JSON: ``scene`` (`Scene.to_dict`), ``case``, ``file``, ``fmus`` (unit to name and SHA-256),
    ``versions``, ``machine``."""
    scene = resolved.scene
    return {
        "scene": scene.to_dict(),
        "case": scene.chosen,
        "file": str(scene.file.absolute()) if scene.file else "",
        "fmus": {name: {"file": unit.path.name, "sha256": digest(unit.path)} for name, unit in resolved.units.items()},
        **surroundings(),
    }


def digest(path: Path) -> str:
    """SHA-256 of an FMU; one that does not change is read once a process, because every run of a sweep asks."""
    status = path.stat()
    return _digest(path, status.st_mtime_ns, status.st_size)


@functools.lru_cache(maxsize=64)
def _digest(path: Path, *stamp: int) -> str:
    return reading.digest(path)


@functools.cache
def surroundings() -> dict[str, Any]:
    """``versions`` of towage, by its text too, of Python, of libraries and of packages that bring units; ``machine``."""
    versions = {name: metadata.version(name) for name in (*LIBRARIES, *brought())}
    versions |= {"python": platform.python_version(), "code": code()}
    return {"versions": versions, "machine": f"{sys.platform} {platform.machine()}"}


@functools.cache
def code() -> str:
    """A digest of the text of towage."""
    root, digest = Path(__file__).parents[1], hashlib.sha256()
    for folder in (root, root / "models", root / "fmus"):  # the latter may be links
        for path in sorted(folder.resolve().rglob("*")):
            if path.suffix in (".py", ".c", ".h"):
                digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def differences(old: Any, new: Any, key: str = "") -> list[str]:
    """What differs between two provenances, one line a leaf."""
    if isinstance(old, dict) and isinstance(new, dict):
        names = dict.fromkeys([*old, *new])
        return [line for name in names for line in differences(old.get(name), new.get(name), f"{key}.{name}".strip("."))]
    if old == new or (isinstance(old, list | tuple) and isinstance(new, list | tuple) and list(old) == list(new)):
        return []
    return [f"{key}: {old!r} there, {new!r} here"]
