"""``towage response``: frequency response and steady shape of the tows of a scene, or the orbits of a lift."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

from towage.commands import common

if TYPE_CHECKING:
    from towage.scene.scene import Scene

LIFTED = {"cradle", "cradle_on_line"}
"""What hangs from a ship in a lift."""
HELP = "response over frequency of a scene's tow or lift"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage response``."""
    common.add_one_scene(parser)
    parser.add_argument("--from", metavar="HZ", dest="first", type=_hertz, default=0.02, help="lowest frequency (0.02)")
    parser.add_argument("--to", metavar="HZ", dest="last", type=_hertz, help="highest frequency (1; lift: 0.3)")
    parser.add_argument("--points", metavar="N", type=common.points, default=40, help="number of frequencies (default: 40)")
    parser.add_argument(
        "--excite", metavar="NAME=AMPLITUDE[@PHASE]", action="append", default=[],
        help="surge or heave of the towpoint, drag or lift on the body (default: heave=1, Quadrant II: lift=1)",
    )  # fmt: skip
    parser.add_argument("--at", metavar="HZ", type=_hertz, action="append", default=[], help="tabulate the cable at HZ")
    parser.add_argument("--stations", metavar="N", type=common.points, default=20, help="points along the cable (default: 20)")
    parser.add_argument("--second", action="store_true", help="the mean shift and what moves at twice the frequency, too")
    lift = parser.add_argument_group("a lift: a ship with a cradle on a line")
    lift.add_argument("--limits", action="store_true", help="the heave at which the line goes slack, and breaks")
    lift.add_argument(
        "--starts", metavar="N", type=common.points, default=0,
        help="follow N x N starts to the motions that they reach at the scene's own period",
    )  # fmt: skip
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "Amplitudes are for 1 m of heave of the towpoint (Quadrant I) or 1 N of lift on the body (Quadrant II), or for what\n"
        "--excite says, phases as q = |q| cos(omega t - phase). Writes <unit>_response.csv and .svg, with --second\n"
        "<unit>_second.csv, and along the cable <unit>_cable.csv and .svg, at the frequency of the ship's heave (the middle of\n"
        "the range without a ship) or --at.\n\n"
        "A lift is followed along exact orbits, up and, where the line goes slack, down again: lift_response.csv and .svg,\n"
        "with --limits lift_limits.csv.\n\n"
        "examples:\n  towage response tow_600ft --to 2\n  towage response slack --limits --points 10\n"
        "  towage response tow_600ft --excite heave='3 ft' --excite surge='2 ft @ 40 deg' --at 0.3"
    )


def _hertz(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e4:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a frequency in Hz, above 0 and below 10000")
    return value


def _excitation(given: list[str]) -> dict[str, float | complex | str]:
    from towage.errors import SceneError

    found: dict[str, float | complex | str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals:
            raise SceneError(f"--excite {text}: expected NAME=AMPLITUDE[@PHASE], as in heave='3 ft @ 40 deg'")
        if name in found:
            raise SceneError(f"--excite {text}: {name} is given twice")
        found[name] = value
    return found


def execute(arguments: argparse.Namespace) -> int:
    """0. Raises `SceneError` where the scene has neither a tow nor a lift, or one that the theory refuses."""
    from towage.errors import SceneError

    scene = common.one_scene(arguments)
    lift = LIFTED & {Path(unit.fmu).stem for unit in scene.units.values()}
    last = arguments.last or (0.3 if lift else 1.0)
    if not arguments.first < last:
        raise SceneError(f"--from {arguments.first:g} --to {last:g}: expected a rising range of frequencies")
    out = common.directory(arguments.out, scene)
    return (_lift if lift else _tows)(arguments, scene, last, out)


def _tows(arguments: argparse.Namespace, scene: Scene, last: float, out: Path) -> int:
    import numpy as np

    from towage.errors import SceneError
    from towage.frequency_response.response import response, save_rows
    from towage.models.cable.case import CableError

    if arguments.limits or arguments.starts:
        raise _not_for("--limits and --starts", "a lift", "a tow")
    hertz = np.geomspace(arguments.first, last, arguments.points)
    answers = response(scene, frequencies=hertz, excitation=_excitation(arguments.excite), fmus=arguments.fmus)
    try:
        second = {answer.name: answer.second_rows() for answer in answers} if arguments.second else {}
    except CableError as error:
        raise SceneError(f"--second: {error}") from error
    for answer in answers:
        files = [*answer.save_plots(out), out / f"{answer.name}_response.csv", out / f"{answer.name}_cable.csv"]
        answer.save_csv(files[-2])
        tables = [answer.along(at, arguments.stations) for at in arguments.at or [None]]
        save_rows(files[-1], [row for table in tables for row in table])
        if arguments.second:
            files.append(out / f"{answer.name}_second.csv")
            save_rows(files[-1], second[answer.name])
        if not arguments.json:
            print(answer.text())
            print(f"written to {out}: {', '.join(file.name for file in files)}")
    if arguments.json:
        documents = [
            {"unit": a.name, "quadrant": a.tow.tow.quadrant, "excitation": a.per, "gains": a.rows()}
            | ({"second": second[a.name]} if second else {})
            for a in answers
        ]
        print(json.dumps({"tows": documents}, indent=2))
    return 0


def _lift(arguments: argparse.Namespace, scene: Scene, last: float, out: Path) -> int:
    import numpy as np

    from towage.frequency_response.lift import lift_response

    if arguments.excite or arguments.at or arguments.second:
        raise _not_for("--excite, --at and --second", "a tow", "a lift, which its ship excites")
    hertz = np.geomspace(arguments.first, last, arguments.points)
    answer = lift_response(
        scene, frequencies=hertz, limits=arguments.limits, starts=arguments.starts, fmus=arguments.fmus
    )
    files = answer.save(out)
    if arguments.json:
        document = {"heave": answer.amplitude, "points": answer.rows(), "limits": answer.limit_rows()}
        print(json.dumps(document, indent=2))
        return 0
    print(answer.text())
    print(f"written to {out}: {', '.join(file.name for file in files)}")
    return 0


def _not_for(options: str, meant: str, given: str) -> Exception:
    from towage.errors import SceneError

    return SceneError(f"{options}: meant for {meant}; this scene is {given}")
