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
from towage.checks.statistics import deciding, longer
from towage.errors import RunError, TowageError
from towage.ladder.axis import Seen, Trial
from towage.ladder.measure import (
    Asked,
    Errors,
    Shown,
    asked,
    bare,
    coarse,
    errors,
    known_to_all,
    lacks,
    moves,
    of_both,
    track,
    word,
    worst,
)
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
    why. ``absent``: question to why it is none for this scene. ``signals``: what was compared, from ``settle``, s, on, by their
    statistics where it is ``statistical``."""

    title: str
    case: str
    tolerance: float
    signals: tuple[str, ...]
    settle: float
    statistical: bool
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
    base = Trial(chosen, {name: name for name in given.columns}, Seen(track(given), question.settle), locate)
    return _climbed(way, base, given, question)


def _climbed(way: _Way, base: Trial, given: Result, question: Asked) -> Ladder:
    """Every rung run, compared, and one recommended."""
    axes, absent = axes_of(base)
    rungs = rungs_of(base, axes)
    shared = known_to_all(question, [rung.trial for rung in rungs if rung.trial])
    if question.named or not shared.signals:
        rungs = [_comparable(rung, question) for rung in rungs]
    else:
        question = shared
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
    full = _shown(runs[top], rungs[top])
    question, own = _certain(way, question, full, (total - 1, total))
    for k, result in runs.items():
        found = errors(question, full, _shown(result, rungs[k]))
        rungs[k] = replace(rungs[k], errors=found, ratio=rungs[k].cost / rungs[top].cost)
    enough, note = recommended(rungs, question, own, moves(question, track(given)))
    return Ladder(
        base.scene.title, base.scene.chosen, question.tolerance, question.signals, question.settle, question.statistical,
        tuple(rungs), rungs[top], worst(own) if own else math.inf, enough, note, absent,
    )  # fmt: skip


def _comparable(rung: Rung, question: Asked) -> Rung:
    """Without its trial where that does not know all that is compared."""
    if rung.trial and (unknown := [name for name in question.signals if lacks(rung.trial, name)]):
        return replace(rung, trial=None, reason=f"it does not know {unknown[0]}, which is compared")
    return rung


def _shown(result: Result, rung: Rung) -> Shown:
    """The run of a rung that was made."""
    assert rung.trial
    return Shown(track(result), rung.trial)


def _equal(one: Scene, two: Scene) -> bool:
    """Whether two scenes run alike."""
    return (one.units, sorted(one.connections), one.coupling) == (two.units, sorted(two.connections), two.coupling)


def cost_of(result: Result) -> float:
    """Processor time of initialisation and run, s."""
    return result.statistics["start_cpu_s"] + result.statistics["cpu_s"]


def _certain(way: _Way, question: Asked, full: Shown, place: tuple[int, int]) -> tuple[Asked, Errors | None]:
    """How much the fullest changes with doubled step, or tenfold tolerance, None where that run fails. Where the motions part,
    chaos is one reason: the question is then for the statistics, which a step that is too long changes too."""
    scene = full.trial.scene
    try:
        twice = Shown(track(way.run(coarse(bare(scene)), "the fullest with doubled step", place)), full.trial)
    except TowageError:
        return question, None
    own = errors(of_both(question, scene.coupling.step), full, twice)
    if question.statistical or worst(own) <= question.tolerance:
        return question, own
    question = question._replace(statistical=True)
    return question, errors(of_both(question, scene.coupling.step), full, twice)


def recommended(rungs: Sequence[Rung], question: Asked, own: Errors | None, moving: bool) -> tuple[Rung | None, str]:
    """(the rung that is enough, why there is none). ``own``: how much the fullest changes with doubled step; ``moving``:
    whether anything does."""
    if not moving:
        return None, "nothing moves, so that no model can be told from another: give the scene a motion"
    tolerance = question.tolerance
    if own is None:
        return None, "not judged: the fullest model fails with doubled step (tenfold tolerance)"
    if word(own, tolerance) != "valid":
        name, statistic = deciding(own, tolerance)
        wide = statistic.half_width > 0.0
        more = longer(statistic, tolerance, float(question.times[-1])) if wide else "take a shorter step"
        return None, (
            f"not judged: with doubled step (tenfold tolerance) the {name} of the fullest model itself changes by "
            f"{100.0 * statistic.error:.3g} %{f' +- {100.0 * statistic.half_width:.3g} %' if wide else ''}: {more}"
        )
    enough = [rung for rung in rungs if rung.errors and word(rung.errors, tolerance) == "valid"]
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
