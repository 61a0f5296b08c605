"""The numbers of the SDOF check: coupled run against one-way run, and the theory from what the units report of themselves.

Ship: ``port_mass``, ``natural_frequency``, ``damping_ratio``, ``heave_amplitude``. Line: ``port_stiffness``. Body:
``port_mass`` or ``virtual_mass``, ``drag_factor``. A scene with other units simply has no estimate.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.checks.check import System
from towage.checks.sdof_section import SdofCheck
from towage.checks.signals import component, dominant_frequency, peak, repeats
from towage.models.heave import linear, sdof
from towage.result.records import Comparison

Array = NDArray[np.float64]
Columns = Mapping[str, Array]
RATIOS = (0.2, 3.0, 281)
"""Frequency ratios of the response curve: from, to, how many."""
BEYOND = 1e6
"""Response that only a cradle without drag has, at its resonance: infinite but for rounding, and not drawn."""
AT_REST = 1e-13
"""Dynamic tension, as a share of the mean one, that is rounding."""


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


def compare(check: SdofCheck, time: Array, coupled: Columns, one_way: Columns, system: System) -> Comparison:
    """The SDOF comparison from ``check.settle`` (s) on. Amplitude (half the swing) and peak tension (above its mean) are
    errors of the one-way model, one-way / coupled - 1; rms is that of the difference over that of the one-way motion;
    the phase is that of the coupled motion against the one-way motion, rad. Amplitude, tension and rms are zero for a body
    at rest: a tension that is constant but for rounding."""
    settled = time >= check.settle
    t = time[settled]
    x2, x1 = coupled[check.motion][settled], one_way[check.motion][settled]
    T2, T1 = coupled[check.tension][settled], one_way[check.tension][settled]
    swing1, swing2 = peak(x1) + peak(-x1), peak(x2) + peak(-x2)
    dynamic1, dynamic2 = peak(T1) - float(T1.mean()), peak(T2) - float(T2.mean())
    amplitude = _change(swing1, swing2)
    tension = _change(dynamic1, dynamic2)
    rms1 = math.sqrt(float(np.mean((x1 - x1.mean()) ** 2)))
    difference = math.sqrt(float(np.mean((x2 - x1) ** 2)))
    rms = difference / rms1 if rms1 else _share_of_nothing(difference)
    if max(dynamic1, dynamic2) <= AT_REST * max(abs(float(T1.mean())), abs(float(T2.mean()))):
        amplitude = tension = rms = 0.0
    omega = dominant_frequency(t, one_way[check.driver][settled])
    phase = 0.0
    if omega and (first := component(t, x1, omega)):
        phase = cmath.phase(component(t, x2, omega) / first)
    indicator = _indicator(check, t, {name: one_way[name][settled] for name in (check.driver, check.reaction)}, system, omega)
    bound = None if indicator is None else indicator / (1.0 - indicator) if indicator < 1.0 else math.inf
    worst = max(abs(amplitude), abs(tension), rms if repeats(t, x1, omega, check.tolerance) else 0.0)
    word = "invalid" if worst > check.tolerance else "marginal" if bound and bound > check.tolerance else "valid"
    return Comparison(check.tolerance, amplitude, phase, tension, rms, indicator, bound, *theory(system, check), word)


def _indicator(check: SdofCheck, time: Array, one_way: Columns, system: System, omega: float | None) -> float | None:
    """eps = |D2/D1| at the dominant frequency, from the one-way run alone; None where the ship does not tell its dynamic
    stiffness or does not move."""
    stiffness = dynamic_stiffness(system, check, omega)
    if not omega or not stiffness:
        return None
    drive = abs(component(time, one_way[check.driver], omega))
    restoring = abs(stiffness) * drive  # may underflow to zero
    return abs(component(time, one_way[check.reaction], omega)) / restoring if restoring else None


def _change(one: float, two: float) -> float:
    """one / two - 1; infinite where only ``one`` is not zero."""
    return one / two - 1.0 if two else _share_of_nothing(one)


def _share_of_nothing(value: float) -> float:
    """``value`` as a share of zero: infinite, but for zero itself."""
    return math.inf if value else 0.0
