"""Runs a resolved scene and has its checks judge it: before, the coupled run, the other runs they ask for, the verdict."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from towage.checks.check import Check, Finished, checks_of
from towage.checks.track import Track, comparison_times
from towage.checks.verdict import verdict
from towage.errors import RunError
from towage.master.checkpoint import Keeper, reopened, thaw
from towage.master.others import OtherRuns, weight
from towage.master.outcome import begun, fail, keep, meddled
from towage.master.plan import plan, refuse, started
from towage.master.recorder import recorder_of
from towage.master.said import after, listen, messages
from towage.master.simulation import Run, Settings, Simulation, simulate
from towage.master.stages import Report, Stages
from towage.master.system import System
from towage.result.journal import Journal, Kept
from towage.result.records import Finding, Item
from towage.result.result import Result
from towage.scene.flavour import Flavour, resolve
from towage.scene.resolve import ResolvedScene, check_instances
from towage.scene.scene import Scene
from towage.scene.select import one_case
from towage.units.doubt import Doubt, Doubts, without
from towage.units.fmu import Unit, UnitFactory

Array = NDArray[np.float64]
Columns = dict[str, Array]
MAIN = "coupled run"


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
    if make_unit is Unit:
        check_instances(resolved)
    doubts: Doubts = {}
    while True:
        try:
            return _run_once(_without(resolved, doubts), report, journal, make_unit, doubts, resume and not doubts)
        except Doubt as doubt:  # begin again, without what that unit does not do
            doubts[doubt.unit, doubt.what] = doubt.why


def _run_once(
    resolved: ResolvedScene,
    report: Report | None,
    journal: Path | None,
    make_unit: UnitFactory,
    doubts: Doubts,
    resume: bool,
) -> Result:
    """As `run_resolved`, with these ``doubts`` heeded. Raises `Doubt` where ``auto`` may choose again."""
    system = started(resolved, make_unit, None, doubts)
    try:
        planned = plan(resolved, system)
        refuse(planned.findings, resolved)
        settings = planned.settings
        stages = Stages(report, {MAIN: 1.0} | {variant.name: weight(variant) for variant in resolved.variants})
        result = begun(resolved, settings.scheme.name, planned.findings)
        columns, track, settings = _coupled_run(resolved, system, settings, result, stages, journal, resume)
        if result.status == "done":
            known = 1 if system.foreign else settings.scheme.order  # nobody knows the order of what others solve inside
            order = known if settings.step else 0
            others = OtherRuns(resolved, settings, stages, make_unit, doubts)
            times = comparison_times(settings.stop_time, settings.step, len(track.time))
            _judge(Finished(resolved, system, order, result, columns, others.columns, settings.step, times, track, others.track))
            stages.done()
        return result
    finally:
        system.close()


def _without(resolved: ResolvedScene, doubts: Doubts) -> ResolvedScene:
    """The scene, and the other runs that its checks ask for, with units of which nothing is asked that they do not do."""

    if not doubts:
        return resolved
    units = {
        name: structs.replace(entry, description=without(entry.description, [what for unit, what in doubts if unit == name]))
        for name, entry in resolved.units.items()
    }
    variants = tuple(structs.replace(v, scene=v.scene and _without(v.scene, doubts)) for v in resolved.variants)
    return structs.replace(resolved, units=units, variants=variants)


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


def _coupled_run(
    resolved: ResolvedScene, system: System, settings: Settings, result: Result, stages: Stages, journal: Path | None,
    resume: bool,
) -> tuple[Columns, Track, Settings]:
    """Every observed output of the coupled run, as recorded and at all communication points, and the settings with the time
    that the run reached; what is recorded, events, counts and what the units said go to the result, which is a failed one where
    the run fails. Raises `Doubt` where ``auto`` may choose again."""
    keep(result, resolved, {})
    keeper = Keeper(journal) if journal else None
    found = keeper.found() if keeper and resume else None
    recorder = recorder_of(system, settings)
    begin_at: Callable[[Simulation], None] | None = None
    kept: Kept | None = None
    if journal and found:
        recorder.journal, kept = reopened(journal, recorder.names, found)
        begin_at = functools.partial(thaw, data=found, kept=kept)
    elif journal and keeper:
        keeper.path.unlink(missing_ok=True)  # one that is left is of the journal that ends here
        about = result.metadata()
        recorder.journal = Journal(journal, recorder.names, about, recorder.interval, recorder.held)
    listen(system, recorder.message, kept.messages if kept else None)
    try:
        report = stages.progress(MAIN, settings.stop_time)
        run = simulate(system, settings, recorder, report, begin_at, keeper.look if keeper else None)
    except Doubt as fault:
        if resolved.scene.coupling.scheme == "auto" and (settings.tolerance is None or fault.what != "state"):
            raise
        fail(result, str(fault))
        run = getattr(fault, "run", Run())
    except RunError as error:
        fail(result, str(error))
        run = getattr(error, "run", Run())
    finally:
        recorder.close()
    result.checks += meddled(system)
    track = recorder.track()
    reached = replace(settings, stop_time=run.time, ended=True) if run.ended_by else settings
    result.time, columns = recorder.columns(track, reached.records_end)
    keep(result, resolved, columns)
    result.texts = recorder.text_columns(result.time)
    result.events = run.events
    result.messages = messages(system)
    result.checks += after(system, settings, run)
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
    return columns, track, reached


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
