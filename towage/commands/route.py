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
    parser.add_argument("--cells", metavar="N", type=_count, default=20, help="meshes of the graph from start to end")
    parser.add_argument("--radius", metavar="R", type=_count, default=3, help="reach of a leg of the graph, meshes")
    parser.add_argument("--csv", metavar="FILE", type=Path, help="write the track of the best route")
    parser.add_argument("--map", metavar="FILE", type=Path, help="draw waves and routes (.svg, .png or .pdf)")
    parser.add_argument("--at", metavar="HOURS", type=_hours, action="append", help="time of a map (may be repeated)")
    parser.add_argument("--parameters", choices=("best", "straight"), help="print the parameters of the unit voyage")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = "example:\n  towage route storm --map storm.svg --csv storm.csv"


def _count(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 200:
        raise argparse.ArgumentTypeError("expected 1 to 200")
    return value


def _hours(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError("expected a finite number of hours, 0 or more")
    return value


def execute(arguments: argparse.Namespace) -> int:
    """0 with a route; every reason for having none is a `TowageError`."""
    from towage.errors import SceneError, TowageError
    from towage.models.route.plan import RouteError, plan
    from towage.routing.file import load
    from towage.routing.output import HOUR, MILE, draw, parameters_text, unit_parameters, write_csv

    if arguments.map and arguments.map.suffix.lower() not in (".svg", ".png", ".pdf"):
        raise SceneError(f"--map {arguments.map}: expected a name that ends in .svg, .png or .pdf")
    given = load(arguments.file)
    problem = given.problem
    try:
        found = plan(problem, method=arguments.method or given.method, cells=arguments.cells, radius=arguments.radius)
    except RouteError as error:
        wrong = error.reason in ("input", "outside", "forbidden")
        raise (SceneError(str(error), file=given.path) if wrong else TowageError(f"{given.path}: {error}")) from error
    if arguments.csv:
        write_csv(arguments.csv, problem, found.best)
    if arguments.map:
        draw(arguments.map, given.title, problem, found, arguments.at)
    if arguments.parameters:
        chosen = found.best if arguments.parameters == "best" else found.straight
        if chosen is None:
            raise TowageError(f"{given.path}: there is no {arguments.parameters} route: {'; '.join(found.notes)}")
        print(parameters_text(unit_parameters(problem, chosen)), end="")
        return 0
    best = found.best
    others = [r.duration / HOUR for r in found.others]
    times = {name: r.duration / HOUR if r else None for name, r in (("straight", found.straight), ("geodesic", found.geodesic))}
    graph = found.graph_time / HOUR if math.isfinite(found.graph_time) else None
    distance = problem.medium.map.distance(problem.start, problem.end) / MILE
    if arguments.json:
        print(json.dumps({
            "title": given.title, "kind": best.kind, "best_h": best.duration / HOUR, "other_minima_h": others,
            "straight_h": times["straight"], "geodesic_h": times["geodesic"], "graph_h": graph, "saving": found.saving,
            "distance_nmi": distance, "certified": best.certified,
            "j_exact_m_per_rad": _finite(best.j_exact), "j_seed_m_per_rad": _finite(best.j_seed),
            "beyond_forecast": found.beyond_horizon, "beyond_polar": found.beyond_polar, "tacking": found.tacking,
            "notes": found.notes,
        }, indent=2))  # fmt: skip
        return 0
    print(f"{given.title}: {distance:.1f} nmi")
    print(f"  best route        {best.duration / HOUR:12.6f} h   ({best.kind})")
    print(f"  second best       {others[0]:12.6f} h   (local minimum)" if others else "  second best            none found")
    for name, hours in times.items():
        print(f"  {name:17} {hours:12.6f} h" if hours is not None else f"  {name:17}       none")
    if graph is not None:
        print(f"  graph             {graph:12.6f} h   ({arguments.cells} meshes, radius {arguments.radius})")
    if found.saving is not None:
        print(f"  saving over the straight route: {found.saving:.2%}")
    if best.certified and math.isfinite(best.j_exact):
        print(f"  certificate: local minimum, j_exact = {best.j_exact / MILE:.6g} nmi/rad > 0 along the track "
              f"(source's j = {best.j_seed / MILE:.6g})")  # fmt: skip
    elif not best.certified:
        print("  certificate: none")
    for note in found.notes:
        print(f"  note: {note}")
    return 0


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
