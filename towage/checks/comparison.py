"""The numbers of the SDOF check: coupled run against one-way run, and the theory from what the units report of themselves.

Ship: ``port_mass``, ``natural_frequency``, ``damping_ratio``, ``heave_amplitude``. Line: ``port_stiffness``. Body:
``port_mass`` or ``virtual_mass``, ``drag_factor``. A scene with other units simply has no estimate.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.checks.check import System
from towage.checks.sdof_section import Sdof
from towage.checks.signals import (
    component,
    dominant_frequency,
    irregular,
    peak,
    relative_change,
    repeats_after,
    share_of_nothing,
)
from towage.checks.statistics import deciding, slack_statistics, statistics, word_of
from towage.checks.track import Track
from towage.models.heave import linear, sdof
from towage.models.numeric.ops import FLOATS
from towage.models.numeric.oscillator import exact_oscillation
from towage.result.records import Comparison, Statistic, Word

Array = NDArray[np.float64]
Columns = Mapping[str, Array]
RATIOS = (0.2, 3.0, 281)
"""Frequency ratios of the response curve: from, to, how many."""
BEYOND = 1e6
"""Response that only a cradle without drag has, at its resonance: infinite but for rounding, and not drawn."""
AT_REST = 1e-13
"""Dynamic tension, as a share of the mean one, that is rounding."""
DRIFTED = 1e-5
"""Difference of twins that began 1e-9 apart, over the standard deviation: chaos. Above what a resonance of damping ratio 1e-4
makes of it."""


class Theory(NamedTuple):
    """``estimate`` eps*, and the thesis's own indicators: ``eigenvector``, the relative gap between eigenvector and
    transmissibility (an identity), and ``frequency_shift``; None where the units do not tell enough."""

    estimate: float | None = None
    eigenvector: float | None = None
    frequency_shift: float | None = None


def suspended(system: System, check: Sdof) -> tuple[float, float, float] | None:
    """(mass, kg; stiffness, N/m; quadratic drag, kg/m) of the body on its line, None if some constant is not known."""
    units = {unit.name: unit for unit in system.units}
    line, body = units[check.tension.split(".")[0]], units[check.motion.split(".")[0]]
    mass = body.constant("virtual_mass") or body.constant("port_mass")
    stiffness, drag = line.constant("port_stiffness"), body.constant("drag_factor")
    return (mass, stiffness, drag) if mass and stiffness and drag is not None else None


def pair(system: System, check: Sdof) -> sdof.Pair | None:
    """Ship, line and body of the comparison, None if some constant is not known."""
    units = {unit.name: unit for unit in system.units}
    amplitude = units[check.ship].constant("heave_amplitude")
    ship, body = ship_of(system, check), suspended(system, check)
    if not (ship and body and amplitude) or units[check.motion.split(".")[0]].constant("linear_damping"):
        return None  # the theory knows no linear damping beside the drag
    return sdof.Pair(*ship, *body, amplitude)


def theory(system: System, check: Sdof) -> Theory:
    """What the theory says of the scene without any run."""
    known = pair(system, check)
    if not known:
        return Theory()
    masses = known.ship_mass, known.ship_stiffness, known.mass, known.stiffness
    eigenvector = max(abs(b / a - 1.0) if a else 0.0 for a, b in sdof.eigenvector_test(*masses))
    return Theory(sdof.closed_form_of(known), eigenvector, sdof.frequency_shift(*masses))


def ship_of(system: System, check: Sdof) -> tuple[float, float, float] | None:
    """(mass, kg; damping, N s/m; stiffness, N/m) of the unit that the cut connections end at, from what it reports of its
    oscillator; None if that is not enough."""
    unit = next(unit for unit in system.units if unit.name == check.ship)
    mass, natural, ratio = (unit.constant(n) for n in ("port_mass", "natural_frequency", "damping_ratio"))
    return (mass, 2.0 * ratio * natural * mass, natural**2 * mass) if mass and natural and ratio is not None else None


def response(system: System, check: Sdof, omega: float | None, columns: Columns, time: Array) -> dict[str, Any] | None:
    """Transmissibility over frequency with the operating point of the one-way run on it."""
    known = pair(system, check)
    if not known or omega is None:
        return None
    ratios = np.linspace(*RATIOS)
    sizes = [
        linear.lorentz(known.mass, known.drag, known.stiffness, known.amplitude, ratio * known.cradle_frequency)[0]
        for ratio in ratios
    ]
    settled = time >= check.settle
    t, motion, driver = time[settled], columns[check.motion][settled], columns[check.driver][settled]
    drive = abs(component(t, driver, omega))
    measured = abs(component(t, motion, omega)) / drive if drive else 0.0
    return {
        "ratio": ratios.tolist(),
        "amplitude": [size / abs(known.amplitude) if size < BEYOND * abs(known.amplitude) else math.nan for size in sizes],
        "operating": [omega / known.cradle_frequency, measured],
        "label": "equivalent linearisation",
    }


class Runs(NamedTuple):
    """Coupled and one-way run from the settling time on: ``time``, s, and columns on it; ``one_way`` is the whole run.
    ``omega``: dominant frequency of the driver, rad/s, None if it has none; ``periods`` as in `Comparison`; ``irregular``:
    the driver itself does not repeat."""

    time: Array
    coupled: Columns
    single: Columns
    one_way: Track
    omega: float | None
    periods: int
    irregular: bool


def runs(check: Sdof, times: Array, coupled: Track, one_way: Track) -> Runs:
    """Both runs at ``times``, s, as far as they are settled."""
    time = times[times >= check.settle]
    names = check.driver, check.motion, check.tension, check.reaction
    two, one = ({name: track.at(name, time) for name in names} for track in (coupled, one_way))
    omega = dominant_frequency(time, one[check.driver])
    periods = repeats_after(time, one[check.motion], omega, check.tolerance)
    return Runs(time, two, one, one_way, omega, periods, irregular(time, one[check.driver], omega, check.tolerance))


def drifts(check: Sdof, runs: Runs, twin: Track) -> bool:
    """Whether the motion of a twin of the one-way run, started 1e-9 apart, has left it: chaos, where a difference grows by
    a constant factor a period. Resonance alone multiplies it by at most 1/(2 zeta)."""
    late = runs.time[-len(runs.time) // 3 :]
    motion = runs.one_way.at(check.motion, late)
    spread = float(motion.std())
    difference = float(np.sqrt(np.mean((twin.at(check.motion, late) - motion) ** 2)))
    return difference > DRIFTED * spread


def compare(check: Sdof, runs: Runs, times: Array, system: System, chaotic: bool) -> Comparison:
    """The SDOF comparison of settled runs; ``times``, s: those of the whole run. Amplitude (half the swing) and peak tension
    (above its mean) are errors of the one-way model, one-way / coupled - 1; both rms are that of the difference over that of
    the one-way signal, where it repeats after n periods the least for a shift by 0 to n - 1 of them; the phase is that of the
    coupled motion against the one-way motion, rad. All but the phase are zero for a body at rest: a tension that is constant
    but for rounding. ``chaotic``: the statistics decide alone."""
    t, omega = runs.time, runs.omega
    x2, x1 = runs.coupled[check.motion], runs.single[check.motion]
    T2, T1 = runs.coupled[check.tension], runs.single[check.tension]
    dynamic1, dynamic2 = peak(T1) - float(T1.mean()), peak(T2) - float(T2.mean())
    amplitude = relative_change(peak(x1) + peak(-x1), peak(x2) + peak(-x2))
    tension = relative_change(dynamic1, dynamic2)
    rms, tension_rms = _least_rms(check, runs)
    if max(dynamic1, dynamic2) <= AT_REST * max(abs(float(T1.mean())), abs(float(T2.mean()))):
        amplitude = tension = rms = tension_rms = 0.0
    phase = 0.0
    if omega and (first := component(t, x1, omega)):
        phase = cmath.phase(component(t, x2, omega) / first)
    indicator = _indicator(check, runs, times, system)
    bound = None if indicator is None else indicator / (1.0 - indicator) if indicator < 1.0 else math.inf
    told: dict[str, Statistic] = {}
    if omega and (chaotic or runs.irregular):
        told = statistics(t, omega, {"motion": (x1, x2), "tension": (T1, T2)}) | slack_statistics(t, omega, T1, T2)
    worst = max(abs(amplitude), abs(tension), rms, tension_rms)
    word: Word = "invalid" if worst > check.tolerance else "marginal" if bound and bound > check.tolerance else "valid"
    known = theory(system, check)
    compared = Comparison(
        check.tolerance, amplitude, phase, tension, rms, indicator, bound, *known, word,
        tension_rms, runs.periods, chaotic, told,
    )  # fmt: skip
    if not chaotic:
        return compared
    if not told:
        return replace(compared, word="not judged")
    return replace(compared, word=word_of(deciding(told, check.tolerance)[1], check.tolerance))


def _least_rms(check: Sdof, runs: Runs) -> tuple[float, float]:
    """(rms of the difference of the motions, of the tensions) over those of the one-way run, at the shift by whole periods
    at which the motions differ least: a subharmonic that started a period later is the same motion."""
    period = 2.0 * math.pi / runs.omega if runs.omega else 0.0
    differences = []
    for shift in range(max(1, runs.periods)):
        time = runs.time[runs.time <= runs.time[-1] - shift * period]
        pair = []
        for name in (check.motion, check.tension):
            one = runs.one_way.at(name, time + shift * period)
            spread = float(one.std())
            difference = math.sqrt(float(np.mean((runs.coupled[name][: len(time)] - one) ** 2)))
            pair.append(difference / spread if spread else share_of_nothing(difference))
        differences.append((pair[0], pair[1]))
    return min(differences)


def _indicator(check: Sdof, runs: Runs, times: Array, system: System) -> float | None:
    """eps, None where the ship does not tell its dynamic stiffness or does not move: the largest of abs(D2/D1) at the dominant
    frequency, and of swing and standard deviation of the motion that the whole reaction of the one-way run, all its harmonics
    and transients, makes by way of the ship, over those of the one-way motion. The ship is the linear one that it reports; the
    body follows it on a taut line with the linear damping that takes as much power as the drag of its motion. Where line and
    body do not tell enough, the ship's response over its own motion."""
    ship = ship_of(system, check)
    if not runs.omega or not ship:
        return None
    driver = runs.single[check.driver]
    drive = abs(component(runs.time, driver, runs.omega))
    restoring = abs(sdof.dynamic_stiffness(*ship, runs.omega)) * drive  # may underflow to zero
    if not restoring:
        return None
    dominant = abs(component(runs.time, runs.single[check.reaction], runs.omega)) / restoring
    moved = oscillator(times, runs.one_way.at(check.reaction, times), *ship)
    reference = driver
    if body := suspended(system, check):
        mass, stiffness, drag = body
        reference = runs.single[check.motion]
        moved = oscillator(times, stiffness * moved, mass, _damping(runs.time, reference, drag), stiffness)
    moved = moved[times >= check.settle]
    swing, spread = peak(reference) + peak(-reference), float(reference.std())
    if not spread:
        return dominant
    return max(dominant, (peak(moved) + peak(-moved)) / swing, float(moved.std()) / spread)


def _damping(time: Array, motion: Array, drag: float) -> float:
    """c, N s/m, that takes as much power from a motion as its drag b |v| v: b mean(|v|^3)/mean(v^2), which is
    8 b omega A/(3 pi) for a harmonic one (`towage.models.heave.linear.equivalent_damping`)."""
    speed = np.abs(np.gradient(motion, time))
    squares = float(np.mean(speed**2))
    return drag * float(np.mean(speed**3)) / squares if squares else 0.0


def oscillator(time: Array, push: Array, mass: float, damping: float, stiffness: float) -> Array:
    """x, m, of mass x" + damping x' + stiffness x = ``push`` (N), at rest at first, on equally spaced ``time`` (s); SI; exact
    for a push that is linear between the times: the map of `exact_oscillation` over one interval, repeated."""
    h = float(time[1] - time[0])

    def after(x: float, rate: float, begin: float, end: float) -> tuple[float, float]:
        reaction = (-begin, (begin - end) / h, 0.0, 0.0)
        moved: tuple[float, float] = exact_oscillation(h, x, rate, reaction, mass, damping, stiffness, FLOATS)
        return moved

    (xx, vx), (xv, vv), (xb, vb), (xe, ve) = (after(*row) for row in np.eye(4).tolist())
    x = v = 0.0
    moved = [x]
    for dx, dv in zip((xb * push[:-1] + xe * push[1:]).tolist(), (vb * push[:-1] + ve * push[1:]).tolist()):
        x, v = xx * x + xv * v + dx, vx * x + vv * v + dv
        moved.append(x)
    return np.array(moved)
