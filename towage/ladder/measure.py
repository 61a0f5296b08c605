"""How far a model is from the fullest: amplitude, peak and rms of motions and tensions, on the solver's own points; statistics
where the motion does not repeat, as the verdict compares it (`towage.checks.statistics`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import structs

from towage.checks.error import judged_names
from towage.checks.signals import at_rest, difference, dominant_frequency, irregular, repeats_after
from towage.checks.statistics import deciding, slack_statistics, statistics, word_of
from towage.checks.track import Track, comparison_times
from towage.ladder.axis import Array, Trial
from towage.result.records import Statistic, Word
from towage.result.result import Result
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Record, Scene

DEFAULT_TOLERANCE = 0.05
"""Where no check of the scene sets one."""

Errors = Mapping[str, Statistic]
"""What was compared, "rms of cradle.heave", to the error of a model; its half width is zero but for statistics."""


class Asked(NamedTuple):
    """What rungs are compared by: ``signals``, "unit.variable" of the scene as given, from ``settle``, s, on; ``named``: by the
    scene. ``driver``: whose period a subharmonic may be shifted by, and which may be irregular, "" if none is known;
    ``tolerance``, relative; ``times``, s, equally spaced. ``statistical``: the statistics are compared and not the motions."""

    signals: tuple[str, ...]
    named: bool
    driver: str
    settle: float
    tolerance: float
    times: Array
    statistical: bool = False


def asked(resolved: ResolvedScene, given: Result, tolerance: float | None) -> Asked:
    """Motion and tension of the checks of the scene; without such checks every recorded length, angle and force of what
    something is connected to. Raises `SceneError` where there is none. ``given``: the run of the scene, with all outputs."""
    scene = resolved.scene
    sdof, simpler = scene.checks.get("sdof"), scene.checks.get("simpler")
    named = [*((sdof.motion, sdof.tension) if sdof else ()), *(simpler.motions if simpler else ())]
    signals = named
    if not named:
        driven = {connection.target_unit for connection in resolved.connections}
        signals = [
            name for name in judged_names(resolved, given.columns)
            if given.units[name] in ("m", "rad", "N") and (name.partition(".")[0] in driven or not driven)
        ]  # fmt: skip
    if not signals:
        raise scene.error(
            "no motion and no tension to compare models by: name them in [checks.sdof] or [checks.simpler]", "checks"
        )
    found = [section for section in (sdof, simpler) if section]
    settle = max((section.settle for section in found), default=0.0)
    limit = tolerance or min((section.tolerance for section in found), default=DEFAULT_TOLERANCE)
    times = comparison_times(float(given.time[-1]), scene.coupling.step, len(given.time))
    times = times[times >= settle]
    driver = sdof.driver if sdof else ""
    drive = track(given).at(driver, times) if driver else times
    statistical = bool(driver) and irregular(times, drive, dominant_frequency(times, drive), limit)
    return Asked(tuple(dict.fromkeys(signals)), bool(named), driver, settle, limit, times, statistical)


def known_to_all(question: Asked, trials: Sequence[Trial]) -> Asked:
    """Without the signals that some model does not know."""
    return question._replace(signals=tuple(name for name in question.signals if not any(lacks(t, name) for t in trials)))


def lacks(trial: Trial, name: str) -> bool:
    """Whether a model does not know an output of the scene as given."""
    unit, _, variable = trial.names[name].partition(".")
    return unit not in trial.resolved.units or variable not in trial.resolved.units[unit].description.by_name()


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


class Shown(NamedTuple):
    """The run of a model: its ``track``, and what the signals are called in it with the constants they lack."""

    track: Track
    trial: Trial

    def at(self, name: str, times: Array) -> Array:
        """A signal of the scene as given, at ``times``, s."""
        values: Array = self.track.at(self.trial.names[name], times) + self.trial.more.get(name, 0.0)
        return values


def errors(asked: Asked, full: Shown, other: Shown) -> Errors:
    """Of a model against the fullest."""
    return _of_statistics(asked, full, other) if asked.statistical else _of_motions(asked, full, other)


def _of_motions(asked: Asked, full: Shown, other: Shown) -> Errors:
    """A subharmonic motion shifted by whole periods of the driver is the same motion: the shift with the least difference
    counts."""
    omega, period = _period(asked, full)
    signal = full.at(asked.signals[0], asked.times)
    found: list[Errors] = []
    for shift in range(max(1, repeats_after(asked.times, signal, omega, asked.tolerance)) if omega else 1):
        times = asked.times[asked.times <= asked.times[-1] - shift * period]
        told = {name: difference(full.at(name, times), other.at(name, times + shift * period)) for name in asked.signals}
        found.append({f"{kind} of {n}": Statistic(v, 0.0) for n, d in told.items() for kind, v in d._asdict().items()})
    return min(found, key=worst)


def _of_statistics(asked: Asked, full: Shown, other: Shown) -> Errors:
    """Those of the verdict, with intervals that hold together; of a tension also how much and how often it is slack."""
    times = asked.times
    omega = _period(asked, full)[0] or dominant_frequency(times, full.at(asked.signals[0], times))
    if omega is None:
        return _of_motions(asked, full, other)
    pairs = {name: (other.at(name, times), full.at(name, times)) for name in asked.signals}
    tensions = [name for name in pairs if name.partition(".")[2].startswith("tension")]
    judged = 2 * (len(pairs) + len(tensions))
    told = statistics(times, omega, pairs, judged)
    for name in tensions:
        told |= {f"{kind}, {name}": one for kind, one in slack_statistics(times, omega, *pairs[name], judged).items()}
    return {name.replace(" of the ", " of ", 1): one for name, one in told.items()}


def _period(asked: Asked, full: Shown) -> tuple[float, float]:
    """(dominant frequency of the driver, rad/s, its period, s), zeros where none is known."""
    if asked.driver not in full.track.columns:
        return 0.0, 0.0
    omega = dominant_frequency(asked.times, full.track.at(asked.driver, asked.times))
    return (omega, 2.0 * math.pi / omega) if omega else (0.0, 0.0)


def worst(errors: Errors) -> float:
    """The largest of all errors, with its interval."""
    return max(abs(error.error) + error.half_width for error in errors.values())


def word(errors: Errors, tolerance: float) -> Word:
    """Valid where all are within the tolerance, invalid where one is beyond, not judged where an interval reaches over it."""
    return word_of(deciding(errors, tolerance)[1], tolerance)
