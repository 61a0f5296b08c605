"""Implicit Runge-Kutta methods of one diagonal with an explicit first stage (ESDIRK), stiffly accurate and L-stable.

The first stage is the last one of the step before, and all others have stage order 2: a stiff mode that the top drives
(the wire's own stretch) costs no order of the motion. Not to be confused with SDIRK methods (stage order 1), nor with
Rosenbrock's, which take a new Jacobian a step.

Source: C. A. Kennedy, M. H. Carpenter, Appl. Numer. Math. 44 (2003) p. 139 (orders 3 and 4); R. E. Bank et al., IEEE
Trans. CAD 4 (1985) p. 436 (TR-BDF2), with the embedded method of M. E. Hosea, L. F. Shampine, Appl. Numer. Math. 20
(1996) p. 21.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Tableau:
    """``rows`` of the stages after the first, diagonal last; the last row is the step. ``error``: weights of the stages in
    the difference from the embedded method of order one less."""

    name: str
    order: int
    diagonal: float
    places: tuple[float, ...]
    rows: tuple[tuple[float, ...], ...]
    error: tuple[float, ...]


def _tableau(name: str, order: int, rows: tuple[tuple[float, ...], ...], embedded: tuple[float, ...]) -> Tableau:
    places = tuple(math.fsum(row) for row in rows)
    return Tableau(name, order, rows[0][-1], places, rows, tuple(b - e for b, e in zip(rows[-1], embedded)))


def _third() -> Tableau:
    g, c3 = 0.4358665215084589994160194, 0.6
    a32 = c3 * (c3 - 2.0 * g) / (4.0 * g)
    b2 = (-2.0 + 3.0 * c3 + 6.0 * g * (1.0 - c3)) / (12.0 * g * (c3 - 2.0 * g))
    b3 = (1.0 - 6.0 * g + 6.0 * g * g) / (3.0 * c3 * (c3 - 2.0 * g))
    rows = ((g, g), (c3 - a32 - g, a32, g), (1.0 - b2 - b3 - g, b2, b3, g))
    embedded = (
        2756255671327 / 12835298489170, -10771552573575 / 22201958757719, 9247589265047 / 10645013368117,
        2193209047091 / 5459859503100,
    )  # fmt: skip
    return _tableau("esdirk3", 3, rows, embedded)


def _second() -> Tableau:
    g, w = 1.0 - 1.0 / math.sqrt(2.0), math.sqrt(2.0) / 4.0
    return _tableau("tr-bdf2", 2, ((g, g), (w, w, g)), ((1.0 - w) / 3.0, (3.0 * w + 1.0) / 3.0, g / 3.0))


def _fourth() -> Tableau:
    a41, a43 = 5012029 / 34652500, 174375 / 388108
    rows = (
        (1 / 4, 1 / 4), (8611 / 62500, -1743 / 31250, 1 / 4),
        (a41, 31 / 50 - a41 - a43 - 1 / 4, a43, 1 / 4),
        (15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912, 1 / 4),
        (82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4),
    )  # fmt: skip
    embedded = (
        4586570599 / 29645900160, 0.0, 178811875 / 945068544, 814220225 / 1159782912, -3700637 / 11593932,
        61727 / 225920,
    )  # fmt: skip
    return _tableau("esdirk4", 4, rows, embedded)


SECOND, THIRD, FOURTH = _second(), _third(), _fourth()
