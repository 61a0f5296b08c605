"""How far a model is from the fullest: amplitude, peak and rms of motions and tensions, on the solver's own points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from msgspec import structs

from towage.checks.error import judged_names
from towage.checks.signals import Difference, at_rest, difference, dominant_frequency, repeats_after
from towage.checks.track import Track, comparison_times
from towage.ladder.axis import Array
from towage.result.result import Result
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Record, Scene

DEFAULT_TOLERANCE = 0.05
"""Where no check of the scene sets one."""


class Asked(NamedTuple):
    """What rungs are compared by: ``signals``, "unit.variable" of the scene as given, from ``settle``, s, on; ``driver``: whose
    period a subharmonic may be shifted by, "" if none is known; ``tolerance``, relative; ``times``, s, equally spaced."""

    signals: tuple[str, ...]
    driver: str
    settle: float
    tolerance: float
    times: Array


def asked(resolved: ResolvedScene, given: Result, tolerance: float | None) -> Asked:
    """Motion and tension of the checks of the scene; without such checks every recorded length, angle and force of what
    something is connected to. Raises `SceneError` where there is none. ``given``: the run of the scene, with all outputs."""
    scene = resolved.scene
    sdof, simpler = scene.checks.get("sdof"), scene.checks.get("simpler")
    named = [*((sdof.motion, sdof.tension) if sdof else ()), *(simpler.motions if simpler else ())]
    if not named:
        driven = {connection.partition(" -> ")[2].partition(".")[0] for connection in scene.connections}
        named = [
            name for name in judged_names(resolved, given.columns)
            if given.units[name] in ("m", "rad", "N") and (name.partition(".")[0] in driven or not driven)
        ]  # fmt: skip
    if not named:
        raise scene.error(
            "no motion and no tension to compare models by: name them in [checks.sdof] or [checks.simpler]", "checks"
        )
    found = [section for section in (sdof, simpler) if section]
    settle = max((section.settle for section in found), default=0.0)
    limit = tolerance or min((section.tolerance for section in found), default=DEFAULT_TOLERANCE)
    times = comparison_times(float(given.time[-1]), scene.coupling.step, len(given.time))
    return Asked(tuple(dict.fromkeys(named)), sdof.driver if sdof else "", settle, limit, times[times >= settle])


def bare(scene: Scene) -> Scene:
    """The scene as a rung is run: one run, no comparisons, every output at every communication point."""
    scene = scene.without_comparisons()
    coupling = structs.replace(scene.coupling, error_estimate=False)
    return structs.replace(scene, coupling=coupling, record=Record())


def coarse(scene: Scene) -> Scene:
    """The scene with doubled step, or tenfold tolerance."""
    coupling = scene.coupling
    if coupling.step is None:
        assert coupling.tolerance is not None
        return structs.replace(scene, coupling=structs.replace(coupling, tolerance=10.0 * coupling.tolerance))
    return structs.replace(scene, coupling=structs.replace(coupling, step=2.0 * coupling.step))


def of_both(asked: Asked, step: float | None) -> Asked:
    """At the points that a run with ``step``, s, shares with one of the doubled step, so that neither is interpolated."""
    if step is None:
        return asked
    count = asked.times / (2.0 * step)
    return asked._replace(times=asked.times[np.abs(count - np.round(count)) < 1e-6])


def track(result: Result) -> Track:
    """The solver's own points of the run of a `bare` scene."""
    return Track(result.time, result.columns)


def moves(asked: Asked, full: Track) -> bool:
    """Whether anything compared moves."""
    return not all(at_rest(full.at(name, asked.times)) for name in asked.signals)


def differences(
    asked: Asked, full: Track, names: Mapping[str, str], other: Track, called: Mapping[str, str]
) -> dict[str, Difference]:
    """Of every signal; ``names`` and ``called``: what it is called in either track. A subharmonic motion shifted by whole
    periods of the driver is the same motion: the shift with the least difference counts."""
    period, periods = _period(asked, full, names)
    found = []
    for shift in range(periods):
        times = asked.times[asked.times <= asked.times[-1] - shift * period]
        pairs = {name: (full.at(names[name], times), other.at(called[name], times + shift * period)) for name in asked.signals}
        found.append({name: difference(*pair) for name, pair in pairs.items()})
    return min(found, key=worst)


def worst(errors: Mapping[str, Difference]) -> float:
    """The largest of all errors."""
    return max(error.worst for error in errors.values())


def _period(asked: Asked, full: Track, names: Mapping[str, str]) -> tuple[float, int]:
    """(period of the driver, s; after how many of them the first signal repeats, 1 where it does not or none is known)."""
    if asked.driver not in full.columns:
        return 0.0, 1
    omega = dominant_frequency(asked.times, full.at(asked.driver, asked.times))
    signal = full.at(names[asked.signals[0]], asked.times)
    return (2.0 * math.pi / omega if omega else 0.0), max(1, repeats_after(asked.times, signal, omega, asked.tolerance))

