"""`run` and `run_all`: from a scene to its results in one call."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from towage.master.master import run_resolved
from towage.master.stages import Report
from towage.result.result import Result
from towage.scene.flavour import Flavour, resolve
from towage.scene.scene import Scene
from towage.scene.select import one_case

NOTHING: Mapping[str, Any] = MappingProxyType({})


def run(
    scene: Scene | str | Path,
    case: str | None = None,
    *,
    set: Mapping[str, Any] = NOTHING,
    fmus: str | Path | None = None,
    flavour: Flavour = "auto",
    timeout: float | None = None,
    isolate: bool = False,
    report: Report | None = None,
) -> Result:
    """Run a scene and judge it:  ``towage.run("sea_cliff", "8 s wave", set={"ship.heave_amplitude": "4 ft"})``

    ``scene``: a `Scene`, the path of a scene file, or the name of a shipped one. ``case``: may be left out where the scene
    has one or none. ``set``: values as in a case, in place of the scene's and its cases': "unit.parameter" or a key as
    "coupling.step"; a number in the variable's own unit (SI for the shipped units) or a text with a unit. ``fmus``: a
    directory with the FMUs of the shipped units; by default they are built into the cache when needed. ``flavour``: "auto"
    takes native FMUs where they are present, "native" builds them, "python" does without. ``isolate``: in a process of its
    own, so that a unit that crashes ends its run and nothing else; ``timeout``: the same, and a run without progress for so
    long (s) is ended. ``report`` hears (share done, what is going on).

    A run that fails on its way comes back as a `Result` with status "failed" and what was recorded until then. Raises
    `SceneError` for a scene that is refused, or has several cases and none is chosen (`run_all` does them all), `FmuError`
    for an FMU that is refused or cannot be built, and `RunError` where a unit fails before the first step.
    """
    return _run(one_case(scene, case, set), fmus, flavour, timeout, isolate, report)


def run_all(
    scene: Scene | str | Path,
    *,
    set: Mapping[str, Any] = NOTHING,
    fmus: str | Path | None = None,
    flavour: Flavour = "auto",
    timeout: float | None = None,
    isolate: bool = False,
    report: Report | None = None,
) -> list[Result]:
    """Run every case of a scene, in their order; the scene itself if it has none. Arguments and errors as those of `run`."""
    loaded = scene if isinstance(scene, Scene) else Scene.load(scene)
    loaded = loaded.with_values(set) if set else loaded
    scenes = [loaded.case(case.name) for case in loaded.cases] or [loaded]
    return [_run(each, fmus, flavour, timeout, isolate, report) for each in scenes]


def _run(
    scene: Scene, fmus: str | Path | None, flavour: Flavour, timeout: float | None, isolate: bool, report: Report | None
) -> Result:
    resolved = resolve(scene, None if fmus is None else Path(fmus), flavour)
    alone = any(unit.description.once_per_process for unit in resolved.units.values())  # one a process
    if not isolate and not alone and timeout is None:
        return run_resolved(resolved, report)
    from towage.process.worker import run_isolated

    return run_isolated(resolved, report, math.inf if timeout is None else timeout)
