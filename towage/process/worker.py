"""Runs one case in a process of its own, so that a unit that crashes, hangs or exits ends its run and nothing else.

The request is pickled (both ends are this module), the answer one of ``{"done"}``, ``{"error"}``, ``{"memory"}``,
``{"bug"}``. In a temporary directory the child leaves the journal of the run, the result, a mark (which unit is at
work, in what, at which time) and the stack of a crash. These outlive the child and tell what happened to it.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import re
import signal
import sys
import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from towage import errors
from towage.files import FULL, reason
from towage.process.child import Died, Report, attend, converse
from towage.process.mark import Mark
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene

if TYPE_CHECKING:
    from towage.result.result import Result


class Request(NamedTuple):
    """What the child is to do; ``task`` is "run" or "check"."""

    task: str
    resolved: ResolvedScene
    directory: Path


class Interrupted(KeyboardInterrupt):
    """Ctrl-C or SIGTERM during a run; ``result`` holds what was recorded until then."""

    def __init__(self, result: Result) -> None:
        super().__init__(result.message)
        self.result = result


def run_isolated(resolved: ResolvedScene, report: Report | None = None, timeout: float = math.inf) -> Result:
    """What ``run_resolved(resolved, report)`` returns, computed in another process.

    A crash, an exit, a lack of memory or ``timeout`` s without progress (the time simulated does not move on) give a
    result with status "failed" that holds what was recorded. Raises what `run_resolved` raises, and `Interrupted` on Ctrl-C.
    """
    from towage.master.master import salvaged
    from towage.result.result import Result

    with tempfile.TemporaryDirectory(prefix="towage-", ignore_cleanup_errors=True) as name:
        directory = Path(name)
        try:
            _ask(Request("run", resolved, directory), report, timeout)
            return Result.load_npz(directory / "result.npz")
        except Died as death:
            message, interrupted = str(named(death, directory)), False
        except KeyboardInterrupt:
            message, interrupted = "interrupted", True
        result = salvaged(resolved, directory / "journal", message)
        reached = f"the record ends at t = {result.time[-1]:.9g} s" if len(result.time) else "nothing was recorded"
        result.message += f"; {reached}"
        if interrupted:
            raise Interrupted(result) from None
        return result


def check_isolated(resolved: ResolvedScene, timeout: float = math.inf) -> list[Finding]:
    """What ``check_resolved(resolved)`` returns. Raises what that raises, and `RunError` where a unit ends the process or
    does not come back within ``timeout`` s."""
    with tempfile.TemporaryDirectory(prefix="towage-", ignore_cleanup_errors=True) as name:
        try:
            findings = _ask(Request("check", resolved, Path(name)), None, timeout)
        except Died as death:
            raise named(death, Path(name)) from None
    return [Finding(**values) for values in findings]


def _ask(request: Request, report: Report | None, timeout: float) -> Any:
    """The answer of a child. Raises `Died` and what the child raised."""
    answer = converse(__name__, pickle.dumps(request), report, timeout)
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


def watch(directory: Path) -> None:
    """Have this process leave its stack in ``directory`` when it crashes or is asked to."""
    import faulthandler

    stack = open(directory / "stack", "w")  # noqa: SIM115 - open until the process ends
    faulthandler.enable(stack)
    if hasattr(signal, "SIGUSR1"):
        faulthandler.register(signal.SIGUSR1, stack, chain=True)  # and end as this signal ends a process


def _serve(request: Request, report: Report) -> dict[str, Any]:
    import traceback

    watch(request.directory)
    try:
        from towage.master.master import check_resolved, run_resolved

        report(0.0, "initialisation")
        make_unit = Mark(request.directory / "mark").unit
        if request.task == "check":
            return {"done": [vars(finding) for finding in check_resolved(request.resolved, make_unit)]}
        result = run_resolved(request.resolved, report, request.directory / "journal", make_unit)
        result.save_npz(request.directory / "result.npz")
        return {"done": None}
    except errors.TowageError as error:
        fields = {k: v for k, v in vars(error).items() if k in ("file", "key", "entry", "unit", "variable", "time")}
        if fields.get("file") is not None:
            fields["file"] = str(fields["file"])
        return {"error": type(error).__name__, "message": str(error.args[0]), "fields": fields}
    except MemoryError:
        return {"memory": True}
    except OSError as error:
        if error.errno not in FULL:
            return {"bug": traceback.format_exc()}
        said = f"the run cannot keep its journal in {request.directory}: {reason(error)}. TMPDIR may name another place"
        return {"error": "TowageError", "message": said, "fields": {}}
    except BaseException:
        return {"bug": traceback.format_exc()}
