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

import math
from typing import NamedTuple

SERIES_BELOW = 0.5
"""Eccentricity below which the series are used."""
TERMS = 32
"""Terms of the series: 0.5^(2 * 32) is below one unit in the last place."""


class Shape(NamedTuple):
    """Eccentricity and inertia coefficients of the ellipsoid, -."""

    e: float
    k1: float
    k2: float
    l3: float


class End(NamedTuple):
    """The seven integrals of one end, -."""

    i1: float
    i2: float
    i3: float
    i4: float
    i5: float
    i6: float
    i7: float


def shape(end_length: float, slenderness: float) -> Shape:
    """The ellipsoid of lam = ``end_length`` and eps = ``slenderness``. Raises ``ValueError`` for lam eps <= 1/2."""
    product = end_length * slenderness
    if not product > 0.5:
        raise ValueError(
            f"end_length * slenderness = {product:g}: expected more than 0.5; half a diameter long, the ends are "
            "hemispheres, and for anything shorter the formulas of a prolate ellipsoid do not hold: use longer ends"
        )
    r = 0.5 / product
    e = math.sqrt((1.0 - r) * (1.0 + r))
    if e < SERIES_BELOW:
        powers = [(j, e ** (2 * j - 2)) for j in range(1, TERMS)]
        axial = sum(q / (2 * j + 1) for j, q in powers)
        lateral = sum(2 * j * q / (2 * j + 1) for j, q in powers)
        k1, k2 = axial / lateral, lateral / sum((2 * j + 2) * q / (2 * j + 1) for j, q in powers)
        # both sums of l3 begin with e^4, which cancels
        numerator = sum((2 * j - 2) * q / (2 * j + 1) for j, q in ((j, e ** (2 * j - 4)) for j in range(2, TERMS)))
        denominator = sum(
            (6.0 / (2 * j + 1) - 3.0 / (2 * j - 1) + 1.0) * e ** (2 * j - 4) for j in range(2, TERMS)
        )
        return Shape(e, k1, k2, e * e * numerator / denominator)
    half, square = math.atanh(e), r * r  # G/2 and 1 - e^2
    lateral = half - e / square
    k1 = -(half - e) / lateral
    k2 = -lateral / (half - (e - 2.0 * e**3) / square)
    ratio = e * e / square
    l3 = -e * e * (3.0 * half / e - 3.0 - ratio) / (3.0 * (2.0 - e * e) * half / e - 6.0 + ratio)
    return Shape(e, k1, k2, l3)


def integrals(end_length: float, body: Shape, cut: float) -> End:
    """The integrals of an end of lam = ``end_length`` up to al = ``cut``, 0 < al <= 1."""
    (e, k1, k2, l3), lam, al = body, end_length, cut
    i2 = lam * al * (1.0 - al * al / 3.0)
    if e < SERIES_BELOW:
        lift = sum(
            e ** (2 * j - 2) * (al ** (2 * j) / j - al ** (2 * j + 2) / (j + 1)) for j in range(1, TERMS)
        )
        stream = sum(
            e ** (2 * j) * al ** (2 * j + 1)
            * ((1.0 - l3) / (2 * j + 1) + al * al * ((3.0 * l3 - 1.0) / (2 * j + 3) - 2.0 * l3 * al * al / (2 * j + 5)))
            for j in range(TERMS)
        )  # fmt: skip
        i6 = lam * (1.0 + k1) * stream - i2
    else:
        lift = (al * al + (1.0 / (e * e) - 1.0) * math.log1p(-e * e * al * al)) / (e * e)
        a, b = k1 - (1.0 + k1) * l3, e * e + 2.0 * (1.0 + k1) * l3
        c = (a - b) / (e * e)
        i6 = lam / (e * e) * (
            b * al**3 / 3.0 + (a - b + b / (e * e)) * al + (a - c - b / e**4) * e * math.atanh(e * al)
        )  # fmt: skip
    return End(
        i1=0.5 * lam * (al * math.sqrt(1.0 - al * al) + math.asin(al)),
        i2=i2,
        i3=k2 * i2,
        i4=0.5 * (1.0 + k1) * (1.0 + k2) * lift,
        i5=0.25 * lam * lam * l3 * al * al * (2.0 - al * al),
        i6=i6,
        i7=0.5 * ((1.0 + k1) ** 2 * lift - al * al),
    )
