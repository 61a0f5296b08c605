"""The linear twin of the cradle, in closed form, and the linear stand-ins for its quadratic drag.

    M y'' + c y' + K (y - X0 sin(omega t)) = 0

| symbol | meaning | unit |
|---|---|---|
| y | heave of the cradle; X0, omega: amplitude and frequency of the upper end | m; m, rad/s |
| M, c, K | mass, linear damping, stiffness | kg, N s/m, N/m |
| b | quadratic drag, force b abs(v) v | kg/m |
| A, phi | steady motion y = A sin(omega t - phi): amplitude, m, and lag, rad, 0 to pi | |

The transient is one formula for every damping and for resonance. With s1, s2 the roots of M s^2 + c s + K and
f[a, b, ...] divided differences of f(s) = exp(s t), the impulse response is f[s1, s2] and the response at rest to
K X0 exp(i omega t) is (K X0/M) f[i omega, s1, s2]: critical damping (s1 = s2) and undamped resonance (s1 = i omega) are
confluent nodes, no separate cases.

Linear stand-ins for b: equal energy per cycle (Lorentz) gives c = 8 b omega A/(3 pi); the envelope of a free decay that
follows from it (Minorsky) is 1/(1 + 4 b omega0 y0 t/(3 pi M)). Both assume (1) a motion near to harmonic, (2) a line
that stays taut. Against the exact solution the amplitude at the peak is 1.1 % low (B = 0.3), at most 4.4 % wrong for
B <= 1, but the dynamic tension up to 27.5 % at a third of resonance (register rows 24 and 27).

Source: MIT thesis 1969, sections III and IV (linear twin, Minorsky), section II (equivalent damping of the U.S. Navy
report); register rows 7, 8, 24, 25, 27.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence


def response(mass: float, damping: float, stiffness: float, omega: float) -> tuple[float, float]:
    """(A/X0, phi, rad): 1/sqrt((1-r^2)^2 + (2 zeta r)^2), tan phi = 2 zeta r/(1-r^2). ZeroDivisionError at undamped
    resonance, where no steady motion exists."""
    real, imaginary = stiffness - mass * omega * omega, damping * omega
    return stiffness / math.hypot(real, imaginary), math.atan2(imaginary, real)


def peak(mass: float, damping: float, stiffness: float) -> tuple[float, float]:
    """(omega, rad/s; A/X0) of the largest response: r^2 = 1 - 2 zeta^2, 1/(2 zeta sqrt(1 - zeta^2)); (0, 1) from
    zeta = 1/sqrt 2 on, where the response only falls; infinite without damping."""
    zeta2 = damping * damping / (4.0 * mass * stiffness)
    if zeta2 >= 0.5:
        return 0.0, 1.0
    if zeta2 == 0.0:
        return math.sqrt(stiffness / mass), math.inf
    return math.sqrt((1.0 - 2.0 * zeta2) * stiffness / mass), 0.5 / math.sqrt(zeta2 * (1.0 - zeta2))


def _first(a: complex, b: complex, t: float) -> complex:
    """exp(s t)[a, b], without cancellation where a and b are close."""
    half = 0.5 * (a - b) * t
    if abs(half) > 0.5:
        return (cmath.exp(a * t) - cmath.exp(b * t)) / (a - b)
    ratio = cmath.sinh(half) / half if half != 0.0 else 1.0
    return t * cmath.exp(0.5 * (a + b) * t) * ratio


def _second(a: complex, b: complex, c: complex, t: float) -> complex:
    """exp(s t)[a, b, c], divided by the largest of the three differences."""
    _, p, q, m = max((abs(a - b), a, b, c), (abs(b - c), b, c, a), (abs(a - c), a, c, b), key=lambda item: item[0])
    return (_first(p, m, t) - _first(m, q, t)) / (p - q)


def transient(
    t: float,
    mass: float,
    damping: float,
    stiffness: float,
    amplitude: float,
    omega: float,
    heave_start: float = 0.0,
    velocity_start: float = 0.0,
) -> tuple[float, float]:
    """(y, m; y', m/s) at ``t`` >= 0, s, for any damping >= 0 and frequency > 0."""
    decay = 0.5 * damping / mass
    root = cmath.sqrt(decay * decay - stiffness / mass)
    # the slow root from the product of both: no cancellation where the damping is large
    fast = -(decay + root)
    slow = stiffness / mass / fast
    drive = 1j * omega
    impulse = _first(fast, slow, t)
    impulse_rate = fast * impulse + cmath.exp(slow * t)
    forced = _second(drive, fast, slow, t)
    forced_rate = drive * forced + impulse
    scale = stiffness * amplitude / mass
    # (y0 M s + y0 c + M v0)/(M s^2 + c s + K) transformed back
    y = heave_start * (impulse_rate + 2.0 * decay * impulse) + velocity_start * impulse
    v = velocity_start * (impulse_rate) - heave_start * (stiffness / mass) * impulse
    return y.real + scale * forced.imag, v.real + scale * forced_rate.imag


def resonance(tau: float) -> tuple[float, float]:
    """(y/X0, y'/(omega X0)) of the undamped body from rest, driven at its own frequency; tau = omega t:
    (sin tau - tau cos tau)/2 and tau sin(tau)/2."""
    return 0.5 * (math.sin(tau) - tau * math.cos(tau)), 0.5 * tau * math.sin(tau)


def equivalent_damping(drag: float, omega: float, amplitude: float) -> float:
    """c with the same loss of energy per cycle as b abs(v) v at v = A omega cos(omega t): 8 b omega A/(3 pi), N s/m."""
    return 8.0 / (3.0 * math.pi) * drag * omega * amplitude


def equal_loss(drag: float, velocity: Sequence[float]) -> float:
    """c with the same loss of energy as b abs(v) v over a motion whose ``velocity``, m/s, is known at equal intervals:
    b sum abs(v)^3 / sum v^2, N s/m. `equivalent_damping` for a harmonic motion, b sqrt(8/pi) sigma for a Gaussian one; 0 at
    rest."""
    squares = math.fsum(v * v for v in velocity)
    return drag * math.fsum(abs(v) ** 3 for v in velocity) / squares if squares else 0.0


def lorentz(mass: float, drag: float, stiffness: float, amplitude: float, omega: float) -> tuple[float, float]:
    """(A, m; phi, rad) with the equivalent damping of the resulting motion itself.

    A^2 ((K - M omega^2)^2 + c1^2 omega^2 A^2) = K^2 X0^2 with c1 = ``equivalent_damping`` at A = 1 m, a quadratic in
    A^2 with one positive root, written without cancellation. (infinity, pi/2) at resonance without drag, where no steady
    motion exists; (0, pi/2) there without motion of the upper end.
    """
    real = stiffness - mass * omega * omega
    gain = omega * equivalent_damping(drag, omega, 1.0)
    force = stiffness * amplitude
    half = 0.5 * real * real
    root = math.hypot(half, gain * force)
    if half + root == 0.0:
        return (math.inf if force != 0.0 else 0.0), 0.5 * math.pi
    size = force / math.sqrt(half + root)
    return size, math.atan2(gain * size, real)


def lorentz_peak(mass: float, drag: float, stiffness: float, amplitude: float) -> tuple[float, float]:
    """(omega, rad/s; A, m) of the largest `lorentz` amplitude: with c = 8 b X0/(3 pi M) and a = A/X0,
    a^2 = (1 + sqrt(1 + 4/c^2))/2 and (omega/omega0)^2 = 1/(1 + c^2 a^2). A tends to sqrt(3 pi M X0/(8 b)) as c does to
    zero: infinite without drag, zero without motion of the upper end."""
    c2 = (equivalent_damping(drag, 1.0, amplitude) / mass) ** 2
    if c2 < 1e-200:
        c1 = equivalent_damping(drag, 1.0, 1.0)
        largest = math.sqrt(amplitude * (mass / c1)) if c1 > 0.0 else math.inf
        return math.sqrt(stiffness / mass), (largest if amplitude != 0.0 else 0.0)
    a2 = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 / c2))
    return math.sqrt(stiffness / mass / (1.0 + c2 * a2)), amplitude * math.sqrt(a2)


def minorsky_envelope(t: float, mass: float, drag: float, stiffness: float, heave_start: float) -> float:
    """Amplitude over ``heave_start`` of a free decay after ``t``, s: 1/(1 + 4 b omega0 y0 t/(3 pi M))."""
    omega = math.sqrt(stiffness / mass)
    return 1.0 / (1.0 + 0.5 * equivalent_damping(drag, omega, abs(heave_start)) * t / mass)
