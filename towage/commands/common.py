"""What the commands that take a scene have in common."""

from __future__ import annotations

import argparse
import contextlib
import math
import re
import signal
import sys
import threading
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from towage.scene.resolve import ResolvedScene
    from towage.scene.scene import Scene

LONGEST_NAME = 100
"""Characters of a case's name that go into a file name."""


def add_scene(parser: argparse.ArgumentParser) -> None:
    """The scene, its cases and values, where its units are, and how long one may take."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file, or the name of a shipped scene")
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


def add_one_scene(parser: argparse.ArgumentParser) -> None:
    """The scene with at most one of its cases, its values, and where its units are."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file, or the name of a shipped scene")
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
    """``out``, or out/<scene><suffix>; made if it is missing. Raises `TowageError`."""
    from towage.errors import TowageError

    place = out or Path("out", f"{scene.file.stem if scene.file else 'scene'}{suffix}")
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
        read = tomllib.loads(f"value = {value}")
    except tomllib.TOMLDecodeError:
        read = {}
    plain = len(read) == 1 and isinstance(read["value"], (bool, int, float, str, list))
    return key.strip(), read["value"] if plain else value.strip()


def seconds(text: str) -> float:
    """A time above 0, in s."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a number of seconds above 0, or inf")
    return value


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

    return [resolve(scene, arguments.fmus, arguments.flavour, _tell) for scene in chosen]


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


@contextlib.contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM is Ctrl-C meanwhile: batch systems end a job with it, and what was recorded is worth keeping."""
    if threading.current_thread() is not threading.main_thread():  # only there may it be caught
        yield
        return

    def interrupt(number: int, frame: object) -> NoReturn:
        """The handler of the signal."""
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def file_name(case: str, taken: list[Path]) -> str:
    """The case's name in characters that every file system and shell takes, not yet used by a file in ``taken``."""
    base = re.sub(r"[^\w.+-]+", "_", case).strip("_.")[:LONGEST_NAME] or "case"
    used = {file.stem.casefold() for file in taken}
    name, count = base, 1
    while name.casefold() in used:
        count += 1
        name = f"{base}_{count}"
    return name
