"""What the two linear towing units share: the prepared state space, its exact steps and its observation.

    z = (x, u, u', u''),   y = [C D E] z,   y' = [C A, C B, D, E] z

The acceleration u' comes with the inputs; u'' is remembered from the step before, so rates of forces are limits from
the left. Everything here is prepared once for a set of parameters; steps once for a length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from .cable_case import Tow
from .cable_fidelity import Chosen
from .cable_linear import PROFILE, LinearModel, steady_towpoint_force
from .cable_parameters import stream_angles
from .cable_steady import Array
from .cable_step import ExactStep, exact_step

FLOOR = 1e-3
"""rad; least distance to the stream's direction by which a turn is measured."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A linear model ready to run; compared by identity."""

    tow: Tow
    chosen: Chosen
    order: int
    values: Array = field(init=False)
    rates: Array = field(init=False)
    steady_tension: Array = field(init=False)
    room: Array = field(init=False)
    end_tension: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        m = self.model
        set_ = object.__setattr__
        set_(self, "values", np.hstack([m.c, m.d, m.e]))
        set_(self, "rates", np.hstack([m.c @ m.a, m.c @ m.b, m.d, m.e])[:PROFILE])
        set_(self, "steady_tension", m.chain.tension)
        d = self.tow.sign * m.chain.directions
        phi = np.arctan2(d[:, 1], d[:, 0])
        set_(self, "room", np.maximum(FLOOR, stream_angles(self.tow, phi.tolist())))
        set_(self, "end_tension", (self.tow.end_tension, float(np.linalg.norm(steady_towpoint_force(m.chain)))))

    @property
    def model(self) -> LinearModel:
        """The state space."""
        return self.chosen.model

    @property
    def top_angle(self) -> float:
        """Steady angle of the cable at the towpoint, rad."""
        force = -self.tow.sign * -steady_towpoint_force(self.model.chain)
        return math.atan2(-force[1], -force[0])


@lru_cache(maxsize=64)
def step_of(prepared: Prepared, step: float) -> ExactStep:
    """The operators for a step length, s."""
    return exact_step(prepared.model.a, prepared.model.b, step, prepared.order)


def observe(
    prepared: Prepared, x: Sequence[float], u: Sequence[float], du: Sequence[float], ddu: Sequence[float]
) -> tuple[list[float], list[float], float, float]:
    """(the first `PROFILE` rows of y, their rates, margin of slack, margin of the quadrant)."""
    z = np.array([*x, *u, *du, *ddu])
    n = prepared.values.shape[1]
    y = prepared.values @ z[:n]
    count = len(prepared.steady_tension)
    tension, turn = y[PROFILE : PROFILE + count], y[PROFILE + count :]
    slack = 1.0 - float((np.abs(tension) / prepared.steady_tension).max())
    quadrant = 1.0 - max(0.0, float((-prepared.tow.sign * turn / prepared.room).max()))
    return y[:PROFILE].tolist(), (prepared.rates @ z).tolist(), slack, quadrant


def flow_margin(prepared: Prepared, velocity: Sequence[float], turn: float) -> float:
    """1 - |V1|/V0 at the towpoint, for its velocity, m/s, and the turn of the cable there, rad."""
    phi, c = prepared.top_angle, prepared.tow.speed
    cosine, sine = math.cos(phi), math.sin(phi)
    change = velocity[0] * cosine + velocity[1] * sine - c * turn * sine
    return 1.0 - abs(change) / max(abs(c * cosine), 1e-6 * c)


def speed_margin(tow_speed: float, limit: float, *velocities: Sequence[float]) -> float:
    """1 - v/(limit c) for the largest of the velocities."""
    return 1.0 - max(math.hypot(v[0], v[1]) for v in velocities) / (limit * tow_speed)
