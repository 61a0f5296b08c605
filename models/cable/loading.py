"""Hydrodynamic loading of a cable element in steady inclined flow, ten coefficients.

    F_L = D (A0 + A1 |cos th| + A2 cos 2th + B1 |sin th| + B2 |sin 2th|) sign(U)        normal set
    F_G = D (the same form)                                              sign(V)        tangential set
    D = rho h C_D (U^2 + V^2)/2,   cos th = V/q,   sin th = U/q,   q = sqrt(U^2 + V^2)

| symbol | meaning | unit |
|---|---|---|
| U, V | velocity of the cable through still water along n = (sin phi, -cos phi) and t = (cos phi, sin phi) | m/s |
| F_L, F_G | load per length against n and against t: the force on the cable is -F_L n - F_G t | N/m |
| rho, h, C_D | density of the water, thickness of the cable, drag coefficient | kg/m3, m, - |

In the source's form for Quadrant I (V > 0) and Quadrant II (V < 0) the sign sigma multiplies A1 and B2 of the normal
and A0, A2 and B1 of the tangential set; both are the one form above, by the mirror symmetry of a round cable. The signs of
U and V extend it to every direction (the source: sin^2 must become sin abs(sin) where phi leaves its quadrant).

Assumptions: (1) the load depends on the local velocity only; (2) the cable is round or faired symmetrically.

Source: small-perturbation report on towed cables, Equations [11]-[14]; Eames' form f as in its section on loading; the
cross-flow form is that of MoorDyn (``source/Line.cpp``), f_t = pi Cdt/Cdn. Validated by the source for 0 <= th <= pi.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Coefficients = tuple[float, float, float, float, float]


@dataclass(frozen=True)
class Loading:
    """(A0, A1, A2, B1, B2) of the normal and of the tangential load, dimensionless."""

    normal: Coefficients
    tangential: Coefficients

    def normal_load(self, normal: Any, tangential: Any) -> Any:
        """F_L over rho h C_D/2 for velocity components U >= 0 and V (of one sign sigma), (m/s)^2; scalars or arrays,
        real or complex."""
        return _form(self.normal, normal, tangential)

    def tangential_load(self, normal: Any, tangential: Any) -> Any:
        """F_G over rho h C_D/2 times sign(V), (m/s)^2; as `normal_load`."""
        return _form(self.tangential, normal, tangential)

    def gradients(self, sine: Any, cosine: Any) -> tuple[Any, Any, Any, Any]:
        """(F_L, F_L', F_G, F_G') over D at the direction theta, ' = d/dtheta; ``sine`` >= 0, ``cosine`` of one sign."""
        sigma = 1.0 - 2.0 * (cosine < 0.0)
        u, v = sine, sigma * cosine
        # d/dtheta of |cos| is -sigma sin, of sin is cos = sigma |cos|: sigma times the slope in the mirrored angle
        normal, normal_slope = _direction(self.normal, u, v)
        tangential, tangential_slope = _direction(self.tangential, u, v)
        return normal, sigma * normal_slope, sigma * tangential, tangential_slope


def _form(c: Coefficients, u: Any, v: Any) -> Any:
    """The five terms times q^2, for U, V >= 0 as mirrored; polynomials wherever q is not needed."""
    q2 = u * u + v * v
    value = c[0] * q2 + c[2] * (v * v - u * u) + 2.0 * c[4] * u * v
    if c[1] or c[3]:
        # at rest q has no derivative; both terms vanish there
        q = (q2 + (abs(q2) < 1e-200) * 1e-200) ** 0.5
        value = value + q * (c[1] * v + c[3] * u)
    return value


def _direction(c: Coefficients, sine: Any, cosine: Any) -> tuple[Any, Any]:
    """(value, d/dtheta) of the five terms."""
    cos2, sin2 = cosine * cosine - sine * sine, 2.0 * sine * cosine
    value = c[0] + c[1] * cosine + c[2] * cos2 + c[3] * sine + c[4] * sin2
    slope = -c[1] * sine - 2.0 * c[2] * sin2 + c[3] * cosine + 2.0 * c[4] * cos2
    return value, slope


def eames(friction: float) -> Loading:
    """Eames: F_L = D ((1 - f) sin^2 + f sin), F_G = D f cos; ``friction`` f, 0 to 1."""
    half = 0.5 * (1.0 - friction)
    return Loading((half, 0.0, -half, friction, 0.0), (0.0, friction, 0.0, 0.0, 0.0))


def cross_flow(friction: float) -> Loading:
    """Independence principle: F_L = D sin^2, F_G = D f_t cos^2; ``friction`` f_t = pi Cdt/Cdn >= 0 (MoorDyn)."""
    return Loading((0.5, 0.0, -0.5, 0.0, 0.0), (0.5 * friction, 0.0, 0.5 * friction, 0.0, 0.0))
