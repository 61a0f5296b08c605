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
    parser.epilog = "example:\n  towage verify --kind free_decay"


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case agrees, 1 if one does not. Raises `SceneError` for a bad file and where there is no case."""
    from towage.errors import SceneError
    from towage.verify.verify import SOLVERS, verify

    for kind in arguments.kind or ():
        if kind not in SOLVERS:
            raise SceneError(f"--kind: there is no kind {kind!r}; the kinds are {', '.join(sorted(SOLVERS))}")
    computed = [case for file in arguments.files or [None] for case in verify(Path(file) if file else None)]
    cases = [case for case in computed if not arguments.kind or case.kind in arguments.kind]
    if not cases:
        raise SceneError("there is no case to verify")
    wrong = sum(not case.ok for case in cases)
    if arguments.json:
        plain = [vars(case) | ({} if math.isfinite(case.worst_error) else {"worst_error": None}) for case in cases]
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
