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

from .cable_loading import Loading


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
        return 1.0 if self.quadrant == 1 else -1.0

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
        return math.hypot(self.body.drag, self.body.lift - self.body.weight)

    @property
    def end_angle(self) -> float:
        """phi0(0), rad [34]."""
        b = self.body
        if self.quadrant == 1:
            return math.atan2(b.weight - b.lift, b.drag)
        return math.atan2(b.lift - b.weight, -b.drag)


POSITIVE = {"length", "mass", "speed"}
SIGNED = {"weight", "lift"}


def refusal(tow: Tow) -> str:
    """Why the tow makes no sense; empty if it does."""
    if tow.quadrant not in (1, 2):
        return f"quadrant is {tow.quadrant}: expected 1 (ship tows a body) or 2 (submarine tows a float)"
    values = [("cable", f.name, getattr(tow.cable, f.name)) for f in fields(Cable)]
    values += [("body", f.name, getattr(tow.body, f.name)) for f in fields(Body)]
    values += [("tow", "speed", tow.speed), ("tow", "density", tow.density)]
    for owner, name, value in values:
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            continue
        if name == "axial_stiffness" and value == math.inf:
            continue
        if not math.isfinite(value):
            return f"{owner}.{name} is {value}: expected a finite number"
        if name == "speed" and value == 0.0:
            return (
                "speed is 0: the direction of the flow is undefined and the linear drag vanishes; expected a speed > 0"
            )
        if ((name in POSITIVE and owner != "body") or name == "axial_stiffness") and not value > 0.0:
            return f"{owner}.{name} is {value:g}: expected a positive number"
        if name not in SIGNED and value < 0.0:
            return f"{owner}.{name} is {value:g}: expected a number >= 0"
    if not all(map(math.isfinite, tow.cable.loading.normal + tow.cable.loading.tangential)):
        return f"the loading has a coefficient that is not finite: {tow.cable.loading}"
    net = tow.body.weight - tow.body.lift
    if tow.end_tension == 0.0:
        return (
            "the cable carries no tension at the body (drag 0, lift equals weight): its direction there is undefined; "
            "expected drag or a net weight, however small"
        )
    if tow.quadrant == 1 and net < 0.0:
        return (
            f"the body is buoyant (lift exceeds weight by {-net:g}) in Quadrant I: expected quadrant 2, or more weight"
        )
    if tow.quadrant == 2 and net > 0.0:
        return f"the body is heavy (weight exceeds lift by {net:g}) in Quadrant II: expected quadrant 1, or more lift"
    return ""
