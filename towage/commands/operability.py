"""``towage operability``: how much of the time a scene's criteria hold in the seas of a place."""

from __future__ import annotations

import argparse
import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING

from towage.commands import common
from towage.commands.sweep import PARTLY_FAILED

if TYPE_CHECKING:
    from towage.operability.study import Done, Study
    from towage.scene.scene import Scene

HELP = "how much of the time criteria hold in the seas of a place"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage operability``."""
    common.add_scene(parser)
    parser.add_argument(
        "--criterion", metavar="UNIT.VARIABLE<VALUE", action="append", default=[],
        help="what has to hold, with < or > (may be repeated): 'line.margin_taut > 0', 'line.tension < 450 kN'",
    )  # fmt: skip
    parser.add_argument(
        "--scatter", metavar="FILE", default="north_atlantic",
        help="a CSV file, Hs by Tp or Tz, or a shipped diagram (default: north_atlantic, IACS Rec. 34)",
    )  # fmt: skip
    parser.add_argument(
        "--headings", metavar="N|LIST", action="append",
        help="so many, equally far apart, or directions with or without probabilities: '180=0.5,150=0.25,210=0.25'; 180 deg is a "
        "head sea (default: 12)",
    )  # fmt: skip
    parser.add_argument(
        "--seeds", metavar="N", type=common.positive, default=20, help="runs a cell (default: 20, at least 5)"
    )
    parser.add_argument(
        "--first-seed", metavar="N", type=common.positive, default=1, help="the first seed (default: 1)"
    )
    parser.add_argument("--length", metavar="TIME", default="3 h", help="of a record (default: 3 h)")
    parser.add_argument("--transient", metavar="TIME", default="200 s", help="before it, not counted (default: 200 s)")
    parser.add_argument(
        "--quantile", metavar="P", type=float, default=0.9,
        help="probability with which an extreme of the record must keep to its limit (default: 0.9)",
    )  # fmt: skip
    parser.add_argument(
        "--engine", choices=("auto", "ensemble", "runs"), default="auto",
        help="all runs as one ensemble in compiled code, or supervised runs of the master (auto: an ensemble if the scene "
        "composes)",
    )  # fmt: skip
    parser.add_argument(
        "--decide-early", action="store_true",
        help="spare the other runs of a cell whose first 5 all pass a limit: it fails, but for a chance of 1e-5 (of an ensemble)",
    )  # fmt: skip
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>_operability)")
    parser.add_argument(
        "--workers", metavar="N", type=common.positive, help="threads or processes (default: one a processor)"
    )
    parser.add_argument("--resume", action="store_true", help="do what is missing of the study in --out")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument(
        "--progress", choices=("auto", "json", "none"), default="auto", help="as of towage run; in simulated hours"
    )
    parser.epilog = (
        "The sea goes to the unit with inputs wave_height, wave_period, wave_direction (ship_in_sea); its spectrum is the\n"
        "scene's, as --set ship.peakedness=3.3 for JONSWAP. Writes journal.jsonl, from which --resume goes on, cells.csv,\n"
        "limits.csv, study.json and report.html. Returns 4 if some runs were not done.\n\n"
        "example:\n  towage operability cage_300m --criterion 'line.margin_taut > 0' --criterion 'line.tension < 350 kN'\n"
        "  towage operability cage_300m --criterion 'cage.velocity < 1.5 m/s' --scatter site.csv --headings '180,150,210'"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0 if all runs were done, 4 if some were not, 130 if interrupted. Raises `TowageError`."""
    from towage.process.stop import heeded
    from towage.terminal import INTERRUPTED, complain, tell

    scene = common.load_one(arguments, "a study")
    out = common.directory(arguments.out, scene, "_operability")
    study = _study(scene, arguments)
    for note in study.notes:
        tell(note)
    try:
        with heeded():
            done = _run(study, out, arguments)
    except KeyboardInterrupt:
        complain(f"interrupted; finished runs are kept in {out}: continue with --resume")
        return INTERRUPTED
    _write(done, out, arguments.json)
    return PARTLY_FAILED if done.lost else 0


def _study(scene: Scene, arguments: argparse.Namespace) -> Study:
    from towage.operability.study import HEADINGS, Study

    return Study.of(
        scene, arguments.criterion, scatter=arguments.scatter, directions=arguments.headings or HEADINGS,
        seeds=arguments.seeds, first=arguments.first_seed, length=_time(arguments.length, "--length"),
        transient=_time(arguments.transient, "--transient"), probability=arguments.quantile,
        engine=arguments.engine, decide_early=arguments.decide_early,
        fmus=arguments.fmus, flavour=arguments.flavour, timeout=arguments.timeout,
    )  # fmt: skip


def _run(study: Study, out: Path, arguments: argparse.Namespace) -> Done:
    from towage.process.progress import Bar, progress

    bars: list[Bar] = []
    with contextlib.ExitStack() as shown:

        def hear(ended: float, total: float, failed: int) -> None:
            """Show simulated hours."""
            if not bars:
                bars.append(shown.enter_context(progress(total, "simulated hours", arguments.progress)))
            bars[0].total = total  # less, once cells are decided
            bars[0].update(ended, f"{failed} runs not done" if failed else "")

        return study.run(out, arguments.resume, arguments.workers, hear)


def _write(done: Done, out: Path, as_json: bool) -> None:
    from towage.operability.files import document, write
    from towage.operability.report import text_summary, write_report

    files = [*write(done, out), write_report(done, out / "report.html")]
    if as_json:
        print(json.dumps({**document(done), "files": [str(file) for file in files]}, indent=2))
    else:
        print(text_summary(done))
        print(f"written to {out}: {', '.join(file.name for file in files)}")


def _time(text: str, option: str) -> float:
    """A time above 0, s; a number without a unit is in s. Raises `SceneError`."""
    import math

    from towage.errors import SceneError
    from towage.fmus.declare.quantities import QuantityError, parse_quantity

    try:
        value = float(text)
    except ValueError:
        try:
            value = parse_quantity(text, "s")
        except QuantityError as error:
            raise SceneError(str(error), key=option) from None
    if not 0.0 < value < math.inf:
        raise SceneError(f"{text!r}: expected a time above 0", key=option)
    return value
