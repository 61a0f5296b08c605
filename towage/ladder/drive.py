"""The axes of what drives: a regular wave for an irregular sea, and one way for both.

A regular wave in place of a sea has its variance and its mean period: a = sqrt(2) s, T = 2 pi s/s', s and s' the standard
deviations of the free heave, m, and of its rate, m/s, in the run of the scene.
"""

from __future__ import annotations

import math
from dataclasses import replace

from msgspec import structs

from towage.ladder.axis import Axis, Level, Trial, Unfit, entry

SEA_INPUTS = ("wave_height", "wave_period", "wave_direction", "speed")
OSCILLATOR = ("ramp_time", "mass", "damping", "stiffness", "sdof_tolerance")

OF_A_SEA = ("margin_froude", "margin_slow_sea", "margin_strip", "margin_response")
"""Margins of a ship in a sea that one in a regular wave has not."""


def _calm(trial: Trial) -> str:
    return "" if trial.units("ship_in_sea") else "no ship_in_sea drives it"


def regular(trial: Trial) -> Trial:
    """Every ship in an irregular sea as one in a regular wave; units that told her of the sea go."""
    units, wiring = dict(trial.scene.units), trial.wiring
    for ship in trial.units("ship_in_sea"):
        spread, speed = trial.seen.spread(f"{ship.name}.free_heave")
        if not (spread and speed):
            raise Unfit(f"{ship.name} does not move in the run of the scene, so that no regular wave stands for its sea")
        given = trial.scene.units[ship.name].parameters
        oscillator = {name: given[name] for name in OSCILLATOR if name in given}
        wave = {"heave_amplitude": math.sqrt(2.0) * spread, "heave_period": 2.0 * math.pi * spread / speed}
        units[ship.name] = entry("ship", oscillator | wave)
        wiring = [wire for wire in wiring if wire[2] not in {f"{ship.name}.{name}" for name in SEA_INPUTS}]
    used, before = ({end.partition(".")[0] for _, *ends in wires for end in ends} for wires in (wiring, trial.wiring))
    kept = {name: unit for name, unit in units.items() if name in used or name not in before}
    scene = structs.replace(trial.scene, units=kept, connections=tuple(text for text, *_ in wiring))
    gone = [name for name in trial.scene.checks.report_only if name.endswith(OF_A_SEA)]
    rest = tuple(name for name in scene.checks.report_only if name not in gone)
    return replace(trial, scene=structs.replace(scene, checks=structs.replace(scene.checks, report_only=rest)))


def back(trial: Trial) -> list[str]:
    """Connections back to what drives: those that the SDOF check cuts, or else those into inputs that mean one way where
    they are open."""
    if section := trial.scene.checks.get("sdof"):
        return list(section.cut)
    variables = {name: unit.description.by_name() for name, unit in trial.resolved.units.items()}
    return [
        text for (text, *_), c in zip(trial.wiring, trial.resolved.connections, strict=True)
        if variables[c.target_unit][c.target].unset.startswith("one way")
    ]  # fmt: skip


def _one_way_already(trial: Trial) -> str:
    return "" if back(trial) else "no connection goes back to what drives"


def one_way(trial: Trial) -> Trial:
    """Without the connections back."""
    return replace(trial, scene=trial.scene.without(back(trial)))


SEA = Axis(
    "sea", "Is the sea regular?", _calm,
    (Level("regular wave", "all but the variance and the mean period of the sea", regular), Level("irregular sea")),
)  # fmt: skip
WAYS = Axis(
    "ways", "Does what hangs or is towed move what drives it?", _one_way_already,
    (Level("one way", "what acts back on the driver", one_way), Level("two ways")),
)  # fmt: skip
