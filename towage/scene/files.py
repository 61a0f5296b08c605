"""Which FMU a unit of a scene is, with the data that it is to carry, and what its file says of itself."""

from __future__ import annotations

from pathlib import Path

from msgspec.structs import replace

from towage.data.given import Given, given
from towage.errors import SceneError, TowageError
from towage.fmus.declare.unit import Unit
from towage.registry import UNITS
from towage.scene.scene import Scene
from towage.units.archive import read_description
from towage.units.description import Description
from towage.units.store import Locate
from towage.units.vetted import heeded


def descriptions_of(scene: Scene, locate: Locate) -> dict[str, Description]:
    """What the FMUs of a scene's units say of themselves, each file read once. Raises what `described` raises."""
    data = {name: carried(scene, name) for name in scene.units}
    paths = {
        name: each.python() if (each := data[name]) else _path(scene, name, entry.fmu, locate)
        for name, entry in scene.units.items()
    }
    read = {path: heeded(path, read_description(path)) for path in dict.fromkeys(paths.values())}
    return {
        name: replace(read[path], warnings=(*read[path].warnings, *each.notes)) if (each := data[name]) else read[path]
        for name, path in paths.items()
    }


def carried(scene: Scene, name: str) -> Given | None:
    """What the unit ``name`` of a scene is to carry, None for nothing. Raises `SceneError`."""
    entry = scene.units[name]
    if not entry.files:
        if entry.fmu in UNITS.own and UNITS.get(entry.fmu).needs_files:
            kinds = ", ".join(f"{kind} ({what})" for kind, what in UNITS.get(entry.fmu).files.items())
            raise scene.error(f"{entry.fmu} means nothing without a file: give it {kinds}", f"units.{name}.files")
        return None
    if entry.fmu not in UNITS.own:
        raise scene.error(f"{entry.fmu} is no shipped unit: only these take files", f"units.{name}.files")

    def fail(message: str, kind: str) -> SceneError:
        return scene.error(message, f"units.{name}.files.{kind}")

    return given(entry.fmu, entry.files, scene.file.parent if scene.file else Path(), fail)


def declared(scene: Scene, name: str) -> Unit:
    """The declaration of the shipped unit ``name`` of a scene, with the data that it carries."""
    data = carried(scene, name)
    unit: Unit = data.unit if data else UNITS.get(scene.units[name].fmu)
    return unit


def _path(scene: Scene, name: str, fmu: str, locate: Locate) -> Path:
    key = f"units.{name}.fmu"
    if fmu.endswith(".fmu"):
        path = (scene.file.parent if scene.file else Path()) / fmu
        if not path.is_file():
            raise scene.error(f"there is no file {path}", key)
        return path
    try:
        return locate(fmu)
    except TowageError:
        raise
    except (LookupError, OSError) as error:
        raise scene.error(f"no unit {fmu!r} ({error}): expected a shipped unit or the path of an .fmu", key) from error
