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
from towage.checks.sdof_section import SdofCheck
from towage.checks.signals import component, dominant_frequency, peak, repeats_after
from towage.checks.statistics import deciding, statistics, word_of
from towage.checks.track import Track
from towage.models.heave import linear, sdof
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


def pair(system: System, check: SdofCheck) -> sdof.Pair | None:
    """Ship, line and body of the comparison, None if some constant is not known."""
    units = {unit.name: unit for unit in system.units}
    ship = units[check.ship]
    line = units[check.tension.split(".")[0]]
    body = units[check.motion.split(".")[0]]
    m1, natural, ratio, amplitude = (
        ship.constant(n) for n in ("port_mass", "natural_frequency", "damping_ratio", "heave_amplitude")
    )
    k2, m2, drag = line.constant("port_stiffness"), body.constant("virtual_mass"), body.constant("drag_factor")
    m2 = m2 or body.constant("port_mass")
    if not (m1 and natural and amplitude and k2 and m2) or ratio is None or drag is None:
        return None
    return sdof.Pair(m1, 2.0 * ratio * natural * m1, natural**2 * m1, m2, k2, drag, amplitude)


def theory(system: System, check: SdofCheck) -> Theory:
    """What the theory says of the scene without any run."""
    known = pair(system, check)
    if not known:
        return Theory()
    masses = known.ship_mass, known.ship_stiffness, known.mass, known.stiffness
    eigenvector = max(abs(b / a - 1.0) if a else 0.0 for a, b in sdof.eigenvector_test(*masses))
    return Theory(sdof.closed_form_of(known), eigenvector, sdof.frequency_shift(*masses))


def dynamic_stiffness(system: System, check: SdofCheck, omega: float | None) -> complex | None:
    """D1 = m1 (w0^2 - w^2 + 2 i zeta w0 w) of the unit that the cut connections end at, N/m, from what it reports."""
    unit = next(unit for unit in system.units if unit.name == check.ship)
    mass, natural, ratio = (unit.constant(n) for n in ("port_mass", "natural_frequency", "damping_ratio"))
    if omega is None or not mass or not natural or ratio is None:
        return None
    return mass * (natural * natural - omega * omega + 2j * ratio * natural * omega)


def response(system: System, check: SdofCheck, omega: float | None, columns: Columns, time: Array) -> dict[str, Any] | None:
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


def runs(check: SdofCheck, times: Array, coupled: Track, one_way: Track) -> Runs:
    """Both runs at ``times``, s, as far as they are settled."""
    time = times[times >= check.settle]
    names = check.driver, check.motion, check.tension, check.reaction
    two, one = ({name: track.at(name, time) for name in names} for track in (coupled, one_way))
    omega = dominant_frequency(time, one[check.driver])
    periods = repeats_after(time, one[check.motion], omega, check.tolerance)
    late = len(time) // 2  # a drive that fades in is regular afterwards
    irregular = not repeats_after(time[late:], one[check.driver][late:], omega, check.tolerance)
    return Runs(time, two, one, one_way, omega, periods, irregular)


def drifts(check: SdofCheck, runs: Runs, twin: Track) -> bool:
    """Whether the motion of a twin of the one-way run, started 1e-9 apart, has left it: chaos, where a difference grows by
    a constant factor a period. Resonance alone multiplies it by at most 1/(2 zeta)."""
    late = runs.time[-len(runs.time) // 3 :]
    motion = runs.one_way.at(check.motion, late)
    spread = float(motion.std())
    difference = float(np.sqrt(np.mean((twin.at(check.motion, late) - motion) ** 2)))
    return difference > DRIFTED * spread


def compare(check: SdofCheck, runs: Runs, times: Array, system: System, chaotic: bool) -> Comparison:
    """The SDOF comparison of settled runs; ``times``, s: those of the whole run. Amplitude (half the swing) and peak tension
    (above its mean) are errors of the one-way model, one-way / coupled - 1; both rms are that of the difference over that of
    the one-way signal, where it repeats after n periods the least for a shift by 0 to n - 1 of them; the phase is that of the
    coupled motion against the one-way motion, rad. All but the phase are zero for a body at rest: a tension that is constant
    but for rounding. ``chaotic``: the statistics decide alone."""
    t, omega = runs.time, runs.omega
    x2, x1 = runs.coupled[check.motion], runs.single[check.motion]
    T2, T1 = runs.coupled[check.tension], runs.single[check.tension]
    dynamic1, dynamic2 = peak(T1) - float(T1.mean()), peak(T2) - float(T2.mean())
    amplitude = _change(peak(x1) + peak(-x1), peak(x2) + peak(-x2))
    tension = _change(dynamic1, dynamic2)
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
        told = statistics(t, omega, {"motion": (x1, x2), "tension": (T1, T2)})
    worst = max(abs(amplitude), abs(tension), rms, tension_rms)
    word: Word = "invalid" if worst > check.tolerance else "marginal" if bound and bound > check.tolerance else "valid"
    known = theory(system, check)
    compared = Comparison(
        check.tolerance, amplitude, phase, tension, rms, indicator, bound, *known, word,
        tension_rms, runs.periods, chaotic, told,
    )  # fmt: skip
    if not chaotic:
        return compared
    return replace(compared, word=word_of(deciding(compared)[1], check.tolerance) if told else "not judged")


def _least_rms(check: SdofCheck, runs: Runs) -> tuple[float, float]:
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
            pair.append(difference / spread if spread else _share_of_nothing(difference))
        differences.append((pair[0], pair[1]))
    return min(differences)


def _indicator(check: SdofCheck, runs: Runs, times: Array, system: System) -> float | None:
    """eps, None where the ship does not tell its dynamic stiffness or does not move: the largest of abs(D2/D1) at the dominant
    frequency, and of swing and standard deviation of the motion that the whole reaction of the one-way run, all its harmonics
    and transients, makes by way of the ship, over those of the one-way motion. The ship is the linear one that it reports; the
    body follows it on a taut line with the equivalent damping of its motion. Where line and body do not tell enough, the
    ship's response over its own motion."""
    stiffness = dynamic_stiffness(system, check, runs.omega)
    if not runs.omega or not stiffness:
        return None
    driver = runs.single[check.driver]
    drive = abs(component(runs.time, driver, runs.omega))
    restoring = abs(stiffness) * drive  # may underflow to zero
    if not restoring:
        return None
    dominant = abs(component(runs.time, runs.single[check.reaction], runs.omega)) / restoring
    unit = next(unit for unit in system.units if unit.name == check.ship)
    mass, natural, ratio = (unit.constant(n) for n in ("port_mass", "natural_frequency", "damping_ratio"))
    assert mass and natural and ratio is not None  # as the dynamic stiffness is known
    moved = oscillator(times, runs.one_way.at(check.reaction, times) / mass, natural, ratio)
    reference = driver
    if known := pair(system, check):
        reference = runs.single[check.motion]
        size = abs(component(runs.time, reference, runs.omega))
        damping = 0.5 * linear.equivalent_damping(known.drag, runs.omega, size) / (known.mass * known.cradle_frequency)
        moved = oscillator(times, known.cradle_frequency**2 * moved, known.cradle_frequency, damping)
    moved = moved[times >= check.settle]
    swing, spread = peak(reference) + peak(-reference), float(reference.std())
    if not spread:
        return dominant
    return max(dominant, (peak(moved) + peak(-moved)) / swing, float(moved.std()) / spread)


def oscillator(time: Array, push: Array, natural: float, ratio: float) -> Array:
    """x of x" + 2 ratio natural x' + natural^2 x = ``push`` (m/s2), at rest at first, on equally spaced ``time`` (s); exact
    for a push that is linear between the times. Two first-order modes z' = lambda z + push, x = (z1 - z2)/(lambda1 -
    lambda2); critical damping is taken 1e-6 off, where the modes differ."""
    h = time[1] - time[0]
    root = cmath.sqrt(ratio * ratio - 1.0) or 1e-6
    x = np.zeros(len(time), dtype=complex)
    first, second = (natural * (-ratio + sign * root) for sign in (1.0, -1.0))
    for eigenvalue, sign in ((first, 1.0), (second, -1.0)):
        a = eigenvalue * h
        e = cmath.exp(a)
        late = h * (e - 1.0 - a) / a**2
        early = h * (e - 1.0) / a - late
        z, modes = 0j, [0j]
        for force in (early * push[:-1] + late * push[1:]).tolist():
            z = e * z + force
            modes.append(z)
        x += sign * np.array(modes)
    moved: Array = (x / (first - second)).real
    return moved


def _change(one: float, two: float) -> float:
    """one / two - 1; infinite where only ``one`` is not zero."""
    return one / two - 1.0 if two else _share_of_nothing(one)


def _share_of_nothing(value: float) -> float:
    """``value`` as a share of zero: infinite, but for zero itself."""
    return math.inf if value else 0.0
