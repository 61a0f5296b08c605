"""Towed slender body: the equation of its lateral motion and its boundary conditions, under three theories.

    g0 y'''' + (C1 + C2 xi) y'' + C3 y' + C4 y = 0,  -1/2 < xi < 1/2,  g0 = 1 + nu s
    xi = -1/2:  g0 y''' + g5 y' + g6 y = 0,   g0 y'' + g7 y' + g8 y = 0
    xi = +1/2:  g0 y''' + g9 y' + g10 y = 0,  y'' = 0

| symbol | name | meaning, dimensionless |
|---|---|---|
| xi, y | | x/L along the body, the nose (towed end) at -1/2; lateral displacement over L, y ~ exp(s t') |
| s | | growth rate and frequency in the time unit tau = L^2 sqrt((m + M)/EI); the thesis' omega = -i s |
| u | | tow speed sqrt(M/EI) U L |
| lam, eps, al | end_length, slenderness, tail_cut | end length/L, L/D, tail cut (1 full, towards 0 flat) |
| Lam | rope_length | length of the rope/L |
| eps cf, eps cd | friction, normal_drag | drag coefficients times eps; e_N = eps (cf + cd) acts across |
| beta | mass_ratio | M/(m + M), M mass of water displaced and m mass of the body per length; 1/2 is neutral |
| nu | damping | Kelvin-Voigt number mu_I/(sqrt(EI (m + M)) L^2) |

Every coefficient is a u^2 + b u s + c s^2: a `Term`.

Theories: ``present`` with the signs as published, which reproduce the tables of the thesis; ``corrected`` with the
nose's added mass, momentum and pressure of the physical sign (as published the nose's added mass is subtracted, and two
full half spheroids have drag in potential flow, 19.5 % of the rope tension; equation 16 measures x towards the nose tip
without reversing the even terms of equation 19); ``modified_old``, Paidoussis (1970), with end factors f1, f2 and c1.

Assumptions: (1) small slopes; (2) Morison-like slender-body forces, no separation but at the base; (3) a massless,
inextensible rope to the tip of the nose; (4) neutral buoyancy; (5) uniform section between the ends; (6) steady tow.

Source: thesis on the towed slender body, equation 61, programs E and F; the old theory: M. P. Paidoussis, J. Ship
Research 14 (1970). C_DB is Hoerner's, used with the base area as printed. Validated there for u <= 14.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

from .slender_ends import End, Shape, integrals, shape

THEORIES = ("present", "corrected", "modified_old")


class Term(NamedTuple):
    """uu u^2 + us u s + ss s^2."""

    uu: float
    us: float = 0.0
    ss: float = 0.0

    def at(self, u: float, s: complex) -> complex:
        """The coefficient at a tow speed and an exponent."""
        return self.uu * u * u + self.us * u * s + self.ss * s * s


@dataclass(frozen=True)
class Body:
    """A towed body, dimensionless. Raises ``ValueError`` with the reason where no theory holds."""

    end_length: float = 0.015
    rope_length: float = 1.0
    tail_cut: float = 1.0
    slenderness: float = 40.0
    friction: float = 1.0
    normal_drag: float = 0.0
    mass_ratio: float = 0.5
    damping: float = 0.0
    theory: str = "present"
    nose_factor: float = 1.0
    tail_factor: float = 1.0
    nose_drag: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "theory" and not math.isfinite(value):
                raise ValueError(f"{field.name} = {value}: expected a finite number")
        for name in ("end_length", "rope_length", "slenderness"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} = {getattr(self, name):g}: expected a positive number")
        for name in ("friction", "normal_drag", "damping"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} = {getattr(self, name):g}: expected a number that is not negative")
        if not 0.0 < self.tail_cut <= 1.0:
            raise ValueError(
                f"tail_cut = {self.tail_cut:g}: expected 0 < tail_cut <= 1, 1 a full half ellipsoid and towards 0 a "
                "flat base"
            )
        if not 0.0 < self.mass_ratio < 1.0:
            raise ValueError(
                f"mass_ratio = {self.mass_ratio:g}: expected M/(m + M) between 0 and 1, 1/2 for neutral buoyancy"
            )
        if self.theory not in THEORIES:
            raise ValueError(f"theory {self.theory!r}: expected one of {', '.join(THEORIES)}")
        shape(self.end_length, self.slenderness)

    @property
    def shape(self) -> Shape:
        """The ellipsoid of the ends."""
        return shape(self.end_length, self.slenderness)

    @property
    def nose(self) -> End:
        """Integrals of the nose, positive as published."""
        return integrals(self.end_length, self.shape, 1.0)

    @property
    def tail(self) -> End:
        """Integrals of the tail."""
        return integrals(self.end_length, self.shape, self.tail_cut)

    @property
    def signed_nose(self) -> End:
        """Integrals of the nose with the signs that this theory gives them."""
        nose = self.nose
        if self.theory == "corrected":
            return nose._replace(i3=-nose.i3, i6=-nose.i6, i7=-nose.i7)
        return nose

    @property
    def base_drag(self) -> float:
        """C_DB = 0.029 (1 - al^2)^(3/2)/sqrt(F0), F0 the drag without the base."""
        return 0.029 * math.sqrt(1.0 - self.tail_cut**2) ** 3 / math.sqrt(self._forebody_drag)

    @property
    def _forebody_drag(self) -> float:
        nose, tail = self.signed_nose, self.tail
        drag = self.friction * (1.0 + nose.i1 + tail.i1) + 2.0 * (nose.i7 + tail.i7)
        if not drag > 0.0:
            raise ValueError(f"drag of the body without its base {drag:g}: expected a positive one, with some friction")
        return drag

    @property
    def tension(self) -> float:
        """P: the rope's pull over rho U^2 S/2."""
        if self.theory == "modified_old":
            return self.nose_drag + (1.0 - self.tail_factor) + self.friction
        return self._forebody_drag + (1.0 - self.tail_cut**2) * self.base_drag


class Coefficients(NamedTuple):
    """C1..C4 of the equation; at the nose g5, g6 with y''' and g7, g8 with y''; at the tail g9, g10 with y'''."""

    c1: Term
    c2: Term
    c3: Term
    c4: Term
    g5: Term
    g6: Term
    g7: Term
    g8: Term
    g9: Term
    g10: Term


def coefficients(body: Body) -> Coefficients:
    """All coefficients under the body's theory."""
    lam, rope, beta = body.end_length, body.rope_length, body.mass_ratio
    nose, tail, pull = body.signed_nose, body.tail, body.tension
    friction, normal = body.friction, body.friction + body.normal_drag
    root, base = math.sqrt(beta), 1.0 - body.tail_cut**2
    c2, c3, c4 = Term(0.5 * friction), Term(0.5 * normal, 2.0 * root), Term(0.0, 0.5 * root * normal, 1.0)
    moment = 0.5 * lam * pull / rope
    g7, g8 = Term(-moment * (lam + rope)), Term(moment)
    if body.theory == "modified_old":
        f1, f2 = body.nose_factor, body.tail_factor
        return Coefficients(
            Term(1.0 - 0.5 * (0.5 * friction + base * (1.0 - f2))), c2, c3, c4,
            Term(f1 - 0.5 * (lam + rope) * pull / rope),
            Term(0.5 * pull / rope, f1 * root, ((1.0 - beta) + beta * f1) * nose.i2),
            g7, g8,
            Term(f2),
            Term(0.0, f2 * root, -((1.0 - beta) + beta * f2) * tail.i2),
        )  # fmt: skip
    end = friction * (0.5 + tail.i1) + 2.0 * tail.i7 + base * body.base_drag
    return Coefficients(
        Term(1.0 - 0.5 * end), c2, c3, c4,
        Term(
            -0.5 * ((lam + rope) / rope * pull - normal * nose.i1 - 2.0 * nose.i4), root * (nose.i6 - nose.i3),
            -beta * nose.i5,
        ),
        Term(
            0.5 * pull / rope, root * (0.5 * normal * nose.i1 + nose.i4), (1.0 - beta) * nose.i2 - beta * nose.i3
        ),
        g7, g8,
        Term(tail.i4 - 0.5 * normal * tail.i1, root * (tail.i6 - tail.i3), -beta * tail.i5),
        Term(
            0.0, root * (tail.i4 - 0.5 * normal * tail.i1), -((1.0 - beta) * tail.i2 + beta * tail.i3)
        ),
    )  # fmt: skip
