"""``towage stability``: critical tow speeds of a scene's slender body, its modes over speed, a stability map."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
from pathlib import Path

from towage.commands import common

HELP = "critical tow speeds of a scene's towed slender body"
MAPS = ("tail_cut", "rope_length", "slenderness", "end_length", "tail_length", "friction")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage stability``."""
    common.add_one_scene(parser)
    parser.add_argument("--map", choices=MAPS, help="a stability map over this parameter too")
    parser.add_argument("--points", metavar="N", type=common.points, default=41, help="values of the map (default: 41)")
    parser.add_argument("--u-max", metavar="U", type=_speed, default=12.0,
                        help="largest dimensionless tow speed u, at most 14 (default: 12)")  # fmt: skip
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--progress", choices=("auto", "json", "none"), default="auto", help="as of towage run")
    parser.epilog = (
        "Writes argand.svg, and for a map <parameter>.svg and <parameter>.csv. Rows of a map are kept in the cache.\n\n"
        "example:\n  towage stability slender_flutter --map tail_cut"
    )


def _speed(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.5 <= value <= 14.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a number from 0.5 to 14")
    return value


def execute(arguments: argparse.Namespace) -> int:
    """0. Raises `SceneError` where the scene has no slender body or one that no theory holds for."""
    from towage.process.progress import progress
    from towage.tow_stability.stability import stability

    scene = common.one_scene(arguments)
    with contextlib.ExitStack() as shown:
        bar = None
        if arguments.map:
            bar = shown.enter_context(progress(1.0, f"map over {arguments.map}", arguments.progress))
        answers = stability(
            scene, u_max=arguments.u_max, map=arguments.map, values=arguments.points, fmus=arguments.fmus,
            report=bar.update if bar else None,
        )  # fmt: skip
    out = common.directory(arguments.out, scene)
    documents = []
    for answer in answers:
        files = answer.save_plots(out)
        if answer.parameter:
            files.append(out / f"{answer.name}_{answer.parameter}.csv")
            answer.save_csv(files[-1])
        documents.append(answer.document() | {"files": [str(file) for file in files]})
        if not arguments.json:
            print(answer.text())
            print(f"written to {out}: {', '.join(file.name for file in files)}")
    if arguments.json:
        print(json.dumps({"bodies": documents}, indent=2))
    return 0
