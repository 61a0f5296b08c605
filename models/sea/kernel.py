"""The kernel of a ship in a sea: `motion` with the amplitudes of a response, as model functions call it.

    kernel(t, signal, anchor, P, C, D, old sea (4), new sea (4), update_interval, seed, L, B, T, smith_oblique, point (3))
        -> motion, its first three time derivatives, variance

Symbols: `ship_in_sea`; signals: `motion.SIGNALS`, and `BEYOND`. In C: ``runtime/kernel/sea.c``, which reads the tables in this
order: number of components, whether there is a table of responses; x, amplitude, cosine and sine of the direction of each
component; `ResponseTable.numbers`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

from ..numeric.kernel import Kernel
from ..numeric.ops import FLOATS
from .heave_response import Components, Hull, heave_rao, pitch_rao
from .motion import POINT, Amplitudes, Motion, Sea, State
from .response_table import ResponseTable
from .seas import SeaTable, Shape, sea_components

RATES = (1, 2, 3, -1, -1)
HEAVE, PITCH = 2, 4
BEYOND = 9
"""The signal whose value is the share of the wave energy at frequencies that the table of responses lacks."""


class Ship(NamedTuple):
    """What answers to the waves: the box of the hull, and the point, m ahead, to port and up from where responses are given."""

    hull: Hull
    point: tuple[float, float, float]


@lru_cache(maxsize=32)
def sea_kernel(shape: Shape, response: ResponseTable | None, spectrum: SeaTable | None) -> Kernel:
    """The kernel of a sea of this shape, or of the ``spectrum``, and a ship that answers by a table, or by the closed form."""

    @lru_cache(maxsize=8)
    def motion(state: State, seed: int, ship: Ship) -> Motion:
        sea = sea_components(shape, spectrum, seed)
        of = by_table(response, ship) if response else by_hull(ship)

        @lru_cache(maxsize=36)
        def amplitudes(signal: int, at: Sea) -> Amplitudes:
            return tuple(b * h for b, h in zip(heights(at, sea), answers(of, signal, at, sea)))

        return Motion(state, sea, amplitudes)

    def run(t: float, *arguments: float) -> tuple[float, ...]:
        signal, anchor, p, c, d, *seas, interval, seed, length, breadth, draught, smith, x, y, z = arguments
        state = State(anchor, p, c, d, Sea(*seas[:4]), Sea(*seas[4:]), interval)
        if signal == BEYOND:
            shares = (share_beyond(response, at, sea_components(shape, spectrum, 0)) for at in (state.old, state.new))
            return (max(shares), 0.0, 0.0, 0.0, 0.0)
        ship = Ship(Hull(length, breadth, draught, smith), (x, y, z))
        return motion(state, round(seed), ship)(t, int(signal))

    made = sea_components(shape, spectrum, 0)
    columns = (made.x, made.amplitude, made.cos, made.sin)
    table = response.numbers if response else ()
    numbers = (float(len(made.x)), float(response is not None), *(v for column in columns for v in column), *table)
    return Kernel("sea", run, RATES, numbers)


Answer = Callable[[int, float, float, float], complex]
"""A signal per wave amplitude at a frequency, a speed and an angle."""


def by_table(table: ResponseTable, ship: Ship) -> Answer:
    """By the table of responses."""
    return lambda signal, omega, speed, beta: table.motion(signal, omega, speed, beta, ship.point)


def by_hull(ship: Ship) -> Answer:
    """By the closed form: heave, pitch, and what they make of the point's height; nothing else moves."""

    def answer(signal: int, omega: float, speed: float, beta: float) -> complex:
        cos_beta, pitch = math.cos(beta), 0j
        if signal in (PITCH, POINT + 2):
            pitch = 1j * pitch_rao(omega, speed, cos_beta, ship.hull, FLOATS)
        if signal in (HEAVE, POINT + 2):
            return complex(heave_rao(omega, speed, cos_beta, ship.hull, FLOATS)) - ship.point[0] * pitch
        return pitch

    return answer


def heights(at: Sea, sea: Components) -> list[float]:
    """Amplitudes of the waves, m."""
    return [at.height * a for a in sea.amplitude]


def answers(of: Answer, signal: int, at: Sea, sea: Components) -> list[complex]:
    """A signal per wave amplitude, for all components."""
    cosine, sine = math.cos(at.direction), math.sin(at.direction)
    angles = (math.atan2(sine * c + cosine * s, cosine * c - sine * s) for c, s in zip(sea.cos, sea.sin))
    return [of(signal, at.frequency * x, at.speed, beta) for x, beta in zip(sea.x, angles)]


def share_beyond(table: ResponseTable | None, at: Sea, sea: Components) -> float:
    """Share of the wave energy at frequencies that the table lacks."""
    if table is None:
        return 0.0
    low, high = table.frequencies[0], table.frequencies[-1]
    return 16.0 * math.fsum(0.5 * a * a for a, x in zip(sea.amplitude, sea.x) if not low <= at.frequency * x <= high)
