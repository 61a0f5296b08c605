"""``towage recover``: a result of the journal that a killed run left behind."""

from __future__ import annotations

import argparse
from pathlib import Path

from towage.commands.run import DEFAULT_WRITERS, kinds

HELP = "make results of the journals of runs that were killed"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage recover``."""
    parser.add_argument(
        "directory", metavar="DIR", type=Path, help="where the files of the run go, or a folder *.unfinished"
    )
    parser.add_argument(
        "--write", metavar="KINDS", type=kinds, default=DEFAULT_WRITERS, help="kinds of files, as in towage run"
    )
    parser.epilog = (
        "Every journal becomes <case>.recovered.csv and .npz, and its folder is removed. A run into the same directory does "
        "the same before it begins; towage run --resume goes on instead.\n\n"
        "example:\n  towage recover out/sea_cliff"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0; raises `TowageError` where there is no journal."""
    from towage.errors import SceneError
    from towage.process.unfinished import left, recovered
    from towage.registry import WRITERS

    if not left(arguments.directory):
        raise SceneError(
            "there is no folder *.unfinished of a run that was killed; a sweep goes on with towage sweep --resume",
            file=arguments.directory,
        )
    files = recovered(arguments.directory, [WRITERS.get(name) for name in dict.fromkeys(arguments.write)])
    print("\n".join(map(str, files)) or "nothing was recorded")
    return 0
