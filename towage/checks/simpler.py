"""Is a simpler model of a unit enough for this scene? A rigid slender body for a flexible one, in the first place.

The scene is run a second time with the values of ``checks.simpler`` (``body.flexible`` = 0: two pairs of states, no flexural
mode), and its motions are compared with those of the full run:

| word | meaning |
|---|---|
| enough | swing and rms difference of every motion within the tolerance e, and the simpler model trusts itself |
| barely enough | differences within e, but the ``margin`` of the simpler run is negative: another scene may break it |
| not enough | a difference exceeds e: what the simpler model leaves out matters |

Differences are relative to the full run: (swing simpler/swing full - 1), swing = largest - smallest value, and
rms(simpler - full)/rms(full - mean). The words are of the simpler model and none of the run's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from towage.checks.check import Check, Finished, told, window
from towage.errors import RunError
from towage.result.records import Finding, Item, Word
from towage.scene.parts import Seconds, Variant
from towage.scene.scene import Scene

if TYPE_CHECKING:
    from towage.checks.signals import Array
    from towage.checks.track import Track
    from towage.result.result import Result
    from towage.scene.resolve import ResolvedScene
    from towage.scene.values import Names

RUN = "simpler model"
SAME_TIME = 1e-9
"""Times closer than this, s, are one."""


class SimplerCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[checks.simpler]``: the run is repeated with the values ``set``, which make a model simpler, and ``motions`` are
    compared from ``settle``, s, on. ``margin`` of the simpler run tells what the simpler model says of itself."""

    set: dict[str, Any]
    motions: tuple[str, ...]
    margin: str | None = None
    tolerance: float = 0.05
    settle: Seconds = 0.0


def read(scene: Scene, section: SimplerCheck) -> SimplerCheck:
    """Refuses values that cannot be set. Raises `SceneError`."""
    window(scene, "simpler", section.tolerance, section.settle)
    _simpler(scene, section)
    return section


def _simpler(scene: Scene, section: SimplerCheck) -> Scene:
    """The scene with the simpler model."""
    return scene.without_comparisons().setting(section.set, "checks.simpler.set")


def fit(names: Names, section: SimplerCheck) -> None:
    """Refuses motions and a margin that are not recorded. Raises `SceneError`."""
    for k, motion in enumerate(section.motions):
        names.recorded(motion, f"checks.simpler.motions[{k}]")
    if section.margin:
        names.recorded(section.margin, "checks.simpler.margin")


def variants(scene: Scene) -> list[Variant]:
    """The run with the simpler model."""
    return [Variant(RUN, _simpler(scene, scene.checks.get("simpler")))]


def reads(scene: ResolvedScene) -> tuple[str, ...]:
    """What is compared."""
    section = scene.scene.checks.get("simpler")
    return (*section.motions, *((section.margin,) if section.margin else ()))


def after(run: Finished) -> list[Finding]:
    """The comparison with the simpler model; a warning where its run fails."""
    try:
        simpler = run.track_of(RUN)
    except RunError as error:
        return [Finding(RUN, "warning", None, None, f"failed: {error}")]
    return [compare(run.scene.scene.checks.get("simpler"), run.times, run.track, simpler)]


def compare(check: SimplerCheck, times: Array, full: Track, simpler: Track) -> Finding:
    """The finding, with the largest difference and the tolerance; a simpler run that ended early is not enough. ``times``,
    s: those of the whole run."""
    import numpy as np

    from towage.checks.signals import difference

    settled = times[times >= check.settle]
    change = ", ".join(f"{key} = {value}" for key, value in check.set.items())
    if len(settled) < 2 or simpler.time[-1] < full.time[-1] - SAME_TIME:
        return Finding(RUN, "info", None, check.tolerance, f"not enough: with {change} the run ended early")
    worst, what = 0.0, "nothing moves"
    for name in check.motions:
        off = difference(full.at(name, settled), simpler.at(name, settled))
        for size, kind in ((abs(off.amplitude), "swing"), (off.rms, "rms")):
            if worst == worst and not size <= worst:  # nothing is worse than no number
                worst, what = size, f"{kind} difference of {name} is {100.0 * size:.3g} %"
    trust = float(np.min(simpler.columns[check.margin])) if check.margin else 1.0
    word = "not enough" if not worst <= check.tolerance else "barely enough" if trust < 0.0 else "enough"
    own = f"; its {check.margin} falls to {trust:.3g}" if check.margin else ""
    message = f"{word}: with {change} the largest difference is: {what}{own}"
    return Finding(RUN, "ok" if word == "enough" else "info", worst, check.tolerance, message)


def item(result: Result) -> Item | None:
    """What the card shows of the simpler model; it does not decide on the run."""
    finding = next((finding for finding in result.checks if finding.name == RUN), None)
    if finding is None:
        return None
    judged = finding.value is not None or finding.limit is not None
    word: Word = "valid" if judged else "not judged"
    reason = f"a simpler model is {finding.message}"
    return Item(word, reason, finding.value, finding.limit, None, "", "simpler", decides=False)


CHECK = Check(
    name="simpler",
    description="Is a simpler model of a unit enough for this scene?",
    section=SimplerCheck,
    read=read,
    fit=fit,
    variants=variants,
    reads=reads,
    after=after,
    item=item,
    summary=lambda result: told(result, RUN),
)
