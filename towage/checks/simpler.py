"""Is a simpler model of a unit enough for this scene? A rigid slender body for a flexible one, in the first place.

The scene is run a second time with the values of ``checks.simpler`` (``body.flexible`` = 0: two pairs of states, no flexural
mode), and its motions are compared with those of the full run; the words are those of the SDOF check:

| word | meaning |
|---|---|
| valid | swing and rms difference of every motion within the tolerance e, and the simpler model trusts itself |
| marginal | differences within e, but the ``margin`` of the simpler run is negative: another scene may break it |
| invalid | a difference exceeds e: what the simpler model leaves out matters |

Differences are relative to the full run: (swing simpler/swing full - 1), swing = largest - smallest value, and
rms(simpler - full)/rms(full - mean). The word judges the simpler model, not the run, whose verdict it leaves alone.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from towage.checks.verdict import peak
from towage.result.result import Check
from towage.scene.scene import SimplerCheck

Array = NDArray[np.float64]


def differences(full: Array, simpler: Array) -> tuple[float, float]:
    """(swing, rms) difference of two motions at the same times; infinite where only one of them moves."""
    swing, spread = peak(full) + peak(-full), float(np.std(full))
    if not swing > 0.0:
        return (0.0, 0.0) if np.array_equal(full, simpler) else (math.inf, math.inf)
    rms = math.sqrt(float(np.mean((simpler - full) ** 2)))
    return (peak(simpler) + peak(-simpler)) / swing - 1.0, rms / spread


def compare(
    check: SimplerCheck, time: Array, full: dict[str, Array], simpler_time: Array, simpler: dict[str, Array]
) -> Check:
    """The finding, with the largest difference and the tolerance. Times are matched; a simpler run that ended early
    counts as invalid."""
    _, here, there = np.intersect1d(np.round(time, 9), np.round(simpler_time, 9), return_indices=True)
    keep = time[here] >= check.settle
    here, there = here[keep], there[keep]
    change = ", ".join(f"{key} = {value}" for key, value in check.set.items())
    if len(here) < 2 or simpler_time[-1] < time[-1] - 1e-9:
        return Check("simpler model", "info", None, check.tolerance, f"invalid: with {change} the run ended early")
    worst, what = 0.0, "nothing moves"
    for name in check.motions:
        swing, rms = differences(full[name][here], simpler[name][there])
        for size, kind in ((abs(swing), "swing"), (rms, "rms")):
            if not size <= worst:
                worst, what = size, f"{kind} difference of {name} is {100.0 * size:.3g} %"
    trust = float(np.min(simpler[check.margin])) if check.margin else 1.0
    word = "invalid" if not worst <= check.tolerance else "marginal" if trust < 0.0 else "valid"
    own = f"; its {check.margin} falls to {trust:.3g}" if check.margin else ""
    return Check(
        "simpler model", "ok" if word == "valid" else "info", worst, check.tolerance,
        f"{word}: with {change} the largest difference is: {what}{own}",
    )  # fmt: skip
