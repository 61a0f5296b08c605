"""Error of motion and tension of a scene against step and scheme, with cost: `precision`.

Error: rms of the difference to the reference over the standard deviation, from the settling time of the checks on, as in the
card's item on numerics. Reference: the monolithic solution where there is one (a ship, a line and a cradle), else the scene's
own scheme at an eighth of its step (a thousandth of its tolerance), which is compared with the run before it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from towage.checks.signals import difference
from towage.checks.track import comparison_times
from towage.errors import SceneError, TowageError
from towage.ladder.measure import asked, bare, track
from towage.master.master import run_resolved
from towage.registry import SCHEMES
from towage.report.format import number, percent
from towage.result.result import Result
from towage.scene.flavour import resolve
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator
from towage.verify.monolithic import solve

Array = NDArray[np.float64]
FACTORS = (4.0, 2.0, 1.0, 0.5)
"""Steps over that of the scene; tolerances over its own are 100, 10, 1, 0.1."""
FINEST = (0.25, 0.125)
"""Those of the reference, the last one, and of the run that it is compared with."""
MOST_STEPS = 1600
"""Of the scene's own length: longer scenes are cut after so many."""
WRONG, FLOORS = 0.5, 3.0
"""An error above the one is of no step that a power tells of; one below so many times what the reference is known to neither."""
EXACT = 1e-9
"""How far the monolithic solution is known, with a wide margin."""
BUDGET = 30.0
"""Processor time of a case, s, beyond which no run is begun."""


@dataclass(frozen=True)
class Row:
    """One scheme and one signal: ``errors``, ``costs`` (s) and ``notes`` why there is none, one a step."""

    scheme: str
    signal: str
    errors: tuple[float | None, ...]
    costs: tuple[float | None, ...]
    notes: tuple[str, ...]

    def order(self, floor: float, ratio: float) -> float | None:
        """The power of the step, or of the tolerance, whose neighbours have this ``ratio``, that the error goes with: from the
        first to the last that tell, above ``floor``, how far the reference is known, and below `WRONG`."""
        known = [(k, e) for k, e in enumerate(self.errors) if e and FLOORS * floor < e < WRONG]
        if len(known) < 2:
            return None
        (a, first), (b, last) = known[0], known[-1]
        return math.log(first / last) / math.log(ratio) / (b - a)


@dataclass(frozen=True)
class Precision:
    """``heads``: the steps in words; ``fixed``: they are steps, and no tolerances; ``reference`` in words, ``floor`` how far it
    is known, ``own`` what tells of chaos: how far the scene as it is, or the run before the reference, is off; ``unit``: cost of
    the scene as it is, s; ``settle``, ``stop``: from when to when, s; ``left_out``: how many runs the budget did not allow."""

    heads: tuple[str, ...]
    fixed: bool
    rows: tuple[Row, ...]
    reference: str
    own: float
    floor: float
    unit: float
    settle: float
    stop: float
    left_out: int


class Reference(NamedTuple):
    """Values of the signals at the times of comparison, what they are; ``own`` and ``floor`` as of a `Precision`."""

    values: Mapping[str, Array]
    said: str
    own: float
    floor: float


def precision(scene: Scene) -> Precision:
    """Of a scene without cases. Raises `TowageError` where the scene itself does not run."""
    cut = shortened(bare(scene))
    given = run(cut, 1.0, cut.coupling.scheme)
    question = asked(described(scene, locator(None)), given, None)
    step = cut.coupling.step
    times = comparison_times(cut.stop_time, step and FACTORS[0] * step, MOST_STEPS)
    times = times[times >= min(question.settle, 0.5 * cut.stop_time)]
    begin = time.process_time()
    reference = _reference(cut, given, question.signals, times)
    runs: dict[tuple[str, float], Result | str] = {(given.scheme, 1.0): given}
    left_out = 0
    schemes = [given.scheme, *(name for name in SCHEMES.own if name != given.scheme)]
    for scheme in schemes:
        for factor in FACTORS:
            if (scheme, factor) not in runs:
                spent = time.process_time() - begin > BUDGET
                runs[scheme, factor] = "left out" if spent else _tried(cut, factor, scheme)
                left_out += spent
    rows = [_row(scheme, name, runs, reference, times) for scheme in schemes for name in question.signals]
    kind, own = ("step", step) if step else ("tolerance", cut.coupling.tolerance)
    heads = [number(_scaled(own or 0.0, factor, kind == "step")) + (" s" if step else "") for factor in FACTORS]
    return Precision(
        tuple(f"{kind} {head}" for head in heads), step is not None, tuple(rows), reference.said, reference.own, reference.floor,
        given.statistics["cpu_s"],
        float(times[0]), cut.stop_time, left_out,
    )  # fmt: skip


def shortened(scene: Scene) -> Scene:
    """The scene of at most `MOST_STEPS` of its own steps."""
    step = scene.coupling.step
    return replace(scene, stop_time=min(scene.stop_time, MOST_STEPS * step)) if step else scene


def _scaled(own: float, factor: float, step: bool) -> float:
    """A step, s, or a tolerance, ten times as fine for half the factor."""
    return own * factor if step else own * 10.0 ** math.log2(factor)


def run(scene: Scene, factor: float, scheme: str) -> Result:
    """With another step, or tolerance, and scheme. Raises `TowageError` where it is refused or fails."""
    coupling = scene.coupling
    size = _scaled(coupling.step or coupling.tolerance or 0.0, factor, coupling.step is not None)
    changed = replace(coupling, scheme=scheme, **{"step" if coupling.step else "tolerance": size})
    result = run_resolved(resolve(replace(scene, coupling=changed), flavour="python"))
    if result.status == "failed":
        raise TowageError(result.message)
    return result


def _tried(scene: Scene, factor: float, scheme: str) -> Result | str:
    """The run, or in a word why there is none."""
    try:
        return run(scene, factor, scheme)
    except SceneError:
        return "refused"
    except TowageError:
        return "fails"


def _reference(scene: Scene, given: Result, signals: tuple[str, ...], times: Array) -> Reference:
    """The monolithic solution where there is one, else the finest run."""
    try:
        heave, tension = solve(resolve(scene, flavour="python"), times)
        values = {name: heave if name.endswith(".heave") else tension for name in signals}
        if all(name.endswith((".heave", ".tension")) for name in signals):
            off = max(difference(values[name], track(given).at(name, times)).rms for name in signals)
            said = f"the monolithic solution to 1e-12; the scene as it is differs by {percent(off, 2)}"
            return Reference(values, said, off, EXACT)
    except SceneError:
        pass
    before, finest = (run(scene, factor, given.scheme) for factor in FINEST)
    one, two = track(before), track(finest)
    own = max(difference(two.at(name, times), one.at(name, times)).rms for name in signals)
    fixed = scene.coupling.step
    what = f"{given.scheme} at {'an eighth of the step' if fixed else 'a thousandth of the tolerance'}"
    order = SCHEMES.get(given.scheme).order
    known = own / (2.0**order - 1.0) if fixed else own
    said = f"{what}; the run before it differs by {percent(own, 2)}"
    said += f", which leaves {percent(known, 2)} (Richardson, order {order})" if fixed else ""
    return Reference({name: two.at(name, times) for name in signals}, said, known, known)


def _row(
    scheme: str, signal: str, runs: Mapping[tuple[str, float], Result | str], reference: Reference, times: Array
) -> Row:
    """Errors and costs of a scheme."""
    errors: list[float | None] = []
    costs: list[float | None] = []
    notes = []
    for factor in FACTORS:
        result = runs[scheme, factor]
        if isinstance(result, str):
            errors.append(None)
            costs.append(None)
            notes.append(result)
            continue
        errors.append(difference(reference.values[signal], track(result).at(signal, times)).rms)
        costs.append(result.statistics["cpu_s"])
        notes.append("")
    return Row(scheme, signal, tuple(errors), tuple(costs), tuple(notes))
