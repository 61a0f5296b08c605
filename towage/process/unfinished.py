"""Folders of runs that are under way, beside their results: ``<name>.unfinished`` holds the journal from the first row.

A folder is locked while its run lasts and removed when the files of the run are written. One that is left tells of a run
that was killed; `recovered` and the next run into the same directory make a result of it.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import shutil
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from towage.errors import FileError, TowageError
from towage.files import claimed, in_use, reason
from towage.master.checkpoint import SUFFIX as CHECKPOINT
from towage.process.worker import JOURNAL, RESULT
from towage.result.journal import read, read_at
from towage.result.result import Result
from towage.result.writers import Writer, write_files
from towage.scene.provenance import differences, provenance
from towage.scene.resolve import ResolvedScene
from towage.terminal import tell

SUFFIX = ".unfinished"
SHOWN = 8
"""Differences that are listed where a run cannot go on."""


@dataclass
class Folder:
    """``path``: None where none could be made. ``done``: what is in it is kept elsewhere, or worth nothing."""

    path: Path | None
    done: bool = False


@contextlib.contextmanager
def unfinished(out: Path, name: str) -> Iterator[Folder]:
    """The folder of a run whose files in ``out`` are called ``name``. Raises `TowageError` where another process has it."""
    place = out / f"{name}{SUFFIX}"
    if place.is_dir() and in_use(place):
        raise TowageError(f"{place} belongs to a run that is under way: wait for it, or choose another --out")
    try:
        place.mkdir(exist_ok=True)
    except OSError as error:
        tell(f"no journal in {out}: {reason(error)}; it is kept among temporary files")
        yield Folder(None)
        return
    folder = Folder(place)
    try:
        with claimed(place):
            yield folder
    finally:
        if folder.done:
            shutil.rmtree(place, ignore_errors=True)
        else:
            tell(f"the journal of the run is left in {place}: towage recover {place}")


def left(directory: Path) -> list[Path]:
    """The folders in ``directory`` of runs that were killed, or ``directory`` itself if it is one."""
    found = [directory] if directory.name.endswith(SUFFIX) else sorted(directory.glob(f"*{SUFFIX}"))
    return [folder for folder in found if folder.is_dir() and not in_use(folder)]


def recovered(directory: Path, writers: Sequence[Writer]) -> list[Path]:
    """Make files of all journals left in ``directory``, and remove them; one that is damaged in its head, without which its
    rows have no names, is put aside. Raises `TowageError` where they cannot be written; the journal then stays."""
    files = []
    for folder in left(directory):
        case = folder.name.removesuffix(SUFFIX)
        if result := _result(folder):
            taken = {path.name.rpartition(".")[0] for path in folder.parent.iterdir()}
            files += write_files(result, folder.parent / _free(f"{case}.recovered", taken), writers)
        elif _damaged(folder / JOURNAL):
            aside = folder.parent / _free(f"{case}.damaged", {path.name for path in folder.parent.iterdir()})
            os.replace(folder, aside)
            tell(f"the journal in {folder.name} is damaged in its first line, which names its columns: it is kept as {aside}")
            continue
        shutil.rmtree(folder)
    return files


def _free(name: str, taken: Collection[str]) -> str:
    """The name, or with the first number that is not taken."""
    return next(free for k in itertools.count(1) if (free := name if k == 1 else f"{name}_{k}") not in taken)


def _damaged(journal: Path) -> bool:
    """Whether a journal has more than a first line, which cannot be read."""
    with contextlib.suppress(OSError), open(journal if journal.is_file() else os.devnull, "rb") as file:
        return file.readline().endswith(b"\n") and bool(file.read(1)) and read(file) is None
    return False


def _result(folder: Path) -> Result | None:
    """What the run in a folder recorded, or the result that it was about to hand over; None if there is nothing."""
    from towage.master.outcome import recovered as of_journal

    if (folder / RESULT).exists():
        try:
            return Result.load_npz(folder / RESULT)
        except TowageError:  # the journal may be whole
            pass
    try:
        kept = read_at(folder / JOURNAL)
    except TowageError:
        return None
    if not len(kept.rows):
        return None
    try:
        result = of_journal(kept, "the run was killed")
    except TowageError as error:
        raise FileError(f"{folder / JOURNAL}: {error}") from error
    result.message += f"; the record ends at t = {result.time[-1]:.9g} s" if len(result.time) else ""
    return result


def can_resume(folder: Path, resolved: ResolvedScene) -> bool:
    """Whether the folder has a checkpoint of this very run; what keeps it from going on is told. Raises `SceneError` where it
    is of another run."""
    if not (folder / JOURNAL).exists():
        return False
    if _damaged(folder / JOURNAL):
        raise resolved.scene.error(f"{folder} is damaged: leave --resume out, and it is put aside", "--resume")
    try:
        kept = read_at(folder / JOURNAL)
    except TowageError:
        tell(f"{folder} holds no row: the run begins anew")
        return False
    if differ := differences(kept.about.get("provenance"), json.loads(json.dumps(provenance(resolved)))):
        more = [f"and {len(differ) - SHOWN} more"] if len(differ) > SHOWN else []
        raise resolved.scene.error(
            "\n  ".join(
                [f"{folder} is of another run:", *differ[:SHOWN], *more, "leave --resume out, and it is kept as it is"]
            ),
            "--resume",
        )
    if not (folder / JOURNAL).with_suffix(CHECKPOINT).exists():
        tell(f"{folder} has no checkpoint, which takes units that can serialise their state: the run begins anew")
        return False
    return True


def done_before(path: Path, resolved: ResolvedScene) -> Result | None:
    """The finished result of this very run at ``path``, if there is one."""
    if not path.exists():
        return None
    try:
        result = Result.load_npz(path)
    except TowageError:
        return None
    same = not differences(result.provenance, json.loads(json.dumps(provenance(resolved))))
    return result if same and result.status == "done" else None
