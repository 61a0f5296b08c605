"""``towage run``: every case of a scene in a process of its own, its files, one report."""

from __future__ import annotations

import argparse
import contextlib
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from towage.commands import common
from towage.errors import TowageError
from towage.terminal import BUG, INTERRUPTED, complain, tell

if TYPE_CHECKING:
    from towage.result.result import Result
    from towage.scene.resolve import ResolvedScene

T = TypeVar("T")
HELP = "run the cases of a scene and judge them"
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
        help="kinds of result files, with commas: csv, npz, mat, nc, and those of other packages (default: csv,npz)",
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on where runs into --out were killed or interrupted, to the same bits"
    )
    parser.add_argument(
        "--isolate", action="store_true", help="a process a unit, with a folder of its own: slower, by some 0.2 ms a call"
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
    """How a case ended: its result, or why there is none; ``code``: what the command returns for it."""

    result: Result | None
    error: str = ""
    code: int = 0


def execute(arguments: argparse.Namespace) -> int:
    """0 if every case was done, 2 if one was refused, 3 if one failed, 70 after a defect, 130 if interrupted."""
    from towage.errors import SceneError
    from towage.process.stop import heeded

    scene, chosen = common.load(arguments)
    resolved = common.resolved(chosen, arguments)
    from towage.report.page import write_report

    work = Work(common.directory(arguments.out, scene), scene.file.stem if scene.file else "scene", arguments)
    with heeded():
        if not arguments.resume:
            work.recover()
        for case in resolved:
            if work.case(case) == INTERRUPTED:
                break
        if work.results and not arguments.no_report:
            work.keep(lambda: work.files.append(write_report(work.results, work.out / "report.html")))
        work.tell()
    if INTERRUPTED in work.codes:
        complain("interrupted; what was recorded is kept")
        return INTERRUPTED
    return SceneError.exit_code if SceneError.exit_code in work.codes else max(work.codes)


class Work:
    """The cases of one command: what came of them, and where it is kept."""

    def __init__(self, out: Path, stem: str, arguments: argparse.Namespace) -> None:
        from towage.registry import WRITERS

        self.out, self.stem, self.arguments = out, stem, arguments
        names = dict.fromkeys((*arguments.write, *(("mat",) if arguments.mat else ())))
        self.writers = [WRITERS.get(name) for name in names]
        self.results: list[Result] = []
        self.files: list[Path] = []
        self.faults: list[dict[str, str]] = []
        self.codes = {0}

    def recover(self) -> None:
        """Make results of what killed runs left in the directory, before it is in anyone's way."""
        from towage.process.unfinished import recovered

        for file in self.keep(lambda: recovered(self.out, self.writers)) or ():
            tell(f"an earlier run was killed: its record is kept as {file}")

    def case(self, resolved: ResolvedScene) -> int:
        """Run one case and write its files; the code it ends with."""
        from towage.errors import RunError
        from towage.process.unfinished import done_before, unfinished
        from towage.report.page import text_summary

        case = resolved.scene.chosen
        name = common.file_name(case or self.stem, self.files)
        if self.arguments.resume and (finished := done_before(self.out / f"{name}.npz", resolved)):
            self.results.append(finished)
            self.files.append(self.out / f"{name}.npz")
            return 0
        with unfinished(self.out, name) as folder:
            result, error, code = _run(resolved, case or self.stem, folder.path, self.arguments)
            if error:  # the other cases may be sound
                complain(f"{case}: {error}" if case else error)
                self.faults.append({"case": case, "message": error})
            if result:
                self.results.append(result)
                code = code or (RunError.exit_code if result.status == "failed" else 0)
                kept = self.keep(lambda: self._write(result, name))
                folder.done = bool(kept) or self._rescue(result, name)
                if not self.arguments.json:
                    print(text_summary(result), flush=True)
            else:
                folder.done = not self.arguments.resume  # what could not be gone on with is kept
        self.codes.add(code)
        return code

    def keep(self, write: Callable[[], T]) -> T | None:
        """What ``write`` returns; None where it raises `TowageError`, which is told and goes into the exit code."""
        try:
            return write()
        except TowageError as error:
            complain(str(error))
            self.faults.append({"case": "", "message": str(error)})
            self.codes.add(error.exit_code)
            return None

    def _write(self, result: Result, name: str) -> bool:
        """One file a writer (`towage.result.writers.Writer`), in a directory that is made again if it is gone."""
        if not self.out.is_dir():
            tell(f"{self.out} was removed during the run: made again")
            self.out = common.made(self.out)
        from towage.result.writers import write_files

        self.files += write_files(result, self.out / name, self.writers)
        return True

    def _rescue(self, result: Result, name: str) -> bool:
        """Keep a result that could not be written where it was wanted: beside, here or among temporary files."""
        for place in (self.out.parent, Path.cwd(), Path(tempfile.gettempdir())):
            with contextlib.suppress(TowageError):
                path = place / f"{name}.rescued.npz"
                result.save_npz(path)
                complain(f"the result is kept as {path}")
                self.files.append(path)
                return True
        return False

    def tell(self) -> None:
        """What was written, or everything as one JSON document."""
        if self.arguments.json:
            summaries = [result.summary() for result in self.results]
            document = {"results": summaries, "errors": self.faults, "files": [str(f) for f in self.files]}
            print(json.dumps(document, indent=2))
        elif self.files:
            print(f"written to {self.out}: {', '.join(file.name for file in self.files)}")


def _run(resolved: ResolvedScene, label: str, folder: Path | None, arguments: argparse.Namespace) -> Outcome:
    """One case; a unit that cannot be initialised is a failed result too."""
    from towage.errors import RunError
    from towage.process.progress import progress
    from towage.process.unfinished import can_resume
    from towage.process.worker import Defect, Interrupted, run_isolated

    stop = resolved.scene.stop_time
    try:
        with progress(stop, label, arguments.progress) as bar:
            report = lambda share, text: bar.update(share * stop, text)  # noqa: E731
            resume = arguments.resume and folder is not None and can_resume(folder, resolved)
            limits, isolate = common.limits(arguments), arguments.isolate
            return Outcome(run_isolated(resolved, report, arguments.timeout, folder, limits, resume, isolate))
    except Interrupted as end:
        return Outcome(end.result, "", INTERRUPTED)
    except Defect as defect:
        tell(str(defect))
        return Outcome(defect.result, "a defect of towage ended the run; what was recorded is kept", BUG)
    except RunError as error:
        from towage.master.outcome import salvaged

        return Outcome(salvaged(resolved, None, str(error)))
    except TowageError as error:
        return Outcome(None, str(error), error.exit_code)
