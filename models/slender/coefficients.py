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
| | tail_length | length/L of the tail before it is cut, where it differs from the nose's lam; 0: it does not |
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

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

from ..numeric.ops import FLOATS, NEVER, Ops, Value
from ..protocol.model import Requirement, refusal_of
from .ends import End, Shape, integrals, shape

THEORIES = ("present", "corrected", "modified_old")
LONGEST = 1e6
"""Diameters that an end may be long: beyond 1e8 its eccentricity is 1 to the last digit."""


class Term(NamedTuple):
    """uu u^2 + us u s + ss s^2."""

    uu: Value
    us: Value = 0.0
    ss: Value = 0.0

    def at(self, u: float, s: complex) -> complex:
        """The coefficient at a tow speed and an exponent."""
        return complex(self.uu * u * u + self.us * u * s + self.ss * s * s)


class Numbers(NamedTuple):
    """A body's dimensionless numbers, of any kind of value; ``theory`` is the position in `THEORIES`."""

    end_length: Value = 0.015
    rope_length: Value = 1.0
    tail_cut: Value = 1.0
    slenderness: Value = 40.0
    friction: Value = 1.0
    normal_drag: Value = 0.0
    mass_ratio: Value = 0.5
    damping: Value = 0.0
    theory: Value = 0.0
    nose_factor: Value = 1.0
    tail_factor: Value = 1.0
    nose_drag: Value = 0.0
    tail_length: Value = 0.0


class Ends(NamedTuple):
    """``shape`` of the nose and ``tail_shape``; ``nose`` as published and ``signed_nose`` with the signs that the theory gives
    it; ``drag`` of the body without its base, ``base_drag`` C_DB = 0.029 (1 - al^2)^(3/2)/sqrt(drag), and ``tension`` P, the
    rope's pull, over rho U^2 S/2."""

    shape: Shape
    tail_shape: Shape
    nose: End
    signed_nose: End
    tail: End
    drag: Value
    base_drag: Value
    tension: Value


def ends(body: Numbers, ops: Ops) -> Ends:
    """What the ends of a body do, under its theory."""
    ellipsoid = shape(body.end_length, body.slenderness, ops)
    nose = integrals(body.end_length, ellipsoid, 1.0, ops)
    own = tail_length(body, ops)
    of_tail = shape(own, body.slenderness, ops)
    tail = integrals(own, of_tail, body.tail_cut, ops)
    sign = ops.where(body.theory == 1.0, -1.0, 1.0)
    signed = nose._replace(i3=sign * nose.i3, i6=sign * nose.i6, i7=sign * nose.i7)
    drag = body.friction * (1.0 + nose.i1 + tail.i1) + 2.0 * (signed.i7 + tail.i7)
    base = 1.0 - body.tail_cut**2
    hidden = 0.029 * base * ops.sqrt(base) / ops.sqrt(ops.where(drag > 0.0, drag, 1.0))
    old = body.nose_drag + (1.0 - body.tail_factor) + body.friction
    tension = ops.where(body.theory == 2.0, old, drag + base * hidden)
    return Ends(ellipsoid, of_tail, nose, signed, tail, drag, hidden, tension)


def tail_length(body: Numbers, ops: Ops) -> Value:
    """Length of the tail before it is cut, over that of the body."""
    return ops.where(body.tail_length > 0.0, body.tail_length, body.end_length)


def requirements(body: Numbers, ops: Ops) -> tuple[Requirement, ...]:
    """(value, message): a theory holds where all values are positive."""

    def within(value: Value, low: float, high: float) -> Value:
        return ops.where(value >= low, ops.where(value <= high, 1.0, 0.0), 0.0)

    positive = ("end_length", "rope_length", "slenderness", "tail_cut", "mass_ratio")
    other = ("friction", "normal_drag", "damping", "tail_length")
    free = ("nose_factor", "tail_factor", "nose_drag")
    simple = [
        *((within(ops.abs(getattr(body, n)), 0.0, NEVER), f"{n}: expected a finite number")
          for n in (*positive, *other, *free)),
        *((getattr(body, n), f"{n}: expected a positive number") for n in positive),
        *((within(getattr(body, n), 0.0, NEVER), f"{n}: expected a number that is not negative") for n in other),
        (within(body.tail_cut, 0.0, 1.0), "tail_cut: expected at most 1, 1 a full half ellipsoid, towards 0 a flat base"),
        (1.0 - body.mass_ratio, "mass_ratio: expected M/(m + M) between 0 and 1, 1/2 for neutral buoyancy"),
        (sum(ops.where(body.theory == k, 1.0, 0.0) for k in range(len(THEORIES))),
         "theory: expected 0 (present), 1 (corrected) or 2 (modified_old)"),
        (body.end_length * body.slenderness - 0.5,
         "end_length * slenderness, the ends' length over the diameter: expected more than 0.5; half a diameter long, the "
         "ends are hemispheres, and for anything shorter the formulas of a prolate ellipsoid do not hold: use longer ends"),
        (LONGEST - body.end_length * body.slenderness,
         f"end_length * slenderness, the ends' length over the diameter: expected less than {LONGEST:g}"),
        (tail_length(body, ops) * body.slenderness - 0.5,
         "tail_length * slenderness, the tail's length over the diameter: expected more than 0.5, or 0 for that of the nose"),
        (LONGEST - tail_length(body, ops) * body.slenderness,
         f"tail_length * slenderness, the tail's length over the diameter: expected less than {LONGEST:g}"),
    ]  # fmt: skip
    drag = ends(where_met(simple, body, ops), ops).drag
    text = "drag of the body without its base: expected a positive one, with some friction"
    return (*simple, (ops.where(body.theory == 2.0, 1.0, drag), text))


def where_met(required: Sequence[Requirement], body: Numbers, ops: Ops) -> Numbers:
    """``body`` where all requirements are met, else one that exists: further ones are asked of what can be computed."""
    met: Value = 1.0
    for value, _ in required:
        met = ops.where(value > 0.0, met, 0.0)
    return Numbers(*(ops.where(met > 0.0, a, b) for a, b in zip(body, Numbers())))


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
    tail_length: float = 0.0

    def __post_init__(self) -> None:
        if reason := refusal_of(requirements(self.numbers, FLOATS)):
            raise ValueError(reason)

    @property
    def numbers(self) -> Numbers:
        """The same with the theory as a number, -1 for one that is not there."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        number = THEORIES.index(self.theory) if self.theory in THEORIES else -1
        return Numbers(**(values | {"theory": float(number)}))

    @property
    def ends(self) -> Ends:
        """What its ends do."""
        return ends(self.numbers, FLOATS)

    @property
    def tension(self) -> float:
        """P: the rope's pull over rho U^2 S/2."""
        return float(self.ends.tension)


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


def coefficients(body: Numbers, its_ends: Ends, ops: Ops) -> Coefficients:
    """All coefficients under the body's theory; ``its_ends`` as of `ends`."""
    lam, rope, beta = body.end_length, body.rope_length, body.mass_ratio
    _, _, bare, nose, tail, _, drag, pull = its_ends
    friction, normal = body.friction, body.friction + body.normal_drag
    root, base = ops.sqrt(beta), 1.0 - body.tail_cut**2
    f1, f2 = body.nose_factor, body.tail_factor
    end = friction * (0.5 + tail.i1) + 2.0 * tail.i7 + base * drag
    old = (
        Term(1.0 - 0.5 * (0.5 * friction + base * (1.0 - f2))),
        Term(f1 - 0.5 * (lam + rope) * pull / rope),
        Term(0.5 * pull / rope, f1 * root, ((1.0 - beta) + beta * f1) * bare.i2),
        Term(f2),
        Term(0.0, f2 * root, -((1.0 - beta) + beta * f2) * tail.i2),
    )
    present = (
        Term(1.0 - 0.5 * end),
        Term(
            -0.5 * ((lam + rope) / rope * pull - normal * nose.i1 - 2.0 * nose.i4), root * (nose.i6 - nose.i3),
            -beta * nose.i5,
        ),
        Term(0.5 * pull / rope, root * (0.5 * normal * nose.i1 + nose.i4), (1.0 - beta) * nose.i2 - beta * nose.i3),
        Term(tail.i4 - 0.5 * normal * tail.i1, root * (tail.i6 - tail.i3), -beta * tail.i5),
        Term(
            0.0, root * (tail.i4 - 0.5 * normal * tail.i1), -((1.0 - beta) * tail.i2 + beta * tail.i3)
        ),
    )  # fmt: skip
    c1, g5, g6, g9, g10 = (
        Term(*(ops.where(body.theory == 2.0, a, b) for a, b in zip(one, other))) for one, other in zip(old, present)
    )
    moment = 0.5 * lam * pull / rope
    return Coefficients(
        c1=c1, c2=Term(0.5 * friction), c3=Term(0.5 * normal, 2.0 * root), c4=Term(0.0, 0.5 * root * normal, 1.0),
        g5=g5, g6=g6, g7=Term(-moment * (lam + rope)), g8=Term(moment), g9=g9, g10=g10,
    )  # fmt: skip
