"""``towage vet``: every trial in a process of its own, what they found, and the settings that follow.

What was found is kept in the cache under the digest of the FMU (`towage.units.vetted`), where the master reads it.
"""

from __future__ import annotations

import math
import pickle
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from towage.process.child import Died, attend, converse
from towage.report.format import page, table
from towage.units import vetted
from towage.units.archive import check_platform, read_description
from towage.units.doubt import THEREFORE, What
from towage.units.vetted import LIMITS
from towage.vet.bench import Trial
from towage.vet.trials import TRIALS, tried

GRAVITY = ("ok", "note", "warning", "fault")
WORDS = {"ok": "sound", "note": "sound", "warning": "to be used with care", "fault": "faulty"}
ONE_SIZE = "communication steps of one size only"
NO_CONTROL = "no tolerance: the error control takes steps back, which this unit cannot"
TIMEOUT = 120.0
"""Longest silence of a trial, s."""


class Vetted(NamedTuple):
    """The trials of an FMU and the word that they come to: sound, to be used with care, faulty."""

    path: Path
    word: str
    trials: tuple[Trial, ...]

    def settings(self) -> str:
        """The settings that a scene should use, as TOML."""
        description = read_description(self.path)
        against = [LIMITS[t.name] for t in self.trials if t.level in ("warning", "fault") and t.name in LIMITS]
        stays = "state" in against or not description.can_get_set_state
        found: list[What] = [*against, "state"] if stays else against
        heeded = [] if description.conventions else [*dict.fromkeys(found)]
        lines = [f"# scheme auto heeds this by itself, for this unit alone: {THEREFORE[what]}" for what in heeded]
        fixed = not description.can_handle_variable_step
        if why := ONE_SIZE if fixed else NO_CONTROL if stays else "":
            size = description.default_experiment.step_size
            lines += ["[coupling]", f"step = {size!r}  # {why}" if size else f"# step = ..., its description names none: {why}"]
        return "\n".join(lines or ["# no settings beside those that a scene has"]) + "\n"

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return {"file": str(self.path), "word": self.word, "trials": [trial._asdict() for trial in self.trials],
                "settings": self.settings()}  # fmt: skip

    def html(self) -> str:
        """As a page."""
        rows = [(trial.name, trial.level, trial.message) for trial in self.trials]
        found = table(("Trial", "Level", "Found"), rows)
        body = f"<section>{found}</section><section><h2>Settings</h2><pre>{escape(self.settings())}</pre></section>"
        return page(self.path.name, f"Vetted: {self.word}", body, "vetted")


def vet(path: Path, timeout: float = TIMEOUT) -> Vetted:
    """Try an FMU. Raises `FmuError` for a file that is none, or that this platform cannot load."""
    check_platform(read_description(path))
    trials: list[Trial] = []
    for name in TRIALS:
        try:
            answer = converse(__name__, pickle.dumps((name, path)), None, timeout)
            trials += [Trial(*each) for each in answer["trials"]]
        except Died as death:
            last = f"; the last it printed: {death.printed}" if death.printed else ""
            trials.append(Trial(name, "fault", f"{death}{last}"))
    gravest = max((trial.level for trial in trials), key=GRAVITY.index)
    made = Vetted(path, WORDS[gravest], tuple(trials))
    vetted.write(path, made.document())
    return made


def main() -> None:
    """The child: one trial."""
    requests, say = attend()
    name, path = pickle.load(requests)
    found = [trial._replace(value=_finite(trial.value)) for trial in tried(name, path)]
    say({"trials": [list(trial) for trial in found]})


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
