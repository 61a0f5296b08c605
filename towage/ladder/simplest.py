"""`simplest`: the ladder of a scene, every rung run, and the cheapest that is enough.

    ladder = towage.simplest("sea_cliff", "8 s wave")
    ladder.enough.name, ladder.enough.error

A rung is a level of every axis that the scene has (`axis`). All are run, each in a process of its own, and compared with the
fullest that ran. Enough is a rung whose largest error is within the tolerance; of those whose cost is within `EQUAL` of the
least the one that leaves most out is taken. Cost: processor time of initialisation and run, without any comparison.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from msgspec import structs

from towage.api import NOTHING
from towage.checks.signals import Difference
from towage.errors import RunError, TowageError
from towage.ladder.axis import Seen, Trial
from towage.ladder.measure import Asked, asked, bare, coarse, differences, moves, of_both, track, worst
from towage.ladder.rungs import Rung, axes_of, rungs_of
from towage.master.stages import Report
from towage.process.worker import run_isolated
from towage.result.result import Result
from towage.scene.flavour import Flavour, resolve
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import one_case
from towage.units.store import locator

EQUAL = 1.5
"""Costs closer than this factor are equal: on a busy machine the processor times of one run differ by as much."""

@dataclass(frozen=True)
class Ladder:
    """The rungs of one case, the fullest last. ``fullest`` is the one that errors are against; ``own_error``: how much it
    changes itself with doubled step, or tenfold tolerance. ``enough``: the rung recommended, None with a ``note`` that says
    why. ``absent``: question to why it is none for this scene. ``signals``: what was compared, from ``settle``, s, on."""

    title: str
    case: str
    tolerance: float
    signals: tuple[str, ...]
    settle: float
    rungs: tuple[Rung, ...]
    fullest: Rung
    own_error: float
    enough: Rung | None
    note: str
    absent: Mapping[str, str]


@dataclass(frozen=True)
class _Way:
    """How scenes are run here."""

    fmus: Path | None
    flavour: Flavour
    timeout: float
    report: Report | None

    def run(self, scene: Scene, label: str, place: tuple[int, int]) -> Result:
        """The run of a `bare` scene. Raises `TowageError` where it fails."""
        done, total = place

        def hear(share: float, text: str) -> None:
            """Progress of one rung as progress of all."""
            if self.report:
                self.report((done + share) / total, label)

        result = run_isolated(resolve(scene, self.fmus, self.flavour), hear, self.timeout)
        if result.status == "failed":
            raise RunError(result.message)
        return result


def simplest(
    scene: Scene | str | Path,
    case: str | None = None,
    *,
    set: Mapping[str, Any] = NOTHING,
    tolerance: float | None = None,
    fmus: str | Path | None = None,
    flavour: Flavour = "auto",
    timeout: float = math.inf,
    report: Report | None = None,
) -> Ladder:
    """The ladder of a case of a scene. ``tolerance``: relative; by default that of the checks of the scene, else 5 %. The other
    arguments are those of `towage.run`; ``timeout``, s, is one of every rung.

    A rung that cannot be made, or fails, says why. Raises `SceneError` for a scene that is refused, or has neither motion nor
    tension, and `RunError` where the scene itself fails.
    """
    chosen = one_case(scene, case, set)
    if tolerance is not None and not 0.0 < tolerance < math.inf:
        raise chosen.error(f"{tolerance} is out of range: expected a finite number above 0", "tolerance")
    if chosen.transformations:
        text = "what these connections become in a simpler scene is not known: the ladder is for scenes without"
        raise chosen.error(text, "transformations")
    way = _Way(None if fmus is None else Path(fmus), flavour, timeout, report)
    locate = locator(way.fmus)
    resolved = described(chosen, locate)  # a scene that is refused is refused before anything runs
    given = way.run(bare(chosen), "the scene as it is", (0, 8))
    question = asked(resolved, given, tolerance)
    base = Trial(chosen, {name: name for name in question.signals}, Seen(track(given), question.settle), locate)
    return _climbed(way, base, given, question)


def _climbed(way: _Way, base: Trial, given: Result, question: Asked) -> Ladder:
    """Every rung run, compared, and one recommended."""
    axes, absent = axes_of(base)
    rungs = rungs_of(base, axes)
    known = [(bare(base.scene), given)]
    total = sum(rung.trial is not None for rung in rungs) + 2
    runs: dict[int, Result] = {}
    for k, rung in enumerate(rungs):
        if not rung.trial:
            continue
        scene = bare(rung.trial.scene)
        try:
            same = next((result for other, result in known if _equal(other, scene)), None)
            runs[k] = same or way.run(scene, rung.name, (len(known), total))
        except TowageError as error:
            rungs[k] = replace(rung, reason=f"failed: {error}")
        else:
            rungs[k] = replace(rung, given=runs[k] is given, cost=cost_of(runs[k]))
            known.append((scene, runs[k]))
    top = max(runs)
    full = runs[top], _trial(rungs[top])
    for k, result in runs.items():
        errors = _errors(question, full, (result, _trial(rungs[k])))
        rungs[k] = replace(rungs[k], errors=errors, ratio=rungs[k].cost / rungs[top].cost)
    own = _own_error(way, question, full, (total - 1, total))
    enough, note = recommended(rungs, question.tolerance, own, moves(question, track(given)))
    return Ladder(
        base.scene.title, base.scene.chosen, question.tolerance, question.signals, question.settle, tuple(rungs), rungs[top],
        own, enough, note, absent,
    )  # fmt: skip


def _trial(rung: Rung) -> Trial:
    """That of a rung that was run."""
    assert rung.trial
    return rung.trial


def _errors(question: Asked, full: tuple[Result, Trial], other: tuple[Result, Trial]) -> dict[str, Difference]:
    """Of a run against the fullest."""
    (one, name), (two, called) = full, other
    return differences(question, track(one), name.names, track(two), called.names)


def _equal(one: Scene, two: Scene) -> bool:
    """Whether two scenes run alike."""
    return (one.units, sorted(one.connections), one.coupling) == (two.units, sorted(two.connections), two.coupling)


def cost_of(result: Result) -> float:
    """Processor time of initialisation and run, s."""
    return result.statistics["start_cpu_s"] + result.statistics["cpu_s"]


def _own_error(way: _Way, question: Asked, full: tuple[Result, Trial], place: tuple[int, int]) -> float:
    """How much the fullest changes with doubled step, or tenfold tolerance; infinite where that run fails."""
    try:
        twice = way.run(coarse(bare(full[1].scene)), "the fullest with doubled step", place)
    except TowageError:
        return math.inf
    return worst(_errors(of_both(question, full[1].scene.coupling.step), full, (twice, full[1])))


def recommended(rungs: Sequence[Rung], tolerance: float, own: float, moving: bool) -> tuple[Rung | None, str]:
    """(the rung that is enough, why there is none). ``own``: how much the fullest changes with doubled step; ``moving``:
    whether anything does."""
    if not moving:
        return None, "nothing moves, so that no model can be told from another: give the scene a motion"
    if not own <= tolerance:
        return None, (
            f"not judged: with doubled step (tenfold tolerance) the fullest model itself changes by {100.0 * own:.3g} %: its "
            "motion is chaotic, or the step too long"
        )
    enough = [rung for rung in rungs if rung.errors and rung.error <= tolerance]
    least = min(rung.cost for rung in enough)
    return next(rung for rung in enough if rung.cost <= EQUAL * least), ""


def scene_of(ladder: Ladder, rung: Rung) -> Scene:
    """The scene of a rung, for a file of its own: its title and description say what it is. Raises ``ValueError`` for a rung
    that was not made."""
    if rung.trial is None:
        raise ValueError(f"{rung.name}: {rung.reason}")
    scene = rung.trial.scene
    case = f", {ladder.case}" if ladder.case else ""
    said = (
        f"{scene.description.strip()}\n\n{rung.name}: of the models of this scene the cheapest that is enough. It leaves out: "
        f"{'; '.join(rung.leaves_out) or 'nothing'}.\nIts largest error against {ladder.fullest.name} was "
        f"{100.0 * rung.error:.3g} %, the tolerance is {100.0 * ladder.tolerance:.3g} %.\n"
    )
    return structs.replace(scene, title=f"{ladder.title}{case}: {rung.name}", description=said.lstrip(), cases=(), source="")
