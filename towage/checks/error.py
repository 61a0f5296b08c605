"""The coupling error: the run against one with doubled step (tenfold tolerance), on the common times.

The estimate is the largest difference relative to the variable's largest value, over 2^p - 1 where the step is fixed and
the scheme of order p (Richardson), for every recorded variable that feeds a connection.
"""

from __future__ import annotations

from towage.checks.check import Check, Finished
from towage.errors import RunError
from towage.result.records import Finding
from towage.scene.parts import Variant
from towage.scene.scene import Scene

RUN = "error estimate"


def variants(scene: Scene) -> list[Variant]:
    """The same run with longer steps, unless the scene does without the estimate."""
    return [Variant(RUN, None, coarse=True)] if scene.coupling.error_estimate else []


def after(run: Finished) -> list[Finding]:
    """Sets the result's ``coupling_error``; nothing where the other run fails."""
    import numpy as np

    if not run.scene.scene.coupling.error_estimate:
        return []
    result = run.result
    try:
        coarse_time, coarse = run.again(RUN)
    except RunError:
        return []
    _, here, there = np.intersect1d(np.round(result.time, 9), np.round(coarse_time, 9), return_indices=True)
    share = 1.0 / (2.0**run.order - 1.0) if run.order else 1.0
    sources = {f"{c.source_unit}.{c.source}" for c in run.scene.connections}
    for name, values in result.columns.items():
        scale = float(np.max(np.abs(values), initial=0.0))
        if name in sources and scale:
            difference = float(np.max(np.abs(values[here] - coarse[name][there])))
            result.coupling_error[name] = share * difference / scale
    return []


CHECK = Check(
    name="error",
    description="How large is the error that the coupling makes?",
    variants=variants,
    after=after,
)
