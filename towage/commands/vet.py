"""``towage vet``: what an FMU of another make does that its description does not say."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

HELP = "try an FMU of another make before it is coupled"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage vet``."""
    parser.add_argument("file", metavar="FILE.fmu", type=Path, help="the FMU")
    parser.add_argument("--out", metavar="DIR", type=Path, help="write vetted.html, vetted.json and settings.toml there")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--timeout", type=float, default=120.0, metavar="S", help="longest silence of a trial (default: 120)")
    parser.epilog = (
        "Every trial runs in a process of its own. What is found is kept in the cache, and runs with this FMU heed it.\n\n"
        "example:\n  towage vet quarter_truck.fmu --out vetted"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0 if the FMU is sound or may be used with care, 3 if it is faulty."""
    from towage.errors import RunError
    from towage.files import atomic_write
    from towage.vet.vet import vet

    found = vet(arguments.file, arguments.timeout)
    text = json.dumps(found.document(), indent=2)
    if arguments.json:
        print(text)
    else:
        print(f"{arguments.file.name}: {found.word}")
        for trial in found.trials:
            print(f"  {trial.level:8} {trial.name}: {trial.message}")
        print(found.settings(), end="")
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        files = {"vetted.html": found.html(), "vetted.json": text, "settings.toml": found.settings()}
        for name, content in files.items():
            with atomic_write(arguments.out / name) as stream:
                stream.write(content.encode())
    return RunError.exit_code if found.word == "faulty" else 0
