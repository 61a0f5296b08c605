"""Check `sinkage`: does a motion stay above a depth?"""

from collections.abc import Sequence

import msgspec

from towage.checks.check import Check, Finished
from towage.result.records import Finding
from towage.scene.scene import Scene


class Sinkage(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks.sinkage]``: the motion and its lowest value allowed, m."""

    motion: str
    lowest: float


def _after(run: Finished) -> Sequence[Finding]:
    scene: Scene = run.scene.scene
    section = scene.checks.sections["sinkage"]
    lowest = float(run.columns[section.motion].min())
    level = "ok" if lowest >= section.lowest else "warning"
    return [Finding("sinkage", level, lowest, section.lowest, f"{section.motion} goes down to {lowest:.3g} m")]


SINKAGE = Check(name="sinkage", description="Does the motion stay above a depth?", section=Sinkage, after=_after)
