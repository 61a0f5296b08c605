"""The kernel of a ship in a sea: `motion` with the amplitudes of a response, as model functions call it.

    kernel(t, signal, anchor, P, C, D, old sea (4), new sea (4), update_interval, seed, L, B, T, smith_oblique)
        -> motion, its first three time derivatives, variance

Symbols: `ship_in_sea`; signals: `motion.SIGNALS`. In C: ``runtime/kernel/sea.c``, which reads the tables in this order: number of
components, then x, amplitude, cosine and sine of the direction of each.
"""

from __future__ import annotations

from functools import lru_cache

from ..numeric.kernel import Kernel
from . import heave_response
from .motion import Amplitudes, Motion, Sea, State

RATES = (1, 2, 3, -1, -1)
HEAVES = (2, 8)
"""Signals that the closed form moves: heave, and z of the point at the ship's centre."""


@lru_cache(maxsize=32)
def sea_kernel(components: float, peakedness: float, spreading: float, directions: float) -> Kernel:
    """The kernel of a sea of so many components; arguments: `ship_in_sea.Parameters`."""
    table = (round(components), peakedness, round(spreading), round(directions))

    @lru_cache(maxsize=8)
    def motion(state: State, seed: int, hull: heave_response.Hull) -> Motion:
        sea = heave_response.components(table[0], seed, *table[1:])

        @lru_cache(maxsize=18)
        def amplitudes(signal: int, at: Sea) -> Amplitudes:
            if signal not in HEAVES:
                return (0j,) * len(sea.x)
            found = heave_response.heave_amplitudes(at.height, at.frequency, at.speed, at.direction, hull, sea)
            return tuple(map(complex, found))

        return Motion(state, sea, amplitudes)

    def run(t: float, *arguments: float) -> tuple[float, ...]:
        signal, anchor, p, c, d, *seas, interval, seed, length, breadth, draught, smith = arguments
        state = State(anchor, p, c, d, Sea(*seas[:4]), Sea(*seas[4:]), interval)
        return motion(state, round(seed), heave_response.Hull(length, breadth, draught, smith))(t, int(signal))

    made = heave_response.components(table[0], 0, *table[1:])
    columns = (made.x, made.amplitude, made.cos, made.sin)
    return Kernel("sea", run, RATES, (float(len(made.x)), *(value for column in columns for value in column)))
