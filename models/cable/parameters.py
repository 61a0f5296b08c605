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
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..numeric.ops import FLOATS, Ops, Value
from .case import Body, Cable, CableError, Condition, Tow, TracedTow, conditions
from .loading import Loading, cross_flow, eames

EAMES, CROSS_FLOW, GENERAL = range(3)
"""Values of ``loading_form``."""
LOADING_FORMS = "loading_form: expected 0 (Eames), 1 (cross-flow) or 2 (ten coefficients)"


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


@dataclass(frozen=True)
class LinearParameters(TowParameters):
    """SI. ``segments`` 0: as many as ``tolerance`` needs up to ``band``, rad/s."""

    segments: float
    tolerance: float
    band: float
    reduced: float


class Modes(NamedTuple):
    """No branches."""


class TowpointInputs(NamedTuple):
    """Velocity of the towpoint in the towing frame, m/s, forward and up; change of body drag (aft) and lift, N."""

    velocity_surge: Value
    velocity_heave: Value
    body_drag_change: Value
    body_lift_change: Value


def integral(h: Value, cubic: Sequence[Value]) -> Value:
    """Integral over 0 to h of a cubic with the coefficients of 1, t, t^2, t^3."""
    a0, a1, a2, a3 = cubic
    return h * (a0 + h * (a1 / 2.0 + h * (a2 / 3.0 + h * a3 / 4.0)))


def _loading(p: TowParameters, ops: Ops) -> Loading:
    """The loading that ``loading_form`` names."""

    def chosen(one: float, two: float, three: Value) -> Value:
        return ops.where(p.loading_form == EAMES, one, ops.where(p.loading_form == CROSS_FLOW, two, three))

    forms = eames(p.loading_friction), cross_flow(p.loading_friction)
    normal = p.normal_a0, p.normal_a1, p.normal_a2, p.normal_b1, p.normal_b2
    tangential = p.tangential_a0, p.tangential_a1, p.tangential_a2, p.tangential_b1, p.tangential_b2
    return Loading(
        tuple(map(chosen, forms[0].normal, forms[1].normal, normal)),
        tuple(map(chosen, forms[0].tangential, forms[1].tangential, tangential)),
    )


def _described(p: TowParameters, ops: Ops) -> tuple[Cable, Body, float, float]:
    """Cable, body, speed, density. ``body_quadratic_drag`` adds the drag's slope about the tow speed: 2 D_B/c in surge,
    D_B/c in heave."""
    cable = Cable(
        p.cable_length, p.cable_mass, p.cable_weight, p.cable_thickness, p.cable_drag_coefficient, _loading(p, ops),
        p.added_mass_coefficient, p.momentum_added_mass > 0.5,
        ops.where(p.axial_stiffness == 0.0, math.inf, p.axial_stiffness),
    )  # fmt: skip
    moving = p.tow_speed > 0.0
    slope = ops.where(
        p.body_quadratic_drag > 0.5, ops.where(moving, p.body_drag / ops.where(moving, p.tow_speed, 1.0), 0.0), 0.0
    )
    body = Body(
        p.body_mass, p.body_added_mass_surge, p.body_added_mass_heave, p.body_weight_in_water, p.body_lift, p.body_drag,
        2.0 * slope, slope,
    )  # fmt: skip
    return cable, body, p.tow_speed, p.water_density


def tow_of(p: TowParameters) -> Tow:
    """The tow. Raises `CableError` for values that make no sense."""
    if p.loading_form not in (EAMES, CROSS_FLOW, GENERAL):
        raise CableError(f"{LOADING_FORMS}, not {p.loading_form:g}")
    return Tow(*_described(p, FLOATS), int(p.quadrant))


def traced_tow(p: TowParameters, ops: Ops, extensible: bool = True) -> TracedTow:
    """The tow of parameters that are symbols, or not yet judged; without EA unless ``extensible``."""
    cable, body, speed, density = _described(p, ops)
    if not extensible:
        cable = replace(cable, axial_stiffness=math.inf)
    return TracedTow(cable, body, speed, density, p.quadrant)  # type: ignore[arg-type]


def tow_requirements(p: TowParameters, ops: Ops) -> list[Condition]:
    """What the parameters of a tow must fulfil."""
    form = ops.where(p.loading_form * (p.loading_form - CROSS_FLOW) * (p.loading_form - GENERAL) == 0.0, 1.0, 0.0)
    return [(form, LOADING_FORMS), *conditions(traced_tow(p, ops), ops)]
