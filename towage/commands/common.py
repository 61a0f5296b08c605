"""What the commands that take a scene have in common."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from towage import reading
from towage.files import cut
from towage.terminal import tell

if TYPE_CHECKING:
    from towage.process.overseer import Limits
    from towage.scene.resolve import ResolvedScene
    from towage.scene.scene import Scene


def add_scene(parser: argparse.ArgumentParser) -> None:
    """The scene, its cases and values, where its units are, and how long one may take."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file, the name of a shipped scene, or a system of SSP or OSP")
    parser.add_argument("--case", metavar="NAME", action="append", help="only this case (may be repeated)")
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        type=setting,
        default=[],
        help="a value in place of the scene's and its cases': unit.parameter or a key such as coupling.step "
        "(may be repeated)",
    )
    add_fmus(parser)
    parser.add_argument(
        "--flavour",
        choices=("auto", "python", "native"),
        default="auto",
        help="which FMUs of the shipped units: native where present (auto), none, or built where they are not; units "
        "that have no native flavour run in Python (default: auto)",
    )
    parser.add_argument(
        "--timeout",
        metavar="SECONDS",
        type=seconds,
        default=60.0,
        help="give a case up after so long without progress (default: 60; inf: never)",
    )
    for option, unit, what in (
        ("--max-time", "SECONDS", "give a case up after so long in all"),
        ("--max-cpu", "SECONDS", "end a case that has used so much processor time"),
        ("--max-memory", "MB", "end a case that wants more memory (its address space: libraries take 1 GB or more)"),
    ):
        parser.add_argument(option, metavar=unit, type=seconds, help=f"{what} (default: no limit)")


def add_one_scene(parser: argparse.ArgumentParser) -> None:
    """The scene with at most one of its cases, its values, and where its units are."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file, the name of a shipped scene, or a system of SSP or OSP")
    parser.add_argument("--case", metavar="NAME", help="with the values of this case (default: the scene's own)")
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        type=setting,
        default=[],
        help="a value in place of the scene's and its case's, as in towage run (may be repeated)",
    )
    add_fmus(parser)


def one_scene(arguments: argparse.Namespace) -> Scene:
    """The scene of `add_one_scene`, without cases. Raises `SceneError`."""
    from towage.scene.select import select

    return select(arguments.scene, arguments.case, dict(arguments.set))


def directory(out: Path | None, scene: Scene, suffix: str = "") -> Path:
    """``out``, or out/<scene><suffix>, whatever directory a unit may go to; made if it is missing. Raises `TowageError`."""
    return made((out or Path("out", f"{scene.file.stem if scene.file else 'scene'}{suffix}")).absolute())


def made(place: Path) -> Path:
    """The directory, made if it is missing. Raises `TowageError`."""
    from towage.errors import TowageError

    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TowageError(f"cannot make the directory {place}: {error.strerror}") from error
    return place


def positive(text: str) -> int:
    """A whole number above 0."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number above 0")
    return int(text)


def points(text: str) -> int:
    """A number of points, 2 to 1000."""
    if not text.isdecimal() or not 2 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 2 to 1000")
    return int(text)


def add_fmus(parser: argparse.ArgumentParser) -> None:
    """Where the shipped units' FMUs are."""
    parser.add_argument(
        "--fmus", metavar="DIR", type=Path, help="take the shipped units' FMUs from here (default: built when needed)"
    )


def setting(text: str) -> tuple[str, Any]:
    """``key=value``; the value as TOML has it, or else a text: 8, true, "8 s" and 8 s."""
    key, separator, value = text.partition("=")
    if not separator or not key.strip():
        raise argparse.ArgumentTypeError(f"{text!r}: expected KEY=VALUE, as ship.heave_period='8 s'")
    try:
        read = reading.toml(f"value = {value}")
    except ValueError:
        read = {}
    plain = len(read) == 1 and isinstance(read["value"], (bool, int, float, str, list))
    return key.strip(), read["value"] if plain else value.strip()


def seconds(text: str) -> float:
    """A number above 0: a time in s, or a size in MB."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a number above 0, or inf")
    return value


def limits(arguments: argparse.Namespace) -> Limits:
    """What a case may use up."""
    from towage.process.overseer import Limits

    given = arguments.max_memory
    memory = None if given is None or given == math.inf else round(given * 2**20)
    times = (None if value == math.inf else value for value in (arguments.max_cpu, arguments.max_time))
    return Limits(memory, *times)


def load_one(arguments: argparse.Namespace, what: str) -> Scene:
    """The only case to run; ``what`` is over one, "a sweep". Raises `SceneError`, where there are several too, and `FmuError`."""
    from towage.errors import SceneError

    _, cases = load(arguments)
    if len(cases) > 1:
        names = ", ".join(repr(case.chosen) for case in cases)
        raise SceneError(f"{what} is over one case: choose one of {names} with --case", key="--case")
    return cases[0]


def load(arguments: argparse.Namespace) -> tuple[Scene, list[Scene]]:
    """The scene with the values of ``--set``, and the scenes to run: each wanted case, or the scene itself.

    All cases are checked against the descriptions of the units. Raises `SceneError` and `FmuError`.
    """
    from towage.scene.resolve import check_all
    from towage.scene.scene import Scene
    from towage.units.store import locator

    scene = Scene.load(arguments.scene)
    if arguments.set:
        scene = scene.with_values(dict(arguments.set), "--set")
    names = list(dict.fromkeys(arguments.case or [case.name for case in scene.cases]))
    chosen = [scene.case(name) for name in names] or [scene]
    check_all(scene, locator(arguments.fmus))
    return scene, chosen


def resolved(chosen: list[Scene], arguments: argparse.Namespace) -> list[ResolvedScene]:
    """The scenes with the FMUs that are wanted, which are built here, where no timeout runs. Raises `SceneError` and
    `FmuError`."""
    from towage.scene.flavour import resolve

    return [resolve(scene, arguments.fmus, arguments.flavour, tell) for scene in chosen]


def file_name(case: str, taken: list[Path]) -> str:
    """The case's name in characters that every file system and shell takes, not yet used by a file in ``taken``."""
    base = cut(re.sub(r"[^\w.+-]+", "_", case).strip("_.")) or "case"
    used = {file.stem.casefold() for file in taken}
    name, count = base, 1
    while name.casefold() in used:
        count += 1
        name = f"{base}_{count}"
    return name
