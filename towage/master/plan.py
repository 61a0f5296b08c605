"""How a scene is coupled: its scheme, step and error control, and what the checks say of them before the run."""

from __future__ import annotations

import contextlib
import math
import os
from time import process_time
from typing import NamedTuple

from towage.checks.check import Start, checks_of
from towage.checks.step import largest_step, loops
from towage.master.auto import choose
from towage.master.schemes import Scheme
from towage.master.simulation import Settings
from towage.master.system import System
from towage.registry import SCHEMES
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene
from towage.units.fmu import UnitFactory
from towage.units.store import cache

FEWEST_STEPS = 50
"""The error control takes at least as many steps."""
DEFAULT_POINTS = 2000
"""Record times of a run with error control and no ``record.interval``."""


class Plan(NamedTuple):
    """How to couple, and what was found on the way; ``start`` is what checks before the run are given."""

    settings: Settings
    start: Start
    findings: list[Finding]


def started(resolved: ResolvedScene, make_unit: UnitFactory, main: ResolvedScene | None = None) -> System:
    """The units of a scene, initialised, coupled as ``main`` (default: the same). Branches are frozen over a step where
    the master looks after events. Raises `RunError` and `FmuError`; the caller closes the system."""
    scene = (main or resolved).scene
    held = scene.coupling.scheme != "auto" and SCHEMES.get(scene.coupling.scheme).holds
    begin = process_time()
    system = System(resolved, cache() / "unpacked", scene.coupling.events and not held, held, make_unit)
    try:
        system.start(0.0, scene.stop_time)
        system.start_cpu = process_time() - begin
    except BaseException:
        system.close()
        raise
    return system


def plan(resolved: ResolvedScene, system: System) -> Plan:
    """Scheme, step and findings of an initialised scene. Raises `SceneError` where the units do not carry the scheme."""
    scene = resolved.scene
    coupling, stop = scene.coupling, scene.stop_time
    step = coupling.step
    interface_loops = loops(system)
    findings = []
    if coupling.scheme == "auto":
        scheme, why = choose(system, interface_loops, step or 0.0)
        findings.append(Finding("scheme", "info", None, None, f"auto: {scheme.name}, because {why}"))
    else:
        scheme = SCHEMES.get(coupling.scheme)
    if refusal := _refusal(scheme, step, system):
        key, message = refusal
        raise scene.error(message, f"coupling.{key}")
    max_step = step or min(stop / FEWEST_STEPS, largest_step(interface_loops, scheme))
    start = Start(resolved, system, scheme, max_step)
    for check in checks_of(scene):
        if check.refuses:
            findings += check.before(start)
    interval = scene.record.interval or step or stop / DEFAULT_POINTS
    if endless := _endless(step or interval, stop, system):
        raise scene.error(endless, "coupling.step" if step else "record.interval")
    settings = Settings(scheme, step, coupling.tolerance, max_step, coupling.events, interval, stop)
    return Plan(settings, start, findings)


def _endless(step: float, stop: float, system: System) -> str:
    """Why a run cannot come to its end, or "": its steps are lost in the digits of the time, or its record, which has every
    communication point, in the memory."""
    if stop + step == stop:
        return f"a step of {step:g} s is below the last digit of a time of {stop:g} s: the run would not move on"
    width = 1 + sum(len(unit.outputs) for unit in system.units)
    wanted, there = 8.0 * width * stop / step, memory()
    if wanted <= there:
        return ""
    return (
        f"{stop / step:.3g} steps of {width} numbers take {wanted / 2**20:.3g} MB, and a run here may use "
        f"{there / 2**20:.3g} MB: take a longer step, or an earlier stop_time"
    )


def memory() -> float:
    """What this process may use, bytes: all of the machine's, or its limit; infinite where that is not known."""
    most = math.inf
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        most = math.inf if limit == resource.RLIM_INFINITY else float(limit)
        most = min(most, float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    return most


def _refusal(scheme: Scheme, step: float | None, system: System) -> tuple[str, str] | None:
    """(key, message) where the units cannot do what the scheme or the error control needs."""
    if scheme.goes_back and not system.can_roll_back:
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
