"""Sweeps: one scene run for many values, supervised, journaled, and resumed to the same bits.

    from towage.sweeps.sweep import sweep

    table = sweep("slack", "ship.heave_amplitude=2 ft:6 ft:9", out="out/sweep")
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Literal

import msgspec

from towage.errors import SceneError
from towage.files import scratch
from towage.process import stop
from towage.process.child import NO_LIMITS
from towage.process.overseer import Limits
from towage.registry import UNITS
from towage.scene.flavour import Flavour, resolve
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import one_case
from towage.sweeps.design import Design, design
from towage.sweeps.journal import Journal
from towage.sweeps.table import Table
from towage.sweeps.workers import Setup, Task, digests, run_here
from towage.units.sources import brought, code_digest
from towage.units.store import locator

JOURNAL = "journal.jsonl"
SAMPLE = 3
"""Members of an ensemble that are computed again by default: each costs what a run does."""
Hear = Callable[[int, int, int], None]
"""Told (runs ended now, runs to do now, runs of the whole sweep that were not done)."""


@dataclass(frozen=True)
class Sweep:
    """A scene without cases (`Scene.case` drops them) over a design.

    ``fmus``: directory of the shipped units' FMUs (None: built when needed). ``flavour``: which of them. ``timeout``:
    longest time that a run may make no progress, s. ``limits``: of every run. ``since``: s, before which no extremes are
    taken."""

    scene: Scene
    design: Design
    fmus: Path | None = None
    flavour: Flavour = "auto"
    timeout: float = 60.0
    limits: Limits = NO_LIMITS
    since: float = 0.0

    def __post_init__(self) -> None:
        if self.scene.cases:
            names = ", ".join(repr(case.name) for case in self.scene.cases)
            raise self.scene.error(f"a sweep is over one case: choose one of {names}", "cases")
        object.__setattr__(self, "scene", msgspec.structs.replace(self.scene, source=""))  # which no row depends on

    def identity(self) -> dict[str, Any]:
        """All that the rows depend on: what must agree for a sweep to be continued."""
        scene = msgspec.to_builtins(msgspec.structs.replace(self.scene, file=None))
        files = digests(self.scene, self.fmus, self.pinned())
        versions = {
            "code": code_digest("towage.sweeps.workers")[:16],
            **{name: metadata.version(name) for name in ("towage", "fmpy", "numpy", "scipy", *brought())},
            "python": platform.python_version(),
            "machine": f"{sys.platform} {platform.machine()}",
        }
        points = {"text": self.design.text, "points": self.design.digest(), "since": self.since}
        return {"scene": scene, "design": points, "flavour": self.pinned(), "fmus": files, "versions": versions}

    def pinned(self) -> Flavour:
        """``auto`` decided once, not by every run from what the cache happens to hold then: native if all units that can
        be native are found so."""
        if self.flavour != "auto":
            return self.flavour
        units = resolve(self.scene, self.fmus, "auto").units
        shipped = {name: entry.fmu for name, entry in self.scene.units.items() if not entry.fmu.endswith(".fmu")}
        able = [name for name, fmu in shipped.items() if fmu in UNITS.own and not UNITS.get(fmu).not_native]
        return "native" if able and all(units[name].flavour == "native" for name in able) else "python"

    def run(
        self,
        out: Path | None = None,
        resume: bool = False,
        workers: int | None = None,
        dask: str | None = None,
        hear: Hear | None = None,
    ) -> Table:
        """The table, from runs by ``workers`` processes (default: one a processor) or on the cluster at ``dask``.

        ``out``: the directory of the journal, from which ``resume`` goes on; None keeps no journal. Raises `SceneError`,
        `FmuError`, `JournalError`, and `TowageError` where the journal cannot be written or the cluster is lost; what was
        finished until then, or until Ctrl-C, is in the journal.
        """
        identity = self.identity()
        setup = Setup(
            self.scene, self.fmus, identity["flavour"], self.timeout, identity["fmus"], self.limits, self.since
        )
        with ExitStack() as stack:
            kept = out or stack.enter_context(scratch())
            count = len(self.design.points)
            journal = stack.enter_context(Journal(kept / JOURNAL, identity, resume, count))
            tasks = [Task(k, self.design.values(k)) for k in range(count) if k not in journal.rows]
            if dask and tasks:
                from towage.sweeps.dask import run_on_dask

                rows = run_on_dask(setup, tasks, dask)
            else:
                rows = run_here(setup, tasks, workers or os.cpu_count() or 1)
            failed = sum(row.status != "done" for row in journal.rows.values())
            with closing(rows):  # type: ignore[type-var]
                for row in rows:
                    stop.look()
                    if row:
                        journal.append(row)
                        failed += row.status != "done"
                    journal.sync()
                    if hear:
                        hear(len(journal.rows) - count + len(tasks), len(tasks), failed)
            return Table.of(self.scene.title, self.design, journal.rows, self.measures())

    def run_ensemble(self, sample: int = SAMPLE, seed: int = 0, threads: int | None = None) -> Table:
        """The table, from all points as one ensemble in ``threads`` threads (default: one a processor): see `by_ensemble`
        for what it leaves out, ``sample``, ``seed`` and errors."""
        from towage.sweeps.ensemble import by_ensemble  # loads what traces and compiles

        return by_ensemble(self.scene, self.design, self.measures(), sample, seed, threads)

    def measures(self) -> dict[str, str]:
        """The recorded variables, "unit.variable", and their units of measure."""
        resolved = described(self.scene, locator(self.fmus))
        known = {name: unit.description.by_name() for name, unit in resolved.units.items()}
        return {f"{u}.{v}": known[u][v].unit or "" for u, v in resolved.record}


def sweep(
    scene: Scene | str | Path,
    vary: str | Sequence[str],
    *,
    case: str | None = None,
    set: Mapping[str, Any] | None = None,
    samples: int | None = None,
    seed: int = 0,
    engine: Literal["runs", "ensemble"] = "runs",
    sample: int | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    fmus: str | Path | None = None,
    flavour: Flavour = "auto",
    timeout: float = 60.0,
    hear: Hear | None = None,
) -> Table:
    """Run a scene for many values: what ``towage sweep`` does, as a `Table`.

        table = towage.sweep("slack", "ship.heave_amplitude=2 ft:6 ft:9")
        table.measures["max:line.tension"]

    ``scene``: a scene, the path of its file, or the name of a shipped one; ``case`` and ``set`` as in `towage.run`.
    ``vary``: ranges "unit.parameter=FROM:TO:COUNT", of which all combinations are run; with ``samples`` ranges
    "unit.parameter=FROM:TO", of whose box so many points of a Sobol sequence, scrambled with ``seed``, are run.
    ``engine``: runs of the master in supervised processes, or all points as one ensemble in compiled code, of which
    ``sample`` points (default 3) are computed again. ``workers``: processes or threads (default: one a processor);
    ``dask``: address of a scheduler. ``out``: directory of a journal (journal.jsonl), from which ``resume`` goes on;
    without it nothing is written. ``timeout``: longest time that a run may make no progress, s. ``hear``: told of
    progress.

    A run that fails, crashes or hangs has its reason in the table. Raises `SceneError` for a scene, range or option that
    does not fit, `FmuError` where an FMU cannot be had, `TowageError` where the journal cannot be written or continued.
    """
    refuse_options(
        engine,
        {"sample": sample, "out": out, "resume": resume, "dask": dask, "fmus": fmus, "flavour": flavour != "auto"},
    )
    place = Path(fmus) if fmus else None
    one = one_case(scene, case, set)
    made = Sweep(one, design(one, [vary] if isinstance(vary, str) else vary, samples, seed, place), place, flavour, timeout)
    if engine == "ensemble":
        return made.run_ensemble(sample or SAMPLE, seed, workers)
    return made.run(Path(out) if out else None, resume, workers, dask, hear)


def refuse_options(engine: str, given: Mapping[str, object]) -> None:
    """Raises `SceneError` for the first of the options ``given`` that has a value and that ``engine`` would ignore."""
    by_runs = engine == "runs"
    for option, value in given.items():
        if not value or option.endswith("sample") != by_runs:
            continue
        if by_runs:
            raise SceneError("only an ensemble has a sample: choose the engine ensemble", key=option)
        raise SceneError("an ensemble runs here, at once, and without FMUs: leave this out, or choose the engine runs",
                         key=option)  # fmt: skip
