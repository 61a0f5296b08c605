"""What the towing units have in common: parameters in SI, the tow that they describe, the margins that they report.

| margin | formula: 1 at rest, 0 at the limit |
|---|---|
| small_perturbation | 1 - v/(r c), v the speed of the towpoint, r = ``perturbation_limit`` |
| slack | 1 - max over the segments of abs(T1)/T0; the tension it predicts vanishes 5 % early |
| flow | 1 - abs(V1)/V0 at the towpoint, V the flow along the cable: the report's criterion |
| quadrant | 1 - largest share of the way to the stream's direction that a segment has turned [12] [13] |
| resolution | 1 - error/tolerance, error of nodes and reduction together, measured against the frequency domain |
| inextensible | 1 - error/tolerance, error of leaving EA out, measured in the frequency domain |

Source: small-perturbation report on towed cables (criterion abs(V1) < V0); thresholds from nonlinear runs of a 120 m
cable at 6 kn: the waveform of the top tension is 1, 5 and 10 % wrong at v/c = 0.042, 0.21 and 0.42.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .cable_case import Body, Cable, CableError, Tow
from .cable_loading import Loading, cross_flow, eames

EAMES, CROSS_FLOW, GENERAL = range(3)
"""Values of ``loading_form``."""


@dataclass(frozen=True)
class TowParameters:
    """SI. ``axial_stiffness`` 0: not known, inextensible. Flags are 0 or 1."""

    quadrant: float
    tow_speed: float
    water_density: float
    cable_length: float
    cable_mass: float
    cable_weight: float
    cable_thickness: float
    cable_drag_coefficient: float
    loading_form: float
    loading_friction: float
    normal_a0: float
    normal_a1: float
    normal_a2: float
    normal_b1: float
    normal_b2: float
    tangential_a0: float
    tangential_a1: float
    tangential_a2: float
    tangential_b1: float
    tangential_b2: float
    added_mass_coefficient: float
    momentum_added_mass: float
    axial_stiffness: float
    body_mass: float
    body_added_mass_surge: float
    body_added_mass_heave: float
    body_weight_in_water: float
    body_lift: float
    body_drag: float
    body_quadratic_drag: float
    perturbation_limit: float


def loading_of(p: TowParameters) -> Loading:
    """The loading that ``loading_form`` names. Raises `CableError` for an unknown form."""
    form = int(p.loading_form)
    if form == EAMES:
        return eames(p.loading_friction)
    if form == CROSS_FLOW:
        return cross_flow(p.loading_friction)
    if form == GENERAL:
        return Loading(
            (p.normal_a0, p.normal_a1, p.normal_a2, p.normal_b1, p.normal_b2),
            (p.tangential_a0, p.tangential_a1, p.tangential_a2, p.tangential_b1, p.tangential_b2),
        )
    raise CableError(f"loading_form is {p.loading_form:g}: expected 0 (Eames), 1 (cross-flow) or 2 (ten coefficients)")


def tow_of(p: TowParameters) -> Tow:
    """The tow. ``body_quadratic_drag`` adds the drag's slope about the tow speed: 2 D_B/c in surge, D_B/c in heave.
    Raises `CableError` for values that make no sense."""
    cable = Cable(
        p.cable_length, p.cable_mass, p.cable_weight, p.cable_thickness, p.cable_drag_coefficient, loading_of(p),
        p.added_mass_coefficient, p.momentum_added_mass > 0.5, p.axial_stiffness or math.inf,
    )  # fmt: skip
    slope = p.body_drag / p.tow_speed if p.body_quadratic_drag > 0.5 and p.tow_speed > 0.0 else 0.0
    body = Body(
        p.body_mass, p.body_added_mass_surge, p.body_added_mass_heave, p.body_weight_in_water, p.body_lift, p.body_drag,
        2.0 * slope, slope,
    )  # fmt: skip
    return Tow(cable, body, p.tow_speed, p.water_density, int(p.quadrant))


def stream_angles(tow: Tow, angles: list[float]) -> list[float]:
    """Angle of each segment from the direction of the stream, rad: phi in Quadrant I, pi - phi in II."""
    return [phi if tow.quadrant == 1 else math.pi - phi for phi in angles]
