"""What can be said before a run: will this scheme carry this loop at this step?

An interface loop of stiffness K between masses m_i oscillates at w = sqrt(K sum 1/m_i). Units report K and m_i
(``port_stiffness``, ``port_mass``). Below the limits on H w the energy of the undamped loop grows by less than 1 % a
radian at mass ratios from 0.06 to 100 (measured: ``benchmarks/coupling.py stability``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from towage.master.schemes import ORDERS
from towage.master.system import System
from towage.result.result import Check

WARN = 0.5
"""H w above which the coupling error is felt: 12 steps a period."""
LIMITS = {
    # scheme: (one mass in the loop, more than one)
    "hermite": (2.4, 1.2),
    "extrapolate": (1.2, 1.2),
    "implicit": (3.1, 1.9),
}
STRONG_RATIO = 0.3
"""Mass ratio above which ``auto`` prefers the implicit scheme."""


@dataclass(frozen=True)
class Loop:
    """An interface loop: the unit with the stiffness, the masses at its ends (kg), frequency (rad/s)."""

    unit: str
    masses: dict[str, float]
    frequency: float

    @property
    def ratio(self) -> float:
        """Largest mass ratio body to ship, at most 1 by convention of which is which; 0 with one mass."""
        if len(self.masses) < 2:
            return 0.0
        values = sorted(self.masses.values())
        return values[0] / values[-1]

    @property
    def name(self) -> str:
        """The unit with the stiffness and those with the masses."""
        return " - ".join([self.unit, *self.masses])


def loops(system: System) -> list[Loop]:
    """Interface loops that the units' port values tell of."""
    found = []
    for i, unit in enumerate(system.units):
        stiffness = unit.constant("port_stiffness")
        if not stiffness:
            continue
        neighbours = {s.source for s in system.into[i]} & {s.target for s in system.out[i]}
        masses = {system.units[j].name: system.units[j].constant("port_mass") for j in sorted(neighbours)}
        known = {name: m for name, m in masses.items() if m}
        if known:
            found.append(Loop(unit.name, known, math.sqrt(stiffness * sum(1.0 / m for m in known.values()))))
    return found


def choose_scheme(system: System, found: list[Loop], step: float) -> tuple[str, str]:
    """(scheme, why) for ``auto``."""
    if not system.can_roll_back:
        stuck = ", ".join(u.name for u in system.units if not u.can_roll_back)
        return "extrapolate", f"{stuck} cannot save and restore the state"
    if not system.looped:
        return "hermite", "no unit depends on a later one: nothing has to be iterated"
    worst = max(found, key=lambda a: a.frequency, default=None)
    if worst:
        two = len(worst.masses) > 1
        if step * worst.frequency > LIMITS["hermite"][two]:
            return "implicit", f"H w = {step * worst.frequency:.3g} in loop {worst.name} is beyond the default scheme"
        if worst.ratio >= STRONG_RATIO and step * worst.frequency > WARN:
            return "implicit", f"mass ratio {worst.ratio:.3g} in loop {worst.name} couples strongly"
    return "hermite", "all units can save and restore their state"


def largest_step(found: list[Loop], scheme: str) -> float:
    """The largest step the limits allow, s; infinite if nothing limits it."""
    if scheme not in LIMITS:
        return math.inf
    return min((LIMITS[scheme][len(a.masses) > 1] / a.frequency for a in found), default=math.inf)


def before_run(system: System, found: list[Loop], scheme: str, step: float) -> list[Check]:
    """The a-priori checks; one of level "refused" means the run would be worth nothing."""
    checks = []
    if ORDERS[scheme] == 1 and system.signals:
        checks.append(
            Check("scheme", "warning", None, None, f"{scheme} holds inputs over the step and creates energy (damping "
                  "ratio -H w/4): for comparison with other tools only")
        )  # fmt: skip
    for loop in found:
        product = step * loop.frequency
        limit = LIMITS.get(scheme, (math.inf, math.inf))[len(loop.masses) > 1]
        what = f"loop {loop.name}: w = {loop.frequency:.4g} rad/s, H w = {product:.3g} at H = {step:.4g} s"
        if product > limit:
            other = next((s for s in LIMITS if product <= LIMITS[s][len(loop.masses) > 1]), None)
            advice = f"a step of at most {limit / loop.frequency:.3g} s" + (f", or scheme {other!r}" if other else "")
            merge = "" if other else ", or units that join line and cradle (cradle_on_line)"
            checks.append(
                Check("step", "refused", product, limit, f"{what}, limit {limit:g} for {scheme}: use {advice}{merge}")
            )
        elif product > WARN:
            checks.append(Check("step", "warning", product, WARN, f"{what}: above {WARN:g} the coupling error is felt"))
        else:
            checks.append(Check("step", "ok", product, WARN, what))
        if loop.ratio:
            strong = loop.ratio >= STRONG_RATIO
            checks.append(
                Check("mass ratio", "warning" if strong else "ok", loop.ratio, STRONG_RATIO,
                      f"loop {loop.name}: masses {', '.join(f'{n} {m:.4g} kg' for n, m in loop.masses.items())}, "
                      f"ratio {loop.ratio:.3g}" + (": they couple strongly" if strong else ""))
            )  # fmt: skip
    return checks
