"""The axes of what drives: a regular wave for an irregular sea, and one way for both.

A regular wave in place of a sea has its variance and its mean period: a = sqrt(2) s, T = 2 pi s/s', s and s' the standard
deviations of the free heave, m, and of its rate, m/s, in the run of the scene.
"""

from __future__ import annotations

import math
from dataclasses import replace

from msgspec import structs

from towage.ladder.axis import Axis, Level, Trial, Unfit, ends, entry

SEA_INPUTS = ("wave_height", "wave_period", "wave_direction", "speed")
OSCILLATOR = ("ramp_time", "mass", "damping", "stiffness", "sdof_tolerance")


def _calm(trial: Trial) -> str:
    return "" if trial.units("ship_in_sea") else "no ship_in_sea drives it"


def regular(trial: Trial) -> Trial:
    """Every ship in an irregular sea as one in a regular wave; units that told her of the sea go."""
    units, connections = dict(trial.scene.units), list(trial.scene.connections)
    for ship in trial.units("ship_in_sea"):
        spread, speed = trial.seen.spread(f"{ship.name}.free_heave")
        if not (spread and speed):
            raise Unfit(f"{ship.name} does not move in the run of the scene, so that no regular wave stands for its sea")
        given = trial.scene.units[ship.name].parameters
        oscillator = {name: given[name] for name in OSCILLATOR if name in given}
        wave = {"heave_amplitude": math.sqrt(2.0) * spread, "heave_period": 2.0 * math.pi * spread / speed}
        units[ship.name] = entry("ship", oscillator | wave)
        connections = [c for c in connections if ends(c)[1] not in {f"{ship.name}.{name}" for name in SEA_INPUTS}]
    used = {end.partition(".")[0] for connection in connections for end in ends(connection)}
    before = {end.partition(".")[0] for connection in trial.scene.connections for end in ends(connection)}
    kept = {name: unit for name, unit in units.items() if name in used or name not in before}
    scene = structs.replace(trial.scene, units=kept, connections=tuple(connections))
    gone = [name for name in trial.scene.checks.report_only if name.endswith(("margin_froude", "margin_slow_sea"))]
    rest = tuple(name for name in scene.checks.report_only if name not in gone)
    return replace(trial, scene=structs.replace(scene, checks=structs.replace(scene.checks, report_only=rest)))


def back(trial: Trial) -> list[str]:
    """Connections back to what drives: those that the SDOF check cuts, or else those into inputs that mean one way where
    they are open."""
    if section := trial.scene.checks.get("sdof"):
        return list(section.cut)
    variables = {name: unit.description.by_name() for name, unit in trial.resolved.units.items()}
    return [
        str(c) for c in trial.resolved.connections if variables[c.target_unit][c.target].unset.startswith("one way")
    ]


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
