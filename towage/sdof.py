"""The theory of the SDOF assumption for a scene, from what its units report of themselves.

Ship: ``port_mass``, ``natural_frequency``, ``damping_ratio``, ``heave_amplitude``. Line: ``port_stiffness``. Body:
``port_mass`` or ``virtual_mass``, ``drag_factor``. A scene with other units simply has no estimate.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .judge import component
from .models import linear, sdof
from .result import Check
from .scene import SdofCheck
from .system import System

Array = NDArray[np.float64]
RULE = 0.9
"""eps* <= 0.9 e promises an error below e (spec of the 1969 thesis, section 4)."""
RATIOS = (0.2, 3.0, 281)
BEYOND = 1e6
"""Response that only a cradle without drag has, at its resonance: infinite but for rounding, and not drawn."""


def pair(system: System, check: SdofCheck) -> sdof.Pair | None:
    """Ship, line and body of the comparison, None if some constant is not known."""
    units = {u.name: u for u in system.units}
    ship = units[check.cut[0].split(" -> ")[1].split(".")[0]]
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


def before_run(system: System, check: SdofCheck | None) -> list[Check]:
    """The closed-form estimate as a check before the run."""
    found = pair(system, check) if check else None
    if not check or not found:
        return []
    estimate, limit = sdof.closed_form_of(found), RULE * check.tolerance
    small = estimate <= limit
    text = "the line moves the ship little at any frequency" if small else "the line may move the ship: measure it"
    message = f"closed form over all frequencies: eps* = {estimate:.3g}, limit {limit:.3g}; {text}"
    return [Check("SDOF eps*", "ok" if small else "warning", estimate, limit, message)]


def theory(system: System, check: SdofCheck) -> dict[str, float | None]:
    """``estimate`` eps*, and the thesis's own indicators: ``eigenvector``, the relative gap between eigenvector and
    transmissibility (an identity), and ``frequency_shift``."""
    found = pair(system, check)
    if not found:
        return {}
    masses = found.ship_mass, found.ship_stiffness, found.mass, found.stiffness
    return {
        "estimate": sdof.closed_form_of(found),
        "eigenvector": max(abs(b / a - 1.0) if a else 0.0 for a, b in sdof.eigenvector_test(*masses)),
        "frequency_shift": sdof.frequency_shift(*masses),
    }


def response(
    system: System, check: SdofCheck, omega: float | None, columns: dict[str, Array], time: Array
) -> dict[str, Any] | None:
    """Transmissibility over frequency with the operating point of the one-way run on it."""
    found = pair(system, check)
    if not found or omega is None:
        return None
    ratios = np.linspace(*RATIOS)
    sizes = [
        linear.lorentz(found.mass, found.drag, found.stiffness, found.amplitude, r * found.cradle_frequency)[0]
        for r in ratios
    ]
    settled = time >= check.settle
    t, motion, driver = time[settled], columns[check.motion][settled], columns[check.driver][settled]
    drive = abs(component(t, driver, omega))
    measured = abs(component(t, motion, omega)) / drive if drive else 0.0
    return {
        "ratio": ratios.tolist(),
        "amplitude": [a / abs(found.amplitude) if a < BEYOND * abs(found.amplitude) else math.nan for a in sizes],
        "operating": [omega / found.cradle_frequency, measured],
        "label": "equivalent linearisation",
    }
