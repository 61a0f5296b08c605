"""``towage sweep``: a scene for many values, on all processors or a cluster; a table, a report, and a way to go on."""

from __future__ import annotations

import argparse
import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING

from towage.commands import common

if TYPE_CHECKING:
    from towage.scene.scene import Scene
    from towage.sweeps.criteria import Criterion
    from towage.sweeps.sweep import Sweep
    from towage.sweeps.table import Table

HELP = "run a scene for many values"
PARTLY_FAILED = 4
"""Part of the runs was not done; the others are complete."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage sweep``."""
    common.add_scene(parser)
    parser.add_argument(
        "--vary",
        metavar="KEY=FROM:TO[:COUNT]",
        action="append",
        required=True,
        help="a range, or a list A,B,C, of unit.parameter or of a key such as coupling.step; all combinations are run (may be "
        "repeated)",
    )
    parser.add_argument("--sobol", action="store_true", help="a scrambled Sobol sequence in place of a grid")
    parser.add_argument("--samples", metavar="N", type=common.positive, help="points of the sequence; best a power of 2")
    parser.add_argument(
        "--seed", metavar="N", type=_seed, default=0, help="of the scrambling and the sample (default: 0)"
    )
    parser.add_argument(
        "--limit",
        metavar="UNIT.VARIABLE<VALUE",
        action="append",
        default=[],
        help="report in what share of the runs a recorded variable stays under (<) or over (>) this value (may be repeated)",
    )
    parser.add_argument(
        "--engine",
        choices=("runs", "ensemble"),
        default="runs",
        help="runs of the master, or all points as one ensemble in compiled code, without comparisons with second runs, "
        "for scenes of shipped units that compose (default: runs)",
    )
    parser.add_argument(
        "--sample",
        metavar="N",
        type=common.positive,
        help="points of an ensemble, drawn with --seed, that are computed again by the FMU path (default: 3)",
    )
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>_sweep)")
    parser.add_argument("--workers", metavar="N", type=common.positive, help="processes or threads (default: one a processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="run on the dask.distributed cluster with this scheduler")
    parser.add_argument("--resume", action="store_true", help="do what is missing of the sweep in --out")
    parser.add_argument("--json", action="store_true", help="print the counts as one JSON document")
    parser.add_argument("--progress", choices=("auto", "json", "none"), default="auto", help="as of towage run")
    parser.epilog = (
        "Writes journal.jsonl (a line a finished run, from which --resume goes on; not of an ensemble), table.npz, "
        "table.csv, report.html.\n"
        "Returns 4 if some runs failed, crashed or hung; these have their reason in the table.\n\n"
        "example:\n  towage sweep sea_cliff --case '8 s wave' --vary 'cradle.mass=20 long_ton:60 long_ton:9' "
        "--vary 'line.stiffness=0.5 tonf_long/ft:2 tonf_long/ft:9'\n"
        "  towage sweep slack --sobol --samples 256 --vary 'ship.heave_amplitude=2 ft:6 ft' "
        "--vary 'ship.heave_period=6 s:10 s' --limit 'line.tension < 60 kip'"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0 if all runs were done, 4 if some were not, 130 if interrupted. Raises `TowageError`."""
    from towage.errors import SceneError
    from towage.process.stop import heeded
    from towage.sweeps.criteria import criterion
    from towage.sweeps.design import design
    from towage.sweeps.sweep import JOURNAL, Sweep
    from towage.terminal import INTERRUPTED, complain

    scene = common.load_one(arguments, "a sweep")
    _check_options(arguments)
    common.resolved([scene], arguments)  # builds FMUs here, where no timeout runs
    points = design(scene, arguments.vary, arguments.samples, arguments.seed, arguments.fmus)
    sweep = Sweep(scene, points, arguments.fmus, arguments.flavour, arguments.timeout, common.limits(arguments))
    recorded = sweep.measures()
    limits = [criterion(text, recorded, "--limit") for text in arguments.limit]
    out = common.directory(arguments.out, scene, "_sweep")
    if arguments.engine == "ensemble" and (out / JOURNAL).exists():
        raise SceneError(f"{out} holds a sweep by runs, whose tables would be lost: choose another", key="--out")
    try:
        with heeded(at_once=arguments.engine == "ensemble"):
            table = _run(sweep, out, arguments)
    except KeyboardInterrupt:
        by_runs = arguments.engine == "runs"
        kept = f"finished runs are kept in {out}: continue with --resume" if by_runs else "an ensemble keeps no part"
        complain(f"interrupted; {kept}")
        return INTERRUPTED
    _write(table, scene, limits, out, arguments.json)
    return 0 if table.done.all() else PARTLY_FAILED


def _run(sweep: Sweep, out: Path, arguments: argparse.Namespace) -> Table:
    from towage.process.progress import Bar, progress
    from towage.sweeps.sweep import SAMPLE

    if arguments.engine == "ensemble":
        return sweep.run_ensemble(arguments.sample or SAMPLE, arguments.seed, arguments.workers)
    bars: list[Bar] = []
    with contextlib.ExitStack() as shown:

        def hear(ended: int, total: int, failed: int) -> None:
            """Show progress."""
            if not bars:  # only now is it known how many are left to do
                bars.append(shown.enter_context(progress(total, "sweep", arguments.progress)))
            bars[0].update(ended, f"{failed} not done" if failed else "")

        return sweep.run(out, arguments.resume, arguments.workers, arguments.dask, hear)


def _write(table: Table, scene: Scene, limits: list[Criterion], out: Path, as_json: bool) -> None:
    """The tables and the report in ``out``, the summary on stdout."""
    from towage.sweeps.report import text_summary, write_report

    files = [out / "table.npz", out / "table.csv"]
    table.save_npz(files[0])
    table.save_csv(files[1])
    files.append(write_report(table, scene, limits, out / "report.html"))
    if as_json:
        print(json.dumps(_document(table, limits, files), indent=2))
    else:
        print(text_summary(table, limits))
        print(f"written to {out}: {', '.join(file.name for file in files)}")


def _check_options(arguments: argparse.Namespace) -> None:
    """Raises `SceneError` for options that do not go together."""
    from towage.errors import SceneError
    from towage.sweeps.sweep import refuse_options

    if arguments.sobol != (arguments.samples is not None):
        raise SceneError("--sobol and --samples N go together", key="--sobol")
    names = ("sample", "resume", "dask", "fmus")
    given = {f"--{name}": getattr(arguments, name) for name in names} | {"--flavour": arguments.flavour != "auto"}
    refuse_options(arguments.engine, given)


def _document(table: Table, limits: list[Criterion], files: list[Path]) -> dict[str, object]:
    from collections import Counter

    from towage.sweeps.report import share_within

    return {
        "runs": len(table.status),
        "status": Counter(table.status),
        "verdicts": Counter(verdict for verdict, done in zip(table.verdict, table.done) if done),
        "limits": [
            {"variable": one.name, "side": one.side, "limit": one.limit,
             "share": share_within(table, one) if table.done.any() else None}
            for one in limits
        ],
        "files": [str(file) for file in files],
    }


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number, 0 or above")
    return int(text)
