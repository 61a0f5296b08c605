"""What the towing units have in common: parameters in SI, the tow that they describe, the margins that they report.

| margin | formula: 1 at rest, 0 at the limit |
|---|---|
| small_perturbation | 1 - v/(r c), v the speed of the towpoint, r = ``perturbation_limit``: a rough sign, see below |
| slack | 1 - max over the segments of abs(T1)/T0; the tension it predicts vanishes 5 % early |
| quadrant | 1 - largest share of the way to the stream's direction that a segment has turned [12] [13] |
| resolution | 1 - error/tolerance, error of nodes and reduction together, measured against the frequency domain |
| inextensible | 1 - error/tolerance, error of leaving EA out, measured in the frequency domain |

Source: small-perturbation report on towed cables, but for its criterion abs(V1) < V0, which is none on a vertical cable.
The limit r is that of a 120 m cable at 6 kn, whose top tension is 1, 5 and 10 % wrong at v/c = 0.042, 0.21 and 0.42;
on other tows 5 % is at v/c of 0.04 to 4. ``lumped/linearity.py`` finds the error of any tow and drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, TypeVar

from ..numeric.ops import FLOATS, Ops, Value
from ..protocol.model import Requirement
from ..protocol.physical import liquid, weight_below_gravity
from ..protocol.variables import Quantity, parameter, tunable
from .case import Body, Cable, CableError, Tow, TracedTow, requirements
from .loading import Loading, cross_flow, eames

P = TypeVar("P")
EAMES, CROSS_FLOW, GENERAL = range(3)
"""Values of ``loading_form``."""
LOADING_FORMS = "loading_form: expected 0 (Eames), 1 (cross-flow) or 2 (ten coefficients)"


ELASTIC = tunable(
    "N", 4e6, "Axial stiffness EA; the start value is a guess for the cable of the other start values, an armoured one of "
    "15 mm: give that of yours", display="lbf", min=0.0, needed=True,
)  # fmt: skip
"""``axial_stiffness`` where a tow means nothing without it: 23 GPa over the section of 15 mm."""


def coefficient(load: str, term: str) -> Quantity:
    """A parameter of the ten-coefficient loading: ``normal`` or ``tangential``, a0 to b2."""
    factor = {"a0": "1", "a1": "cos", "a2": "cos 2", "b1": "sin", "b2": "sin 2"}[term]
    return tunable("1", 0.0, f"Coefficient of {factor} in the {load} load, loading_form 2")


@dataclass(frozen=True)
class TowParameters:
    """Cable, body and speed, SI."""

    quadrant: Annotated[
        Value, parameter("1", 1.0, "1: a ship tows a deep body; 2: a submarine tows a float", min=1.0, max=2.0)
    ]
    tow_speed: Annotated[Value, tunable("m/s", 3.0867, "Tow speed", display="kn")]
    water_density: Annotated[Value, tunable("kg/m3", 1025.0, "Density of the water", display="slug/ft3")]
    cable_length: Annotated[Value, tunable("m", 120.0, "Unstretched length", display="ft")]
    cable_mass: Annotated[Value, tunable("kg/m", 0.83, "Mass per length", display="slug/ft")]
    cable_weight: Annotated[Value, tunable("N/m", 6.36, "Weight in water per length", display="lbf/ft")]
    cable_thickness: Annotated[Value, tunable("m", 0.015, "Thickness", display="in")]
    cable_drag_coefficient: Annotated[Value, tunable("1", 1.2, "Drag coefficient of the cable across the flow")]
    loading_form: Annotated[
        Value, parameter("1", 0.0, "0: Eames; 1: cross-flow; 2: ten coefficients", min=0.0, max=2.0)
    ]
    loading_friction: Annotated[
        Value, tunable("1", 0.03, "Friction f of Eames, or pi Cdt/Cdn of the cross-flow form", min=0.0)
    ]
    normal_a0: Annotated[Value, coefficient("normal", "a0")]
    normal_a1: Annotated[Value, coefficient("normal", "a1")]
    normal_a2: Annotated[Value, coefficient("normal", "a2")]
    normal_b1: Annotated[Value, coefficient("normal", "b1")]
    normal_b2: Annotated[Value, coefficient("normal", "b2")]
    tangential_a0: Annotated[Value, coefficient("tangential", "a0")]
    tangential_a1: Annotated[Value, coefficient("tangential", "a1")]
    tangential_a2: Annotated[Value, coefficient("tangential", "a2")]
    tangential_b1: Annotated[Value, coefficient("tangential", "b1")]
    tangential_b2: Annotated[Value, coefficient("tangential", "b2")]
    added_mass_coefficient: Annotated[
        Value, tunable("1", 1.0, "Added mass over displaced mass; 1: bare and round", min=0.0)
    ]
    momentum_added_mass: Annotated[
        Value, parameter("1", 0.0, "1: momentum form of the added mass; 0: Morison's", min=0.0, max=1.0)
    ]
    axial_stiffness: Annotated[Value, tunable("N", 0.0, "Axial stiffness EA; 0: not known", display="lbf", min=0.0)]
    body_mass: Annotated[Value, tunable("kg", 900.0, "Mass of the body", display="slug", min=0.0)]
    body_added_mass_surge: Annotated[
        Value, tunable("kg", 256.0, "Added mass of the body in surge", display="slug", min=0.0)
    ]
    body_added_mass_heave: Annotated[
        Value, tunable("kg", 256.0, "Added mass of the body in heave", display="slug", min=0.0)
    ]
    body_weight_in_water: Annotated[Value, tunable("N", 6313.0, "Weight of the body in water", display="lbf")]
    body_lift: Annotated[Value, tunable("N", 0.0, "Steady lift of the body", display="lbf")]
    body_drag: Annotated[Value, tunable("N", 1465.0, "Steady drag of the body", display="lbf", min=0.0)]
    body_quadratic_drag: Annotated[
        Value, parameter("1", 1.0, "1: drag goes with speed squared; 0: constant", min=0.0, max=1.0)
    ]
    perturbation_limit: Annotated[
        Value,
        tunable(
            "1", 0.21,
            "Towpoint speed over tow speed at margin 0: 0.042, 0.21, 0.42 for 1, 5, 10 % error of the tension", min=1e-6,
        ),
    ]  # fmt: skip


@dataclass(frozen=True)
class Choice:
    """How large a linear model is to be, and how near the truth."""

    segments: Annotated[Value, parameter("1", 0.0, "Number of segments; 0: as many as tolerance needs", min=0.0, max=400.0)]
    grading: Annotated[
        Value,
        parameter(
            "1", 0.0, "Length of the segment at the towpoint over that at the body; 0: chosen with segments, else 1",
            min=0.0, max=100.0,
        ),
    ]  # fmt: skip
    tolerance: Annotated[Value, parameter("1", 0.02, "Relative error of the gains up to band", min=1e-5, max=0.5)]
    band: Annotated[
        Value, parameter("rad/s", 2.0, "Highest angular frequency for which tolerance holds", min=1e-3, max=1e3)
    ]
    reduced: Annotated[
        Value,
        parameter("1", 1.0, "1: reduce the number of states as tolerance allows; 0: keep all", min=0.0, max=1.0),
    ]


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
    return TracedTow(cable, body, speed, density, p.quadrant)


def tow_requirements(p: TowParameters, ops: Ops) -> list[Requirement]:
    """What the parameters of a tow must fulfil: a known form of the loading, what `case.requirements` asks, and a cable, a
    body and a liquid that there can be. A body without mass is not weighed: the report's printed sample is one, whose mass
    is in its added masses."""
    possible, why = weight_below_gravity(
        p.body_weight_in_water, p.body_mass, p.water_density, "body_weight_in_water", "body_mass", ops
    )
    physical = [
        weight_below_gravity(p.cable_weight, p.cable_mass, p.water_density, "cable_weight", "cable_mass", ops),
        (ops.where(p.body_mass == 0.0, 1.0, possible), why),
        liquid(p.water_density, ops),
    ]
    form = ops.where(p.loading_form * (p.loading_form - CROSS_FLOW) * (p.loading_form - GENERAL) == 0.0, 1.0, 0.0)
    return [(form, LOADING_FORMS), *requirements(traced_tow(p, ops), ops), *physical]


def refusal_by(prepare: Callable[[P], object]) -> Callable[[P], str]:
    """Why there is no such tow, empty if there is: the message of the `CableError` that ``prepare(parameters)`` raises."""

    def refusal(p: P) -> str:
        try:
            prepare(p)
        except CableError as error:
            return str(error)
        return ""

    return refusal
