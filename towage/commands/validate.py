"""``towage validate``: structure, names, units and connections of scenes, without loading a unit."""

from __future__ import annotations

import argparse

from towage.commands import common

HELP = "check scene files: structure, names, units, connections, inputs, bodies that cannot be"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage validate``."""
    parser.add_argument("scenes", metavar="SCENE", nargs="+", help="a scene file, or the name of a shipped scene")
    common.add_fmus(parser)
    parser.epilog = "No FMU is loaded.\n\nexample:\n  towage validate sea_cliff my_scene.toml"


def execute(arguments: argparse.Namespace) -> int:
    """0 if all are right, 2 if one is not."""
    from towage.errors import TowageError
    from towage.scene.inputs import unset_text
    from towage.scene.resolve import check_all, warned
    from towage.scene.scene import Scene
    from towage.terminal import complain
    from towage.units.store import locator

    code, locate = 0, locator(arguments.fmus)
    for name in arguments.scenes:
        try:
            scene = Scene.load(name)
            forgotten = check_all(scene, locate)
            print(f"{name}: ok", flush=True)
            for text in warned(scene, locate):
                print(f"  warning  units: {text}", flush=True)
            if forgotten:
                print(f"  warning  inputs: {unset_text(forgotten)}", flush=True)
        except TowageError as error:
            complain(str(error))
            code = error.exit_code
    return code
