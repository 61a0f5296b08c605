"""The distribution of the largest value in a record of fixed length, from the maxima of N records that differ in their seeds.

    P(max <= y) = exp(-exp(-(y - mu)/beta)),   y_q = mu - beta ln(-ln q),   P(max > L) = 1 - exp(-exp(-(L - mu)/beta))

| symbol | meaning | unit |
|---|---|---|
| mu, beta | location and scale of the Gumbel distribution; mu is the most probable maximum | that of y |
| y_q | value that the maximum stays under with probability q | that of y |

Fitted by maximum likelihood. The estimators move with the data (y -> a + b y), so that (y_q - mu^)/beta^ has one distribution
for every mu and beta, which is found once for N and q from `DRAWS` samples of N standard Gumbel values. Confidence intervals are
thus exact for maxima that are Gumbel's, for any N, but for 1 % of their width (the draws). So is the test of fit by the
correlation coefficient of the probability plot. Minima are maxima of -y.

Assumptions: (1) the records are independent; (2) peaks have a tail of the exponential kind (Gaussian, Rayleigh, Weibull),
whose maxima tend to Gumbel's distribution (Fisher and Tippett; with 1000 waves in three hours it is near, and the fit is tested);
a line that snaps or a value with a bound has another one. Where several records have one and the same extreme, as at a bound,
nothing is fitted: quantiles are those of the sample, and intervals those of binomial counts.

Sources: E. J. Gumbel, Statistics of Extremes (1958); J. F. Lawless, Statistical Models and Methods for Lifetime Data (2003), 5.2
(pivotal quantities); R. M. Vogel, Water Resources Research 22 (1986) 587-590 (correlation test); C. J. Clopper, E. S. Pearson,
Biometrika 26 (1934) 404-413. That maxima of some 20 records are fitted so is common practice offshore (DNV-RP-C205, 3.7).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DRAWS = 20_000
"""Samples from which the distribution of the pivots is taken."""
FEWEST = 5
"""Records for which a distribution is fitted: below, intervals are wider than anyone would use."""
CONFIDENCE = 0.9
"""Of all intervals: 5 % on each side."""
REJECTED = 0.05
"""Level of the test of fit."""
EQUAL = 1e-9
"""Of the largest value: extremes no further apart are one value, a bound."""


@dataclass(frozen=True)
class Extreme:
    """What N extremes say. ``probable``: most probable extreme; ``quantile``, not passed with the probability asked for, and its
    confidence interval ``low`` ... ``high``; ``exceedance``: probability to pass the limit, with ``least`` ... ``most``. ``fit``:
    share of samples of Gumbel's distribution that look less like it (NaN: nothing was fitted). ``kind``: "Gumbel", "sample" (of
    values at a bound), "constant", "linear" (`screening`)."""

    probable: float
    quantile: float
    low: float
    high: float
    exceedance: float
    least: float
    most: float
    fit: float
    kind: str


def of_maxima(values: Array, limit: float, upper: bool, probability: float) -> Extreme:
    """From the extremes of N records, shape (N,), finite, N >= `FEWEST`: maxima for an ``upper`` limit, else minima."""
    sign = 1.0 if upper else -1.0
    y, bound = np.sort(sign * np.asarray(values, float)), sign * limit
    if len(y) < FEWEST:
        raise ValueError(f"{len(y)} extremes: expected at least {FEWEST}")
    size = EQUAL * float(np.abs(y).max())
    if y[-1] - y[0] <= size:
        passed = float(y[-1] > bound)
        value = sign * float(y[-1])
        return Extreme(value, value, value, value, passed, passed, passed, np.nan, "constant")
    if (np.diff(y) <= size).any():
        return _of_sample(y, bound, sign, probability)
    mu, beta, fit = (float(v[0]) for v in fitted(y[None, :]))
    locations, scales, fits = _pivots(len(y))
    g = -math.log(-math.log(probability))
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile((g - locations) / scales, (tail, 1.0 - tail))
    z = (bound - mu) / beta
    # P(g_p <= locations + scales z): what the limit is in the sample's own measure (Lawless)
    inner, outer = np.quantile(locations + scales * z, (1.0 - tail, tail))
    least, most = sorted((sign * (mu + beta * float(low)), sign * (mu + beta * float(high))))
    return Extreme(
        sign * mu, sign * (mu + beta * g), least, most, _passes(z), _passes(inner), _passes(outer),
        float(np.mean(fits <= fit)), "Gumbel",
    )  # fmt: skip


def _passes(z: float) -> float:
    """1 - exp(-exp(-z))."""
    return float(-np.expm1(-np.exp(-z)))


def _of_sample(y: Array, bound: float, sign: float, probability: float) -> Extreme:
    """Quantile and share of a sample, sorted, with their binomial intervals."""
    from scipy.stats import beta, binom

    n, passed = len(y), int((y > bound).sum())
    tail = 0.5 * (1.0 - CONFIDENCE)
    least = float(beta.ppf(tail, passed, n - passed + 1)) if passed else 0.0
    most = float(beta.ppf(1.0 - tail, passed + 1, n - passed)) if passed < n else 1.0
    ranks = binom.ppf((tail, 1.0 - tail), n, probability)
    low, high = (y[int(min(max(rank - shift, 0), n - 1))] for rank, shift in zip(ranks, (1, 0)))
    quantile = float(np.quantile(y, probability, method="higher"))
    low, high = sorted((sign * float(low), sign * float(high)))
    return Extreme(sign * float(np.median(y)), sign * quantile, low, high, passed / n, least, most, np.nan, "sample")


def fitted(samples: Array) -> tuple[Array, Array, Array]:
    """mu, beta and the correlation coefficient of the probability plot of each row of ``samples``, shape (rows, N), by maximum
    likelihood: beta = mean(y) - sum y exp(-y/beta) / sum exp(-y/beta), by Newton's method from the moments."""
    least = samples.min(axis=1, keepdims=True)
    y = samples - least  # so that no exponential overflows
    mean = y.mean(axis=1)
    beta = np.sqrt(6.0) / np.pi * y.std(axis=1)
    for _ in range(60):
        w = np.exp(-y / beta[:, None])
        total = w.sum(axis=1)
        first, second = (y * w).sum(axis=1) / total, (y * y * w).sum(axis=1) / total
        step = (beta - mean + first) / (1.0 + (second - first * first) / (beta * beta))
        beta = np.maximum(beta - step, 0.1 * beta)
        if (np.abs(step) <= 1e-12 * beta).all():
            break
    w = np.exp(-y / beta[:, None])
    mu = least[:, 0] - beta * np.log(w.mean(axis=1))
    n = samples.shape[1]
    places = -np.log(-np.log((np.arange(1, n + 1) - 0.44) / (n + 0.12)))  # Gringorten's
    ordered = np.sort(y, axis=1) - mean[:, None]
    places = places - places.mean()
    return mu, beta, ordered @ places / np.sqrt((ordered * ordered).sum(axis=1) * (places @ places))


@lru_cache(maxsize=16)
def _pivots(n: int) -> tuple[Array, Array, Array]:
    """mu^, beta^ and the correlation of many samples of n standard Gumbel values."""
    uniform = np.random.default_rng(1958).random((DRAWS, n))
    return fitted(-np.log(-np.log(np.clip(uniform, 1e-300, None))))
