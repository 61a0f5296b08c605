"""What ``towage vet`` found of FMUs, kept in the cache under the digest of the file, and what a run makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from msgspec.structs import replace

from towage import reading
from towage.files import atomic_write, sealed, unsealed
from towage.units.description import Description
from towage.units.doubt import THEREFORE, What, without
from towage.units.store import cache

LIMITS: dict[str, What] = {
    "noise": "state", "state": "state", "determinism": "state",
    "rates": "rates", "slopes": "slopes", "feedthrough": "feedthrough",
}  # fmt: skip
"""What cannot be relied on where a trial of this name ends with a warning or a fault."""
HEED = {what: THEREFORE[limit] for what, limit in LIMITS.items()} | {
    "runs": "a run may fail",
    "two instances": "each of its instances in a scene has a copy of the library",
    "environment": "what it changes is set back after each of its calls, and processes that it starts end with the run",
    "leaks": "the memory of a long run grows",
    "serialisation": "a run leaves no checkpoint",
    "reading": "what is recorded depends on how often it is read: do not rely on it",
    "delay": "take steps that are short beside what it answers to",
    "start": "look whether it does what it was set to",
    "step size": "its numbers are those of the step: halve it until they stand still",
}
"""What each trial means for a run."""


class Found(NamedTuple):
    """What a trial found against a unit."""

    trial: str
    message: str


def _place(path: Path) -> Path:
    status = path.stat()
    return cache() / "vetted" / f"{_digest(path, status.st_mtime_ns, status.st_size)}.json"


@lru_cache(maxsize=64)
def _digest(path: Path, *stamp: int) -> str:
    return reading.digest(path)[:32]


def write(path: Path, document: Mapping[str, Any]) -> None:
    """Keep what was found of the FMU at ``path``. Raises `TowageError` where it cannot be written."""
    place = _place(path)
    place.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(place) as stream:
        stream.write(sealed(document))


def found(path: Path) -> tuple[Found, ...]:
    """What was found against the FMU at ``path``; empty if nothing is known."""
    try:
        place = _place(path)
        return _read(place, place.stat().st_mtime_ns)
    except OSError:
        return ()


@lru_cache(maxsize=64)
def _read(place: Path, stamp: int) -> tuple[Found, ...]:
    try:
        trials = unsealed(place.read_bytes())["trials"]
        against = (t for t in trials if t["level"] in ("warning", "fault") and t["name"] in HEED)
        return tuple(Found(t["name"], str(t["message"])) for t in against)
    except (ValueError, KeyError, TypeError):
        return ()


def stays(path: Path) -> str:
    """Why the FMU at ``path`` is not to go back to a saved state, as it was found; "" if nothing is known against it."""
    return next((f"was vetted: {each.message}" for each in found(path) if LIMITS.get(each.trial) == "state"), "")


def heeded(path: Path, description: Description) -> Description:
    """The description without what was found not to be so, with warnings that say what was found and what follows. Units that
    keep to towage's conventions are not looked up."""
    if description.conventions or not (against := found(path)):
        return description
    limits = [LIMITS[each.trial] for each in against if each.trial in LIMITS]
    told = [each for each in against if LIMITS.get(each.trial) != "state"]  # which the run tells, where it has a say
    warnings = [f"was vetted: {each.message}, therefore {HEED[each.trial]}" for each in told]
    serialises = description.can_serialize_state and all(each.trial != "serialisation" for each in against)
    description = without(description, [limit for limit in limits if limit != "state"])
    return replace(description, warnings=(*description.warnings, *warnings), can_serialize_state=serialises)
