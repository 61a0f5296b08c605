"""Units that crash, hang, fail or lie in a call of the standard: exit code 3, the record kept up to there, and the unit named."""

from __future__ import annotations

import contextlib
import json
import math
import resource
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil

from tests.foreign.units import hostile

from .survival import DUE, STEP, STOP, Case, scene

ADDRESS_SPACE = 4 << 30
"""More than a run takes with all its libraries, bytes."""
NEXT = DUE + STEP


def misbehaving(misdeed: str, coupling: str = "", **how: object) -> Callable[[Path], Path]:
    """The scene y1' = -y2, y2' = y1, in which the first unit does ``misdeed``."""

    def write(directory: Path) -> Path:
        units = {
            "winch": hostile(directory / "winch.fmu", misdeed, **how),  # type: ignore[arg-type]
            "load": hostile(directory / "load.fmu"),
        }
        connections = ["winch.y -> load.u", "load.y -> winch.u"]
        start = {"units.winch.parameters": "gain = -1.0\nx0 = 1.0"}
        return scene(directory, units, connections, coupling=coupling, **start)

    return write


def named(case: str) -> Callable[[Path], Path]:
    """A sound scene with one case of that name."""

    def write(directory: Path) -> Path:
        path = misbehaving("none")(directory)
        path.write_text(f"{path.read_text('utf-8')}\n[[cases]]\nname = {json.dumps(case)}\n", "utf-8")
        return path

    return write


def stepped(step: float, more: str = "") -> Callable[[Path], Path]:
    """A sound scene with that step, s, and ``more`` tables."""

    def write(directory: Path) -> Path:
        path = misbehaving("none")(directory)
        path.write_text(path.read_text("utf-8").replace(f"step = {STEP}", f"step = {step}") + more, "utf-8")
        return path

    return write


@contextlib.contextmanager
def little_memory(directory: Path) -> Iterator[None]:
    """An address space that a unit can use up without harm to the machine, here and in the processes started."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


@contextlib.contextmanager
def nothing_stays(directory: Path) -> Iterator[None]:
    """No process is left that has a folder of the case open or in its arguments, nor a child of this one."""
    me = psutil.Process()
    before = {child.pid for child in me.children(recursive=True)}
    known = set(psutil.pids())
    yield
    left = [child for child in me.children(recursive=True) if child.pid not in before]
    left += [p for p in psutil.process_iter() if p.pid not in known and _runs_towage(p)]
    assert not left, left


def _runs_towage(process: psutil.Process) -> bool:
    with contextlib.suppress(psutil.Error):
        return process.ppid() == 1 and "towage.process.worker" in " ".join(process.cmdline())
    return False


ANY_TIME = math.nan
SIGNALS = {
    "segv": "SIGSEGV", "overflow": "SIGSEGV", "divide": "SIGFPE", "abort": "SIGABRT", "kill": "SIGKILL",
    "free twice": "SIGABRT", "leave": r"exit code 0\) in its step",
    "hang": "made no progress for 2 s", "spin": "made no progress for 2 s",
    "close": "ended the process of the run",
}  # fmt: skip
DEATHS: list[tuple[str, float | None, str]] = [
    ("instantiate:segv", None, r"winch: crashed .*SIGSEGV.* in its instantiation; nothing was recorded"),
    ("setup:abort", None, r"winch, t = 0 s: crashed .*SIGABRT.* in its initialisation"),
    ("enter:segv", None, r"winch, t = 0 s: crashed .*SIGSEGV.* in its initialisation"),
    ("exit:hang", None, r"winch, t = 0 s: made no progress for 2 s .* in its initialisation"),
    *((f"step:{what}@1", ANY_TIME if what == "close" else DUE, says) for what, says in SIGNALS.items()),
    ("set:segv@1", NEXT, "SIGSEGV"),
    ("get:segv@1", DUE, "SIGSEGV"),
    ("save:segv@1", NEXT, "SIGSEGV.* in its state"),
    ("restore:segv@1", DUE, "SIGSEGV.* in its state"),
    ("terminate:segv", STOP, "winch: crashed .* in its termination; the record ends at t = 2 s"),
    ("terminate:leave", STOP, r"winch: ended .*exit code 0\) in its termination"),
    ("terminate:hang", STOP, "winch: made no progress for 2 s .* in its termination"),
    ("free:segv", STOP, "winch: crashed .* in its termination"),
]  # fmt: skip
FAILURES: list[tuple[str, float | None, str]] = [
    ("instantiate:error", None, "winch: could not be instantiated"),
    ("setup:error", None, "winch, t = 0 s: setting up the experiment failed"),
    ("exit:fatal", None, "winch, t = 0 s: initialisation failed"),
    ("set:fatal@1", NEXT, "winch, t = 1.1 s: setting inputs returned Fatal"),
    ("restore:fatal@1", DUE, "winch, t = 1 s: restoring the state returned Fatal"),
    ("set:error@1", NEXT, "winch, t = 1.1 s: setting inputs returned Error"),
    ("get:fatal@1", DUE, "winch, t = 1.1 s: reading outputs returned Fatal"),
    ("step:discard@1", DUE, "no step is short enough for a unit .*: winch, Discard"),
    ("step:error@1", DUE, "no step is short enough for a unit .*: winch, Error"),
    ("step:fatal@1", DUE, "winch, t = 1 s: the step returned Fatal"),
    ("step:pending@1", DUE, "the step returned Pending"),
    ("step:nonsense@1", DUE, "the step returned 77, which is none of the standard's"),
    ("save:error@1", NEXT, "winch, t = 1.1 s: saving the state returned Error"),
    ("restore:discard@1", DUE, "winch, t = 1 s: restoring the state returned Discard"),
]
LIES: list[tuple[str, float | None, str]] = [
    ("step:nan@1", DUE, r"winch\.y, t = 1.1 s: y became nan; its last finite value was 0\.54"),
    ("step:inf@1", DUE, r"winch\.y, t = 1.1 s: y became inf; its last finite value was 0\.54"),
    ("get:nan@1", DUE, r"winch\.y, t = 1.1 s: y became nan"),
]
HARMLESS: list[tuple[str, str]] = [
    ("step:flood@1", "40,000 lines on stdout that look like answers"),
    ("step:torrent@1", "200 MB on stdout without an end of line"),
    ("step:babble@1", "400,000 log messages that are no UTF-8, with format codes"),
    ("step:silent log@1", "a log message that is NULL"),
    ("frozen", "OK without stepping (not visible from outside)"),
    ("deaf", "inputs are ignored (not visible from outside)"),
]
MEDDLING: list[tuple[str, str]] = [
    ("step:chdir@1", r"winch changed the working directory, to /: set back"),
    ("instantiate:chdir", r"winch changed the working directory, to /: set back"),
    ("step:umask@1", r"winch changed the mask of new files, to 000: set back"),
    ("enter:mask", r"winch changed the mask of signals: set back"),
    ("step:rounding@1", r"winch changed the floating-point mode: set back"),
    ("set:rounding@0", r"winch changed the floating-point mode: set back"),
]
OFFSPRING: list[tuple[str, str]] = [
    ("step:fork@1", "children that never end"),
    ("step:daemon@1", "a daemon in a session of its own"),
    ("step:twin@1", "a copy of the process that goes on with the run"),
]
LOST: list[tuple[str, str]] = [
    ("step:descriptors@1", "all descriptors used up"),
    ("step:short files@1", "files limited to nothing"),
]
ACTING = "a\x1b[2Jb\u202e/../c"
EXTRAPOLATE = "scheme = 'extrapolate'\nevents = false\n"
CASES = [
    *(Case("death", m, misbehaving(m), 3, says, end) for m, end, says in DEATHS),
    Case("death", "step:glutton@1", misbehaving("step:glutton@1"), 3, "winch, t = 1 s: crashed", DUE, little_memory),
    *(Case("failure", m, misbehaving(m), 3, says, end) for m, end, says in FAILURES),
    Case("failure", "step:discard@1, no way back", misbehaving("step:discard@1", rollback=False), 3,
         "refused the step of 0.1 s .*winch, Discard.* not all units can go back", DUE),
    Case("failure", "rollback wanted of a unit that has none", misbehaving("none", "scheme = 'hermite'\n", rollback=False),
         2, "hermite needs units that save and restore their state, winch cannot: use 'extrapolate'"),
    *(Case("lie", m, misbehaving(m), 3, says, end) for m, end, says in LIES),
    Case("lie", "forgetful, under hermite", misbehaving("forgetful", "scheme = 'hermite'\n"), 3,
         r"winch\.y, t = 0 s: does not restore its state, though .*Take scheme 'extrapolate'", 0.0),
    Case("lie", "forgetful, under auto, which begins again", misbehaving("forgetful"), 0, "extrapolate", STOP),
    Case("lie", "forgetful, under extrapolate", misbehaving("forgetful", EXTRAPOLATE), 0, "", STOP),
    *(Case("lost", f"{m}: {what}", misbehaving(m), 0, "", STOP) for m, what in LOST),
    Case("lost", "the name of a case of 300 letters of three bytes", named("瀬" * 300), 0, "", STOP),
    Case("lost", "the name of a case that would act on a terminal", named(ACTING), 0, r"a\\x1b\[2Jb\\u202e", STOP),
    Case("endless", "1e12 steps", stepped(STOP / 1e12), 2, r"1e\+12 steps of . numbers take .* MB"),
    Case("endless", "1e18 steps", stepped(STOP / 1e18), 2, "below the last digit of a time of 2 s"),
    Case("endless", "1e12 records", stepped(STEP, f"\n[record]\ninterval = {STOP / 1e12}\n"), 2, r"1e\+12 steps of . numbers"),
    *(Case("meddling", m, misbehaving(m), 0, says, STOP) for m, says in MEDDLING),
    *(Case("offspring", f"{m}: {what}", misbehaving(m), 0, "", STOP, nothing_stays) for m, what in OFFSPRING),
    *(Case("harmless", f"{m}: {what}", misbehaving(m), 0, "", STOP) for m, what in HARMLESS),
]  # fmt: skip
