"""A tow: cable, body, speed and quadrant, and what makes no sense of them.

    Quadrant I:  a surface ship tows a deep body;    towpoint above the body,  0 < phi < pi/2
    Quadrant II: a submarine tows a buoyant float;   towpoint below the body,  pi/2 < phi < pi

| symbol | meaning | unit |
|---|---|---|
| s | length along the cable from the body, positive upwards: towpoint at +L (I) or -L (II) | m |
| phi | angle of the tangent (towards increasing s) with the direction of towing | rad |
| mu, w | mass and weight in water per length | kg/m, N/m |
| lam | nu rho pi h^2/(4 mu): added mass over mass, normal to the cable | - |
| m, m_s, m_h | mass of the body, its added masses in surge and heave | kg |
| W_B, L_B, D_B | weight (in water, or in air with the buoyancy in L_B), lift and drag of the body | N |
| c | tow speed | m/s |
| EA | axial stiffness; infinite: inextensible | N |

The numbers may be in any consistent units.

Assumptions: (1) motion in the vertical plane of towing, still water; (2) no bending stiffness, no torsion; (3) loads
per unstretched length; (4) constant lift and drag of the body, unless damping is given.

Source: small-perturbation report on towed cables, Equations [1]-[14], Figures 1 and 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from ..numeric.ops import FLOATS, Ops, Value
from ..protocol.model import Requirement, refusal_of
from .loading import Loading


class CableError(ValueError):
    """A tow that makes no sense, or a solve that reached its bound; the message says which and what was expected."""


@dataclass(frozen=True)
class Cable:
    """Cable; ``added_mass`` is nu (1: bare and round), ``momentum_form`` the report's form of the added mass
    (d/dt of lam mu U n), else Morison's (lam mu times the normal acceleration)."""

    length: float
    mass: float
    weight: float
    thickness: float
    drag_coefficient: float
    loading: Loading
    added_mass: float = 1.0
    momentum_form: bool = False
    axial_stiffness: float = math.inf


@dataclass(frozen=True)
class Body:
    """Towed body: masses, kg; weight in water, lift and drag, N; linear damping, N s/m, on top of the constant drag."""

    mass: float
    added_mass_surge: float
    added_mass_heave: float
    weight: float
    lift: float
    drag: float
    damping_surge: float = 0.0
    damping_heave: float = 0.0


@dataclass(frozen=True)
class Tow:
    """Everything the theory needs. Raises `CableError` at once for values that make no sense."""

    cable: Cable
    body: Body
    speed: float
    density: float
    quadrant: int = 1

    def __post_init__(self) -> None:
        reason = refusal(self)
        if reason:
            raise CableError(reason)

    @property
    def sign(self) -> float:
        """sigma: +1 in Quadrant I, -1 in Quadrant II."""
        return 3.0 - 2.0 * self.quadrant

    @property
    def drag_factor(self) -> float:
        """rho h C_D/2, N s^2/m^3."""
        return 0.5 * self.density * self.cable.thickness * self.cable.drag_coefficient

    @property
    def added_mass_ratio(self) -> float:
        """lam [14]."""
        k = self.cable
        return k.added_mass * self.density * math.pi * k.thickness**2 / (4.0 * k.mass)

    @property
    def end_tension(self) -> float:
        """T0(0), N [33]."""
        net = self.body.weight - self.body.lift
        # a power, which symbols have too
        size: float = (self.body.drag * self.body.drag + net * net) ** 0.5
        return size

    @property
    def end_angle(self) -> float:
        """phi0(0), rad [34]."""
        b = self.body
        if self.quadrant == 1:
            return math.atan2(b.weight - b.lift, b.drag)
        return math.atan2(b.lift - b.weight, -b.drag)


@dataclass(frozen=True)
class TracedTow(Tow):
    """A tow of symbols, which cannot be refused: its `requirements` are results of the trace."""

    def __post_init__(self) -> None:
        pass


POSITIVE = {"cable.length", "cable.mass", "cable.axial_stiffness"}
SIGNED = {"cable.weight", "body.weight", "body.lift"}


def _named(tow: Tow) -> list[tuple[str, Value]]:
    """The plain numbers of a tow by their full names."""
    values = [(f"cable.{f.name}", getattr(tow.cable, f.name)) for f in fields(Cable)]
    values += [(f"body.{f.name}", getattr(tow.body, f.name)) for f in fields(Body)]
    values = [(n, v) for n, v in values if not isinstance(v, (bool, Loading)) and n != "cable.momentum_form"]
    return [*values, ("speed", tow.speed), ("density", tow.density)]


def requirements(tow: Tow, ops: Ops) -> list[Requirement]:
    """What must hold for a tow to make sense; messages give the offending number, if it is a number."""

    def said(value: Value, what: str = " is {:.6g}") -> str:
        return what.format(value) if isinstance(value, (int, float)) else ""

    def holds(condition: Value) -> Value:
        return ops.where(condition, 1.0, 0.0)

    net = tow.body.weight - tow.body.lift
    required = [
        (
            holds(tow.sign * tow.sign == 1.0),
            f"quadrant{said(tow.quadrant)}: expected 1 (ship tows a body) or 2 (submarine tows a float)",
        )
    ]
    for name, value in _named(tow):
        if name == "speed":
            expected = "a speed > 0: at rest the direction of the flow is undefined and the linear drag vanishes"
            required.append((value, f"speed{said(value)}: expected {expected}"))
        elif name in POSITIVE:
            required.append((value, f"{name}{said(value)}: expected a positive number"))
        elif name not in SIGNED:
            required.append((holds(value >= 0.0), f"{name}{said(value)}: expected a number >= 0"))
    return [
        *required,
        (
            tow.end_tension,
            "the cable carries no tension at the body (drag 0, lift equals weight): its direction there is undefined; "
            "expected drag or a net weight, however small",
        ),
        (
            holds((tow.sign < 0.0) + (net >= 0.0)),
            f"the body is buoyant{said(-net, ' (lift exceeds weight by {:g})')} in Quadrant I: expected quadrant 2, or "
            "more weight",
        ),
        (
            holds((tow.sign > 0.0) + (net <= 0.0)),
            f"the body is heavy{said(net, ' (weight exceeds lift by {:g})')} in Quadrant II: expected quadrant 1, or "
            "more lift",
        ),
    ]


def refusal(tow: Tow) -> str:
    """Why the tow, of numbers, makes no sense; empty if it does."""
    for name, value in _named(tow):
        if not (math.isfinite(value) or (name == "cable.axial_stiffness" and value == math.inf)):
            return f"{name} is {value}: expected a finite number"
    if not all(map(math.isfinite, tow.cable.loading.normal + tow.cable.loading.tangential)):
        return f"the loading has a coefficient that is not finite: {tow.cable.loading}"
    return refusal_of(requirements(tow, FLOATS))
