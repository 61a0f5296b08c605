"""Small oscillations of a tow cable about its steady state: the linear equations, before anything solves them.

    q = q0 + Re(q1 exp(-i omega t)),   y = (phi1, T1, U1, V1),   y' = A(s) y

    T0 phi1' = -T1 phi0' - 2 F_L eps1 - F_L' th1 - w sin phi0 phi1
               + i omega mu (lam c phi1 cos phi0 + (1 + lam) U1)                                   [37]
       T1'   = 2 F_G eps1 + F_G' th1 + w cos phi0 phi1 - i omega mu (V1 + lam c phi1 sin phi0)      [38]
       U1'   = i omega (1 + T0/EA) phi1 + V1 phi0'                                                  [35]
       V1'   = -U1 phi0' - i omega T1/EA                                                            [36]
    eps1 = (U1 sin phi0 + V1 cos phi0)/c,   th1 = phi1 + (U1 cos phi0 - V1 sin phi0)/c

| symbol | meaning | unit |
|---|---|---|
| phi1, T1 | amplitudes of angle and tension | rad, N |
| U1, V1 | amplitudes of the velocity along the steady normal and tangent | m/s |
| F_L, F_G | steady loads; F' = dF/dtheta | N/m |

In Morison's form of the added mass the terms lam c phi1 are absent. Terms with EA are ours: the source's cable is
inextensible. The body's rows are [39] and [40] with its damping, the towpoint's [41] to [44].

Assumptions: (1) amplitudes small against the steady values; (2) of ``cable/case.py``. The phase of q1 is
atan2(Im, Re): q = |q1| cos(omega t - phase).

Source: small-perturbation report on towed cables, Equations [17]-[24], [35]-[44]; validated there for cables to
1200 ft, to 0.8 Hz, 6 to 14 kn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array, ComplexArray
from ..case import CableError, Tow
from .steady import Steady, slopes


@dataclass(frozen=True)
class Excitation:
    """Complex amplitudes: motion of the towpoint, m (surge forward, heave up), oscillating force on the body, N (drag
    backward, lift up); a quantity is Re(amplitude exp(-i omega t))."""

    surge: complex = 0.0
    heave: complex = 0.0
    drag: complex = 0.0
    lift: complex = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (math.isfinite(complex(value).real) and math.isfinite(complex(value).imag)):
                raise CableError(f"excitation {name} is {value}: expected a finite number")


def coefficients(tow: Tow, omega: float, angle: Array, log_tension: Array) -> ComplexArray:
    """A of dy/dsigma = A y with sigma the distance from the body, shape (..., 4, 4), at given phi0 and ln T0."""
    cable, c = tow.cable, tow.speed
    sine, cosine, tension = np.sin(angle), np.cos(angle), np.exp(log_tension)
    curvature = tow.sign * slopes(tow, angle, log_tension)[0]
    normal, normal_slope, tangential, tangential_slope = cable.loading.gradients(sine, cosine)
    # load over speed in closed form: no 0/0 as c -> 0
    per_speed = tow.drag_factor * c
    lam = tow.added_mass_ratio
    convected = lam * c if cable.momentum_form else 0.0
    inertia = 1j * omega * cable.mass
    a = np.empty((*np.shape(angle), 4, 4), dtype=complex)
    a[..., 0, 0] = (-per_speed * c * normal_slope - cable.weight * sine + inertia * convected * cosine) / tension
    a[..., 0, 1] = -curvature / tension
    a[..., 0, 2] = (-per_speed * (2.0 * normal * sine + normal_slope * cosine) + inertia * (1.0 + lam)) / tension
    a[..., 0, 3] = -per_speed * (2.0 * normal * cosine - normal_slope * sine) / tension
    a[..., 1, 0] = per_speed * c * tangential_slope + cable.weight * cosine - inertia * convected * sine
    a[..., 1, 1] = 0.0
    a[..., 1, 2] = per_speed * (2.0 * tangential * sine + tangential_slope * cosine)
    a[..., 1, 3] = per_speed * (2.0 * tangential * cosine - tangential_slope * sine) - inertia
    a[..., 2, 0] = 1j * omega * (1.0 + tension / cable.axial_stiffness)
    a[..., 2, 1] = a[..., 2, 2] = 0.0
    a[..., 2, 3] = curvature
    a[..., 3, 0] = a[..., 3, 3] = 0.0
    a[..., 3, 1] = -1j * omega / cable.axial_stiffness
    a[..., 3, 2] = -curvature
    a *= tow.sign
    return a


def body_rows(tow: Tow, omega: float, excitation: Excitation) -> tuple[ComplexArray, ComplexArray]:
    """(rows (2, 4), right sides (2,)) of the conditions at the body [39] [40], N."""
    body, sigma = tow.body, tow.sign
    sine, cosine = math.sin(tow.end_angle), math.cos(tow.end_angle)
    surge = -1j * omega * (body.mass + body.added_mass_surge) + body.damping_surge
    heave = -1j * omega * (body.mass + body.added_mass_heave) + body.damping_heave
    # horizontal and vertical velocity from (U1, V1)
    along = np.array([sine, cosine])
    across = np.array([-cosine, sine])
    rows = np.zeros((2, 4), dtype=complex)
    rows[0, 1] = 1.0
    rows[0, 2:] = -sigma * (surge * cosine * along + heave * sine * across)
    rows[1, 0] = tow.end_tension
    rows[1, 2:] = -sigma * (-surge * sine * along + heave * cosine * across)
    d, lift = complex(excitation.drag), complex(excitation.lift)
    return rows, np.array([sigma * (d * cosine - lift * sine), sigma * (-d * sine - lift * cosine)])


def towpoint_values(omega: float, angle: float, excitation: Excitation) -> ComplexArray:
    """(U1, V1) at the towpoint, m/s [41]-[44]; ``angle`` is phi0 there, rad."""
    surge, heave = -1j * omega * complex(excitation.surge), -1j * omega * complex(excitation.heave)
    sine, cosine = math.sin(angle), math.cos(angle)
    return np.array([surge * sine - heave * cosine, surge * cosine + heave * sine])


@dataclass(frozen=True)
class Response:
    """Amplitudes on the nodes of a mesh, shape (K, p+1) each, at one angular frequency, rad/s: angle, rad, tension, N,
    velocity along the steady normal and tangent, m/s."""

    steady: Steady
    omega: float
    angle: ComplexArray
    tension: ComplexArray
    normal: ComplexArray
    tangential: ComplexArray

    @property
    def velocity(self) -> tuple[ComplexArray, ComplexArray]:
        """Physical perturbations of U and V, m/s (the source's UM and VM): along the moving normal and tangent."""
        c, phi = self.steady.tow.speed, self.steady.angle
        return c * self.angle * np.cos(phi) + self.normal, -c * self.angle * np.sin(phi) + self.tangential

    @property
    def displacement(self) -> tuple[ComplexArray, ComplexArray]:
        """Forward and upward displacement in the towing frame, m: i u/omega, free of quadrature."""
        sine, cosine = np.sin(self.steady.angle), np.cos(self.steady.angle)
        factor = 1j / self.omega
        return (
            factor * (self.normal * sine + self.tangential * cosine),
            factor * (self.tangential * sine - self.normal * cosine),
        )

    @property
    def configuration(self) -> tuple[ComplexArray, ComplexArray]:
        """x1, y1: displacement relative to the body, m [56] [58], the integrals of phi1 (-sin, cos) over s accumulated
        from the body on; the printed program tabulates the increments of single segments instead."""
        x, y = self.displacement
        return x - x[0, 0], y - y[0, 0]

    @property
    def towpoint_force(self) -> tuple[complex, complex]:
        """Amplitude of the force that the towpoint exerts on the cable, N, forward and up."""
        sigma = self.steady.tow.sign
        phi, tension = self.steady.angle[-1, -1], self.steady.tension[-1, -1]
        along, across = complex(self.tension[-1, -1]), complex(tension * self.angle[-1, -1])
        sine, cosine = math.sin(phi), math.cos(phi)
        return sigma * (along * cosine - across * sine), sigma * (along * sine + across * cosine)
