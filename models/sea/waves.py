"""Wind waves: spectra, their Gauss rules, and phases.

    S(omega) = m0 b(x) / omega_p,   b(x) = 5 x^-5 exp(-5/4 x^-4) q(x),   x = omega/omega_p,   m0 = Hs^2/16

| symbol | meaning | unit |
|---|---|---|
| S | one-sided spectrum of the surface elevation | m2 s/rad |
| Hs, omega_p | significant height, peak frequency 2 pi/Tp | m, rad/s |
| q | 1 for Bretschneider and Pierson-Moskowitz; C gamma^r, r = exp(-(x - 1)^2/(2 sigma^2)), for JONSWAP | - |
| sigma | 0.07 below the peak, 0.09 above | - |
| x_i, w_i | nodes and weights of the n-point Gauss rule of b(x) dx on a band | - |

A long-crested sea of n components is eta(t) = sum sqrt(2 m0 w_i) cos(omega_p x_i t + e_i). As the nodes are those of
the Gauss rule, its moments m_0 ... m_{2n-1} are those of the truncated spectrum exactly; equal-energy bins lose
5e-4 of m2 and 1e-2 of m4, equidistant frequencies repeat after 2 pi/d omega. The shape does not depend on the sea
state, so x_i and w_i stay while height and period change.

Assumptions: (1) deep water, k = omega^2/g; (2) a Gaussian sea: random phases, amplitudes fixed; (3) frequencies
outside the band carry nothing (0.5 % of m0 for 0.45 ... 4); (4) the autocorrelation of n components follows that of
the spectrum for about 2 n seconds at Tp = 12 s (to 1e-3: 210 s for 100, 427 s for 200).

Sources: W. J. Pierson, L. Moskowitz, J. Geophys. Res. 69 (1964) 5181-5190 (alpha = 0.0081); K. Hasselmann et al.,
Dtsch. Hydrogr. Z. A8-12 (1973); M. K. Ochi, E. N. Hubble, Proc. 15th Coastal Engineering Conf. (1976) 301-328 (order lambda);
W. Gautschi, Orthogonal Polynomials (2004), 2.2 (Stieltjes) and 1.4.1 (Golub-Welsch); G. L. Steele, D. Lea, C. H. Flood,
OOPSLA 2014 (SplitMix64). Range: Hs > 0, Tp > 0, 1 <= gamma <= 10, 0.3 <= lambda <= 20.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise

from ..numeric.ops import FLOATS, Ops, Value

GRAVITY = 9.80665
PHILLIPS = 0.0081
"""Pierson's and Moskowitz's alpha."""
BAND = (0.45, 4.0)
"""Default band of a Gauss rule in units of the peak frequency."""
_PANEL = 160
"""Gauss-Legendre points a panel: exact to rounding for these spectra (halving it changes no moment by 1e-14)."""


def peak_frequency(height: float, period: float = 0.0, gravity: float = GRAVITY) -> float:
    """omega_p, rad/s: 2 pi/``period``, or for ``period`` <= 0 that of a Pierson-Moskowitz sea of ``height`` (m),
    (4 alpha 4/5)^(1/4) sqrt(g/Hs) = 0.40124 sqrt(g/Hs)."""
    if period > 0.0:
        return 2.0 * math.pi / period
    return float(steepest_frequency(height, FLOATS, gravity))


def steepest_frequency(height: Value, ops: Ops, gravity: float = GRAVITY) -> Value:
    """omega_p, rad/s, of a Pierson-Moskowitz sea of ``height``, m."""
    return ops.sqrt(math.sqrt(3.2 * PHILLIPS) * gravity / height)


def shape(x: float, gamma: float = 1.0, order: float = 1.0) -> float:
    """b(x), the spectrum for m0 = omega_p = 1; ``gamma`` = 1: Bretschneider and Pierson-Moskowitz, of another ``order``
    lambda one of the two of Ochi and Hubble."""
    if x <= 0.2:
        return 0.0  # below exp(-780)
    if order == 1.0:
        b = 5.0 * x**-5 * math.exp(-1.25 * x**-4)
    else:
        c = order + 0.25
        b = 4.0 * math.exp(order * math.log(c) - math.lgamma(order) - (4.0 * order + 1.0) * math.log(x) - c * x**-4)
    return b if gamma == 1.0 else b * _normalisation(gamma, order) * _peak(x, gamma)


def _peak(x: float, gamma: float) -> float:
    """gamma^r."""
    sigma = 0.07 if x <= 1.0 else 0.09
    return float(gamma ** math.exp(-0.5 * ((x - 1.0) / sigma) ** 2))


@lru_cache(maxsize=64)
def _normalisation(gamma: float, order: float = 1.0) -> float:
    """C such that b keeps m0 = 1: 1/C = 1 + int b_1 (gamma^r - 1) dx, which vanishes away from the peak."""
    excess = sum(w * shape(x, 1.0, order) * (_peak(x, gamma) - 1.0) for x, w in _points(0.2, 2.2))
    return 1.0 / (1.0 + excess)


def spectrum(omega: float, height: float, omega_p: float, gamma: float = 1.0) -> float:
    """S, m2 s/rad, at ``omega``, rad/s, of a sea of significant ``height``, m, and peak frequency ``omega_p``, rad/s."""
    return height * height / 16.0 * shape(omega / omega_p, gamma) / omega_p


def closed_moments(height: float, omega_p: float) -> tuple[float, float, float]:
    """m0, m1, m2 of a Bretschneider spectrum over all frequencies, m2 (rad/s)^k; m4 diverges.

    With A = 5/16 Hs^2 omega_p^4 and B = 5/4 omega_p^4: A/(4B), A Gamma(3/4)/(4 B^(3/4)), sqrt(pi) A/(4 sqrt B).
    """
    m0 = height * height / 16.0
    b = 1.25 * omega_p**4
    return m0, m0 * math.gamma(0.75) * b**0.25, m0 * math.sqrt(math.pi * b)


@lru_cache(maxsize=8)
def legendre_rule(n: int) -> tuple[tuple[float, float], ...]:
    """(node, weight) of the n-point Gauss-Legendre rule on [-1, 1], by Newton's method from Tricomi's start."""
    rule = []
    for k in range(n):
        x = (1.0 - (1.0 - 1.0 / n) / (8.0 * n * n)) * math.cos(math.pi * (4 * k + 3) / (4 * n + 2))
        for _ in range(20):
            p0, p1 = 1.0, x
            for j in range(2, n + 1):
                p0, p1 = p1, ((2 * j - 1) * x * p1 - (j - 1) * p0) / j
            slope = n * (x * p1 - p0) / (x * x - 1.0)
            x -= p1 / slope
            if abs(p1 / slope) < 1e-15:
                break
        rule.append((x, 2.0 / ((1.0 - x * x) * slope * slope)))
    return tuple(rule)


def _points(low: float, high: float) -> list[tuple[float, float]]:
    """(x, weight) of a fine rule on [low, high], split at the peak, where a JONSWAP shape has a kink."""
    cuts = [low, *(cut for cut in (1.0, 1.7) if low < cut < high), high]
    return [
        (0.5 * (a + b) + 0.5 * (b - a) * x, 0.5 * (b - a) * w)
        for a, b in pairwise(cuts)
        for x, w in legendre_rule(_PANEL)
    ]


def integrate(f: Callable[[float], float], low: float, high: float) -> float:
    """int f(x) dx over ``low`` ... ``high`` in x = omega/omega_p: Gauss-Legendre panels split at the peak."""
    return math.fsum(w * f(x) for x, w in _points(low, high))


@lru_cache(maxsize=32)
def gauss_rule(
    n: int, gamma: float = 1.0, band: tuple[float, float] = BAND, order: float = 1.0
) -> tuple[tuple[float, float], ...]:
    """(x_i, w_i) of the n-point Gauss rule of b(x) dx on ``band``, ascending: sum w_i x_i^k is its k-th moment for
    k < 2n. Raises ``ValueError`` unless 1 <= n <= 300 and 0 < band[0] < band[1], and where the band
    carries nothing."""
    if not (1 <= n <= 300 and 0.0 < band[0] < band[1]):
        raise ValueError(f"{n} components on {band}: expected 1 to 300 on a band 0 < low < high")
    points = [(x, w * shape(x, gamma, order)) for x, w in _points(*band)]
    if not math.fsum(w for _, w in points) > 1e-200:  # a share of m0; of less the polynomials overflow
        raise ValueError(f"a band of {band[0]} to {band[1]} peak frequencies carries no energy: waves begin at 0.23 of them")
    return rule_of(points, n)


def rule_of(points: Sequence[tuple[float, float]], n: int) -> tuple[tuple[float, float], ...]:
    """(x_i, w_i) of the n-point Gauss rule of a measure given by many (x, weight), ascending; n is at most their number."""
    diagonal, beside, total = _stieltjes(points, n)
    nodes, first = _eigen(diagonal, beside)
    return tuple(sorted((x, total * v * v) for x, v in zip(nodes, first)))


def _stieltjes(points: Sequence[tuple[float, float]], n: int) -> tuple[list[float], list[float], float]:
    """Three-term recurrence of the orthonormal polynomials of a discrete measure: diagonal and off-diagonal of the
    Jacobi matrix, and the total mass."""
    x = [a for a, _ in points]
    w = [b for _, b in points]
    total = math.fsum(w)
    p0, p1 = [0.0] * len(x), [1.0 / math.sqrt(total)] * len(x)
    diagonal, beside, b = [], [], 0.0
    for k in range(n):
        a = math.fsum(wi * pi * pi * xi for wi, pi, xi in zip(w, p1, x))
        diagonal.append(a)
        if k == n - 1:
            break
        q = [(xi - a) * pi - b * oi for xi, pi, oi in zip(x, p1, p0)]
        b = math.sqrt(math.fsum(wi * qi * qi for wi, qi in zip(w, q)))
        beside.append(b)
        p0, p1 = p1, [qi / b for qi in q]
    return diagonal, beside, total


def _eigen(diagonal: list[float], beside: list[float]) -> tuple[list[float], list[float]]:
    """Eigenvalues of a symmetric tridiagonal matrix and first components of its unit eigenvectors: implicit QL
    (Golub and Welsch, Math. Comp. 23 (1969) 221-230)."""
    n = len(diagonal)
    d, e, z = list(diagonal), [*beside, 0.0], [1.0] + [0.0] * (n - 1)
    for low in range(n):
        while True:
            m = low
            while m < n - 1 and abs(e[m]) > 1e-17 * (abs(d[m]) + abs(d[m + 1])):
                m += 1
            if m == low:
                break
            g = (d[low + 1] - d[low]) / (2.0 * e[low])
            g = d[m] - d[low] + e[low] / (g + math.copysign(math.hypot(g, 1.0), g))
            s, c, p = 1.0, 1.0, 0.0
            for i in range(m - 1, low - 1, -1):
                f, b = s * e[i], c * e[i]
                r = math.hypot(f, g)
                e[i + 1] = r
                if r == 0.0:
                    d[i + 1] -= p
                    e[m] = 0.0
                    break
                s, c = f / r, g / r
                g = d[i + 1] - p
                r = (d[i] - g) * s + 2.0 * c * b
                p = s * r
                d[i + 1] = g + p
                g = c * r - b
                z[i + 1], z[i] = s * z[i] + c * z[i + 1], c * z[i] - s * z[i + 1]
            else:
                d[low] -= p
                e[low] = g
                e[m] = 0.0
    return d, z


def phases(seed: int, n: int) -> tuple[float, ...]:
    """n phases 2 pi u_i in [0, 2 pi), u_i = SplitMix64(``seed``) >> 11 times 2^-53: the same everywhere and for ever.

    Golden-ratio phases will not do: they cancel coherently, and the first 10 s of the sea are flat."""
    mask, state, angles = (1 << 64) - 1, seed & ((1 << 64) - 1), []
    for _ in range(n):
        state = (state + 0x9E3779B97F4A7C15) & mask
        z = state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        z ^= z >> 31
        angles.append(2.0 * math.pi * ((z >> 11) * 2.0**-53))
    return tuple(angles)


def spreading(s: int, directions: int) -> tuple[tuple[float, float], ...]:
    """(mu_j, share_j) of ``directions`` equispaced directions of the distribution cos^2s(mu/2), shares adding to 1.

    For integer s it is a trigonometric polynomial of degree s: with more than s + 2 directions its first and second
    harmonics are exact. Raises ``ValueError`` for fewer."""
    if s < 0 or directions <= s + 2:
        raise ValueError(f"{directions} directions for s = {s}: expected s >= 0 and more than s + 2 directions")
    angles = [2.0 * math.pi * j / directions - math.pi for j in range(1, directions + 1)]
    shares = [max(0.0, math.cos(0.5 * mu)) ** (2 * s) for mu in angles]
    total = math.fsum(shares)
    return tuple((mu, share / total) for mu, share in zip(angles, shares))
