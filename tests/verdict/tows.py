"""Linear tows drawn at random over the whole range of each parameter, under a towpoint that moves as in a sea.

| parameter | range |
|---|---|
| length, speed of the tow | 50 .. 3000 m, 0.3 .. 8 m/s, log-uniform |
| mass, weight in water of the body | 30 .. 5000 kg, 0.2 .. 20 kN (at most 0.87 m g), log-uniform |
| cable | 6 .. 25 mm, 2500 .. 6500 kg/m3; a half bare, a fifth faired, the rest by the cross-flow principle |
| velocity of the towpoint over that of the tow | 0.02 .. 0.4, log-uniform; of an irregular sea its significant amplitude |
| frequency | 0.05 .. 0.3 Hz, log-uniform; heave, or surge too |
| sea | three fifths regular, the rest irregular: 16 components of a narrow band |

Tows that do not hang inside their quadrant, which the unit refuses, are drawn again.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from tests.verdict import sea_unit, tow_truth
from tests.verdict.family import Family, Truth
from tests.verdict.tow_truth import Sea
from towage.models.cable.case import Body, Cable, CableError, Tow
from towage.models.cable.loading import cross_flow, eames
from towage.models.cable.lumped.lumped import hanging
from towage.models.cable.parameters import CROSS_FLOW, EAMES
from towage.models.protocol.physical import GRAVITY
from towage.result.records import Margin
from towage.result.result import Result
from towage.scene.scene import Scene
from towage.units.store import cache

TOLERANCE = 0.05
DENSITY = 1025.0
STEPS = 24
"""Communication steps a period of the fastest component."""
RAMP, REGULAR, IRREGULAR = 4.0, 16.0, 32.0
"""Periods of the ramp, of a regular and of an irregular run."""
SURGE, HEAVE = 0, 1


class Drawn(NamedTuple):
    """A tow, ``form`` and ``friction`` of its loading, how its towpoint moves, and the end of the run, s."""

    tow: Tow
    form: int
    friction: float
    sea: Sea
    stop: float


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.random())


def draw(seed: int, index: int) -> Drawn:
    """The tow ``index`` of the run that ``seed`` begins."""
    rng = np.random.default_rng((seed, index))
    while True:
        tow, form, friction = _tow(rng)
        try:
            hanging(tow)
        except CableError:
            continue
        return Drawn(tow, form, friction, *_drive(rng, tow.speed))


def _tow(rng: np.random.Generator) -> tuple[Tow, int, float]:
    speed, mass, thickness = log_uniform(rng, 0.3, 8.0), log_uniform(rng, 30.0, 5000.0), log_uniform(rng, 0.006, 0.025)
    area, density = 0.25 * math.pi * thickness**2, log_uniform(rng, 2500.0, 6500.0)
    kind = rng.choice(["bare", "faired", "cross_flow"], p=[0.5, 0.2, 0.3])
    friction = log_uniform(rng, 0.02, 0.06) if kind != "faired" else 0.35
    form = CROSS_FLOW if kind == "cross_flow" else EAMES
    cable = Cable(
        log_uniform(rng, 50.0, 3000.0), density * area, (density - DENSITY) * GRAVITY * area, thickness,
        0.25 if kind == "faired" else log_uniform(rng, 1.0, 2.0), cross_flow(friction) if form == CROSS_FLOW else eames(friction),
        axial_stiffness=log_uniform(rng, 2e10, 8e10) * area,
    )  # fmt: skip
    weight = log_uniform(rng, 200.0, min(20e3, 0.87 * mass * GRAVITY))
    drag = 0.5 * DENSITY * speed**2 * log_uniform(rng, 0.1, 1.0) * (mass / 2000.0) ** (2.0 / 3.0)
    surge, heave = log_uniform(rng, 0.05, 0.3) * mass, log_uniform(rng, 0.1, 0.8) * mass
    body = Body(mass, surge, heave, weight, 0.0, drag, 2.0 * drag / speed, drag / speed)
    return Tow(cable, body, speed, DENSITY), form, friction


def _drive(rng: np.random.Generator, speed: float) -> tuple[Sea, float]:
    """One frequency, or sixteen of a narrow spectrum whose significant amplitude is that of the one; the end of the run."""
    velocity, middle = speed * log_uniform(rng, 0.02, 0.4), 2.0 * math.pi * log_uniform(rng, 0.05, 0.3)
    turn, period = rng.choice([0.0, 0.3, 1.2]) * math.pi / 2.0, 2.0 * math.pi / middle
    direction = np.array([math.sin(turn) * np.exp(1j * rng.random()), math.cos(turn)])
    if rng.random() < 0.6:
        return Sea(np.array([middle]), velocity / middle * direction[None, :], RAMP * period), REGULAR * period
    omega = middle * np.linspace(0.7, 1.5, sea_unit.COUNT)
    size = np.exp(-(((omega / middle - 1.0) / 0.2) ** 2))
    phases = np.exp(2j * math.pi * rng.random(len(omega)))
    amplitudes = (velocity / math.sqrt(2.0 * (size**2).sum()) * size * phases / omega)[:, None] * direction
    return Sea(omega, amplitudes, RAMP * period), IRREGULAR * period


@functools.cache
def waves_fmu() -> str:
    """The FMU of `sea_unit`, built once for this process."""
    return str(sea_unit.build(cache() / "tests"))


def _sea(drawn: Drawn, direction: int) -> dict[str, object]:
    """The unit that moves the towpoint."""
    x = drawn.sea.amplitudes[:, direction]
    values = sea_unit.values(*zip(np.abs(x).tolist(), drawn.sea.omega.tolist(), (-np.angle(x)).tolist()))
    return {"fmu": waves_fmu(), "parameters": {**values, "ramp_time": drawn.sea.ramp}}


def scene(drawn: Drawn) -> Scene:
    """The drawn tow as a user writes it, who tells the unit how fast his sea is."""
    tow, cable, body = drawn.tow, drawn.tow.cable, drawn.tow.body
    highest = float(drawn.sea.omega.max())
    parameters = {
        "tow_speed": tow.speed, "water_density": tow.density, "cable_length": cable.length, "cable_mass": cable.mass,
        "cable_weight": cable.weight, "cable_thickness": cable.thickness, "cable_drag_coefficient": cable.drag_coefficient,
        "loading_form": drawn.form, "loading_friction": drawn.friction, "axial_stiffness": cable.axial_stiffness,
        "extensible": 1.0, "body_mass": body.mass, "body_added_mass_surge": body.added_mass_surge,
        "body_added_mass_heave": body.added_mass_heave, "body_weight_in_water": body.weight, "body_drag": body.drag,
        "band": highest,
    }  # fmt: skip
    step = 2.0 * math.pi / highest / STEPS
    return Scene.from_dict(
        {
            "title": "drawn",
            "stop_time": drawn.stop,
            "connections": ["surge.velocity -> tow.velocity_surge", "heave.velocity -> tow.velocity_heave"],
            "units": {
                "surge": _sea(drawn, SURGE), "heave": _sea(drawn, HEAVE), "tow": {"fmu": "tow_system", "parameters": parameters},
            },
            "coupling": {"step": step},
            "record": {"interval": step},
        }
    )  # fmt: skip


def true(drawn: Drawn, result: Result) -> Truth:
    """The errors of what the run recorded of its linear tow, in the second half, which is what the word is about."""
    own = tow_truth.Tensions(
        result["tow.tension_top"], result["tow.tension_body"], np.array([result["tow.body_surge"], result["tow.body_heave"]])
    )  # fmt: skip
    error, noise = tow_truth.error(drawn.tow, drawn.sea, result.time, own, 0.5 * drawn.stop)
    return Truth(error, error, noise=noise)


def word_of(result: Result, unit: str = "tow") -> tuple[float, str]:
    """(bound of the error, word) that a run's premises give to the linear tow ``unit``."""
    margin: Margin = next(m for m in result.margins if m.variable == f"{unit}.margin_small_perturbation")
    limit = margin.limit or TOLERANCE
    return limit * (1.0 - margin.worst), margin.word


def kind(drawn: Drawn) -> str:
    """What is counted apart."""
    direction = "surge and heave" if np.abs(drawn.sea.amplitudes[:, SURGE]).max() else "heave"
    return f"{direction}, {'regular' if len(drawn.sea.omega) == 1 else 'irregular'}"


FAMILY = Family("tows", TOLERANCE, draw, scene, true, kind, flavour="python")
"""Its native units have the number of segments of their build, and every tow would be one."""
