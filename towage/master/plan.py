"""How a scene is coupled: its scheme, step and error control, and what the checks say of them before the run."""

from __future__ import annotations

import math
from time import process_time
from typing import Literal, NamedTuple

from towage import reading
from towage.checks.check import Start, checks_of
from towage.checks.step import largest_step, loops
from towage.master.auto import choose
from towage.master.schemes import Scheme
from towage.master.simulation import MERGE, Settings
from towage.master.system import System
from towage.registry import SCHEMES
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Scene
from towage.units.doubt import Doubts, said
from towage.units.fmu import UnitFactory
from towage.units.store import cache
from towage.units.vetted import stays

FEWEST_STEPS = 50
"""The error control takes at least as many steps."""
DEFAULT_POINTS = 2000
"""Record times of a run with error control and no ``record.interval``."""


class Plan(NamedTuple):
    """How to couple, and what was found on the way; ``start`` is what checks before the run are given."""

    settings: Settings
    start: Start
    findings: list[Finding]


def started(
    resolved: ResolvedScene,
    make_unit: UnitFactory,
    main: ResolvedScene | None = None,
    doubts: Doubts | None = None,
) -> System:
    """The units of a scene, initialised, coupled as ``main`` (default: the same). Branches are frozen over a step where
    the master looks after events. ``doubts``: what units were found not to do. Raises `RunError` and `FmuError`;
    the caller closes the system."""
    scene = (main or resolved).scene
    held = scene.coupling.scheme != "auto" and SCHEMES.get(scene.coupling.scheme).holds
    freeze = scene.coupling.events and not held and not on_grid(resolved)
    stuck = {unit: why for (unit, what), why in (doubts or {}).items() if what == "state"}
    distrusted = _vetted(resolved) | stuck
    begin = process_time()
    system = System(resolved, cache() / "unpacked", freeze, held, make_unit, distrusted)
    system.doubts = dict(doubts or {})
    try:
        system.start(0.0, scene.stop_time, scene.coupling.tolerance)
        system.start_cpu = process_time() - begin
    except BaseException:
        system.close()
        raise
    return system


def plan(resolved: ResolvedScene, system: System) -> Plan:
    """Scheme, step and findings of an initialised scene. Raises `SceneError` where the units do not carry the scheme."""
    scene = resolved.scene
    coupling, stop = scene.coupling, scene.stop_time
    grid = on_grid(resolved)
    step, tolerance = coupling.step, coupling.tolerance
    if grid and step is None:
        step, tolerance = own_step(resolved, grid), None
    interface_loops = loops(system)
    findings = _of_grid(grid, step, scene) if grid and step else []
    if coupling.scheme == "auto":
        scheme, why = choose(system, interface_loops, step or 0.0)
        level: Literal["info", "warning"] = "warning" if system.distrusted else "info"
        findings.append(Finding("scheme", level, None, None, f"auto: {scheme.name}, because {why}"))
        fallbacks: Doubts = {(unit, "state"): why for unit, why in system.distrusted.items()} | system.doubts
        findings += [Finding("fallback", "warning", None, None, said(unit, why, what)) for (unit, what), why in fallbacks.items()]
    else:
        scheme = SCHEMES.get(coupling.scheme)
    if refusal := _refusal(scheme, step, system, coupling.scheme == "auto"):
        key, message = refusal
        raise scene.error(message, f"coupling.{key}")
    max_step = step or min(stop / FEWEST_STEPS, largest_step(interface_loops, scheme))
    start = Start(resolved, system, scheme, max_step)
    for check in checks_of(scene):
        if check.refuses:
            findings += check.before(start)
    interval = scene.record.interval or step or stop / DEFAULT_POINTS
    if endless := _endless(min(step or interval, interval), stop, system):
        raise scene.error(endless, "coupling.step" if step and step <= interval else "record.interval")
    settings = Settings(scheme, step, tolerance, max_step, coupling.events, interval, stop, grid)
    return Plan(settings, start, findings)


def _endless(step: float, stop: float, system: System) -> str:
    """Why a run cannot come to its end, or "": its steps, or the times of its record, are lost in the digits of the time, or
    what is recorded in the memory."""
    if stop + step == stop:
        return f"a step of {step:g} s is below the last digit of a time of {stop:g} s: the run would not move on"
    width = 1 + sum(len(unit.outputs) for unit in system.units)
    wanted, there = 8.0 * width * stop / step, reading.memory()
    if wanted <= there:
        return ""
    return (
        f"{stop / step:.3g} steps of {width} numbers take {wanted / 2**20:.3g} MB, and a run here may use "
        f"{there / 2**20:.3g} MB: take a longer step or interval, or an earlier stop_time"
    )


def _vetted(resolved: ResolvedScene) -> dict[str, str]:
    """The units of other makes that `towage vet` found not to restore their state, and why."""
    others = ((name, unit) for name, unit in resolved.units.items() if not unit.description.conventions)
    return {name: why for name, unit in others if (why := stays(unit.path))}


def on_grid(resolved: ResolvedScene) -> tuple[str, ...]:
    """The units of other makes that take communication steps of one size only."""
    return tuple(
        name for name, unit in resolved.units.items()
        if not (unit.description.can_handle_variable_step or unit.description.conventions)
    )  # fmt: skip


def own_step(resolved: ResolvedScene, grid: tuple[str, ...]) -> float:
    """The step that the units of ``grid`` have by their default experiment, s. Raises `SceneError` where there is none, or more
    than one."""
    steps = {resolved.units[name].description.default_experiment.step_size for name in grid} - {None}
    if len(steps) != 1 or not (size := steps.pop()) or size > resolved.scene.stop_time:
        raise resolved.scene.error(
            f"{', '.join(grid)} takes communication steps of one size only, so that there is no error control, and names none "
            "for all of them: give a step instead, coupling.step",
            "coupling.tolerance",
        )
    return size


def _of_grid(grid: tuple[str, ...], step: float, scene: Scene) -> list[Finding]:
    """What it means for the run that units take steps of one size only."""
    count = max(1, math.floor(scene.stop_time / step + MERGE))
    message = (
        f"{', '.join(grid)} takes communication steps of one size only (canHandleVariableCommunicationStepSize is false): all "
        f"points lie on the grid of {step:g} s, and events happen at the next of them"
    )
    if scene.coupling.step is None:
        message += "; there is no error control, the step is that of the unit's default experiment"
    level: Literal["info", "warning"] = "info"
    if abs(count * step - scene.stop_time) > MERGE * step:
        level, message = "warning", f"{message}; the run ends at {count * step:.9g} s, not at {scene.stop_time:g} s"
    return [Finding("grid", level, step, None, message)]


def _refusal(scheme: Scheme, step: float | None, system: System, auto: bool) -> tuple[str, str] | None:
    """(key, message) where the units cannot do what the scheme or the error control needs; what ``auto`` took does without those
    that do not go back."""
    if scheme.goes_back and not system.can_roll_back and not (auto and system.repeated):
        stuck = ", ".join(unit.name for unit in system.units if not unit.can_roll_back)
        needs = f"{scheme.name} needs units that save and restore their state"
        return "scheme", f"{needs}, {stuck} cannot: use 'extrapolate'"
    if step is None and not system.can_roll_back:
        return "tolerance", "error control needs units that save and restore their state: give a step instead"
    if step is None and scheme.holds:
        return "tolerance", f"{scheme.name} has no error estimate to control the step by: give a step instead"
    return None


def refuse(findings: list[Finding], resolved: ResolvedScene) -> None:
    """Raise `SceneError` for a run that would be worth nothing."""
    for finding in findings:
        if finding.level == "refused":
            raise resolved.scene.error(finding.message, "coupling.step")
