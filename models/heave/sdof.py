"""How far the line moves the ship: the theory of the assumption of a single degree of freedom (SDOF).

    D1 X = D1 X0 - D2 X,    D1 = K1 - m1 omega^2 + i omega c1,    D2 = K2 (1 - G)
    G = Y/X = K2/(K2 - m2 omega^2 + i omega c)

| symbol | meaning | unit |
|---|---|---|
| X0, X, Y | complex amplitudes: ship without and with the reaction of its line, cradle | m |
| m1, c1, K1 | mass, damping, stiffness of the ship in heave | kg, N s/m, N/m |
| m2, K2, b | virtual mass of the cradle, stiffness of its line, quadratic drag | kg, N/m, kg/m |
| c | equivalent linear damping 8 b omega abs(Y)/(3 pi) (`linear.equivalent_damping`) | N s/m |
| D1, D2 | dynamic stiffness of the ship; reaction per motion of the ship | N/m |
| eps | abs(D2/D1) at the amplitude of the one-way motion | - |
| mu, Omega, zeta1, B | m2/m1, sqrt(K1 m2/(m1 K2)), c1/(2 sqrt(K1 m1)), b X0/m2 | - |

Quantities are Re(q exp(i omega t)); a lag is minus the phase. The SDOF assumption is X = X0. Because the row of the
cradle holds either way, the whole error is that of X:

    Y2way/Y1way = D1/(D1 + D2)  (linear drag),  hence  error of the amplitude <= eps/(1 - eps)

With quadratic drag D2 follows the amplitude; the bound held in all 1404 cases of the spec with eps < 0.9 (and in
``tests/models/test_sdof.py`` on random ones). Two-way the amplitude A = abs(Y) solves a quartic whose coefficients are
not negative, A^2 (p + q A + s A^2) = d, so that exactly one steady motion exists. A closed form that needs no run is

    eps* = mu/abs(Omega^2 - 1) max(1/(2 zeta1), sqrt(1 + 3 pi/(8 B)))

with the rule eps* <= 0.9 e for an error below e.

The source's own two tests fail: `eigenvector_test` compares two numbers that are equal for any masses, because row 2 of
the eigenproblem is the SDOF equation; `frequency_shift` below 1 % lets pass cases with 35 % error.

Assumptions: (1) harmonic forcing and response (describing function of the drag); (2) a line that stays taut.
Source: MIT thesis 1969, example 1; register rows 1 to 5 and section 4 of its spec.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..numeric.ops import FLOATS
from . import cradle, linear, ship, spring_line


@dataclass(frozen=True)
class Pair:
    """Ship and cradle, SI; ``amplitude`` X0 of the ship without reaction, m."""

    ship_mass: float
    ship_damping: float
    ship_stiffness: float
    mass: float
    stiffness: float
    drag: float
    amplitude: float

    @classmethod
    def of(cls, hull: ship.Parameters, line: spring_line.Parameters, body: cradle.Parameters) -> Pair:
        """From the parameters of the three models."""
        mass, drag = cradle.calculated(body, FLOATS)
        k = spring_line.stiffness(line, FLOATS)
        return cls(hull.mass, hull.damping, hull.stiffness, mass, k, drag, hull.heave_amplitude)

    @classmethod
    def dimensionless(cls, mass_ratio: float, stiffness_ratio: float, damping_ratio: float, drag: float) -> Pair:
        """From mu = m2/m1, K2/K1, zeta1 and B, with m2 = K2 = X0 = 1."""
        m1, k1 = 1.0 / mass_ratio, 1.0 / stiffness_ratio
        return cls(m1, 2.0 * damping_ratio * math.sqrt(k1 * m1), k1, 1.0, 1.0, drag, 1.0)

    @property
    def ship_frequency(self) -> float:
        """sqrt(K1/m1), rad/s."""
        return math.sqrt(self.ship_stiffness / self.ship_mass)

    @property
    def ship_damping_ratio(self) -> float:
        """c1/(2 sqrt(K1 m1)), infinite for a ship without stiffness that has damping."""
        critical = self.ship_mass * self.ship_frequency
        if critical == 0.0:
            return math.inf if self.ship_damping > 0.0 else 0.0
        return 0.5 * self.ship_damping / critical

    @property
    def cradle_frequency(self) -> float:
        """sqrt(K2/m2), rad/s."""
        return math.sqrt(self.stiffness / self.mass)


@dataclass(frozen=True)
class Response:
    """At one frequency: complex amplitudes, m, relative to the phase of X0, and `eps`."""

    ship: complex
    cradle_two_way: complex
    cradle_one_way: complex
    eps: float

    @property
    def amplitude_error(self) -> float:
        """abs(abs(Y1way)/abs(Y2way) - 1): how wrong the one-way amplitude is; infinite where only it moves."""
        one, two = abs(self.cradle_one_way), abs(self.cradle_two_way)
        if one == two:  # both may be zero, or infinite
            return 0.0
        return abs(one / two - 1.0) if two > 0.0 else math.inf

    @property
    def bound(self) -> float:
        """eps/(1 - eps), infinite from eps = 1 on."""
        return self.eps / (1.0 - self.eps) if self.eps < 1.0 else math.inf


def dynamic_stiffness(mass: float, damping: float, stiffness: float, omega: float) -> complex:
    """K - m omega^2 + i omega c, N/m."""
    return complex(stiffness - mass * omega * omega, omega * damping)


def _amplitude(p: float, q: float, s: float, d: float) -> float:
    """The root A >= 0 of A^2 (p + q A + s A^2) = d, p, q, s, d >= 0: Newton from above, where the left side is convex and
    increasing. Zero for d = 0, infinite for p = s = 0, at resonance without drag and damping."""
    a = min(math.sqrt(d / p) if p > 0.0 else math.inf, (d / s) ** 0.25 if s > 0.0 else math.inf) if d > 0.0 else 0.0
    if not 0.0 < a < math.inf:
        return a
    for _ in range(200):
        lower = a - (a * a * (p + a * (q + a * s)) - d) / (a * (2.0 * p + a * (3.0 * q + 4.0 * a * s)))
        if not lower < a * (1.0 - 1e-15):
            break
        a = lower
    return a


def _small_amplitude(smooth: float, q: float, rough: float, force: float) -> float:
    """`_amplitude` for p = smooth^2, s = rough^2 and d = force^2, which may underflow: in units of the largest that A can
    be."""
    if force == 0.0:
        return 0.0
    bounds = (force / smooth if smooth > 0.0 else math.inf, math.sqrt(force / rough) if rough > 0.0 else math.inf)
    largest = min(bounds)
    if not 0.0 < largest < math.inf:
        return largest
    share = largest / force
    return largest * _amplitude((smooth * share) ** 2, q * share * largest * share, (rough * largest * share) ** 2, 1.0)


def two_way(pair: Pair, omega: float) -> Response:
    """Ship and cradle together and the cradle alone, at ``omega``, rad/s. Amplitudes are infinite at resonance without
    drag and damping, `eps` where the ship has neither damping nor a force against the line's; for X0 = 0 the latter is
    that of vanishing X0."""
    size, lag = linear.lorentz(pair.mass, pair.drag, pair.stiffness, pair.amplitude, omega)
    resonant = size == math.inf
    alone = complex(0.0, -size) if resonant else complex(size * math.cos(lag), -size * math.sin(lag))
    d1 = dynamic_stiffness(pair.ship_mass, pair.ship_damping, pair.ship_stiffness, omega)
    if resonant or pair.amplitude == 0.0:
        d2 = _undragged(pair, omega)
    else:
        d2 = abs(pair.stiffness * (1.0 - alone / pair.amplitude))
    # cradle: (Z + i h A) Y = K2 X;  ship: (D1 + K2) X - K2 Y = D1 X0
    z = dynamic_stiffness(pair.mass, 0.0, pair.stiffness, omega)
    h = omega * linear.equivalent_damping(pair.drag, omega, 1.0)
    held = d1 + pair.stiffness
    smooth = held * z - pair.stiffness**2
    rough = 1j * h * held
    p, s = abs(smooth) ** 2, abs(rough) ** 2
    q = 2.0 * h * pair.stiffness**2 * max(d1.imag, 0.0)  # = 2 Re(smooth conj(rough)), without cancellation
    force = abs(pair.stiffness * d1 * pair.amplitude)
    a = _amplitude(p, q, s, force**2) if force > 1e-140 else _small_amplitude(abs(smooth), q, abs(rough), force)
    if d1 != 0.0:
        eps = d2 / abs(d1)
    else:
        eps = math.inf if d2 > 0.0 else 0.0
    if a == math.inf:
        return Response(complex(math.inf), complex(math.inf), alone, eps)
    together = pair.stiffness * d1 * pair.amplitude / (smooth + rough * a) if a > 0.0 else 0j
    return Response(
        ship=together * (z + 1j * h * a) / pair.stiffness,
        cradle_two_way=together,
        cradle_one_way=alone,
        eps=eps,
    )


def _undragged(pair: Pair, omega: float) -> float:
    """abs(D2) of a motion so small that its drag vanishes, K2 m2 omega^2/abs(K2 - m2 omega^2), N/m."""
    load = pair.mass * omega * omega
    return pair.stiffness * load / abs(pair.stiffness - load) if pair.stiffness != load else math.inf


def worst(pair: Pair, low: float = 0.2, high: float = 4.0, points: int = 400) -> tuple[float, float, float]:
    """(omega, rad/s; amplitude error; eps) of the worst amplitude error for omega/omega_cradle in [low, high]:
    ``points`` steps and more about each resonance, then the best interval is narrowed by thirds to 1e-7 of itself."""
    unit = pair.cradle_frequency

    def error(r: float) -> float:
        return two_way(pair, r * unit).amplitude_error

    grid = [low + (high - low) * k / points for k in range(points + 1)]
    width = min(max(pair.ship_damping_ratio, 0.002), 1e3)
    near = [r * (1.0 + 0.25 * k * width) for r in _resonances(pair) for k in range(-12, 13)]
    grid = sorted(grid + [r for r in near if low < r < high])
    best = max(range(len(grid)), key=lambda k: error(grid[k]))
    a, b = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    for _ in range(40):
        left, right = a + (b - a) / 3.0, b - (b - a) / 3.0
        a, b = (left, b) if error(left) < error(right) else (a, right)
    r = max((grid[best], 0.5 * (a + b)), key=error)
    return r * unit, error(r), two_way(pair, r * unit).eps


def _resonances(pair: Pair) -> list[float]:
    """Frequencies of the parts and of the pair, over that of the cradle."""
    own = modes(pair.ship_mass, pair.ship_stiffness, pair.mass, pair.stiffness)
    return [omega / pair.cradle_frequency for omega in (own[0].omega, own[1].omega, pair.ship_frequency)]


def closed_form(mass_ratio: float, frequency_ratio: float, damping_ratio: float, drag: float) -> float:
    """eps* of mu, Omega, zeta1 and B; infinite where ship and cradle have one frequency, or no damping or drag."""
    detuning = abs(frequency_ratio**2 - 1.0)
    if detuning == 0.0 or damping_ratio <= 0.0 or drag <= 0.0:
        return math.inf
    return mass_ratio / detuning * max(0.5 / damping_ratio, math.sqrt(1.0 + 3.0 * math.pi / (8.0 * drag)))


def closed_form_of(pair: Pair) -> float:
    """eps* of a pair in SI."""
    drag = pair.drag * pair.amplitude / pair.mass
    ratio = pair.ship_frequency / pair.cradle_frequency
    return closed_form(pair.mass / pair.ship_mass, ratio, pair.ship_damping_ratio, drag)


@dataclass(frozen=True)
class Mode:
    """Frequency, rad/s, and shape x2/x1 (cradle over ship) of the undamped pair."""

    omega: float
    shape: float


def modes(m1: float, k1: float, m2: float, k2: float) -> tuple[Mode, Mode]:
    """Upper and lower mode of m1 x1" + K1 x1 + K2 (x1 - x2) = 0, m2 x2" + K2 (x2 - x1) = 0."""
    a, b, coupling = (k1 + k2) / m1, k2 / m2, k2 / math.sqrt(m1 * m2)
    root = math.hypot(0.5 * (a - b), coupling)
    upper = 0.5 * (a + b) + root
    lower = k1 * k2 / (m1 * m2) / upper
    # row 1 of the eigenproblem; row 2 would be the SDOF equation, which `eigenvector_test` compares with
    return tuple(Mode(math.sqrt(w2), (k1 + k2 - m1 * w2) / k2) for w2 in (upper, lower))  # type: ignore[return-value]


def eigenvector_test(m1: float, k1: float, m2: float, k2: float) -> Sequence[tuple[float, float]]:
    """The source's first test, for both modes: (shape x2/x1, undamped SDOF transmissibility 1/(1 - (omega/omega2)^2)).
    An identity for any masses and stiffnesses: it cannot fail and tells nothing."""
    inverse = [(mode.shape, 1.0 - mode.omega**2 * m2 / k2) for mode in modes(m1, k1, m2, k2)]
    return [(shape, 1.0 / rest if rest != 0.0 else math.inf) for shape, rest in inverse]


def frequency_shift(m1: float, k1: float, m2: float, k2: float) -> float:
    """The source's second test: the larger relative shift of the frequencies of ship and cradle by their coupling; a
    ship without stiffness has no frequency to be shifted."""
    alone = sorted((math.sqrt(k1 / m1), math.sqrt(k2 / m2)), reverse=True)
    pairs = zip(modes(m1, k1, m2, k2), alone)
    return max(abs(mode.omega / omega - 1.0) for mode, omega in pairs if omega > 0.0)
