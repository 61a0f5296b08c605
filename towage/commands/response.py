"""``towage response``: frequency response and steady shape of the tows of a scene."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from towage.commands import common

HELP = "frequency response and steady shape of a scene's tow"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage response``."""
    common.add_one_scene(parser)
    parser.add_argument("--from", metavar="HZ", dest="first", type=_hertz, default=0.02, help="lowest frequency (0.02)")
    parser.add_argument("--to", metavar="HZ", dest="last", type=_hertz, default=1.0, help="highest frequency (1)")
    parser.add_argument("--points", metavar="N", type=common.points, default=40, help="number of frequencies (default: 40)")
    parser.add_argument(
        "--excite", metavar="NAME=AMPLITUDE[@PHASE]", action="append", default=[],
        help="surge or heave of the towpoint, drag or lift on the body (default: heave=1, Quadrant II: lift=1)",
    )  # fmt: skip
    parser.add_argument("--at", metavar="HZ", type=_hertz, action="append", default=[], help="tabulate the cable at HZ")
    parser.add_argument("--stations", metavar="N", type=common.points, default=20, help="points along the cable (default: 20)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "Amplitudes are for 1 m of heave of the towpoint (Quadrant I) or 1 N of lift on the body (Quadrant II), or for what\n"
        "--excite says, phases as q = |q| cos(omega t - phase). Writes <unit>_response.csv and .svg, and along the cable\n"
        "<unit>_cable.csv and .svg, at the frequency of the ship's heave (the middle of the range without a ship) or --at.\n\n"
        "examples:\n  towage response tow_600ft --to 2\n"
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
    """0. Raises `SceneError` where the scene has no tow or one that the theory refuses."""
    import numpy as np

    from towage.errors import SceneError
    from towage.frequency_response.response import response, save_rows

    if not arguments.first < arguments.last:
        raise SceneError(f"--from {arguments.first:g} --to {arguments.last:g}: expected a rising range of frequencies")
    hertz = np.geomspace(arguments.first, arguments.last, arguments.points)
    scene = common.one_scene(arguments)
    out = common.directory(arguments.out, scene)
    excitation = _excitation(arguments.excite)
    answers = response(scene, frequencies=hertz, excitation=excitation, fmus=arguments.fmus)
    for answer in answers:
        files = [*answer.save_plots(out), out / f"{answer.name}_response.csv", out / f"{answer.name}_cable.csv"]
        answer.save_csv(files[-2])
        tables = [answer.along(hertz, arguments.stations) for hertz in arguments.at or [None]]
        save_rows(files[-1], [row for table in tables for row in table])
        if not arguments.json:
            print(answer.text())
            if answer.spring:
                print(f"{answer.spring.name}: {answer.spring.message}")
            print(f"written to {out}: {', '.join(file.name for file in files)}")
    if arguments.json:
        documents = [{"unit": a.name, "quadrant": a.tow.tow.quadrant, "excitation": a.per, "gains": a.rows()} for a in answers]
        print(json.dumps({"tows": documents}, indent=2))
    return 0
