"""A ship's motions by a table: complex amplitudes in six degrees of freedom over speed, heading and wave frequency.

    motion_k = Re(H_k(omega, V, beta) a exp(j omega_e t))   beside the wave a cos(omega_e t) at the reference point

| symbol | meaning | unit |
|---|---|---|
| H_k | k = 0 ... 5: surge, sway, heave (m/m), roll, pitch, yaw (rad/m) | |
| x, y, z | axes of the ship: ahead, to port, up; rotations are right-handed: roll lowers starboard, pitch the bow | |
| beta | from the course to the waves' travel: 0 following, pi/2 towards port, pi head sea | rad |
| omega, V | frequency of the wave (not of the encounter), speed of the ship | rad/s, m/s |

arg H_k is a phase lead over the crest at the reference point. The point r = (x, y, z) of the ship moves, to first order, by
(H_0, H_1, H_2) + (H_3, H_4, H_5) x r.

Between the entries: cubics with the slopes of parabolas through three neighbours, real and imaginary parts apart, over
frequency and heading (periodic), lines over speed. Below the lowest frequency its entry stays, above the highest the ship lies
still, beyond the speeds the nearest counts; `share_beyond` tells how much of a sea that is. In C: ``runtime/kernel/sea_table.c``.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
TURN = 2.0 * math.pi
MIRRORED = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0)
"""Sign of the motions where the waves come from the other side of a ship that is alike on both."""


@dataclass(frozen=True)
class ResponseTable:
    """``speeds``, ``headings`` (0 ... 2 pi, the circle) and ``frequencies``, each ascending; ``values`` of H_k by k, speed,
    heading, frequency, each a complex number."""

    speeds: tuple[float, ...]
    headings: tuple[float, ...]
    frequencies: tuple[float, ...]
    values: tuple[complex, ...]

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """All of it as the C function reads it: three sizes, the axes, real and imaginary parts in turn."""
        sizes = (float(len(self.speeds)), float(len(self.headings)), float(len(self.frequencies)))
        parts = (part for value in self.values for part in (value.real, value.imag))
        return (*sizes, *self.speeds, *self.headings, *self.frequencies, *parts)

    def at(self, dof: int, omega: float, speed: float, beta: float) -> complex:
        """H of a degree of freedom."""
        nb, nw = len(self.headings), len(self.frequencies)
        if omega > self.frequencies[-1]:
            return 0j
        along = weights(self.frequencies, min(max(omega, self.frequencies[0]), self.frequencies[-1]), 0.0)
        around = weights(self.headings, beta % TURN, TURN)
        total = 0j
        for i, a in line(self.speeds, speed):
            for j, b in around:
                first = ((dof * len(self.speeds) + i) * nb + j) * nw
                total += a * b * sum(c * self.values[first + k] for k, c in along)
        return total

    def motion(self, signal: int, omega: float, speed: float, beta: float, point: Sequence[float]) -> complex:
        """H of a signal of `motion`: a degree of freedom, or a coordinate of the ``point``, m."""
        if signal < 6:
            return self.at(signal, omega, speed, beta)
        axis = signal - 6
        after, last = (axis + 1) % 3, (axis + 2) % 3
        moved = self.at(axis, omega, speed, beta)
        if point[last]:
            moved += point[last] * self.at(3 + after, omega, speed, beta)
        if point[after]:
            moved -= point[after] * self.at(3 + last, omega, speed, beta)
        return moved


def line(places: Sequence[float], x: float) -> list[tuple[int, float]]:
    """(entry, weight) at ``x`` by lines; the nearest end beyond."""
    if len(places) == 1 or x <= places[0]:
        return [(0, 1.0)]
    if x >= places[-1]:
        return [(len(places) - 1, 1.0)]
    k = bisect_right(places, x) - 1
    s = (x - places[k]) / (places[k + 1] - places[k])
    return [(k, 1.0 - s), (k + 1, s)]


def weights(places: Sequence[float], x: float, period: float) -> list[tuple[int, float]]:
    """(entry, weight) at ``x`` by cubics whose slopes are those of parabolas through three neighbours; ``period`` 0: with ends,
    where the slope is that of the parabola through the last three (of the line, where there are two)."""
    n = len(places)
    k = bisect_right(places, x) - 1
    if not period:
        k = min(max(k, 0), n - 2)

    def place(i: int) -> float:
        return places[i % n] + (i // n) * period if period else places[i]

    h = place(k + 1) - place(k)
    s = (x - place(k)) / h
    w = {k: 1.0 - s * s * (3.0 - 2.0 * s), k + 1: s * s * (3.0 - 2.0 * s)}
    for at, share in ((k, h * s * (1.0 - s) * (1.0 - s)), (k + 1, -h * s * s * (1.0 - s))):
        middle = at if period else min(max(at, 1), n - 2)
        if n == 2 and not period:
            slope = {0: -1.0 / h, 1: 1.0 / h}
        else:
            slope = parabola(place(middle - 1), place(middle), place(middle + 1), place(at))
            slope = {middle - 1 + i: value for i, value in slope.items()}
        for i, value in slope.items():
            w[i] = w.get(i, 0.0) + share * value
    return [(i % n if period else i, value) for i, value in w.items()]


def parabola(a: float, b: float, c: float, x: float) -> dict[int, float]:
    """Weights of the values at a, b, c in the slope at ``x`` of the parabola through them."""
    return {
        0: (2.0 * x - b - c) / ((a - b) * (a - c)),
        1: (2.0 * x - a - c) / ((b - a) * (b - c)),
        2: (2.0 * x - a - b) / ((c - a) * (c - b)),
    }
