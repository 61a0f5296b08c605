"""``towage reproduce``: tables and figures of the source reports, beside what these print."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

HELP = "compute tables and figures of the source reports again"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage reproduce``."""
    parser.add_argument("names", metavar="NAME", nargs="*", help="a report or one of its items, report.item (default: list all)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="where CSV and SVG files go (default: out/reports)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = "example:\n  towage reproduce slender.table_1"


def execute(arguments: argparse.Namespace) -> int:
    """0; 1 if a printed number differs and no row of the register says why. Raises `TowageError` for an unknown name."""
    from towage.commands.common import made
    from towage.reproduce import gallery
    from towage.reproduce.items import REPORTS, named, reproduce

    if not arguments.names:
        for report, title in REPORTS.items():
            print(f"{title}\n{gallery.known(report)}")
        return 0
    chosen = named(arguments.names)
    directory = made((arguments.out or Path("out", "reports")).absolute())
    documents, wrong = [], 0
    for item in chosen:
        found = reproduce(item)
        files = gallery.write_files(found, directory)
        wrong += bool(found.faults)
        documents.append(gallery.document(found) | {"files": [str(file) for file in files]})
        if not arguments.json:
            print(gallery.text(found))
            if files:
                print(f"  written to {directory}: {', '.join(file.name for file in files)}")
    if arguments.json:
        print(json.dumps({"items": documents, "wrong": wrong}, indent=2))
    return 1 if wrong else 0
