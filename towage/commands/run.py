"""``towage run``: every case of a scene in a process of its own, its files, one report."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

from towage.commands import common

if TYPE_CHECKING:
    from towage.result.result import Result
    from towage.scene.scene import Scene

HELP = "run the cases of a scene and judge them"
LONGEST_NAME = 100
"""Characters of a case's name that go into a file name."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage run``."""
    common.add_scene(parser)
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print the summaries as one JSON document")
    parser.add_argument(
        "--progress",
        choices=("auto", "json", "none"),
        default="auto",
        help="on stderr: a bar on a terminal and a rare line elsewhere, JSON lines, or nothing (default: auto)",
    )
    parser.add_argument("--mat", action="store_true", help="write MATLAB files too")
    parser.add_argument("--no-report", action="store_true", help="write no report.html")
    parser.epilog = (
        "Every case is written to <case>.csv and <case>.npz, and one report.html shows them all.\n\n"
        "example:\n  towage run sea_cliff --case '8 s wave' --set ship.heave_amplitude='4 ft' --out out/sea_cliff"
    )


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case was done, 2 if one was refused, 3 if one failed, 130 if interrupted."""
    from towage.cli import INTERRUPTED, complain
    from towage.errors import RunError, SceneError, TowageError

    scene, names = common.load(arguments)
    from towage.process.worker import Interrupted
    from towage.report.page import text_summary, write_report

    stem = scene.file.stem if scene.file else "scene"
    out = arguments.out or Path("out", stem)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TowageError(f"cannot make the directory {out}: {error.strerror}") from error
    results: list[Result] = []
    files: list[Path] = []
    faults: list[dict[str, str]] = []
    codes = {0}
    interrupted = False
    for name in names:
        try:
            with common.terminable():
                result = _run(scene, name, name or stem, arguments)
        except Interrupted as stop:
            result, interrupted = stop.result, True
        except TowageError as error:  # the other cases may be sound
            complain(f"{name}: {error}" if name else str(error))
            faults.append({"case": name or "", "message": str(error)})
            codes.add(error.exit_code)
            continue
        results.append(result)
        codes.add(RunError.exit_code if result.status == "failed" else 0)
        files += _write(result, out / _file_name(name or stem, files), arguments.mat)
        if not arguments.json:
            print(text_summary(result), flush=True)
        if interrupted:
            break
    if results and not arguments.no_report:
        files.append(write_report(results, out / "report.html"))
    if arguments.json:
        document = {
            "results": [result.summary() for result in results],
            "errors": faults,
            "files": [str(file) for file in files],
        }
        print(json.dumps(document, indent=2))
    elif files:
        print(f"written to {out}: {', '.join(file.name for file in files)}")
    if interrupted:
        complain("interrupted; what was recorded is kept")
        return INTERRUPTED
    return SceneError.exit_code if SceneError.exit_code in codes else max(codes)


def _run(scene: Scene, name: str | None, label: str, arguments: argparse.Namespace) -> Result:
    """One case; a unit that cannot be initialised is a failed result too."""
    from towage.errors import RunError
    from towage.process.progress import progress
    from towage.process.worker import run_isolated

    stop = (scene.case(name) if name else scene).stop_time
    try:
        with progress(stop, label, arguments.progress) as bar:
            return run_isolated(
                scene,
                name,
                arguments.fmus,
                lambda share, text: bar.update(share * stop, text),
                arguments.timeout,
                arguments.flavour,
            )
    except RunError as error:
        from towage.master.master import Master

        return Master(scene, name, arguments.fmus, arguments.flavour).salvage(None, str(error))


def _write(result: Result, path: Path, mat: bool) -> list[Path]:
    """``path`` has no suffix yet."""
    files = [path.with_name(f"{path.name}.{suffix}") for suffix in ("csv", "npz", *(["mat"] if mat else []))]
    for file, save in zip(files, (result.save_csv, result.save_npz, result.save_mat)):
        save(file)
    return files


def _file_name(case: str, taken: list[Path]) -> str:
    """The case's name in characters that every file system and shell takes, not yet used by a file in ``taken``."""
    base = re.sub(r"[^\w.+-]+", "_", case).strip("_.")[:LONGEST_NAME] or "case"
    used = {file.stem.casefold() for file in taken}
    name, count = base, 1
    while name.casefold() in used:
        count += 1
        name = f"{base}_{count}"
    return name
