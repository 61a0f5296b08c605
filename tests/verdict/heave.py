"""Heave scenes drawn at random over the whole range of each parameter: ship, spring line, cradle.

| parameter | range |
|---|---|
| mass and stiffness ratio of body to ship | 1e-4 .. 1, log-uniform |
| damping ratio of the ship | 5e-3 .. 0.2, log-uniform |
| drag B = b X0/m2 | 1e-2 .. 10, log-uniform |
| frequency of the sea over that of the body on its line | 0.2 .. 3, uniform |
| weight W/(K2 X0) | 30 .. 3000; in four fifths of every second scene 0.2 .. 3, where the line goes slack |
| sea | a half regular, a quarter of two frequencies, a quarter irregular |

The body has 10 t and a natural frequency of 1 rad/s, which loses nothing: the equations have no other scale, and so the
amplitude may be chosen such that the weight in water stays below 0.9 m g.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from tests.verdict import sea_unit
from tests.verdict.family import Family, Truth
from tests.verdict.truth import Pair, truth
from towage.models.sea import waves
from towage.result.result import Result
from towage.scene.scene import Scene
from towage.units.store import cache

MASS, FREQUENCY = 10e3, 1.0
STEPS = 24
"""Communication steps a period of wave or body, the shorter."""
TOLERANCE = 0.05

class Drawn(NamedTuple):
    """A scene by its numbers; ``settle`` and ``stop``, s; ``sea``: regular, two frequencies or irregular; ``omega``: of the wave,
    or the middle of the sea, rad/s."""

    pair: Pair
    settle: float
    stop: float
    sea: str
    omega: float


def draw(seed: int, index: int) -> Drawn:
    """The scene ``index`` of the run that ``seed`` begins."""
    rng = np.random.default_rng((seed, index))

    def log(low: float, high: float) -> float:
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    mass_ratio, stiffness_ratio, damping, drag = log(1e-4, 1.0), log(1e-4, 1.0), log(5e-3, 0.2), log(1e-2, 10.0)
    omega = rng.uniform(0.2, 3.0) * FREQUENCY
    slack = index % 2 == 1 and rng.uniform() < 0.8
    weight = rng.uniform(0.2, 3.0) if slack else log(30.0, 3000.0)
    sea = str(rng.choice(["regular", "regular", "two frequencies", "irregular"]))
    size = min(1.0, 0.9 * waves.GRAVITY / (weight * FREQUENCY**2))
    stiffness, ship_mass = MASS * FREQUENCY**2, MASS / mass_ratio
    ship_stiffness = stiffness / stiffness_ratio
    fixed = (
        ship_mass, 2.0 * damping * math.sqrt(ship_stiffness * ship_mass), ship_stiffness, MASS, drag * MASS / size, stiffness,
        weight * stiffness * size,
    )  # fmt: skip
    period = 2.0 * math.pi / omega
    if sea == "regular":
        pair = Pair(*fixed, 0.0, (size,), (omega,), (-0.5 * math.pi,), period)
        periods = rng.uniform(60.0, 120.0) if slack else 60.0  # chaos has statistics from 40 periods after settling on
        return Drawn(pair, 30.0 * period, periods * period, sea, omega)
    if sea == "irregular":  # the narrow band of a swell or the broad one of a wind sea
        width = rng.uniform(0.05, 0.3)
        frequency = omega * np.sort(np.clip(rng.normal(1.0, width, sea_unit.COUNT), 0.4, 2.0))
        amplitude = np.full(sea_unit.COUNT, size / math.sqrt(sea_unit.COUNT))
    else:
        frequency = omega * np.array([1.0, rng.uniform(0.4, 2.5)])
        share = rng.uniform(0.1, 0.9)
        amplitude = size * np.sqrt([share, 1.0 - share])
    phase = rng.uniform(0.0, 2.0 * math.pi, len(frequency))
    rows = (tuple(row.tolist()) for row in (amplitude, frequency, phase))
    return Drawn(Pair(*fixed, 2.0 * period, *rows, 0.0), 15.0 * period, rng.uniform(75.0, 105.0) * period, sea, omega)


@functools.cache
def waves_fmu() -> str:
    """The FMU of `sea_unit`, built once for this process."""
    return str(sea_unit.build(cache() / "tests"))


def scene(drawn: Drawn) -> Scene:
    """The drawn scene, coupled as a user would who resolves wave and body with 24 steps."""
    p = drawn.pair
    parameters = {"mass": p.ship_mass, "damping": p.ship_damping, "stiffness": p.ship_stiffness, "ramp_time": p.ramp}
    if drawn.sea == "regular":
        fmu, sea = "ship", {"heave_amplitude": p.size, "heave_period": p.period}
    else:
        fmu, sea = waves_fmu(), sea_unit.values(*zip(p.amplitude, p.frequency, p.phase))
    body = {
        "mass": p.mass, "weight_in_water": p.weight, "water_density": 1000.0, "drag_area": 2.0 * p.drag / 1000.0,
        "critical_reynolds": 0.0,
    }  # fmt: skip
    margins = ["line.margin_taut", *(["ship.margin_sdof"] if fmu == "ship" else [])]
    back = "line.reaction -> ship.reaction"
    return Scene.from_dict(
        {
            "title": "drawn",
            "stop_time": drawn.stop,
            "connections": [
                "ship.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension", back,
            ],
            "units": {
                "ship": {"fmu": fmu, "parameters": {**parameters, **sea}},
                "line": {"fmu": "spring_line", "parameters": {"stiffness": p.stiffness, "static_tension": p.weight}},
                "cradle": {"fmu": "cradle", "parameters": body},
            },
            "coupling": {"step": 2.0 * math.pi / max(*p.frequency, FREQUENCY) / STEPS},
            "checks": {
                "report_only": margins,
                "sdof": {
                    "cut": [back], "driver": "ship.heave", "motion": "cradle.heave", "tension": "line.tension",
                    "tolerance": TOLERANCE, "settle": drawn.settle,
                },
            },
        }
    )  # fmt: skip


def true(drawn: Drawn, result: Result) -> Truth:
    """The truth of the drawn scene, whatever its run says."""
    return truth(drawn.pair, drawn.settle, drawn.stop)


def kind(drawn: Drawn) -> str:
    """What is counted apart."""
    slack = "slack" if drawn.pair.weight < 4.0 * drawn.pair.stiffness * drawn.pair.size else "taut"
    return f"{slack}, {drawn.sea}"


FAMILY = Family("heave", TOLERANCE, draw, scene, true, kind)
