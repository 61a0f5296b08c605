"""``towage verify``: the models against reference cases."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

HELP = "compute reference cases and compare"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage verify``."""
    parser.add_argument("files", metavar="FILE", nargs="*", help="files of cases (default: those shipped)")
    parser.add_argument("--kind", metavar="KIND", action="append", help="only cases of this kind (may be repeated)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = "example:\n  towage verify --kind cradle_linear"


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case agrees, 1 if one does not. Raises `SceneError` for a bad file and where there is no case."""
    from ..errors import SceneError
    from ..verify import SOLVERS, verify

    found = [case for file in arguments.files or [None] for case in verify(Path(file) if file else None)]
    cases = [case for case in found if not arguments.kind or case.kind in arguments.kind]
    if not cases:
        kinds = ", ".join(sorted({case.kind for case in found} or SOLVERS))
        raise SceneError(f"there is no case to verify; the kinds are {kinds}")
    wrong = sum(not case.ok for case in cases)
    if arguments.json:
        plain = [{k: None if v != v else v for k, v in vars(case).items()} for case in cases]
        print(json.dumps({"cases": plain, "wrong": wrong}, indent=2))
        return 1 if wrong else 0
    width = max(len(case.name) for case in cases)
    for case in cases:
        print(f"{'ok   ' if case.ok else 'WRONG'} {case.name:{width}}  {case.worst_error:8.1e} of {case.rtol:.0e}")
        if case.message:
            print(f"      {case.message}")
    worst = max((case.worst_error for case in cases if not math.isnan(case.worst_error)), default=math.nan)
    print(f"{len(cases) - wrong} of {len(cases)} cases agree; the largest error is {worst:.1e}")
    return 1 if wrong else 0
