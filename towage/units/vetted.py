"""What ``towage vet`` found of FMUs, kept in the cache under the digest of the file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from towage import reading
from towage.files import atomic_write, sealed, unsealed
from towage.units.store import cache

LIMITED = ("noise", "state")
"""Trials whose warning means that the unit is not to go back."""


def _place(path: Path) -> Path:
    return cache() / "vetted" / f"{reading.digest(path)[:32]}.json"


def write(path: Path, document: Mapping[str, Any]) -> None:
    """Keep what was found of the FMU at ``path``. Raises `TowageError` where it cannot be written."""
    place = _place(path)
    place.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(place) as stream:
        stream.write(sealed(document))


def stays(path: Path) -> str:
    """Why the FMU at ``path`` is not to go back to a saved state, as it was found; "" if nothing is known against it, or what
    was kept was changed."""
    try:
        trials = unsealed(_place(path).read_bytes())["trials"]
        return next((f"was vetted: {t['message']}" for t in trials if t["name"] in LIMITED and t["level"] == "warning"), "")
    except (OSError, ValueError, KeyError, TypeError):
        return ""
