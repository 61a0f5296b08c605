"""Runs a resolved scene and has its checks judge it: before, the coupled run, the other runs they ask for, the verdict."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from towage.checks.check import Check, Finished, checks_of
from towage.checks.track import Track, comparison_times
from towage.checks.verdict import verdict
from towage.errors import RunError
from towage.master.checkpoint import Keeper, reopened, thaw
from towage.master.outcome import begun, fail, keep, meddled
from towage.master.plan import plan, refuse, started
from towage.master.recorder import Recorder
from towage.master.simulation import Run, Settings, Simulation, simulate
from towage.master.stages import Report, Stages
from towage.master.system import System
from towage.result.journal import Journal
from towage.result.records import Finding, Item
from towage.result.result import Result
from towage.scene.flavour import Flavour, resolve
from towage.scene.resolve import ResolvedScene, ResolvedVariant
from towage.scene.scene import Scene
from towage.scene.select import one_case
from towage.units.fmu import Unit, UnitFactory

Array = NDArray[np.float64]
Columns = dict[str, Array]
MAIN = "coupled run"
COARSE = 2.0
"""A coarse run has a step so much longer, and takes so much less time; its error is 2^p as large."""
NUDGE = 1e-9
"""Relative change of a value that shows whether a motion is chaotic."""
COARSE_TOLERANCE = 10.0
"""A coarse run under error control has a tolerance so much larger."""


class Master:
    """A scene, one case of it, ready to run.

    ``case`` may be left out where there is only one, or none. ``fmus``: where the shipped units' FMUs are, else the cache.
    Raises `SceneError` and `FmuError` if the scene does not fit its units.
    """

    def __init__(
        self,
        scene: Scene,
        case: str | None = None,
        fmus: Path | None = None,
        flavour: Flavour = "auto",
        make_unit: UnitFactory = Unit,
    ) -> None:
        self._make_unit = make_unit
        self.resolved = resolve(one_case(scene, case), fmus, flavour)
        self.scene = self.resolved.scene

    def run(self, report: Report | None = None, journal: Path | None = None) -> Result:
        """`run_resolved` of the scene."""
        return run_resolved(self.resolved, report, journal, self._make_unit)

    def check(self) -> list[Finding]:
        """`check_resolved` of the scene."""
        return check_resolved(self.resolved, self._make_unit)


def run_resolved(
    resolved: ResolvedScene,
    report: Report | None = None,
    journal: Path | None = None,
    make_unit: UnitFactory = Unit,
    resume: bool = False,
) -> Result:
    """Run, compare, judge. ``report`` hears (share done, what is going on); ``journal`` keeps rows on disk, and checkpoints
    beside it, from which ``resume`` goes on if there is one; ``make_unit`` makes the units.

    Raises `SceneError` for a scene that the checks before the run refuse. A run that fails on its way comes back as a
    result with status "failed" and what was recorded until then.
    """
    system = started(resolved, make_unit)
    try:
        planned = plan(resolved, system)
        refuse(planned.findings, resolved)
        settings = planned.settings
        stages = Stages(report, {MAIN: 1.0} | {variant.name: _weight(variant) for variant in resolved.variants})
        result = begun(resolved, settings.scheme.name, planned.findings)
        columns, track = _coupled_run(resolved, system, settings, result, stages, journal, resume)
        if result.status == "done":
            order = settings.scheme.order if settings.step else 0
            others = OtherRuns(resolved, settings, stages, make_unit)
            times = comparison_times(settings.stop_time, settings.step, len(track.time))
            _judge(Finished(resolved, system, order, result, columns, others.columns, settings.step, times, track, others.track))
            stages.done()
        return result
    finally:
        system.close()


def check_resolved(resolved: ResolvedScene, make_unit: UnitFactory = Unit) -> list[Finding]:
    """What the checks say before a run, without running. Raises `SceneError` and `RunError`."""
    system = started(resolved, make_unit)
    try:
        planned = plan(resolved, system)
        findings = planned.findings
        for check in checks_of(resolved.scene):
            if not check.refuses:
                findings += check.before(planned.start)
        return findings
    finally:
        system.close()


class OtherRun(NamedTuple):
    """What the scene records of another run, (time, columns), and all its communication points."""

    record: tuple[Array, Columns]
    track: Track


class OtherRuns:
    """The other runs that checks ask for. Each is made when it is first asked for, and once, whoever asks."""

    def __init__(
        self, resolved: ResolvedScene, settings: Settings, stages: Stages, make_unit: UnitFactory
    ) -> None:
        self._resolved = resolved
        self._settings = settings
        self._stages = stages
        self._make_unit = make_unit
        self._variants = {variant.name: variant for variant in resolved.variants}
        self._known: list[tuple[ResolvedScene, bool, OtherRun | RunError]] = []

    def columns(self, name: str) -> tuple[Array, Columns]:
        """(time, columns) of what the run called ``name`` records. Raises `RunError` where it fails."""
        return self._made(name).record

    def track(self, name: str) -> Track:
        """All communication points of the run called ``name``. Raises `RunError` where it fails."""
        return self._made(name).track

    def _made(self, name: str) -> OtherRun:
        variant = self._variants[name]
        scene = nudged(variant.scene or self._resolved, variant.nudged)
        outcome = next((o for s, coarse, o in self._known if s == scene and coarse == variant.coarse), None)
        if outcome is None:
            outcome = self._run(name, scene, _coarse(self._settings) if variant.coarse else self._settings)
            self._known.append((scene, variant.coarse, outcome))
        if isinstance(outcome, RunError):
            raise outcome
        return outcome

    def _run(self, name: str, scene: ResolvedScene, settings: Settings) -> OtherRun | RunError:
        try:
            system = started(scene, self._make_unit, self._resolved)
            try:
                recorder = _recorder(system, settings)
                simulate(system, settings, recorder, self._stages.progress(name, settings.stop_time))
            finally:
                system.close()
        except RunError as error:
            return error
        track = recorder.track()
        return OtherRun(recorder.columns(track), track)


def _weight(variant: ResolvedVariant) -> float:
    """Expected time of another run over that of the coupled one; a nudged one is made in few scenes only."""
    return 0.0 if variant.nudged else 1.0 / COARSE if variant.coarse else 1.0


def nudged(resolved: ResolvedScene, unit: str) -> ResolvedScene:
    """The scene with the first value set on ``unit`` (or else on any other unit) that is a number other than zero changed
    by `NUDGE`; the scene itself without a name. Raises `RunError` where there is no such value."""
    if not unit:
        return resolved
    for name in sorted(resolved.units, key=lambda name: name != unit):
        entry = resolved.units[name]
        for parameter, value in entry.parameters.items():
            if isinstance(value, float) and value and math.isfinite(value):
                changed = structs.replace(entry, parameters={**entry.parameters, parameter: value * (1.0 + NUDGE)})
                return structs.replace(resolved, units={**resolved.units, name: changed})
    raise RunError("no unit of the scene has a value that could be changed by 1e-9")


def _coarse(settings: Settings) -> Settings:
    step, tolerance = settings.step, settings.tolerance
    return replace(
        settings,
        step=step and COARSE * step,
        tolerance=tolerance and COARSE_TOLERANCE * tolerance,
        max_step=COARSE * settings.max_step,
    )


def _coupled_run(
    resolved: ResolvedScene, system: System, settings: Settings, result: Result, stages: Stages, journal: Path | None,
    resume: bool,
) -> tuple[Columns, Track]:
    """Every observed output of the coupled run, as recorded and at all communication points; those that are recorded,
    events and counts go to the result, which is a failed one where the run fails."""
    keep(result, resolved, {})
    keeper = Keeper(journal) if journal else None
    found = keeper.found() if keeper and resume else None
    recorder = _recorder(system, settings)
    begin_at: Callable[[Simulation], None] | None = None
    if journal and found:
        recorder.journal, kept = reopened(journal, recorder.names, found)
        begin_at = functools.partial(thaw, data=found, kept=kept)
    elif journal and keeper:
        keeper.path.unlink(missing_ok=True)  # one that is left is of the journal that ends here
        about = result.metadata()
        recorder.journal = Journal(journal, recorder.names, about, recorder.interval, recorder.held)
    try:
        report = stages.progress(MAIN, settings.stop_time)
        run = simulate(system, settings, recorder, report, begin_at, keeper.look if keeper else None)
    except RunError as error:
        fail(result, str(error))
        run = getattr(error, "run", Run())
    finally:
        recorder.close()
    result.checks += meddled(system)
    track = recorder.track()
    result.time, columns = recorder.columns(track)
    keep(result, resolved, columns)
    result.events = run.events
    result.step_sizes = np.array(run.steps)
    result.power_residual = {b.name: b.residual / b.throughput if b.throughput else 0.0 for b in run.bonds}
    result.statistics = {
        "steps": float(len(run.steps)),
        "rejected": float(run.rejected),
        "events_located": float(run.located),
        "wall_s": run.wall,
        "cpu_s": run.cpu,
        "start_cpu_s": system.start_cpu,
        "real_time_factor": run.time / run.wall if run.wall else math.nan,
    }
    return columns, track


def _judge(run: Finished) -> None:
    """Have the checks look at the run, and put their words together. A check that breaks costs its own word, never the
    finished run."""
    checks, broken = checks_of(run.scene.scene), {}
    for check in checks:
        try:
            run.result.checks += check.after(run)
        except Exception as error:
            broken[check.name] = _broken(run.result, check, error)
    said = []
    for check in checks:
        try:
            item = broken.get(check.name) or check.item(run.result)
        except Exception as error:
            item = _broken(run.result, check, error)
        said.append(item and replace(item, name=item.name or check.name))
    run.result.verdict = verdict(said)


def _broken(result: Result, check: Check, error: Exception) -> Item:
    """What a check says that broke."""
    reason = f"could not be judged: {type(error).__name__}: {error}"
    result.checks.append(Finding(check.name, "warning", None, None, reason))
    return Item("not judged", f"{check.name} {reason}", None, None)


def _recorder(system: System, settings: Settings) -> Recorder:
    outputs = [(f"{unit.name}.{name}", unit.variables.get(name)) for unit in system.units for name in unit.outputs]
    held = [column for column, variable in outputs if variable and variable.variability == "discrete"]
    return Recorder([column for column, _ in outputs], None, settings.record_interval, held)
