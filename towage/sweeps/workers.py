"""Supervised workers of a sweep: processes that do run after run, and are replaced when one of these ends them.

A crash, an exit or a hang costs its run and the process. A run that dies in a process that has done others is done once
more in a fresh one, so that a row never depends on the runs that were done before it in the same process.
The child is this module's `main`; the parent never loads a unit.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import queue
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from towage.errors import RunError, TowageError
from towage.files import scratch
from towage.process.child import NO_LIMITS, Child, Died, Hung, Report, attend
from towage.process.mark import Mark
from towage.process.overseer import Limits
from towage.process.worker import named, watch
from towage.reading import digest
from towage.scene.scene import Scene

if TYPE_CHECKING:
    from towage.scene.flavour import Flavour
    from towage.sweeps.row import Row

READY = 60.0
"""What a process is given to load its libraries, s, beyond what `child` gives it."""
TRIES = 3
"""Processes in a row that may fail to get ready."""
LOOK = 0.5
"""Longest wait of the parent for a row, s: it keeps the journal in the meantime."""


class Setup(NamedTuple):
    """What all runs of a sweep share; ``scene`` has no cases. ``timeout``: longest run without progress, s. ``digests``:
    of the FMUs that the sweep began with. ``limits``: of every run. ``since``: s, before which no extremes are taken."""

    scene: Scene
    fmus: Path | None
    flavour: Flavour
    timeout: float
    digests: dict[str, str]
    limits: Limits = NO_LIMITS
    since: float = 0.0


def digests(scene: Scene, fmus: Path | None, flavour: Flavour) -> dict[str, str]:
    """A hash of the FMU of every unit, by the unit's name."""
    from towage.scene.flavour import resolve

    units = resolve(scene, fmus, flavour).units
    return {name: digest(unit.path)[:16] for name, unit in units.items()}


@dataclass(frozen=True)
class Task:
    """One run of a sweep: its index, and what it sets."""

    index: int
    values: dict[str, float | int]


class Stopped(Exception):
    """The sweep was ended while this run was under way."""


class Worker:
    """Does the runs of one sweep in a process that it starts when needed."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._open = contextlib.ExitStack()
        self._child: Child | None = None
        self._directory = Path()
        self._stopped = False

    def run(self, task: Task) -> Row:
        """The row of one run, whatever it did to its process. Raises `Stopped`."""
        fresh = self._child is None
        try:
            return self._ask(task)
        except Died as death:
            if fresh:
                return self._row(task, death)
            self.close()
        try:
            return self._ask(task)
        except Died as death:
            return self._row(task, death)

    def _ask(self, task: Task) -> Row:
        from towage.sweeps.row import Row

        child = self._child or self._start()
        return Row(**child.ask(pickle.dumps(task), None, self._setup.timeout))

    def _start(self) -> Child:
        """A process that stands ready. Raises `TowageError` if none gets ready in `TRIES` attempts."""
        said = ""
        for _ in range(TRIES):
            self._directory = self._open.enter_context(scratch())
            self._child = child = self._open.enter_context(Child(__name__, self._setup.limits))
            if self._stopped:
                raise Stopped
            try:
                child.ask(pickle.dumps((self._setup, self._directory)), None, READY)
                return child
            except Died as death:
                if self._stopped:
                    raise Stopped from None
                said = f"{death}; the last it printed: {child.printed.strip() or 'nothing'}"
            self.close()
        raise TowageError(f"no process for the runs of the sweep can be had, the last one {said}")

    def _row(self, task: Task, death: Died) -> Row:
        """The row of a run that ended its process, which is cleared away."""
        from towage.sweeps.row import Row

        if self._stopped:
            raise Stopped
        death.printed = self._child.printed.strip() if self._child else ""
        unit, stage, time = Mark.read(self._directory / "mark")
        said = str(RunError(f"{death} in its {stage}" if stage else str(death), unit=unit, time=time))
        note = str(named(death, self._directory))
        self.close()
        return Row(task.index, "hung" if isinstance(death, Hung) else "crashed", message=said, note=note)

    def stop(self) -> None:
        """From another thread: end the process, and the run that waits for it."""
        self._stopped = True
        if self._child:
            self._child.end()

    def close(self) -> None:
        """End the process, if any; the next run starts another."""
        self._child = None
        self._open.close()


def run_here(setup: Setup, tasks: Sequence[Task], workers: int) -> Iterator[Row | None]:
    """Rows in the order in which runs end, done by ``workers`` processes of this machine; None every
    `LOOK` seconds without one, so that the caller can do other work. Closing the iterator ends all processes."""
    left, ended = iter(tasks), 0
    lock, rows = threading.Lock(), queue.SimpleQueue[Any]()
    crew = [Worker(setup) for _ in range(min(workers, len(tasks)))]

    def serve(worker: Worker) -> None:
        """Do runs until none is left; a row, the worker at its end, or an error goes to the queue."""
        try:
            while True:
                with lock:
                    task = next(left, None)
                if task is None:
                    break
                rows.put(worker.run(task))
            rows.put(worker)
        except Stopped:
            pass
        except BaseException as error:  # raised again where the rows are read
            rows.put(error)
        finally:
            worker.close()

    threads = [threading.Thread(target=serve, args=(worker,), daemon=True) for worker in crew]
    try:
        for thread in threads:
            thread.start()
        while ended < len(crew):
            try:
                ended_run = rows.get(timeout=LOOK)
            except queue.Empty:
                yield None
                continue
            if isinstance(ended_run, BaseException):
                raise ended_run
            if isinstance(ended_run, Worker):
                ended += 1
            else:
                yield ended_run
    finally:
        for worker in crew:
            worker.stop()
        for thread in threads:
            thread.join()


def main() -> None:
    """The child process: does the runs that it is sent, until its parent ends."""
    commands, say = attend()
    requests = queue.SimpleQueue[Any]()

    def read() -> None:
        """Take requests in, and end with the parent."""
        try:
            while True:
                requests.put(pickle.load(commands))
        except EOFError:
            os._exit(0)
        except BaseException:
            os._exit(1)

    threading.Thread(target=read, daemon=True).start()
    setup, directory = requests.get()
    watch(directory)
    mark = Mark(directory / "mark")
    from towage.sweeps import row as sweep_row  # noqa: F401 - what all runs need

    def report(share: float, text: str) -> None:
        """Tell the parent of progress."""
        say({"share": share, "text": text})

    now = digests(setup.scene, setup.fmus, setup.flavour)
    if now != setup.digests:
        changed = ", ".join(name for name in now if now[name] != setup.digests.get(name))
        print(f"the FMUs of {changed} are not those that the sweep began with", file=sys.stderr, flush=True)
        os._exit(1)
    say({"ready": True})
    task = requests.get()  # of which nothing is said until its time moves on: units are loaded for the first time
    while True:
        say(vars(_serve(setup, task, mark, report)))
        task = requests.get()
        mark.note(b"", b"", math.nan)
        report(0.0, "initialisation")


def _serve(setup: Setup, task: Task, mark: Mark, report: Report) -> Row:
    """The row of a run done in this process."""
    import traceback

    from towage.master.master import Master
    from towage.sweeps.design import VARY
    from towage.sweeps.row import Row, row

    try:
        scene = setup.scene.setting(task.values, VARY)
        master = Master(scene, None, setup.fmus, setup.flavour, mark.unit)
        return row(task.index, master.run(report), master.resolved, setup.since)
    except TowageError as error:
        return Row(task.index, "failed" if isinstance(error, RunError) else "refused", message=_without_file(error))
    except MemoryError:
        return Row(task.index, "crashed", message="ran out of memory")
    except Exception as error:
        said = f"a defect of towage: {type(error).__name__}: {error}"
        return Row(task.index, "defect", message=said, note=traceback.format_exc())


def _without_file(error: TowageError) -> str:
    """Its message; the scene's file says nothing in a sweep over one scene."""
    if getattr(error, "file", None) is not None and not getattr(error, "entry", ""):
        vars(error)["file"] = None
    return str(error)
