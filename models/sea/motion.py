"""Motions of a ship in a sea of many components, as polynomials of time over short windows.

    f(t) = Re sum_i a_i(t) exp(j phi_i(t)),   phi_i = x_i P - x_i^2 (cos(mu_i) C - sin(mu_i) D) + e_i

Symbols: `ship_in_sea`. Over a window of W s, in which the fastest component turns by at most `REACH` rad, f is the Chebyshev
interpolant of `ORDER` nodes: its error is below 1e-15 of the components' sum, and its derivatives are exact ones of what is
played. While the sea stays, the coefficients of a window are one product of a matrix, made once, with the phasors at its
start, which turn from window to window by a fixed factor: no sine is computed but every `BLOCK` windows, where phasors start
anew from their phases, so that rounding does not grow. While the sea changes the nodes are summed as they are. The second
derivative has a series of its own, as differentiating twice would lose five digits.

What is found at a time depends on the arguments alone, not on what was asked before.

Sources: L. N. Trefethen, Approximation Theory and Approximation Practice (2013), chapters 3 and 8 (interpolation in Chebyshev
points and its geometric convergence); C. W. Clenshaw, Math. Comp. 9 (1955) 118-120. In C: ``runtime/kernel/sea.c``.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from operator import mul
from typing import NamedTuple

from ..numeric.ops import FLOATS
from ..numeric.ramp import ramp, ramp_integral
from .heave_response import Components
from .waves import GRAVITY

ORDER = 18
"""Chebyshev coefficients of a window."""
REACH = 4.0
"""rad: turn of the fastest component over a window. The first coefficient left out is 2 J_18(REACH/2) = 3e-16."""
BLOCK = 32
"""Windows from one computation of all phases to the next."""
SIGNALS = 9
"""Motions: surge, sway, heave, roll, pitch, yaw of the reference point, then x, y, z of the point that holds the line."""
POINT = 6
"""Where the motions of the point begin."""

Amplitudes = tuple[complex, ...]


class Sea(NamedTuple):
    """Significant height, m, peak frequency, rad/s, direction, rad, speed of the ship, m/s."""

    height: float
    frequency: float
    direction: float
    speed: float


class State(NamedTuple):
    """What fixes a motion but for the time: the phase integrals at the time ``anchor``, rad; the sea that is left and the one
    that is approached within ``interval``, s, equal while the sea stays."""

    anchor: float
    peak_phase: float
    doppler_cos: float
    doppler_sin: float
    old: Sea
    new: Sea
    interval: float


def doppler(sea: Sea) -> tuple[float, float]:
    """C' and D', rad/s."""
    scale = sea.frequency * sea.frequency * sea.speed / GRAVITY
    return scale * math.cos(sea.direction), scale * math.sin(sea.direction)


def encounter(sea: Sea, components: Components) -> tuple[float, ...]:
    """Frequencies of encounter, rad/s, signed."""
    c, s = doppler(sea)
    omega_p = sea.frequency
    return tuple(
        x * omega_p - x * x * (mc * c - ms * s) for x, mc, ms in zip(components.x, components.cos, components.sin)
    )


@lru_cache(maxsize=1)
def nodes() -> tuple[tuple[float, ...], tuple[tuple[float, ...], ...]]:
    """Places of the nodes in a window, 0 ... 1, and the matrix from values there to Chebyshev coefficients."""
    angles = [math.pi * (j + 0.5) / ORDER for j in range(ORDER)]
    matrix = [[(2.0 if k else 1.0) / ORDER * math.cos(k * angle) for angle in angles] for k in range(ORDER)]
    return tuple(0.5 + 0.5 * math.cos(angle) for angle in angles), tuple(map(tuple, matrix))


def derived(c: Sequence[float], scale: float) -> list[float]:
    """Coefficients of the derivative, one less, of a series in 2 s/W - 1 with ``scale`` = 2/W."""
    n = len(c)
    d = [0.0] * (n + 1)
    for k in range(n - 1, 0, -1):
        d[k - 1] = d[k + 1] + 2.0 * k * scale * c[k]
    d[0] *= 0.5
    return d[: n - 1]


def series(c: Sequence[float], tau: float) -> float:
    """Value of a Chebyshev series (Clenshaw)."""
    b1 = b2 = 0.0
    for value in reversed(c[1:]):
        b1, b2 = 2.0 * tau * b1 - b2 + value, b1
    return tau * b1 - b2 + c[0]


class Motion:
    """The motions of one `State`. ``amplitudes(signal, sea)`` are the complex ones of all components."""

    def __init__(self, state: State, components: Components, amplitudes: Callable[[int, Sea], Amplitudes]) -> None:
        self.state, self.components, self._amplitudes = state, components, amplitudes
        self.steady = state.old == state.new
        self._rates = encounter(state.old, components), encounter(state.new, components)
        fastest = max(map(abs, (*self._rates[0], *self._rates[1])))
        self.windows = max(1, math.ceil(state.interval * fastest / REACH))
        self.width = state.interval / self.windows
        self._turn = [cmath.exp(1j * w * self.width) for w in self._rates[0]]
        self._at = -1
        self._phasors: list[complex] = []
        self._matrices: dict[int, list[list[list[complex]]]] = {}
        self._made: dict[tuple[int, int], list[list[float]]] = {}
        self._sums: dict[int, list[float]] = {}

    def __call__(self, t: float, signal: int) -> tuple[float, float, float, float, float]:
        """The motion, its first three time derivatives, and its variance."""
        if not any(self._squares(signal)):
            return 0.0, 0.0, 0.0, 0.0, 0.0
        since = t - self.state.anchor
        n = math.floor(since / self.width)
        if not self.steady:
            n = min(max(n, 0), self.windows - 1)
        key = signal, n
        if key not in self._made:
            while len(self._made) >= 4 * SIGNALS:
                del self._made[next(iter(self._made))]
            self._made[key] = self._window(signal, n)
        tau = 2.0 * (since - n * self.width) / self.width - 1.0
        value, rate, second, third = (series(c, tau) for c in self._made[key])
        return value, rate, second, third, self._variance(signal, since)

    def _window(self, signal: int, n: int) -> list[list[float]]:
        """Series of the motion and its first three derivatives."""
        scale = 2.0 / self.width
        value, second = self._steady(signal, n) if self.steady else self._changing(signal, n)
        return [value, derived(value, scale), second, derived(second, scale)]

    def _steady(self, signal: int, n: int) -> list[list[float]]:
        if signal not in self._matrices:
            a, rates = self._amplitudes(signal, self.state.old), self._rates[0]
            self._matrices[signal] = [self._matrix(a), self._matrix([-w * w * b for b, w in zip(a, rates)])]
        z = self._phasors_at(n)
        return [[sum(map(mul, row, z)).real for row in matrix] for matrix in self._matrices[signal]]

    def _matrix(self, a: Sequence[complex]) -> list[list[complex]]:
        """From phasors at the start of a window to the coefficients."""
        places, transform = nodes()
        turned = [[b * cmath.exp(1j * (w * (self.width * s))) for b, w in zip(a, self._rates[0])] for s in places]
        return [[sum(map(mul, row, column)) for column in zip(*turned)] for row in transform]

    def _phasors_at(self, n: int) -> list[complex]:
        """exp(j phi_i) at the start of window ``n``."""
        block = n // BLOCK
        if not block * BLOCK <= self._at <= n:
            self._at = block * BLOCK
            self._phasors = [cmath.exp(1j * phi) for phi in self._phases(self._at * self.width, 0.0)]
        while self._at < n:
            self._phasors = [*map(mul, self._phasors, self._turn)]
            self._at += 1
        return self._phasors

    def _phases(self, since: float, area: float) -> list[float]:
        """phi_i at ``since`` s after the anchor, of which the new sea has had ``area`` s."""
        state, components = self.state, self.components
        (c0, d0), (c1, d1) = doppler(state.old), doppler(state.new)
        p = state.peak_phase + (state.old.frequency * since + (state.new.frequency - state.old.frequency) * area)
        c = state.doppler_cos + (c0 * since + (c1 - c0) * area)
        d = state.doppler_sin + (d0 * since + (d1 - d0) * area)
        return [
            x * (p - x * (mc * c - ms * d)) + e
            for x, mc, ms, e in zip(components.x, components.cos, components.sin, components.phase)
        ]

    def _changing(self, signal: int, n: int) -> list[list[float]]:
        places, transform = nodes()
        old, new = self._amplitudes(signal, self.state.old), self._amplitudes(signal, self.state.new)
        interval, values, seconds = self.state.interval, [], []
        for place in places:
            since = (n + place) * self.width
            r, r1, r2 = ramp(since, interval, FLOATS)
            value = second = 0.0
            phases = self._phases(since, ramp_integral(since, interval, FLOATS))
            for a0, a1, w0, w1, phi in zip(old, new, *self._rates, phases):
                da, dw, turned = a1 - a0, w1 - w0, cmath.exp(1j * phi)
                a, w = a0 + r * da, w0 + r * dw
                value += (a * turned).real
                second += ((r2 * da - w * w * a + 1j * (2.0 * r1 * w * da + r1 * dw * a)) * turned).real
            values.append(value)
            seconds.append(second)
        return [[sum(map(mul, row, column)) for row in transform] for column in (values, seconds)]

    def _variance(self, signal: int, since: float) -> float:
        """Half the sum of the squares of the amplitudes, without the ramp at the start."""
        squares = self._squares(signal)
        if self.steady:
            return squares[0]
        share: float = ramp(since, self.state.interval, FLOATS)[0]
        rest = 1.0 - share
        return rest * rest * squares[0] + 2.0 * rest * share * squares[1] + share * share * squares[2]

    def _squares(self, signal: int) -> list[float]:
        """Half the sums of |old|^2, Re(old new*), |new|^2."""
        if signal not in self._sums:
            old, new = self._amplitudes(signal, self.state.old), self._amplitudes(signal, self.state.new)
            pairs = ((old, old), (old, new), (new, new))
            self._sums[signal] = [0.5 * math.fsum((a * b.conjugate()).real for a, b in zip(*pair)) for pair in pairs]
        return self._sums[signal]
