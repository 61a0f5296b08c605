"""Potential flow about the tapered ends of a slender body: the closed end integrals of the thesis.

Both ends are half ellipsoids of revolution of length lam L; the tail is cut off at al lam L. With x from 0 at the
shoulder to 1 at the full tip, and e^2 = 1 - 1/(4 lam^2 eps^2) the eccentricity of the full ellipsoid:

| name | integral from 0 to al (the nose has al = 1) | enters |
|---|---|---|
| i1 | lam sqrt(1 - x^2) | friction area |
| i2 | lam (1 - x^2) | volume |
| i3 | k2 i2 | lateral added mass |
| i4 | (1 + k1)(1 + k2) x (1 - x^2)/(1 - e^2 x^2) | lift |
| i5 | lam^2 l3 x (1 - x^2) | moment of added mass |
| i6 | lam (1 - x^2) [(1 + k1)(1 + l3 (2 x^2 - 1))/(1 - e^2 x^2) - 1] | momentum of the stream |
| i7 | x [(1 + k1)^2 (1 - x^2)/(1 - e^2 x^2) - 1] | axial pressure |

k1, k2 are Lamb's inertia coefficients along and across, l3 that of rotation. All numbers are dimensionless: lengths over
the length L of the cylindrical body, eps = L/D.

Assumptions: (1) the flow about an end is that about the whole ellipsoid; (2) a cut tail keeps it up to the cut.

The closed forms subtract equal numbers where the ellipsoid is near a sphere (e -> 0: l3 has lost all digits at
e = 0.0014) and are replaced by power series in e^2 below e = 0.5; the sphere's limits are k1 = k2 = 1/2, l3 = e^2/3.

Source: thesis on the towed slender body, appendix B and program E; the closed forms agree with quadrature to 4e-16.
Not valid for lam eps <= 1/2, where the ellipsoid is oblate.
"""

from __future__ import annotations

from itertools import accumulate, repeat
from operator import mul
from typing import NamedTuple

from ..numeric.ops import Ops, Value

SERIES_BELOW = 0.5
"""Eccentricity below which the series are used."""
TERMS = 32
"""Terms of the series: 0.5^(2 * 32) is below one unit in the last place."""


class Shape(NamedTuple):
    """Eccentricity and inertia coefficients of the ellipsoid, -."""

    e: Value
    k1: Value
    k2: Value
    l3: Value


class End(NamedTuple):
    """The seven integrals of one end, -."""

    i1: Value
    i2: Value
    i3: Value
    i4: Value
    i5: Value
    i6: Value
    i7: Value


def shape(end_length: Value, slenderness: Value, ops: Ops) -> Shape:
    """The ellipsoid of lam = ``end_length`` and eps = ``slenderness``, lam eps > 1/2."""
    r = 0.5 / (end_length * slenderness)
    e = ops.sqrt((1.0 - r) * (1.0 + r))
    near, far = _by_series(ops.minimum(e, SERIES_BELOW)), _closed(ops.maximum(e, SERIES_BELOW), r * r, ops)
    return Shape(e, *(ops.where(e < SERIES_BELOW, a, b) for a, b in zip(near, far)))


def integrals(end_length: Value, body: Shape, cut: Value, ops: Ops) -> End:
    """The integrals of an end of lam = ``end_length`` up to al = ``cut``, 0 < al <= 1."""
    (e, k1, k2, l3), lam, al = body, end_length, cut
    near = _flow_by_series(ops.minimum(e, SERIES_BELOW), al, k1, l3)
    far = _flow_closed(ops.maximum(e, SERIES_BELOW), al, k1, l3, ops)
    lift, momentum = (ops.where(e < SERIES_BELOW, a, b) for a, b in zip(near, far))
    square = al * al
    i2 = lam * al * (1.0 - square / 3.0)
    root = ops.sqrt(1.0 - square)
    return End(
        i1=0.5 * lam * (al * root + ops.atan2(al, root)),
        i2=i2,
        i3=k2 * i2,
        i4=0.5 * (1.0 + k1) * (1.0 + k2) * lift,
        i5=0.25 * lam * lam * l3 * square * (2.0 - square),
        i6=lam * momentum,
        i7=0.5 * ((1.0 + k1) ** 2 * lift - square),
    )


def _powers(q: Value) -> list[Value]:
    """1, q, q^2, ..., q^(`TERMS` - 1)."""
    return list(accumulate(repeat(q, TERMS - 1), mul, initial=1.0))


def _by_series(e: Value) -> tuple[Value, Value, Value]:
    """(k1, k2, l3) of a small eccentricity."""
    power = _powers(e * e)
    axial = sum(power[j] / (2 * j + 3) for j in range(TERMS))
    lateral = sum((2 * j + 2) * power[j] / (2 * j + 3) for j in range(TERMS))
    k2 = lateral / sum((2 * j + 4) * power[j] / (2 * j + 3) for j in range(TERMS))
    # both sums of l3 begin with e^4, which cancels
    numerator = sum((2 * j + 2) * power[j] / (2 * j + 5) for j in range(TERMS))
    denominator = sum((6.0 / (2 * j + 5) - 3.0 / (2 * j + 3) + 1.0) * power[j] for j in range(TERMS))
    return axial / lateral, k2, e * e * numerator / denominator


def _closed(e: Value, square: Value, ops: Ops) -> tuple[Value, Value, Value]:
    """(k1, k2, l3) of an eccentricity that is not small, ``square`` = 1 - e^2."""
    half = _artanh(e, ops)
    lateral = half - e / square
    ratio = e * e / square
    l3 = -e * e * (3.0 * half / e - 3.0 - ratio) / (3.0 * (2.0 - e * e) * half / e - 6.0 + ratio)
    return -(half - e) / lateral, -lateral / (half - (e - 2.0 * e * e * e) / square), l3


def _flow_by_series(e: Value, al: Value, k1: Value, l3: Value) -> tuple[Value, Value]:
    """The integral of 2 x (1 - x^2)/(1 - e^2 x^2), and i6/lam."""
    square = al * al
    power = _powers(e * e * square)
    lift = square * sum(power[j] * (1.0 / (j + 1) - square / (j + 2)) for j in range(TERMS))
    stream = sum(
        power[j]
        * ((1.0 - l3) / (2 * j + 1) + square * ((3.0 * l3 - 1.0) / (2 * j + 3) - 2.0 * l3 * square / (2 * j + 5)))
        for j in range(TERMS)
    )
    return lift, (1.0 + k1) * al * stream - al * (1.0 - square / 3.0)


def _flow_closed(e: Value, al: Value, k1: Value, l3: Value, ops: Ops) -> tuple[Value, Value]:
    """The same for an eccentricity that is not small."""
    q, square = e * e, al * al
    lift = (square + (1.0 / q - 1.0) * ops.log1p(-q * square)) / q
    a, b = k1 - (1.0 + k1) * l3, q + 2.0 * (1.0 + k1) * l3
    c = (a - b) / q
    momentum = b * al * square / 3.0 + (a - b + b / q) * al + (a - c - b / (q * q)) * e * _artanh(e * al, ops)
    return lift, momentum / q


def _artanh(x: Value, ops: Ops) -> Value:
    return 0.5 * ops.log1p(2.0 * x / (1.0 - x))
