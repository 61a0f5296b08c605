"""Sweeps: one scene run for many values, supervised, journaled, and resumed to the same bits.

    from towage.sweep import Sweep
    from towage.sweep_design import grid

    sweep = Sweep(scene, grid(scene, ["ship.heave_amplitude=2 ft:6 ft:9"]))
    table = sweep.run(Path("out/sweep"))
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from towage import __version__
from towage.scene.flavour import Flavour, resolve
from towage.scene.scene import Scene
from towage.sweeps.design import Design
from towage.sweeps.journal import Journal
from towage.sweeps.table import Table
from towage.sweeps.workers import Setup, Task, digests, run_here
from towage.units.store import locator

JOURNAL = "journal.jsonl"
Hear = Callable[[int, int, int], None]
"""Told (runs ended now, runs to do now, runs of the whole sweep that were not done)."""


@dataclass(frozen=True)
class Sweep:
    """A scene, without cases, over a design. ``timeout``: longest run without progress, s."""

    scene: Scene
    design: Design
    fmus: Path | None = None
    flavour: Flavour = "auto"
    timeout: float = 60.0

    def identity(self) -> dict[str, Any]:
        """All that the rows depend on: what must agree for a sweep to be continued."""
        scene = msgspec.to_builtins(msgspec.structs.replace(self.scene, file=None, source="", cases=()))
        files = digests(self.scene, self.fmus, self.pinned())
        versions = {
            "towage": __version__,
            "numpy": np.__version__,
            "python": platform.python_version(),
            "machine": f"{sys.platform} {platform.machine()}",
        }
        points = {"text": self.design.text, "points": self.design.digest()}
        return {"scene": scene, "design": points, "flavour": self.pinned(), "fmus": files, "versions": versions}

    def pinned(self) -> Flavour:
        """``auto`` decided once, not by every run from what the cache happens to hold then: native if all units that can
        be native are found so."""
        from towage.fmus.declare.unit import load

        if self.flavour != "auto":
            return self.flavour
        found = resolve(self.scene, self.fmus, "auto").units
        shipped = {name: entry.fmu for name, entry in self.scene.units.items() if not entry.fmu.endswith(".fmu")}
        able = [name for name, fmu in shipped.items() if not load(fmu).not_native]
        return "native" if able and all(found[name].flavour == "native" for name in able) else "python"

    def run(
        self,
        out: Path,
        resume: bool = False,
        workers: int | None = None,
        dask: str | None = None,
        hear: Hear | None = None,
    ) -> Table:
        """The table, from runs by ``workers`` processes (default: one a processor) or on the cluster at ``dask``.

        ``out`` keeps the journal. Raises `SceneError`, `FmuError`, `JournalError`, and `TowageError` where the journal
        cannot be written or the cluster is lost; what was finished until then, or until Ctrl-C, is in the journal.
        """
        identity = self.identity()
        bare = msgspec.structs.replace(self.scene, source="", cases=())
        setup = Setup(bare, self.fmus, identity["flavour"], self.timeout, identity["fmus"])
        with Journal(out / JOURNAL, identity, resume) as journal:
            count = len(self.design.points)
            tasks = [Task(k, self.design.values(k)) for k in range(count) if k not in journal.rows]
            failed = sum(row.status != "done" for row in journal.rows.values())
            if dask and tasks:
                from towage.sweeps.dask import run_on_dask

                rows = run_on_dask(setup, tasks, dask)
            else:
                rows = run_here(setup, tasks, workers or os.cpu_count() or 1)
            with closing(rows):  # type: ignore[type-var]
                for row in rows:
                    if row:
                        journal.append(row)
                        failed += row.status != "done"
                    journal.sync()
                    if hear:
                        hear(len(journal.rows) - count + len(tasks), len(tasks), failed)
            return Table.of(self.scene.title, self.design, journal.rows, self.measures())

    def measures(self) -> dict[str, str]:
        """The recorded variables and their units of measure."""
        resolved = self.scene.resolve(locator(self.fmus))
        known = {name: unit.description.by_name() for name, unit in resolved.units.items()}
        return {f"{u}.{v}": known[u][v].unit or "" for u, v in resolved.record}
