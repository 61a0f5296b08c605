"""``towage simplest``: the cheapest model of a scene that is enough, and what every other would cost."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from towage.commands import common

if TYPE_CHECKING:
    from towage.errors import TowageError
    from towage.ladder.simplest import Ladder
    from towage.scene.scene import Scene

HELP = "find the simplest model of a scene that is enough"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage simplest``."""
    common.add_scene(parser)
    parser.add_argument(
        "--tolerance", metavar="E", type=float, help="largest relative error (default: that of the scene's checks, else 0.05)"
    )
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>_simplest)")
    parser.add_argument("--json", action="store_true", help="print the ladders as one JSON document")
    parser.add_argument("--progress", choices=("auto", "json", "none"), default="auto", help="as of towage run")
    parser.epilog = (
        "Every model that can be made of the scene is run, from the simplest to the fullest: one way or two ways, linear or\n"
        "quadratic drag, always taut, with slack, elastic or nonlinear wire, regular wave, spring or linear cable,\n"
        "rigid or flexible body. Writes <case>.toml, the scene of the cheapest that is enough, ladder.json and report.html.\n\n"
        "example:\n  towage simplest sea_cliff --case '8 s wave' --tolerance 0.02\n"
        "  towage run out/sea_cliff_simplest/8_s_wave.toml"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case has its ladder, 2 if one was refused, 3 if one failed."""
    from towage.errors import SceneError, TowageError
    from towage.files import atomic_write
    from towage.process.stop import heeded
    from towage.terminal import complain

    scene, chosen = common.load(arguments)
    common.resolved(chosen, arguments)  # builds FMUs here, where no timeout runs
    from towage.ladder.report import document, text, write_report

    out = common.directory(arguments.out, scene, "_simplest")
    stem = scene.file.stem if scene.file else "scene"
    ladders: list[Ladder] = []
    files: list[Path] = []
    faults: list[TowageError] = []
    for case in chosen:
        label = case.chosen or stem
        try:
            with heeded(at_once=True):
                ladders.append(_ladder(case, label, arguments))
        except TowageError as error:  # the other cases may be sound
            complain(f"{label}: {error}")
            faults.append(error)
            continue
        files += _scene_file(ladders[-1], out / common.file_name(label, files))
        if not arguments.json:
            print(text(ladders[-1]), flush=True)
    told = {"ladders": [document(ladder) for ladder in ladders], "errors": [str(error) for error in faults]}
    if ladders:
        files.append(out / "ladder.json")
        with atomic_write(files[-1]) as stream:
            stream.write(json.dumps(told, indent=2).encode())
        files.append(write_report(ladders, out / "report.html"))
    if arguments.json:
        print(json.dumps(told | {"files": [str(file) for file in files]}, indent=2))
    elif files:
        print(f"written to {out}: {', '.join(file.name for file in files)}")
    codes = {error.exit_code for error in faults}
    return SceneError.exit_code if SceneError.exit_code in codes else max(codes, default=0)


def _ladder(case: Scene, label: str, arguments: argparse.Namespace) -> Ladder:
    """The ladder of one case. Raises `TowageError`."""
    from towage.ladder.simplest import simplest
    from towage.process.progress import progress

    with progress(1.0, label, arguments.progress) as bar:
        return simplest(
            case, tolerance=arguments.tolerance, fmus=arguments.fmus, flavour=arguments.flavour, timeout=arguments.timeout,
            report=bar.update,
        )  # fmt: skip


def _scene_file(ladder: Ladder, path: Path) -> list[Path]:
    """The file of the recommended scene, if there is one."""
    from towage.files import atomic_write
    from towage.ladder.axis import moved
    from towage.ladder.simplest import scene_of
    from towage.scene.scene_file import toml

    if not ladder.enough:
        return []
    file = path.with_name(f"{path.name}.toml")
    with atomic_write(file) as stream:
        stream.write(toml(moved(scene_of(ladder, ladder.enough), path.parent)).encode())
    return [file]
