"""``towage run``: every case of a scene in a process of its own, its files, one report."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from towage.commands import common
from towage.files import atomic_write

if TYPE_CHECKING:
    from towage.errors import TowageError
    from towage.result.result import Result
    from towage.scene.resolve import ResolvedScene

HELP = "run the cases of a scene and judge them"
LONGEST_NAME = 100
"""Characters of a case's name that go into a file name."""
DEFAULT_WRITERS = ("csv", "npz")


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
    parser.add_argument(
        "--write",
        metavar="KINDS",
        type=kinds,
        default=DEFAULT_WRITERS,
        help="kinds of result files, with commas: csv, npz, mat, and those of other packages (default: csv,npz)",
    )
    parser.add_argument("--mat", action="store_true", help="write MATLAB files too")
    parser.add_argument("--no-report", action="store_true", help="write no report.html")
    parser.epilog = (
        "Every case is written to <case>.csv and <case>.npz, what its units say to <case>.log, and one report.html shows "
        "them all.\n\n"
        "example:\n  towage run sea_cliff --case '8 s wave' --set ship.heave_amplitude='4 ft' --out out/sea_cliff"
    )


def kinds(text: str) -> tuple[str, ...]:
    """Names of writers, with commas between them."""
    from towage.errors import suggest
    from towage.registry import WRITERS

    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in WRITERS:
            known = WRITERS.names()
            hint = f"{suggest(name, known)}; expected some of: {', '.join(known)}"
            raise argparse.ArgumentTypeError(f"unknown writer {name!r}{hint}")
    return names


class Outcome(NamedTuple):
    """How a case ended: its result, or why there is none; ``interrupted``: by the user, who wants no further case."""

    case: str
    result: Result | None
    error: TowageError | None = None
    interrupted: bool = False


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case was done, 2 if one was refused, 3 if one failed, 130 if interrupted."""
    from towage.cli import INTERRUPTED, complain
    from towage.errors import RunError, SceneError
    from towage.registry import WRITERS

    writers = [WRITERS.get(name) for name in dict.fromkeys((*arguments.write, *(("mat",) if arguments.mat else ())))]
    scene, chosen = common.load(arguments)
    resolved = common.resolved(chosen, arguments)
    from towage.report.page import text_summary, write_report

    stem = scene.file.stem if scene.file else "scene"
    out = common.directory(arguments.out, scene)
    results: list[Result] = []
    files: list[Path] = []
    faults: list[dict[str, str]] = []
    codes = {0}
    interrupted = False
    for outcome in _outcomes(resolved, stem, arguments):
        interrupted = outcome.interrupted
        if outcome.error:  # the other cases may be sound
            complain(f"{outcome.case}: {outcome.error}" if outcome.case else str(outcome.error))
            faults.append({"case": outcome.case, "message": str(outcome.error)})
            codes.add(outcome.error.exit_code)
        if outcome.result:
            results.append(outcome.result)
            codes.add(RunError.exit_code if outcome.result.status == "failed" else 0)
            files += _write(outcome.result, out / _file_name(outcome.case or stem, files), writers)
            if not arguments.json:
                print(text_summary(outcome.result), flush=True)
    if results and not arguments.no_report:
        files.append(write_report(results, out / "report.html"))
    _tell(results, faults, files, out, arguments.json)
    if interrupted:
        complain("interrupted; what was recorded is kept")
        return INTERRUPTED
    return SceneError.exit_code if SceneError.exit_code in codes else max(codes)


def _outcomes(cases: Sequence[ResolvedScene], stem: str, arguments: argparse.Namespace) -> Iterator[Outcome]:
    """The cases, run one after the other until the user interrupts one."""
    from towage.errors import TowageError
    from towage.process.worker import Interrupted

    for resolved in cases:
        case = resolved.scene.chosen
        try:
            with common.terminable():
                result = _run(resolved, case or stem, arguments)
        except Interrupted as stop:
            yield Outcome(case, stop.result, interrupted=True)
            return
        except TowageError as error:
            yield Outcome(case, None, error)
        else:
            yield Outcome(case, result)


def _run(resolved: ResolvedScene, label: str, arguments: argparse.Namespace) -> Result:
    """One case; a unit that cannot be initialised is a failed result too."""
    from towage.errors import RunError
    from towage.process.progress import progress
    from towage.process.worker import run_isolated

    stop = resolved.scene.stop_time
    try:
        with progress(stop, label, arguments.progress) as bar:
            return run_isolated(resolved, lambda share, text: bar.update(share * stop, text), arguments.timeout)
    except RunError as error:
        from towage.master.master import salvaged

        return salvaged(resolved, None, str(error))


def _write(result: Result, path: Path, writers: Sequence[Any]) -> list[Path]:
    """One file a writer (`towage.result.writers.Writer`), and a log of what the units said, if they did; ``path`` has no
    suffix yet."""
    files = []
    if result.messages:
        files.append(path.with_name(f"{path.name}.log"))
        with atomic_write(files[-1]) as stream:
            stream.write("".join(f"{message.line()}\n" for message in result.messages).encode(errors="backslashreplace"))
    for writer in writers:
        files.append(path.with_name(f"{path.name}.{writer.suffix}"))
        writer.write(result, files[-1])
    return files


def _tell(
    results: Sequence[Result], faults: list[dict[str, str]], files: Sequence[Path], out: Path, as_json: bool
) -> None:
    """What was written, or everything as one JSON document."""
    if as_json:
        summaries = [result.summary() for result in results]
        print(json.dumps({"results": summaries, "errors": faults, "files": [str(f) for f in files]}, indent=2))
    elif files:
        print(f"written to {out}: {', '.join(file.name for file in files)}")


def _file_name(case: str, taken: list[Path]) -> str:
    """The case's name in characters that every file system and shell takes, not yet used by a file in ``taken``."""
    base = re.sub(r"[^\w.+-]+", "_", case).strip("_.")[:LONGEST_NAME] or "case"
    used = {file.stem.casefold() for file in taken}
    name, count = base, 1
    while name.casefold() in used:
        count += 1
        name = f"{base}_{count}"
    return name
