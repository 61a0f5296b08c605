"""The check of the tows in a scene: is the model fine enough before the run, does a spring EA/L stand for the cable after it?

The numbers are in `towing`, whose models take long to import: only a scene with a tow pays for them.
"""

from __future__ import annotations

from towage.checks.check import Check, Finished, Start, told
from towage.checks.tow_names import SPRING, UNITS
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene


def has_tow(scene: ResolvedScene) -> bool:
    """Whether a unit of the scene tows."""
    return any(unit.description.model_name in UNITS for unit in scene.units.values())


def before(start: Start) -> list[Finding]:
    """Which fidelity every tow needs."""
    if not has_tow(start.scene):
        return []
    from towage.checks import towing

    return towing.before_run(start.scene)


def after(run: Finished) -> list[Finding]:
    """Whether one degree of freedom on a spring EA/L stands for every tow."""
    if not has_tow(run.scene):
        return []
    from towage.checks import towing

    return towing.after_run(run.scene)


CHECK = Check(
    name="towing",
    description="Which model does a tow need, and would a spring do?",
    before=before,
    after=after,
    summary=lambda result: told(result, SPRING),
)
