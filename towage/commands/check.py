"""``towage check``: what can be said of a scene's scheme and step before it runs."""

from __future__ import annotations

import argparse
import json
from typing import Any

from towage.commands import common

HELP = "check before a run whether scheme and step carry the coupling"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage check``."""
    common.add_scene(parser)
    parser.add_argument("--json", action="store_true", help="print the checks as one JSON document")
    parser.epilog = "Units are initialised but not run.\n\nexample:\n  towage check sea_cliff --set coupling.step='1 s'"


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case may run, 2 if one is refused, 3 if a unit fails in its initialisation."""
    from towage.cli import complain
    from towage.errors import TowageError

    scene, names = common.load(arguments)
    from towage.process.worker import check_isolated

    code = 0
    document: list[dict[str, Any]] = []
    for name in names:
        label = name or scene.title
        try:
            checks = check_isolated(scene, name, arguments.fmus, arguments.timeout, arguments.flavour)
        except TowageError as error:
            complain(f"{label}: {error}")
            document.append({"case": name or "", "checks": [], "error": str(error)})
            code = code if code == 2 else error.exit_code
            continue
        if any(check.level == "refused" for check in checks):
            code = 2
        document.append({"case": name or "", "checks": [vars(check) for check in checks], "error": None})
        if not arguments.json:
            print(label)
            for check in checks:
                print(f"  {check.level:8} {check.name}: {check.message}")
    if arguments.json:
        print(json.dumps({"cases": document}, indent=2))
    return code
