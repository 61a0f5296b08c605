"""``towage import``: a system of SSP or OSP as a scene file, to which checks can be added."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from towage.terminal import escaped, tell

if TYPE_CHECKING:
    from towage.scene.scene import Scene

HELP = "write a system of SSP or OSP as a scene file, with its FMUs beside it"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage import``."""
    parser.add_argument(
        "system",
        metavar="SYSTEM",
        help="an .ssp (FILE.ssp#NAME.ssd for another variant), .ssd or OspSystemStructure.xml, or the folder of one",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="the scene file; FMUs go into a folder beside it (default: <system>.toml)",
    )
    parser.epilog = (
        "towage run SYSTEM runs a system as it is; a scene file is for adding checks, cases and a choice of what is recorded.\n\n"
        "example:\n  towage import crane.ssp --out crane.toml"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0."""
    from towage.errors import SceneError, TowageError
    from towage.files import atomic_write, reason
    from towage.scene.scene import Scene
    from towage.scene.scene_file import toml
    from towage.systems.load import system_file

    if not system_file(arguments.system):
        expected = "expected an .ssp, an .ssd or an OspSystemStructure.xml, or a folder that has one"
        raise SceneError(f"is no system of SSP or OSP: {expected}", file=Path(arguments.system))
    scene = Scene.load(arguments.system)
    out = arguments.out or Path(f"{scene.file.stem if scene.file else 'scene'}.toml")
    folder = out.with_name(f"{out.stem}_fmus")
    if taken := next((place for place in (out, folder) if place.exists()), None):
        raise SceneError("is there already, and may have been worked on: choose another --out", file=taken)
    try:
        folder.mkdir(parents=True)
        beside = _copied(scene, folder)
    except OSError as error:
        raise TowageError(f"cannot write {folder}: {reason(error)}") from error
    said = "".join(f"# {note.level}: {escaped(note.text, keep='')}\n" for note in scene.notes)
    with atomic_write(out) as stream:
        stream.write(f"# Imported from {escaped(str(arguments.system), keep='')}\n{said}\n{toml(beside)}".encode())
    for note in scene.notes:
        tell(f"{note.level}: {note.text}")
    print(f"written to {out}: {len(scene.units)} units, {len(scene.connections)} connections; FMUs in {folder}")
    return 0


def _copied(scene: Scene, folder: Path) -> Scene:
    """The scene with copies of its FMUs in ``folder``, one of each."""
    from msgspec.structs import replace

    copies: dict[str, str] = {}
    for entry in scene.units.values():
        if entry.fmu not in copies:
            name, count = Path(entry.fmu).name, 1
            while (folder / name).exists():
                count += 1
                name = f"{Path(entry.fmu).stem}_{count}.fmu"
            shutil.copyfile(entry.fmu, folder / name)
            copies[entry.fmu] = f"{folder.name}/{name}"
    units = {name: replace(entry, fmu=copies[entry.fmu]) for name, entry in scene.units.items()}
    return replace(scene, units=units)
