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
    from towage.errors import SceneError, TowageError
    from towage.terminal import complain

    scene, chosen = common.load(arguments)
    from towage.process.worker import check_isolated

    code = 0
    document: list[dict[str, Any]] = []
    for resolved in common.resolved(chosen, arguments):
        case = resolved.scene.chosen
        label = case or scene.title
        try:
            findings = check_isolated(resolved, arguments.timeout, common.limits(arguments))
        except TowageError as error:
            complain(f"{label}: {error}")
            document.append({"case": case, "checks": [], "error": str(error)})
            code = code if code == SceneError.exit_code else error.exit_code
            continue
        if any(finding.level == "refused" for finding in findings):
            code = SceneError.exit_code
        document.append({"case": case, "checks": [vars(finding) for finding in findings], "error": None})
        if not arguments.json:
            print(label)
            for finding in findings:
                print(f"  {finding.level:8} {finding.name}: {finding.message}")
    if arguments.json:
        print(json.dumps({"cases": document}, indent=2))
    return code
