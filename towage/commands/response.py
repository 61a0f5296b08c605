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
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "Amplitudes are for 1 m of heave of the towpoint (Quadrant I) or 1 N of lift on the body (Quadrant II), phases as\n"
        "q = |q| cos(omega t - phase). Writes <unit>_response.svg, <unit>_cable.svg and <unit>_response.csv.\n\n"
        "example:\n  towage response tow_600ft --to 2"
    )


def _hertz(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e4:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a frequency in Hz, above 0 and below 10000")
    return value


def execute(arguments: argparse.Namespace) -> int:
    """0. Raises `SceneError` where the scene has no tow or one that the theory refuses."""
    import numpy as np

    from towage.errors import SceneError
    from towage.frequency_response.response import response

    if not arguments.first < arguments.last:
        raise SceneError(f"--from {arguments.first:g} --to {arguments.last:g}: expected a rising range of frequencies")
    hertz = np.geomspace(arguments.first, arguments.last, arguments.points)
    scene = common.one_scene(arguments)
    out = common.directory(arguments.out, scene)
    answers = response(scene, frequencies=hertz, fmus=arguments.fmus)
    for answer in answers:
        files = [*answer.save_plots(out), out / f"{answer.name}_response.csv"]
        answer.save_csv(files[-1])
        if not arguments.json:
            print(answer.text())
            if answer.spring:
                print(f"{answer.spring.name}: {answer.spring.message}")
            print(f"written to {out}: {', '.join(file.name for file in files)}")
    if arguments.json:
        documents = [{"unit": a.name, "quadrant": a.tow.tow.quadrant, "gains": a.rows()} for a in answers]
        print(json.dumps({"tows": documents}, indent=2))
    return 0
