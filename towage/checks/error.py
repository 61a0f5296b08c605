"""The coupling error: the run against one with doubled step (tenfold tolerance), at the solver's own points.

The estimate is the largest difference relative to the variable's largest value, over 2^p - 1 where the step is fixed and the
scheme of order p (Richardson; p = 1 where a unit of another make takes part, whose order nobody knows), for every recorded
variable but margins, whether it feeds a connection or not.

The word takes another measure, that of the comparisons it guards: the rms of the estimated error over the standard deviation
of the signal, from the settling time of the SDOF check on, for the signals that the checks judge; without such a check for all
recorded motions and forces. Beyond the tolerance nothing is judged, beyond a fifth of it the word is marginal at best, and so
it is where the scene does without the estimate, for nobody knows then.
Richardson's estimate is asymptotic, and no bound.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from towage.checks.check import Check, Finished
from towage.checks.verdict import NUMERICS
from towage.errors import RunError
from towage.result.records import Finding, Item, Word
from towage.scene.parts import Variant
from towage.scene.scene import Scene
from towage.units.conventions import has, indicators

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from towage.result.result import Result
    from towage.scene.resolve import ResolvedScene

    Array = NDArray[np.float64]

RUN = "error estimate"
DEFAULT_TOLERANCE = 0.05
"""Of the word where no check sets one."""
SHARE = 0.2
"""Share of the tolerance beyond which the word is marginal at best."""
FEWEST = 2
"""Points from which an error is told."""
AT_REST = 1e-9
"""Standard deviation over the largest value of a signal that does not move but for rounding."""


def variants(scene: Scene) -> list[Variant]:
    """The same run with longer steps, unless the scene does without the estimate."""
    return [Variant(RUN, None, coarse=True)] if scene.coupling.error_estimate else []


def after(run: Finished) -> list[Finding]:
    """Sets the result's ``coupling_error``; the finding that the word is taken from."""
    import numpy as np

    from towage.checks.track import comparison_times

    section = run.scene.scene.checks.get("sdof")
    tolerance = section.tolerance if section else DEFAULT_TOLERANCE
    if not run.scene.scene.coupling.error_estimate:
        message = "the coupling error is not estimated: coupling.error_estimate = false"
        return [Finding(NUMERICS, "info", None, tolerance, message, "set coupling.error_estimate = true")]
    try:
        coarse = run.track_of(RUN)
    except RunError as error:
        message = f"the coupling error could not be estimated, the run with longer steps failed: {error}"
        return [Finding(NUMERICS, "warning", None, tolerance, message, "take a shorter step")]
    times = run.times if run.step is None else comparison_times(float(run.times[-1]), 2.0 * run.step)
    share = 1.0 / (2.0**run.order - 1.0) if run.order else 1.0
    errors: dict[str, Array] = {}
    values: dict[str, Array] = {}
    decide = [section.motion, section.tension] if section else []
    for name in dict.fromkeys([*judged_names(run.scene, run.result.columns), *decide]):
        values[name] = run.track.at(name, times)
        errors[name] = share * (values[name] - coarse.at(name, times))
        if name in run.result.columns and (scale := float(np.max(np.abs(values[name]), initial=0.0))):
            run.result.coupling_error[name] = float(np.max(np.abs(errors[name]))) / scale
    settled = times >= (section.settle if section else 0.0)
    if settled.sum() < FEWEST:
        message = "the coupling error cannot be told: fewer than two points that both runs have lie after settling"
        return [Finding(NUMERICS, "warning", None, tolerance, message, "a longer run, or a shorter step")]
    shares = {name: _share(values, errors, name, settled) for name in decide or values}
    if not shares:
        return [Finding(NUMERICS, "warning", None, tolerance, "nothing is recorded of which the error could be told")]
    return [_finding(run, max(shares, key=shares.__getitem__), shares, tolerance)]


def judged_names(resolved: ResolvedScene, columns: Iterable[str]) -> list[str]:
    """Those of ``columns`` that have an error: smooth ones, no margins, which guard, and no event functions."""
    judged = []
    for column in columns:
        unit, _, name = column.partition(".")
        description = resolved.units[unit].description
        variable = description.by_name()[name]
        smooth = variable.type == "Real" and variable.variability == "continuous"
        guards = (name.startswith("margin_") and has(description, name)) or name in indicators(description)
        judged += [column] if smooth and not guards else []
    return judged


def _share(values: Mapping[str, Array], errors: Mapping[str, Array], name: str, settled: NDArray[np.bool_]) -> float:
    """rms of the error over the standard deviation; zero for a signal at rest."""
    import numpy as np

    signal, error = values[name][settled], errors[name][settled]
    if not len(signal) or (spread := float(signal.std())) <= AT_REST * float(np.max(np.abs(signal))):
        return 0.0
    return float(np.sqrt(np.mean(error**2))) / spread


def _finding(run: Finished, name: str, shares: Mapping[str, float], tolerance: float) -> Finding:
    """Level and remedy of the largest share."""
    share, wanted = shares[name], SHARE * tolerance
    message = f"estimated coupling error of {name}, rms over its standard deviation"
    if share <= wanted:
        return Finding(NUMERICS, "ok", share, tolerance, message)
    if run.step is not None and run.order:
        remedy = f"step <= {run.step * (wanted / share) ** (1.0 / run.order):.2g} s"
    else:
        remedy = "a tighter coupling.tolerance" if run.step is None else "a shorter step"
    return Finding(NUMERICS, "warning", share, tolerance, message, remedy)


def item(result: Result) -> Item | None:
    """What the finding says to the verdict. In chaos trajectories part whatever the error: statistics decide there."""
    finding = next((finding for finding in result.checks if finding.name == NUMERICS), None)
    if finding is None:
        return None
    value, limit = finding.value, finding.limit
    chaotic = bool(result.comparison and result.comparison.chaotic)
    if value is None:
        word: Word = "marginal" if finding.level == "info" else "not judged"
        return Item(word, finding.message, None, limit, None, finding.remedy, NUMERICS)
    assert limit is not None
    if chaotic:
        reason = f"{finding.message}: of chaos it tells nothing, its statistics decide"
        return Item("not judged", reason, value, limit, None, "", NUMERICS, decides=False)
    word = "valid" if value <= SHARE * limit else "marginal" if value <= limit else "not judged"
    shown = SHARE * limit if word == "marginal" else limit
    return Item(word, finding.message, value, shown, None, finding.remedy, NUMERICS)


CHECK = Check(
    name="error",
    description="How large is the error that the coupling makes?",
    variants=variants,
    after=after,
    item=item,
)
