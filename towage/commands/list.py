"""``towage list``: what comes with towage."""

from __future__ import annotations

import argparse
import json

HELP = "list the shipped scenes and units"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage list``."""
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = "example:\n  towage list --json"


def execute(arguments: argparse.Namespace) -> int:
    """0."""
    from towage.registry import UNITS
    from towage.scene.scene import available_scenes

    scenes = {scene.name: scene.title for scene in available_scenes()}
    declared = [UNITS.get(name) for name in UNITS.names()]
    units = {u.name: u.description + (" (Python flavour only)" if u.not_native else "") for u in declared}
    if arguments.json:
        document = {
            "scenes": [{"name": name, "title": title} for name, title in scenes.items()],
            "units": [
                {"name": u.name, "description": u.description, "native": not u.not_native} for u in declared
            ],
        }
        print(json.dumps(document, indent=2))
        return 0
    width = max(map(len, (*scenes, *units)))
    for title, entries in (("Scenes", scenes), ("Units", units)):
        print(title)
        for name, text in entries.items():
            print(f"  {name:{width}}  {text}")
    return 0
