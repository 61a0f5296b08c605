"""What can be promised before a run: the worst error of the single-degree-of-freedom model over frequency.

eps* <= 0.9 e promises an error below e where drag is small and the line soft (B <= 1, K2/K1 <= 1) and the line stays taut:
beyond, pairs that pass it may err by much more (``tests/scenes/verdict/epsstar.toml``: tension 34 %). So the describing
function is solved at every frequency (`towage.models.heave.sdof.worst`), and nothing is promised outside that range, or
where the dynamic tension of either run reaches the static one at some frequency.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from towage.models.heave import sdof
from towage.result.records import Finding

if TYPE_CHECKING:
    from towage.checks.check import System
    from towage.checks.sdof_section import Sdof

NAME = "SDOF before the run"
RULE = 0.9
"""An estimate <= 0.9 e promises an error below e (spec of the 1969 thesis, section 4)."""
LOW, HIGH, POINTS = 0.2, 4.0, 200
"""Frequencies looked at, over that of the body on its line."""


def promise(system: System, section: Sdof) -> list[Finding]:
    """The finding before the run; empty where the units do not tell enough."""
    from towage.checks.comparison import pair

    known = pair(system, section)
    if not known:
        message = "nothing can be said before the run: the ship does not move, or ship, line and body do not tell enough"
        return [Finding(NAME, "info", None, None, message)]
    estimate, limit = sdof.closed_form_of(known), RULE * section.tolerance
    omega, error, _ = sdof.worst(known, LOW, HIGH, POINTS)
    line = next(unit for unit in system.units if unit.name == section.tension.split(".")[0])
    static, dynamic = line.constant("static_tension"), largest_tension(known)
    reasons = []
    if max(estimate, error) > limit:
        reasons.append("the line may move the ship")
    if static is None or dynamic >= static:
        reasons.append("the line may go slack")
    if known.drag * abs(known.amplitude) > known.mass or known.stiffness > known.ship_stiffness:
        reasons.append("drag or a stiff line matters (B > 1 or K2 > K1)")
    text = f"{'; '.join(reasons)}: measure it" if reasons else "the line moves the ship little at any frequency"
    message = (
        f"worst amplitude error over all frequencies {error:.3g} at w = {omega:.3g} rad/s, closed form eps* = {estimate:.3g}, "
        f"limit {limit:.3g}; {text}"
    )
    return [Finding(NAME, "warning" if reasons else "ok", max(error, estimate), limit, message)]


def largest_tension(known: sdof.Pair) -> float:
    """Largest amplitude of the dynamic tension over frequency, one-way or two-way, N, by the describing function."""
    largest = 0.0
    for k in range(POINTS + 1):
        omega = known.cradle_frequency * (LOW + (HIGH - LOW) * k / POINTS)
        r = sdof.two_way(known, omega)
        for stretch in (abs(r.ship - r.cradle_two_way), abs(known.amplitude - r.cradle_one_way)):
            largest = max(largest, known.stiffness * stretch if math.isfinite(stretch) else math.inf)
    return largest
