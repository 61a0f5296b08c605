"""The check of the tows in a scene: is the model fine enough before the run; how far is a linear one off, and does a spring
EA/L stand for the cable, after it?

The numbers are in `towing` and `linearity`, whose models take long to import: only a scene with a tow pays for them.
"""

from __future__ import annotations

from pathlib import Path

from towage.checks.check import Check, Finished, Start, told
from towage.checks.tow_names import OWN, SPRING, UNITS, WHOLE
from towage.result.records import Finding
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Scene


def has_tow(scene: ResolvedScene) -> bool:
    """Whether a unit of the scene tows."""
    return any(unit.description.model_name in UNITS for unit in scene.units.values())


def before(start: Start) -> list[Finding]:
    """Which fidelity every tow needs."""
    if not has_tow(start.scene):
        return []
    from towage.checks import towing

    return towing.before_run(start.scene)


def reads(scene: Scene) -> tuple[str, ...]:
    """Whatever is connected to an input of a unit of the kinds that tow, or of a towed body, and what a linear tow made of it."""
    kinds = {*UNITS, "towed_body"}
    ends = (text.rpartition(" -> ") for text in scene.connections)  # no input of these units has an arrow in its name
    units = ((source, scene.units.get(target.split(".")[0])) for source, _, target in ends)
    driven = [source for source, unit in units if unit and Path(unit.fmu).stem in kinds]
    wholes = [name for name, unit in scene.units.items() if Path(unit.fmu).stem == WHOLE]
    return (*driven, *(f"{name}.{output}" for name in wholes for output in OWN))


def after(run: Finished) -> list[Finding]:
    """The error of every linear tow, as its margin; whether one degree of freedom on a spring EA/L stands for every tow."""
    if not has_tow(run.scene):
        return []
    from towage.checks import linearity, towing

    return [*linearity.judge(run), *towing.after_run(run.scene)]


CHECK = Check(
    name="towing",
    description="Which model does a tow need, how far is a linear one off, and would a spring do?",
    reads=reads,
    before=before,
    after=after,
    summary=lambda result: told(result, SPRING),
)
