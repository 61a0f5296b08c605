"""An operability study: a scene in all seas of a scatter diagram, from all headings, some seeds each; journaled, and resumed.

    from towage.operability.study import Study

    study = Study.of("cage_300m", ["line.margin_taut > 0", "line.tension < 450 kN"], seeds=20)
    result = study.run("out/study")
    result.outcome.whole.holds
"""

from __future__ import annotations

import os
import time as clock
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from towage.errors import SceneError
from towage.operability import early
from towage.operability import scatter as diagrams
from towage.operability.cells import Cells, cells, headings
from towage.operability.extremes import FEWEST
from towage.operability.outcome import Outcome, outcome
from towage.operability.screening import Screening, screened
from towage.process import stop
from towage.scene.flavour import Flavour
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import one_case
from towage.sweeps.criteria import Criterion, criterion
from towage.sweeps.design import Design
from towage.sweeps.journal import Journal
from towage.sweeps.row import Row
from towage.sweeps.sweep import JOURNAL, Sweep
from towage.sweeps.table import Table
from towage.units.store import locator

if TYPE_CHECKING:
    from towage.ensemble.ensemble import Ensemble

Engine = Literal["auto", "ensemble", "runs"]
Hear = Callable[[float, float, int], None]
"""Told (hours simulated now, hours to do now, runs of the whole study that were not done)."""
BY_RUNS = "by supervised runs of the master"
SPARED = "the cell fails for certain"
SEEDS, LENGTH, TRANSIENT, PROBABILITY, HEADINGS = 20, 10800.0, 200.0, 0.9, ("12",)


@dataclass(frozen=True)
class Done:
    """A study that came to its end. ``hours``: simulated now, transients included, in ``elapsed`` s; ``notes``: how."""

    outcome: Outcome
    table: Table
    screening: Screening
    hours: float
    elapsed: float
    notes: tuple[str, ...]

    @property
    def lost(self) -> int:
        """Runs that were not done and not spared."""
        return sum(status not in ("done", "spared") for status in self.table.status)

    @property
    def rate(self) -> float:
        """Simulated hours a second of this call; NaN where nothing was left to do."""
        return self.hours / self.elapsed if self.hours else float("nan")


@dataclass(frozen=True)
class Study:
    """A scene without cases and what is asked of it. ``length`` of a record and ``transient`` before it, s. ``probability`` with
    which an extreme is not passed. ``engine``: "ensemble" or "runs". ``early``: runs are spared in
    cells that fail for certain (`towage.operability.early`). ``notes``: what was decided. ``ensemble``: its
    runs, in their order."""

    sweep: Sweep
    cells: Cells
    criteria: tuple[Criterion, ...]
    transient: float
    probability: float
    engine: Engine
    step: float
    early: bool
    notes: tuple[str, ...]
    ensemble: Ensemble | None = None

    @classmethod
    def of(
        cls,
        scene: Scene | str | Path,
        criteria: Sequence[str],
        *,
        case: str | None = None,
        scatter: str = "north_atlantic",
        directions: Sequence[str] = HEADINGS,
        seeds: int = SEEDS,
        first: int = 1,
        length: float = LENGTH,
        transient: float = TRANSIENT,
        probability: float = PROBABILITY,
        engine: Engine = "auto",
        decide_early: bool = False,
        fmus: Path | None = None,
        flavour: Flavour = "auto",
        timeout: float = 60.0,
    ) -> Study:
        """The study of a scene. ``criteria`` as in `towage.sweeps.criteria`, at least one; ``scatter``: a file or the name of a
        shipped diagram; ``directions`` as in `cells.headings`; ``decide_early`` as in `early`. Raises `SceneError` and
        `FileError`."""
        if not criteria:
            raise SceneError("no criterion: give at least one, as 'line.margin_taut > 0'", key="--criterion")
        if seeds < FEWEST:
            raise SceneError(
                f"{seeds} seeds: expected at least {FEWEST}, by which a distribution is fitted", key="--seeds"
            )
        if not 0.5 <= probability < 1.0:
            raise SceneError(f"{probability:g}: expected a probability from 0.5 to below 1", key="--quantile")
        one = one_case(scene, case)
        changed = one.setting({"stop_time": transient + length}, "--length")
        diagram, chosen = diagrams.load(scatter), headings(directions)
        resolved = described(changed, locator(fmus))
        plan = cells(resolved, diagram, chosen, seeds, first, length)
        sweep = Sweep(changed, plan.design(), fmus, flavour, timeout, since=transient)
        recorded = sweep.measures()
        wanted = tuple(criterion(text, recorded, "--criterion") for text in criteria)
        noted = (diagram_note(plan),)
        made = cls(sweep, plan, wanted, transient, probability, engine, 0.0, decide_early, noted)
        made = made if engine == "runs" else made._compiled()
        if decide_early and made.engine == "runs":
            raise SceneError("only an ensemble decides early: leave this out", key="--decide-early")
        return made

    def _compiled(self) -> Study:
        """By an ensemble, if the scene composes; headings are mirrored where that changes nothing."""
        from towage.operability.ensembles import ensemble_of, interval, mirrored

        try:
            ensemble = ensemble_of(self.scene, self.cells, self.names)
        except (SceneError, ImportError) as error:
            if self.engine == "ensemble":
                raise
            note = f"the scene is not computed as an ensemble: {error}"
            return replace(self, engine="runs", notes=(*self.notes, note))
        plan, notes = self.cells, [*self.notes]
        resolved = described(self.scene, locator(self.sweep.fmus))
        paired = cells(resolved, plan.scatter, plan.headings, plan.seeds, plan.first, plan.length, mirror=True)
        if paired.run != plan.run and mirrored(ensemble, plan):
            count = sum(run != k for k, run in enumerate(paired.run))
            notes.append(
                f"{count} headings take the runs of their mirrors: in all periods the motions there were found to be the same"
            )
            own = [k for k, run in enumerate(paired.run) if run == k]
            kept = np.repeat(np.isin(plan.places[:, 0], own), plan.seeds)
            plan, ensemble = paired, ensemble.part(np.flatnonzero(kept))
        sweep = replace(self.sweep, design=plan.design())
        return replace(
            self, sweep=sweep, cells=plan, engine="ensemble", step=interval(self.scene, plan), notes=tuple(notes),
            ensemble=ensemble,
        )  # fmt: skip

    @property
    def scene(self) -> Scene:
        """The scene, with the length of the study's runs."""
        return self.sweep.scene

    @property
    def names(self) -> list[str]:
        """Variables that criteria look at."""
        return list(dict.fromkeys(one.name for one in self.criteria))

    @property
    def design(self) -> Design:
        """The runs."""
        return self.sweep.design

    def identity(self) -> dict[str, Any]:
        """All that the rows depend on."""
        from towage.operability import ensembles

        known: dict[str, Any] = {"engine": self.engine, "length": self.cells.length, "transient": self.transient}
        if self.engine == "ensemble":
            known |= {"step": self.step, "accuracy": ensembles.ACCURACY, "observed": self.names}
        return {**self.sweep.identity(), "study": known}

    def run(self, out: str | Path, resume: bool = False, workers: int | None = None, hear: Hear | None = None) -> Done:
        """The study, by ``workers`` threads or processes (default: one a processor); its journal in ``out``, from which
        ``resume`` goes on. Raises what `Sweep.run` and `Ensemble` raise."""
        place, threads = Path(out), workers or os.cpu_count() or 1
        place.mkdir(parents=True, exist_ok=True)
        begun = clock.monotonic()
        each = (self.cells.length + self.transient) / 3600.0
        if self.engine == "runs":
            counted = [0]

            def heard(ended: int, total: int, failed: int) -> None:
                """Runs as hours."""
                counted[0] = ended
                if hear:
                    hear(ended * each, total * each, failed)

            table = self.sweep.run(place, resume, threads, None, heard)
            hours, said = counted[0] * each, BY_RUNS
        else:
            table, hours, said = self._by_ensemble(place, resume, threads, each, hear)
        elapsed = clock.monotonic() - begun
        found = outcome(self.cells, table, self.criteria, self.probability, self.scene.checks.report_only)
        linear = screened(described(self.scene, locator(self.sweep.fmus)), self.cells, self.criteria, self.probability)
        return Done(found, table, linear, hours, elapsed, (*self.notes, said))

    def _by_ensemble(
        self, out: Path, resume: bool, workers: int, each: float, hear: Hear | None
    ) -> tuple[Table, float, str]:
        """(table, hours simulated, how it was made)."""
        from towage.operability import ensembles

        count = len(self.design.points)
        ensemble = self.ensemble
        assert ensemble
        times = ensembles.times_of(self.cells.length, self.transient, self.step)
        with Journal(out / JOURNAL, self.identity(), resume, count) as journal:
            known = len(journal.rows)
            differs = ensembles.checked(ensemble, self.step)

            def do(wanted: Sequence[int], total: int) -> None:
                """Do what is missing of some runs, of which ``total`` are expected in the end."""
                todo = [k for k in wanted if k not in journal.rows]
                with closing(ensembles.rows(ensemble, todo, times, workers)) as batches:  # type: ignore[type-var]
                    for batch in batches:
                        stop.look()
                        for row in batch or ():
                            journal.append(row)
                        journal.sync()
                        if hear:
                            lost = sum(row.status != "done" for row in journal.rows.values())
                            hear(each * (len(journal.rows) - known), each * (total - known), lost)

            spared: set[int] = set()
            if self.early:
                do(early.first(self.cells), count)
                spared = early.settled(self.cells, journal.rows, self.criteria, self.probability) - set(journal.rows)
            do([k for k in range(count) if k not in spared], count - len(spared))
            rows = {**journal.rows, **{k: Row(k, "spared", message=SPARED) for k in spared}}
            table = Table.of(self.scene.title, self.design, rows, self.sweep.measures())
            hours = each * (len(journal.rows) - known)
        note = (
            f"computed as one ensemble in compiled code, extremes of outputs every {self.step:g} s; {ensembles.SAMPLE} runs, "
            f"drawn at random, were computed again by the FMU path over {ensembles.SAMPLED:g} s and differ by at most "
            f"{differs:.1e} of a variable's largest value. Comparisons with a second run (checks sdof and wire, "
            "coupling errors) are not made in an ensemble: run a cell near the limit by `towage run`"
        )
        return table, hours, f"{note}. {self._spared(len(spared))}" if spared else note

    def _spared(self, count: int) -> str:
        wrong = (1.0 - self.probability) ** FEWEST
        return (
            f"{count} of {len(self.design.points)} runs were spared (--decide-early): a cell fails whose first {FEWEST} runs all "
            f"pass a limit, as one that holds would with a chance of at most {wrong:.0e}"
        )


def diagram_note(plan: Cells) -> str:
    """The diagram and the spectrum in words."""
    scatter = plan.scatter
    return f"scatter diagram {scatter.source}, {len(scatter.heights)} heights by {len(scatter.periods)} periods; {plan.note}"
