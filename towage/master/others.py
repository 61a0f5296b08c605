"""The other runs of a scene that checks ask for."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from towage.checks.track import Track
from towage.errors import RunError
from towage.master.plan import started
from towage.master.recorder import recorder_of
from towage.master.simulation import Settings, simulate
from towage.master.stages import Stages
from towage.master.system import SAME_STEP
from towage.scene.resolve import ResolvedScene, ResolvedVariant
from towage.units.doubt import Doubts
from towage.units.fmu import UnitFactory

Array = NDArray[np.float64]
Columns = dict[str, Array]
COARSE = 2.0
"""A coarse run has a step so much longer, and takes so much less time; its error is 2^p as large."""
NUDGE = 1e-9
"""Relative change of a value that shows whether a motion is chaotic."""
COARSE_TOLERANCE = 10.0
"""A coarse run under error control has a tolerance so much larger."""


class OtherRun(NamedTuple):
    """What the scene records of another run, (time, columns), and all its communication points."""

    record: tuple[Array, Columns]
    track: Track


class OtherRuns:
    """The other runs that checks ask for. Each is made when it is first asked for, and once, whoever asks."""

    def __init__(
        self,
        resolved: ResolvedScene,
        settings: Settings,
        stages: Stages,
        make_unit: UnitFactory,
        doubts: Doubts,
    ) -> None:
        self._resolved = resolved
        self._settings = settings
        self._stages = stages
        self._make_unit = make_unit
        self._doubts = doubts
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
            system = started(scene, self._make_unit, self._resolved, self._doubts)
            try:
                recorder = recorder_of(system, settings)
                run = simulate(system, settings, recorder, self._stages.progress(name, settings.stop_time))
            finally:
                system.close()
            if run.time < settings.stop_time * (1.0 - SAME_STEP) and run.ended_by:
                raise RunError(f"ended before the coupled run: {run.ended_by}", time=run.time)
        except RunError as error:
            return error
        track = recorder.track()
        return OtherRun(recorder.columns(track, settings.records_end), track)


def weight(variant: ResolvedVariant) -> float:
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
