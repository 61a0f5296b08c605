"""The rungs of a scene: every combination of the levels that can be made of it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from towage.errors import TowageError
from towage.ladder.axis import Axis, Level, Trial, Unfit
from towage.ladder.measure import Errors, worst
from towage.registry import AXES


@dataclass(frozen=True)
class Rung:
    """A model of the scene. ``levels``: the level on every axis; ``leaves_out`` what it does not know; ``trial``: its scene;
    ``reason``: why it was not made or not run, else empty. ``errors`` against the fullest; ``cost``,
    processor time, s, ``ratio``, over that of the fullest. ``given``: it is the scene as it is."""

    levels: tuple[str, ...]
    leaves_out: tuple[str, ...]
    trial: Trial | None
    reason: str = ""
    given: bool = False
    errors: Errors | None = None
    cost: float = math.nan
    ratio: float = math.nan

    @property
    def name(self) -> str:
        """Its levels in words."""
        return ", ".join(self.levels) or "the scene as it is"

    @property
    def error(self) -> float:
        """The largest error; NaN where it was not run."""
        return worst(self.errors) if self.errors else math.nan


def axes_of(base: Trial) -> tuple[list[Axis], dict[str, str]]:
    """(the axes that a scene has, question to why it has not the others)."""
    every: list[Axis] = [AXES.get(name) for name in AXES.names()]
    absent = {axis.description: why for axis in every if (why := axis.lacks(base))}
    return [axis for axis in every if axis.description not in absent], absent


def rungs_of(base: Trial, axes: Sequence[Axis]) -> list[Rung]:
    """From the simplest to the fullest. A level that fits in no model of the scene is one rung that says why, and so is a
    combination that does not."""
    asked = [[level for level in axis.levels if level.asked(base)] for axis in axes]
    every = [(levels, _rung(base, levels)) for levels in itertools.product(*asked)]
    fit = {id(level) for levels, rung in every if rung.trial for level in levels}
    never = [level for levels in asked for level in levels if id(level) not in fit]
    unfit = []
    for level in never:
        alone = _rung(base, [level])
        reason = alone.reason or next(rung.reason for levels, rung in every if level in levels)
        unfit.append(replace(alone, trial=None, reason=reason))
    return unfit + [rung for levels, rung in every if rung.trial or not any(level in levels for level in never)]


def _rung(base: Trial, levels: Sequence[Level]) -> Rung:
    """The scene with these levels, or why there is none."""
    trial, reason = base, ""
    try:
        for level in levels:
            trial = level.make(trial)
        trial.resolved  # noqa: B018 - refuses what does not fit
    except (Unfit, TowageError) as error:
        reason = str(error.args[0])
    out = tuple(level.leaves_out for level in levels if level.leaves_out)
    return Rung(tuple(level.name for level in levels), out, None if reason else trial, reason)
