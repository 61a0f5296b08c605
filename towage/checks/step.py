"""What can be said before a run: will this scheme carry this loop at this step?

An interface loop of stiffness K between masses m_i oscillates at w = sqrt(K sum 1/m_i). Units report K and m_i
(``port_stiffness``, ``port_mass``). A scheme knows its limits on H w (`towage.master.schemes`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from towage.checks.check import Check, Component, Scheme, Start, System
from towage.registry import SCHEMES
from towage.result.records import Finding
from towage.units.conventions import has

WARN = 0.5
"""H w above which the coupling error is felt: 12 steps a period."""
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
    loops = []
    for i, unit in enumerate(system.units):
        stiffness = _port(unit, "port_stiffness")
        if not stiffness:
            continue
        neighbours = {s.source for s in system.into[i]} & {s.target for s in system.out[i]}
        masses = {system.units[j].name: _port(system.units[j], "port_mass") for j in sorted(neighbours)}
        known = {name: mass for name, mass in masses.items() if mass}
        if known:
            frequency = math.sqrt(stiffness * sum(1.0 / mass for mass in known.values()))
            loops.append(Loop(unit.name, known, frequency))
    return loops


def _port(unit: Component, name: str) -> float | None:
    """What the unit contributes to the loop; None where it tells nothing, or means something else by the name."""
    return unit.constant(name) if has(unit.description, name) else None


def largest_step(loops: list[Loop], scheme: Scheme) -> float:
    """The largest step that the limits of the scheme allow, s; infinite if nothing limits it."""
    return min((scheme.limit(len(loop.masses)) / loop.frequency for loop in loops), default=math.inf)


def before(start: Start) -> list[Finding]:
    """Findings on scheme and step; one of level "refused" means that the run would be worth nothing."""
    scheme, findings = start.scheme, []
    if scheme.holds and start.system.signals:
        message = (
            f"{scheme.name} holds inputs over the step and creates energy (damping ratio -H w/4): for comparison with "
            "other tools only"
        )
        findings.append(Finding("scheme", "warning", None, None, message))
    for loop in loops(start.system):
        findings.append(_of_step(loop, scheme, start.step))
        if loop.ratio:
            findings.append(_of_masses(loop))
    return findings


def _of_step(loop: Loop, scheme: Scheme, step: float) -> Finding:
    """Whether the scheme carries the loop at this step, s; where it does not, what would."""
    product, limit = step * loop.frequency, scheme.limit(len(loop.masses))
    what = f"loop {loop.name}: w = {loop.frequency:.4g} rad/s, H w = {product:.3g} at H = {step:.4g} s"
    if product > limit:
        schemes = map(SCHEMES.get, SCHEMES.own)
        other = next((s.name for s in schemes if s.limits and product <= s.limit(len(loop.masses))), None)
        advice = f"a step of at most {limit / loop.frequency:.3g} s" + (f", or scheme {other!r}" if other else "")
        merge = "" if other else ", or units that join line and cradle (cradle_on_line)"
        message = f"{what}, limit {limit:g} for {scheme.name}: use {advice}{merge}"
        return Finding("step", "refused", product, limit, message)
    if product > WARN:
        return Finding("step", "warning", product, WARN, f"{what}: above {WARN:g} the coupling error is felt")
    return Finding("step", "ok", product, WARN, what)


def _of_masses(loop: Loop) -> Finding:
    """How strongly the masses of a loop couple."""
    strong = loop.ratio >= STRONG_RATIO
    masses = ", ".join(f"{name} {mass:.4g} kg" for name, mass in loop.masses.items())
    message = f"loop {loop.name}: masses {masses}, ratio {loop.ratio:.3g}" + (": they couple strongly" if strong else "")
    return Finding("mass ratio", "warning" if strong else "ok", loop.ratio, STRONG_RATIO, message)


CHECK = Check(
    name="step",
    description="Will the scheme carry the interface loops at this step?",
    before=before,
    refuses=True,
)
