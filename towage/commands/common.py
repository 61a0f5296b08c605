"""What the commands that take a scene have in common."""

from __future__ import annotations

import argparse
import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..scene import Scene

EXCLUSIVE = {"coupling.step": "coupling.tolerance", "coupling.tolerance": "coupling.step"}


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
        "--timeout",
        metavar="SECONDS",
        type=seconds,
        default=60.0,
        help="give a case up after so long without progress (default: 60; inf: never)",
    )


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


def load(arguments: argparse.Namespace) -> tuple[Scene, list[str | None]]:
    """The scene with the values of ``--set``, and the names of the cases to do (None: the scene itself).

    Every case is checked against the descriptions of the units. Raises `SceneError` and `FmuError`.
    """
    from ..scene import Scene
    from ..store import locator

    scene = Scene.load(arguments.scene)
    if arguments.set:
        scene = override(scene, dict(arguments.set))
    names: list[str | None] = list(dict.fromkeys(arguments.case or [case.name for case in scene.cases]))
    for name in names:
        scene.case(name or "")
    scene.resolve(locator(arguments.fmus))
    return scene, names or [None]


def override(scene: Scene, values: dict[str, Any]) -> Scene:
    """The scene with ``values``, which prevail over those of its cases; its source says so. Raises `SceneError`."""
    from msgspec.structs import replace

    from ..errors import SceneError
    from ..scene import Case

    option = "--set"
    try:
        changed = replace(scene, cases=(Case(option, values),)).case(option)
    except SceneError as error:
        raise scene.error(str(error.args[0]), option) from None
    taken = {*values, *(EXCLUSIVE[key] for key in values if key in EXCLUSIVE)}
    cases = tuple(replace(c, set={k: v for k, v in c.set.items() if k not in taken}) for c in scene.cases)
    note = "".join(f"# {option} {key}={value}\n" for key, value in values.items())
    return replace(changed, cases=cases, source=f"{scene.source.rstrip()}\n\n{note}" if scene.source else "")
