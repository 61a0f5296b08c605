"""``towage route``: the minimal-time route of a file, what it saves, a map and tables of it."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

HELP = "compute a minimal-time route"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage route``."""
    parser.add_argument("file", metavar="FILE", help="a route file, or the name of a shipped route (storm, pacific)")
    parser.add_argument("--method", choices=("safeguarded", "seed", "graph"), help="in place of the file's")
    parser.add_argument("--fraction", metavar="F", type=float, help="of the corrections of the method seed; the source's: 0.5")
    parser.add_argument("--cells", metavar="N", type=_count, default=20, help="meshes of the graph from start to end")
    parser.add_argument("--radius", metavar="R", type=_count, default=3, help="reach of a leg of the graph, meshes")
    parser.add_argument("--csv", metavar="FILE", type=Path, help="write the track, as the unit playback plays it")
    parser.add_argument("--rows", metavar="N", type=_rows, default=101, help="of the CSV and points of the GPX file (101)")
    parser.add_argument("--of", choices=("best", "straight"), default="best", help="whose track is written (best)")
    parser.add_argument("--gpx", metavar="FILE", type=Path, help="write it as GPX, for a plotter")
    parser.add_argument("--source-table", metavar="FILE", type=Path,
                        help="write the source's columns along an extremal: LAMBDA, S, J, Q")  # fmt: skip
    parser.add_argument("--map", metavar="FILE", type=Path, help="draw waves and routes (.svg, .png or .pdf)")
    parser.add_argument("--at", metavar="HOURS", type=_hours, action="append", help="time of a map (may be repeated)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = "example:\n  towage route storm --map storm.svg --csv storm.csv"


def _count(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 200:
        raise argparse.ArgumentTypeError("expected 1 to 200")
    return value


def _rows(text: str) -> int:
    value = int(text)
    if not 2 <= value <= 100_000:
        raise argparse.ArgumentTypeError("expected 2 to 100000")
    return value


def _hours(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError("expected a finite number of hours, 0 or more")
    return value


def execute(arguments: argparse.Namespace) -> int:
    """0 with a route; every reason for having none is a `TowageError`."""
    from towage.errors import SceneError
    from towage.routing.route import route

    if arguments.map and arguments.map.suffix.lower() not in (".svg", ".png", ".pdf"):
        raise SceneError(f"--map {arguments.map}: expected a name that ends in .svg, .png or .pdf")
    planned = route(arguments.file, method=arguments.method, cells=arguments.cells, radius=arguments.radius,
                    fraction=arguments.fraction)  # fmt: skip
    if arguments.csv:
        planned.save_csv(arguments.csv, arguments.of, arguments.rows)
    if arguments.gpx:
        planned.save_gpx(arguments.gpx, arguments.of, arguments.rows)
    if arguments.source_table:
        planned.save_source_table(arguments.source_table)
    if arguments.map:
        planned.save_map(arguments.map, arguments.at)
    if arguments.json:
        print(json.dumps(planned.document(), indent=2))
    else:
        print(planned.text())
    return 0
