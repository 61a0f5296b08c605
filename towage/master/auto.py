"""What ``scheme = "auto"`` takes: the cheapest of the project's own schemes that suits the units and their loops."""

from __future__ import annotations

from dataclasses import replace

from towage.checks.step import STRONG_RATIO, WARN, Loop
from towage.master.schemes import Scheme
from towage.master.system import System
from towage.registry import SCHEMES


def choose(system: System, loops: list[Loop], step: float) -> tuple[Scheme, str]:
    """(scheme, why) for a communication step of ``step`` s; 0 where the error control chooses it."""
    schemes = [scheme for scheme in map(SCHEMES.get, SCHEMES.own) if not scheme.holds]
    usual = min(schemes, key=lambda s: (-s.order, s.calls))
    if not system.can_roll_back:
        stuck = ", ".join(u.name for u in system.units if not u.can_roll_back and u.name not in system.distrusted)
        explicit = max((s for s in schemes if not s.goes_back), key=lambda s: s.order)
        reasons = [f"{stuck} cannot save and restore the state"] if stuck else []
        why = "; ".join([*reasons, *(f"{unit} {why}" for unit, why in system.distrusted.items())])
        if not system.repeated or not step:
            return explicit, why
        others = ", ".join(system.units[i].name for i in system.repeated)
        taken = replace(usual, order=min(usual.order, explicit.order), limits=explicit.limits)
        return taken, f"{others} can go back, with one step each and extrapolated inputs for the others: {why}"
    solver = next(s for s in schemes if s.solves_loops)
    if not system.looped:
        return usual, "no unit depends on a later one: nothing has to be iterated"
    worst = max(loops, key=lambda loop: loop.frequency, default=None)
    if worst:
        product = step * worst.frequency
        if product > usual.limit(len(worst.masses)):
            return solver, f"H w = {product:.3g} in loop {worst.name} is beyond the default scheme"
        if worst.ratio >= STRONG_RATIO and product > WARN:
            return solver, f"mass ratio {worst.ratio:.3g} in loop {worst.name} couples strongly"
    return usual, "all units can save and restore their state"
