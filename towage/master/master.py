"""Runs a scene and judges it: checks before, the coupled run, its error estimate, the one-way run, the verdict."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from towage.checks import sdof
from towage.checks import simpler as judge_slender
from towage.checks import step as checks
from towage.checks import verdict as judge
from towage.errors import RunError, SceneError
from towage.master.auto import choose
from towage.master.recorder import Recorder, read_events, read_journal
from towage.master.schemes import Scheme
from towage.master.simulation import Run, Settings, simulate
from towage.master.system import System
from towage.registry import SCHEMES
from towage.result.result import Check, Result, Verdict
from towage.scene.flavour import Flavour, resolve
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Scene
from towage.units.fmu import Unit, UnitFactory
from towage.units.store import cache

Array = NDArray[np.float64]
DEFAULT_POINTS = 2000
"""Record times of a run with error control and no ``record.interval``."""
Report = Callable[[float, str], None]


class Master:
    """A scene (one case of it) ready to run.

    Raises `SceneError` and `FmuError` if the scene does not fit its units. `run` raises the same for a scene that the
    checks before the run refuse; a run that fails on its way comes back as a result with status "failed" and what was
    recorded until then.
    """

    def __init__(
        self,
        scene: Scene,
        case: str | None = None,
        fmus: Path | None = None,
        flavour: Flavour = "python",
        make_unit: UnitFactory = Unit,
    ) -> None:
        self._make_unit = make_unit
        self.case = case or (scene.cases[0].name if len(scene.cases) == 1 else "")
        self.scene = msgspec.structs.replace(scene.case(case) if case else scene, cases=())
        self._resolve = partial(resolve, fmus=fmus, flavour=flavour)
        self.resolved = self._resolve(self.scene)

    def run(self, report: Report | None = None, journal: Path | None = None) -> Result:
        """Run, compare, judge. ``report`` hears (share done, what is going on); ``journal`` keeps rows on disk."""
        say = report or (lambda share, text: None)
        system = self._system(self.resolved)
        try:
            settings, before = self._settings(system)
            result = self._result(settings.scheme.name, before)
            recorder = Recorder([f"{u.name}.{o}" for u in system.units for o in u.outputs], journal)
            stop = settings.stop_time
            simpler = self.scene.checks.simpler
            extra = self.scene.coupling.error_estimate, self.scene.checks.sdof is not None
            share = 1.0 / (1.0 + 0.5 * extra[0] + extra[1] + (simpler is not None))

            def hear(begin: float, size: float, text: str) -> Callable[[float], None]:
                return lambda t: say(share * (begin + size * t / stop), text)

            try:
                run = simulate(system, settings, recorder, hear(0.0, 1.0, "coupled run"))
            except RunError as error:
                result.status, result.message = "failed", str(error)
                result.verdict = Verdict("not judged", "the run failed", None, None)
                run = getattr(error, "run", Run())
            finally:
                recorder.close()
            result.time, columns = recorder.columns()
            recorded = [f"{u}.{v}" for u, v in self.resolved.record]
            self._fill(result, system, run, columns, recorded)
            if result.status == "failed":
                return result
            if extra[0]:
                told = hear(1.0, 0.5, "error estimate")
                result.coupling_error = self._error(settings, result.time, columns, recorded, told)
            if extra[1]:
                told = hear(1.0 + 0.5 * extra[0], 1.0, "one-way run")
                self._compare(result, settings, system, columns, recorded, told)
            if simpler:
                told = hear(1.0 + 0.5 * extra[0] + extra[1], 1.0, "simpler model")
                try:
                    time, other = self._second_run(self.scene.simpler(), settings, told)
                    result.checks.append(judge_slender.compare(simpler, result.time, columns, time, other))
                except RunError as error:
                    result.checks.append(Check("simpler model", "warning", None, None, f"failed: {error}"))
            if towing := self._towing():
                result.checks += towing.after_run(self.resolved)
            result.margins = judge.margins(self.resolved, result.time, {n: columns[n] for n in recorded})
            result.verdict = judge.verdict(result.comparison, result.margins)
            say(1.0, "done")
            return result
        finally:
            system.close()

    def check(self) -> list[Check]:
        """The checks before a run, without running."""
        system = self._system(self.resolved)
        try:
            found = self._settings(system, refuse=False)[1] + sdof.before_run(system, self.scene.checks.sdof)
            return found + (towing.before_run(self.resolved) if (towing := self._towing()) else [])
        finally:
            system.close()

    def salvage(self, journal: Path | None, message: str) -> Result:
        """A failed result with what is in the journal of a run that ended with its process."""
        result = self._result(self.scene.coupling.scheme, [])
        result.status, result.message = "failed", message
        result.verdict = Verdict("not judged", "the run failed", None, None)
        if journal:
            result.time, columns = read_journal(journal)
            result.events = read_events(journal)
            names = [f"{u}.{v}" for u, v in self.resolved.record]
            self._fill_columns(result, columns, [n for n in names if n in columns])
        return result

    # ---- parts ------------------------------------------------------------------------------------------------------

    def _towing(self) -> ModuleType | None:
        """The checks of tows, whose models are heavy to import; None for a scene without a unit `tow_...`."""
        if not any(u.description.model_name.startswith("tow_") for u in self.resolved.units.values()):
            return None
        from towage.checks import towing

        return towing

    def _system(self, resolved: ResolvedScene) -> System:
        """The units, initialised. Branches are frozen over a step where the master will look after events."""
        name = self.scene.coupling.scheme
        held = name != "auto" and SCHEMES.get(name).holds
        system = System(resolved, cache() / "unpacked", self.scene.coupling.events and not held, held, self._make_unit)
        try:
            system.start(0.0, self.scene.stop_time)
        except BaseException:
            system.close()
            raise
        return system

    def _settings(self, system: System, refuse: bool = True) -> tuple[Settings, list[Check]]:
        """How to couple, and the checks that led to it."""
        coupling, stop = self.scene.coupling, self.scene.stop_time
        found = checks.loops(system)
        step = coupling.step
        scheme: Scheme
        before: list[Check] = []
        if coupling.scheme == "auto":
            scheme, why = choose(system, found, step or 0.0)
            before.append(Check("scheme", "info", None, None, f"auto: {scheme.name}, because {why}"))
        else:
            scheme = SCHEMES.get(coupling.scheme)
        if scheme.goes_back and not system.can_roll_back:
            stuck = ", ".join(u.name for u in system.units if not u.can_roll_back)
            raise SceneError(
                f"{scheme.name} needs units that save and restore their state, {stuck} cannot: use 'extrapolate'",
                file=self.scene.file, key="coupling.scheme",
            )  # fmt: skip
        if step is None and not system.can_roll_back:
            raise SceneError("error control needs units that save and restore their state: give a step instead",
                             file=self.scene.file, key="coupling.tolerance")  # fmt: skip
        if step is None and scheme.holds:
            raise SceneError(f"{scheme.name} has no error estimate to control the step by: give a step instead",
                             file=self.scene.file, key="coupling.tolerance")  # fmt: skip
        max_step = step or min(stop / 50.0, checks.largest_step(found, scheme))
        before += checks.before_run(system, found, scheme, max_step)
        refused = [c for c in before if c.level == "refused"]
        if refused and refuse:
            raise SceneError(refused[0].message, file=self.scene.file, key="coupling.step")
        interval = self.scene.record.interval or step or stop / DEFAULT_POINTS
        settings = Settings(scheme, step, coupling.tolerance, max_step, coupling.events, interval, stop)
        return settings, before

    def _result(self, scheme: str, before: list[Check]) -> Result:
        return Result(
            title=self.scene.title, case=self.case, scheme=scheme, status="done", message="",
            time=np.empty(0), columns={}, units={}, checks=before, scene_source=self.scene.source,
            flavours={name: unit.flavour for name, unit in self.resolved.units.items()},
        )  # fmt: skip

    def _fill(self, result: Result, system: System, run: Run, columns: dict[str, Array], recorded: list[str]) -> None:
        self._fill_columns(result, columns, recorded)
        result.events = run.events
        result.step_sizes = np.array(run.steps)
        result.power_residual = {b.name: b.residual / b.throughput if b.throughput else 0.0 for b in run.bonds}
        result.statistics = {
            "steps": float(len(run.steps)), "rejected": float(run.rejected), "events_located": float(run.located),
            "wall_s": run.wall, "cpu_s": run.cpu,
            "real_time_factor": run.time / run.wall if run.wall else math.nan,
        }  # fmt: skip

    def _fill_columns(self, result: Result, columns: dict[str, Array], recorded: list[str]) -> None:
        result.columns = {n: columns[n] for n in recorded}
        result.units = {
            f"{u}.{v}": self.resolved.units[u].description.by_name()[v].unit or "" for u, v in self.resolved.record
        }

    def _second_run(
        self, scene: Scene, settings: Settings, report: Callable[[float], None]
    ) -> tuple[Array, dict[str, Array]]:
        """Another run: (time, columns)."""
        system = self._system(self._resolve(scene))
        recorder = Recorder([f"{u.name}.{o}" for u in system.units for o in u.outputs])
        try:
            simulate(system, settings, recorder, report)
        finally:
            system.close()
        return recorder.columns()

    def _error(
        self,
        settings: Settings,
        time: Array,
        columns: dict[str, Array],
        recorded: list[str],
        report: Callable[[float], None],
    ) -> dict[str, float]:
        """Largest difference to a run with doubled step (tenfold tolerance) on the common times, relative to the
        variable's largest value, over 2^p - 1."""
        doubled: dict[str, Any] = {
            "step": None if settings.step is None else 2.0 * settings.step,
            "tolerance": None if settings.tolerance is None else 10.0 * settings.tolerance,
            "max_step": 2.0 * settings.max_step,
        }
        order = settings.scheme.order if settings.step else 0.0
        if settings.step:
            doubled["record_interval"] = max(settings.record_interval, 2.0 * settings.step)
        coarse = Settings(**{**vars(settings), **doubled})
        try:
            coarse_time, coarse_columns = self._second_run(self.scene, coarse, report)
        except RunError:
            return {}
        _, here, there = np.intersect1d(np.round(time, 9), np.round(coarse_time, 9), return_indices=True)
        share = 1.0 / (2.0**order - 1.0) if order else 1.0
        sources = {f"{c.source_unit}.{c.source}" for c in self.resolved.connections}
        found = {}
        for name in recorded:
            scale = float(np.max(np.abs(columns[name]), initial=0.0))
            if name in sources and scale:
                found[name] = share * float(np.max(np.abs(columns[name][here] - coarse_columns[name][there]))) / scale
        return found

    def _compare(
        self,
        result: Result,
        settings: Settings,
        system: System,
        columns: dict[str, Array],
        recorded: list[str],
        report: Callable[[float], None],
    ) -> None:
        check = self.scene.checks.sdof
        assert check is not None
        one_way_scene = self.scene.without(check.cut)
        try:
            time, one_way = self._second_run(one_way_scene, settings, report)
        except RunError as error:
            result.checks.append(Check("one-way run", "warning", None, None, f"failed: {error}"))
            return
        if len(time) < len(result.time):
            result.checks.append(Check("one-way run", "warning", None, None, "ended early"))
            return
        result.one_way = {name: one_way[name] for name in recorded if name in one_way}
        settled = time >= check.settle
        omega = judge.dominant_frequency(time[settled], one_way[check.driver][settled])
        stiffness = judge.dynamic_stiffness(system, check, omega)
        result.checks += sdof.before_run(system, check)
        result.comparison = judge.compare(check, time, columns, one_way, sdof.theory(system, check), stiffness)
        result.response = sdof.response(system, check, omega, one_way, time)


def run(
    scene: Scene | str | Path, case: str | None = None, report: Report | None = None, flavour: Flavour = "auto"
) -> Result:
    """Run a scene (its path or name), or one case of it."""
    loaded = scene if isinstance(scene, Scene) else Scene.load(scene)
    return Master(loaded, case, None, flavour).run(report)


def run_all(scene: Scene | str | Path, report: Report | None = None, flavour: Flavour = "auto") -> list[Result]:
    """Run every case of a scene."""
    loaded = scene if isinstance(scene, Scene) else Scene.load(scene)
    names: list[str | None] = [case.name for case in loaded.cases]
    return [Master(loaded, name, None, flavour).run(report) for name in names or [None]]
