"""The verdict: coupled run against one-way run, margins, and the single-degree-of-freedom (SDOF) assumption.

The SDOF models let the ship drive the body and not the body the ship. A scene that names the connections back to the
ship (``checks.sdof.cut``) is run a second time without them, and the two runs are compared:

| word | meaning |
|---|---|
| valid | amplitude, peak tension and rms difference within the tolerance e, and the bound eps/(1 - eps) too |
| marginal | measured differences within e, but the bound is not: a slightly different sea may break it |
| invalid | a measured difference exceeds e, or a margin that decides is negative |

The rms difference is left out where the one-way motion does not repeat after a period.

eps = |D2/D1|: amplitude of the line's reaction in the one-way run over that of the ship's dynamic stiffness times its
motion; eps/(1 - eps) bounds the amplitude error of a steady motion rigorously.
"""

from __future__ import annotations

import cmath
import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .resolve import ResolvedScene
from .result import Comparison, Margin, Verdict
from .scene import SdofCheck
from .system import System

Array = NDArray[np.float64]
AT_REST = 1e-13
"""Dynamic tension, as a share of the mean one, that is rounding."""


def dominant_frequency(time: Array, values: Array) -> float | None:
    """Angular frequency of the largest component, rad/s, by a least-squares refinement of the spectrum's peak; None
    for less than two periods or no motion."""
    n = len(time)
    if n < 16 or not np.ptp(values) > 0.0:
        return None
    step = (time[-1] - time[0]) / (n - 1)
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(n), 8 * n))
    peak = int(np.argmax(spectrum[1:])) + 1
    if peak < 16 or peak + 1 >= len(spectrum):
        return None
    left, middle, right = np.log(spectrum[peak - 1 : peak + 2] + 1e-300)
    bend = left - 2.0 * middle + right
    shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0  # no peak where the motion is too small to be squared
    return float(2.0 * math.pi * (peak + shift) / (8 * n * step))


def component(time: Array, values: Array, omega: float) -> complex:
    """Complex amplitude A of Re(A exp(i omega t)) by least squares, over whole periods."""
    period = 2.0 * math.pi / omega
    periods = math.floor((time[-1] - time[0]) / period + 1e-9)
    keep = time >= time[-1] - periods * period
    t = time[keep]
    basis = np.column_stack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t)])
    c, s, _ = np.linalg.lstsq(basis, values[keep], rcond=None)[0]
    return complex(c, -s)


def repeats(time: Array, values: Array, omega: float | None, tolerance: float) -> bool:
    """Whether a motion is the same one period later, within half the tolerance. A subharmonic or chaotic motion is not:
    two such runs may differ by a whole amplitude at every instant and still be the same motion."""
    if omega is None:
        return True
    period = 2.0 * math.pi / omega
    late = time[time <= time[-1] - period]
    if len(late) < 8:
        return True
    change = np.interp(late + period, time, values) - values[: len(late)]
    spread = float(np.std(values))
    return not spread or math.sqrt(float(np.mean(change**2))) <= 0.5 * tolerance * spread


def peak(values: Array) -> float:
    """Largest value, refined by a parabola through the samples around it."""
    k = int(np.argmax(values))
    if 0 < k < len(values) - 1:
        a, b, c = (float(x) for x in values[k - 1 : k + 2])
        curvature = a - 2.0 * b + c
        if curvature < 0.0:
            return b - (a - c) ** 2 / (8.0 * curvature)
    return float(values[k])


def _of_none(a: float) -> float:
    """The share of ``a`` in zero: infinite, but for zero."""
    return math.inf if a else 0.0


def compare(
    check: SdofCheck,
    time: Array,
    coupled: dict[str, Array],
    one_way: dict[str, Array],
    theory: dict[str, float | None],
    stiffness: complex | None,
) -> Comparison:
    """The SDOF comparison after ``check.settle``. Amplitude (half the swing) and peak tension (above its mean) are
    errors of the one-way model, one-way / coupled - 1; rms is that of the difference over that of the one-way motion;
    the phase is that of the coupled motion against the one-way motion. All are zero for a body at rest: a tension that
    is constant but for rounding. ``stiffness``: the ship's dynamic stiffness D1
    at the dominant frequency, N/m, if known; ``theory``: estimate, eigenvector and frequency_shift, where known."""
    keep = time >= check.settle
    t = time[keep]
    x2, x1 = coupled[check.motion][keep], one_way[check.motion][keep]
    T2, T1 = coupled[check.tension][keep], one_way[check.tension][keep]
    swing1 = peak(x1) + peak(-x1)
    rms1 = math.sqrt(float(np.mean((x1 - x1.mean()) ** 2)))
    driver = one_way[check.driver][keep]
    omega = dominant_frequency(t, driver)
    phase, indicator = 0.0, None
    if omega:
        a1, a2 = component(t, x1, omega), component(t, x2, omega)
        phase = cmath.phase(a2 / a1) if a1 else 0.0
        reaction = one_way[check.cut[0].split(" -> ")[0]][keep]
        drive = abs(component(t, driver, omega))
        if stiffness and (restoring := abs(stiffness) * drive):
            indicator = abs(component(t, reaction, omega)) / restoring
    bound = None if indicator is None else indicator / (1.0 - indicator) if indicator < 1.0 else math.inf
    swing2 = peak(x2) + peak(-x2)
    dynamic1, dynamic2 = peak(T1) - float(T1.mean()), peak(T2) - float(T2.mean())
    amplitude = swing1 / swing2 - 1.0 if swing2 else _of_none(swing1)
    tension = dynamic1 / dynamic2 - 1.0 if dynamic2 else _of_none(dynamic1)
    difference = math.sqrt(float(np.mean((x2 - x1) ** 2)))
    rms = difference / rms1 if rms1 else _of_none(difference)
    if max(dynamic1, dynamic2) <= AT_REST * max(abs(float(T1.mean())), abs(float(T2.mean()))):
        amplitude = tension = rms = 0.0
    worst = max(abs(amplitude), abs(tension), rms if repeats(t, x1, omega, check.tolerance) else 0.0)
    word = "invalid" if worst > check.tolerance else "marginal" if bound and bound > check.tolerance else "valid"
    return Comparison(
        check.tolerance, amplitude, phase, tension, rms, indicator, bound, theory.get("estimate"),
        theory.get("eigenvector"), theory.get("frequency_shift"), word,
    )  # fmt: skip


def dynamic_stiffness(system: System, check: SdofCheck, omega: float | None) -> complex | None:
    """D1 = m1 (w0^2 - w^2 + 2 i zeta w0 w) of the unit that the cut connections end at, N/m, from what it reports."""
    unit = next(u for u in system.units if u.name == check.cut[0].split(" -> ")[1].split(".")[0])
    mass, natural, ratio = (unit.constant(n) for n in ("port_mass", "natural_frequency", "damping_ratio"))
    if omega is None or not mass or not natural or ratio is None:
        return None
    return mass * (natural * natural - omega * omega + 2j * ratio * natural * omega)


def margins(scene: ResolvedScene, time: Array, columns: dict[str, Array]) -> list[Margin]:
    """The worst of every recorded margin and when."""
    found = []
    for name, values in columns.items():
        if name.split(".", 1)[1].startswith("margin_") and len(values):
            k = int(np.argmin(values))
            found.append(Margin(name, float(values[k]), float(time[k]), name not in scene.scene.checks.report_only))
    return found


def verdict(comparison: Comparison | None, found: list[Margin]) -> Verdict:
    """One word for the run, with the number that decided."""
    worst = min((m for m in found if m.decides), key=lambda m: m.worst, default=None)
    if comparison and comparison.word == "invalid":
        return _sdof(comparison)
    if worst and worst.worst < 0.0:
        return Verdict("invalid", f"{worst.variable} is negative at t = {worst.time:.4g} s", worst.worst, 0.0)
    if comparison:
        return _sdof(comparison)
    if worst:
        return Verdict("valid", f"smallest margin is {worst.variable}", worst.worst, 0.0)
    return Verdict("not judged", "no check and no margin decides", None, None)


def _sdof(c: Comparison) -> Verdict:
    numbers = {"peak tension": abs(c.peak_tension), "amplitude": abs(c.amplitude)}
    if c.word == "invalid" or c.rms <= c.tolerance:
        numbers["rms difference"] = c.rms
    name = max(numbers, key=numbers.__getitem__)
    if c.word == "marginal":
        return Verdict("marginal", "SDOF: the bound eps/(1 - eps) exceeds the tolerance", c.bound, c.tolerance)
    word: Literal["valid", "invalid"] = "valid" if c.word == "valid" else "invalid"
    return Verdict(word, f"SDOF: {name} of the one-way run against the coupled run", numbers[name], c.tolerance)
