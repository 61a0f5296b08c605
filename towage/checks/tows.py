"""The check of the tows in a scene: is the model fine enough before the run, and how far is a linear one off after it?

The numbers are in `towing` and `linearity`, whose models take long to import: only a scene with a tow pays for them.
"""

from __future__ import annotations

from towage.checks.check import Check, Finished, Start
from towage.checks.tow_names import LINEAR, OWN, WHOLE
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene


def has_tow(scene: ResolvedScene) -> bool:
    """Whether a unit of the scene tows."""
    return any(unit.description.model_name in LINEAR for unit in scene.units.values())


def before(start: Start) -> list[Finding]:
    """Which fidelity every tow needs."""
    if not has_tow(start.scene):
        return []
    from towage.checks import towing

    return towing.before_run(start.scene)


def reads(scene: ResolvedScene) -> tuple[str, ...]:
    """Whatever is connected to an input of a unit of the kinds that tow, or of a towed body, and what a linear tow made of it."""
    kinds = {*LINEAR, "towed_body"}
    driven = {name for name, unit in scene.units.items() if unit.description.model_name in kinds}
    wholes = [name for name, unit in scene.units.items() if unit.description.model_name == WHOLE]
    sources = (f"{c.source_unit}.{c.source}" for c in scene.connections if c.target_unit in driven)
    return (*sources, *(f"{name}.{output}" for name in wholes for output in OWN))


def after(run: Finished) -> list[Finding]:
    """The error of every linear tow, as its margin."""
    if not has_tow(run.scene):
        return []
    from towage.checks import linearity

    return linearity.judge(run)


CHECK = Check(
    name="towing",
    description="Which model does a tow need, and how far is a linear one off?",
    reads=reads,
    before=before,
    after=after,
)
