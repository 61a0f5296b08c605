"""Runs one case in a process of its own, so that a unit that crashes, hangs or exits ends its run and nothing else.

The request is pickled (both ends are this module), the answer one of ``{"done"}``, ``{"error"}``, ``{"memory"}``,
``{"bug"}``. In the folder of the run the child leaves the journal, the result, a mark (which unit is at
work, in what, at which time) and the stack of a crash. These outlive the child and tell what happened to it.
"""

from __future__ import annotations

import base64
import contextlib
import io
import math
import os
import pickle
import re
import signal
import sys
import threading
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from towage import errors
from towage.files import FULL, reason, scratch
from towage.process import stop
from towage.process.child import NO_LIMITS, Died, Report, attend, converse
from towage.process.mark import Mark
from towage.process.overseer import Limits
from towage.result.journal import read
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene

if TYPE_CHECKING:
    from towage.result.result import Result
    from towage.units.description import Description
    from towage.units.fmu import Unit, UnitFactory
    from towage.units.wiring import Wanted


JOURNAL, RESULT = "journal", "result.npz"
"""Files in the folder of a run."""
LARGE = 16 << 20
"""Bytes of a result that does not go through the pipe where it can be left on the disk."""


class Request(NamedTuple):
    """What the child is to do; ``task`` is "run" or "check"; ``resume``: go on from the checkpoint in the directory;
    ``isolate``: a process a unit, within ``limits``."""

    task: str
    resolved: ResolvedScene
    directory: Path
    resume: bool = False
    isolate: bool = False
    limits: Limits = NO_LIMITS


class Ended(BaseException):
    """A run that did not come to its end, and is not the run's own fault; ``result`` holds what was recorded until then."""

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result


class Interrupted(Ended, KeyboardInterrupt):
    """A signal that ends a job, during a run."""


class Defect(Ended, RuntimeError):
    """An error of towage, during a run."""


def run_isolated(
    resolved: ResolvedScene,
    report: Report | None = None,
    timeout: float = math.inf,
    folder: Path | None = None,
    limits: Limits = NO_LIMITS,
    resume: bool = False,
    a_process_a_unit: bool = False,
) -> Result:
    """What ``run_resolved(resolved, report)`` returns, computed in another process.

    ``folder``: where the run keeps its journal, one that the caller made and removes once the result is kept; None: a
    temporary one; ``resume``: go on from the checkpoint in it; ``a_process_a_unit``: see `towage.process.isolated`.

    A crash, an exit, a lack of memory or ``timeout`` s without progress (the time simulated does not move on) give a result
    with status "failed" that holds what was recorded; so does an error after the first row. Raises what `run_resolved`
    raises before it, `Interrupted` on Ctrl-C and the signals of `towage.process.stop`, and `Defect`.
    """
    from towage.result.result import Result

    with contextlib.ExitStack() as stack:
        directory = folder if folder and _usable(folder) else stack.enter_context(scratch())
        mode = "r+b" if resume else "w+b"  # opened here, so that it is read even if the folder is gone by then
        journal = stack.enter_context(open(directory / JOURNAL, mode))
        kind: type[Ended] | None = None
        try:
            done = _ask(Request("run", resolved, directory.absolute(), resume, a_process_a_unit, limits), report, timeout, limits)
            return Result.load_npz(io.BytesIO(base64.b64decode(done)) if done else directory / RESULT)
        except Died as death:
            message = str(named(death, directory))
        except KeyboardInterrupt:
            message, kind = "interrupted" + (f" by {stop.asked()}" if stop.asked() else ""), Interrupted
        except (errors.TowageError, RuntimeError) as error:
            kept = read(journal)
            if kept is None or not len(kept.rows):
                raise
            message, kind = str(error), None if isinstance(error, errors.TowageError) else Defect
        result = _salvaged(resolved, journal, message)
        if kind:
            raise kind(message, result) from None
        return result


def _usable(folder: Path) -> bool:
    """Whether a run can keep something in the folder."""
    with contextlib.suppress(OSError):
        Mark(folder / "mark")
        return True
    return False


def _salvaged(resolved: ResolvedScene, journal: IO[bytes], message: str) -> Result:
    from towage.master.outcome import salvaged

    result = salvaged(resolved, read(journal), message)
    reached = f"the record ends at t = {result.time[-1]:.9g} s" if len(result.time) else "nothing was recorded"
    result.message += f"; {reached}"
    return result


def check_isolated(resolved: ResolvedScene, timeout: float = math.inf, limits: Limits = NO_LIMITS) -> list[Finding]:
    """What ``check_resolved(resolved)`` returns. Raises what that raises, and `RunError` where a unit ends the process or
    does not come back within ``timeout`` s."""
    with scratch() as directory:
        try:
            findings = _ask(Request("check", resolved, directory), None, timeout, limits)
        except Died as death:
            raise named(death, directory) from None
    return [Finding(**values) for values in findings]


def _ask(request: Request, report: Report | None, timeout: float, limits: Limits) -> Any:
    """The answer of a child. Raises `Died` and what the child raised."""
    answer = converse(__name__, pickle.dumps(request), report, timeout, limits)
    if "error" in answer:
        raise _rebuilt(answer)
    if "bug" in answer:
        raise RuntimeError(f"the process of the run raised\n{answer['bug']}")
    if "memory" in answer:
        raise Died("ran out of memory")
    return answer["done"]


def named(death: Died, directory: Path) -> errors.RunError:
    """The death of a child with the unit, the time, and the line of the unit's script where these are known."""
    unit, stage, time = Mark.read(directory / "mark")
    where = f" in its {stage}" if stage else ""
    with contextlib.suppress(OSError):
        stack = (directory / "stack").read_text(errors="replace")
        if line := re.search(r'File ".*[\\/]resources[\\/](.*)", line (\d+) in (.+)', stack):
            where += " ({}, line {}, in {})".format(*line.groups())
    last = f"; the last it printed: {death.printed}" if death.printed else ""
    return errors.RunError(f"{death}{where}{last}", unit=unit, time=time)


def _rebuilt(answer: dict[str, Any]) -> errors.TowageError:
    kind: type[errors.TowageError] = getattr(errors, answer["error"])
    fields = answer["fields"]
    if fields.get("file") is not None:
        fields["file"] = Path(fields["file"])
    return kind(answer["message"], **fields)


def main() -> None:
    """The child: serves one request from stdin and leaves without clearing up, which is where libraries crash."""
    commands, say = attend()
    request: Request = pickle.load(commands)
    threading.Thread(target=lambda: (commands.read(), os._exit(1)), daemon=True).start()  # the end of the parent
    say(_serve(request, lambda share, text: say({"share": share, "text": text})))
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _there(directory: Path) -> None:
    """Make the directory again that was removed since the parent began."""
    with contextlib.suppress(OSError):
        directory.mkdir(parents=True, exist_ok=True)


def watch(directory: Path) -> None:
    """Have this process leave its stack in ``directory`` when it crashes or is asked to."""
    import faulthandler

    stack = open(directory / "stack", "w")  # noqa: SIM115 - open until the process ends
    faulthandler.enable(stack)
    if hasattr(signal, "SIGUSR1"):
        faulthandler.register(signal.SIGUSR1, stack, chain=True)  # and end as this signal ends a process


def _handed_over(result: Result, path: Path) -> str:
    """Leave the result at ``path``; its bytes go through the pipe too unless it is large, so that it arrives whatever a unit
    did to this process, or anybody to the disk: the file in base64, or ""."""
    left = False
    with contextlib.suppress(errors.TowageError, OSError, MemoryError):
        result.save_npz(path)
        left = True
    arrays = (result.time, result.step_sizes, *result.columns.values(), *result.one_way.values())
    if left and sum(values.nbytes for values in arrays) > LARGE:
        return ""
    stream = io.BytesIO()
    result.save_npz(stream)
    return base64.b64encode(stream.getvalue()).decode()


def _factory(request: Request) -> UnitFactory:
    """Makes the units of the run: in this process, or in others where that is asked for, or where a process holds one alone."""
    mark = Mark(request.directory / "mark")
    units = request.resolved.units.values()
    if not request.isolate and not any(unit.description.once_per_process for unit in units):
        return mark.unit
    from towage.process.isolated import Remote

    def make(name: str, description: Description, directory: Path, wanted: Wanted) -> Unit:
        """One unit."""
        if request.isolate or description.once_per_process:
            return Remote(mark.note, request.limits, name, description, directory, wanted)
        return mark.unit(name, description, directory, wanted)

    return make


def _serve(request: Request, report: Report) -> dict[str, Any]:
    import traceback

    _there(request.directory)
    try:
        watch(request.directory)
        from towage.master.master import check_resolved, run_resolved

        report(0.0, "initialisation")
        make_unit = _factory(request)
        if request.task == "check":
            return {"done": [vars(finding) for finding in check_resolved(request.resolved, make_unit)]}
        result = run_resolved(request.resolved, report, request.directory / JOURNAL, make_unit, request.resume)
        return {"done": _handed_over(result, request.directory / RESULT)}
    except errors.TowageError as error:
        fields = {k: v for k, v in vars(error).items() if k in ("file", "key", "entry", "unit", "variable", "time")}
        if fields.get("file") is not None:
            fields["file"] = str(fields["file"])
        return {"error": type(error).__name__, "message": str(error.args[0]), "fields": fields}
    except MemoryError:
        return {"memory": True}
    except OSError as error:
        if error.errno not in FULL and not str(error.filename).startswith(str(request.directory)):
            return {"bug": traceback.format_exc()}
        said = f"the run cannot keep its journal in {request.directory}: {reason(error)}. TMPDIR may name another place"
        return {"error": "TowageError", "message": said, "fields": {}}
    except BaseException:
        return {"bug": traceback.format_exc()}
