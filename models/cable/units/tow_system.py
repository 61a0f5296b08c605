"""Tow cable and towed body in one linear model: towpoint velocity in, its force and the body's motion out.

    x' = A x + B u,  y = C x + D u + E u',  u = (v_surge, v_heave, drag, lift)          (``cable/lumped/linear.py``)

Steady tow plus small perturbation. The velocity of the towpoint is integrated inside; an input position beside it
would contradict it. The force contains the apparent mass -m_app a: a host that gives no derivatives of the inputs
(``*_d1``) must add m_app to the ship instead. Steps are exact for inputs that are cubics of time, of any length.

``apparent_mass_*`` and ``port_mass`` are m_app of the full model, also where the states are reduced: what an interface
loop feels faster than the band. E of a reduced elastic model, which acts in the loop, holds the inertia of the modes left
out beside it, and may be negative.

States: x (balanced or modal coordinates where reduced), displacement of the towpoint (surge, heave), m, and u''.

Assumptions: (1) small perturbations, margins tell how small; (2) of ``cable/case.py``; (3) inextensible unless asked.

Source: small-perturbation report on towed cables, in the time domain by ``cable/lumped/lumped.py``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from ...numeric.matrix_ops import MatrixOps, numbers
from ...numeric.ops import Ops, Value
from ...protocol.linear_model import LinearModel
from ...protocol.model import Requirement, remembered
from ...protocol.state_space import Comparison, Reduction, Setup, Study
from ...protocol.variables import EVERY_INPUT, Rate, calculated_parameter, margin, parameter, state
from ..case import Tow
from ..lumped.fidelity import Chosen, choose
from ..lumped.linear import PROFILE, Rows, StateSpace, elastic_model, rigid_model
from ..lumped.lumped import hang, matrices
from ..parameters import Choice, TowParameters, integral, refusal_by, tow_of, tow_requirements, traced_tow
from . import linear_tow, ports
from .linear_tow import Constants
from .ports import second_derivative

Inputs = ports.TowpointInputs


@dataclass(frozen=True)
class Stretch(TowParameters):
    """Whether EA counts."""

    extensible: Annotated[
        Value, parameter("1", 0.0, "1: the cable stretches by axial_stiffness", min=0.0, max=1.0)
    ]


@dataclass(frozen=True)
class Parameters(Choice, Stretch):
    """The tow first, then how it is modelled."""


class Size(NamedTuple):
    """What fixes the number of states. 20 segments: 1 % of the force at 0.2 Hz on a cable of 120 m."""

    segments: float = 20.0
    extensible: float = 0.0
    grading: float = 1.0


class Own(NamedTuple):
    """Integrals of the velocity, and second derivatives of the inputs over the last step."""

    towpoint_surge: Annotated[
        Value, state("m", "Displacement of the towpoint in the towing frame, forward", display="ft")
    ]
    towpoint_heave: Annotated[Value, state("m", "Displacement of the towpoint, up", display="ft")]
    velocity_surge_d2: Annotated[Value, second_derivative("velocity_surge", "m/s")]
    velocity_heave_d2: Annotated[Value, second_derivative("velocity_heave", "m/s")]
    body_drag_change_d2: Annotated[Value, second_derivative("body_drag_change", "N")]
    body_lift_change_d2: Annotated[Value, second_derivative("body_lift_change", "N")]


class Outputs(NamedTuple):
    """Forces on the towpoint, motion of the body, margins."""

    reaction_surge: Annotated[Value, ports.REACTION_SURGE]
    reaction_heave: Annotated[Value, ports.REACTION_HEAVE]
    tension_top: Annotated[Value, ports.TENSION_TOP]
    tension_body: Annotated[Value, ports.TENSION_BODY]
    # a reduced model moves the body at once by what the modes left out would have answered
    body_surge: Annotated[Value, replace(ports.BODY_SURGE, also=EVERY_INPUT)]
    body_heave: Annotated[Value, replace(ports.BODY_HEAVE, also=EVERY_INPUT)]
    body_velocity_surge: Annotated[Value, ports.BODY_VELOCITY_SURGE]
    body_velocity_heave: Annotated[Value, ports.BODY_VELOCITY_HEAVE]
    margin_small_perturbation: ports.MarginSmallPerturbation
    margin_slack: ports.MarginSlack
    margin_quadrant: ports.MarginQuadrant
    margin_resolution: ports.MarginResolution
    margin_inextensible: Annotated[Value, margin("1 - inextensible_error / tolerance")]
    reaction_surge_rate: Rate
    reaction_heave_rate: Rate
    tension_top_rate: Rate
    body_surge_rate: Rate
    body_heave_rate: Rate
    body_velocity_surge_rate: Rate
    body_velocity_heave_rate: Rate


class Calculated(NamedTuple):
    """What was chosen and found at the start."""

    port_mass: Annotated[
        Value, calculated_parameter("kg", "Apparent mass in heave that the towpoint feels at once", tunable=True)
    ]
    apparent_mass_surge: Annotated[Value, calculated_parameter("kg", "Apparent mass in surge", tunable=True)]
    apparent_mass_coupling: Annotated[
        Value, calculated_parameter("kg", "Apparent mass between surge and heave", tunable=True)
    ]
    apparent_mass_heave: Annotated[Value, calculated_parameter("kg", "Apparent mass in heave", tunable=True)]
    steady_tension_top: ports.SteadyTensionTop
    steady_tension_body: ports.SteadyTensionBody
    steady_body_surge: Annotated[
        Value,
        calculated_parameter("m", "Steady position of the body from the towpoint, forward", display="ft", tunable=True),
    ]
    steady_body_heave: Annotated[
        Value,
        calculated_parameter("m", "Steady position of the body from the towpoint, up", display="ft", tunable=True),
    ]
    states: ports.States
    segments_used: ports.SegmentsUsed
    model_error: ports.ModelError
    inextensible_error: Annotated[
        Value,
        calculated_parameter(
            "1", "Relative error of leaving axial_stiffness out; 0: none or not known", tunable=True
        ),
    ]


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """What the parameters must fulfil."""
    elastic = (
        ops.where(p.extensible > 0.5, p.axial_stiffness, 1.0),
        "extensible is 1 and axial_stiffness 0: expected a positive axial stiffness EA",
    )
    return (*tow_requirements(p, ops), elastic)


def setup(p: Parameters, size: Size, ops: MatrixOps) -> Setup:
    """The full model of ``size``."""
    tow = traced_tow(p, ops.scalars, extensible=size.extensible > 0.5)
    elastic = size.extensible > 0.5
    hanging = matrices(hang(tow, int(size.segments), ops, size.grading), elastic, ops)
    model = elastic_model(hanging, ops) if elastic else rigid_model(hanging, ops)
    return _setup(model, model, tow, ops)


def _setup(model: StateSpace, full: StateSpace, tow: Tow, ops: MatrixOps) -> Setup:
    """``full``: ``model`` before reduction."""
    # in Quadrant I the towpoint drives the tow, in II forces on the body do too
    return linear_tow.setup_of(model, full.apparent_mass, 3.0 - tow.sign, ops)


def study(size: Size) -> Study:
    """Reduction, error of the segments, error of leaving EA out."""
    elastic = size.extensible > 0.5
    stretched = Comparison(
        size._replace(extensible=1.0), 1.0, "inextensible_error", truer=True, when=lambda p, ops: p.axial_stiffness
    )
    return Study(
        Reduction(elastic, "measured_inputs", "states", "model_error"),
        linear_tow.halved(size, 1) + (() if elastic else (stretched,)),
    )


def drive(own: Own, cubics: Inputs, p: Parameters, constants: Constants, ops: Ops) -> tuple[Sequence[Value], ...]:
    """Velocities and forces."""
    surge, heave, drag, lift = cubics
    return surge, heave, [-a for a in drag], lift


def own_after(
    h: Value, own: Own, cubics: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """`Own` after a step of ``h``, s."""
    surge = own.towpoint_surge + integral(h, cubics.velocity_surge)
    heave = own.towpoint_heave + integral(h, cubics.velocity_heave)
    return (surge, heave, *(2.0 * c2 + 6.0 * c3 * h for _, _, c2, c3 in cubics))


def own_rates(
    own: Own, u: Inputs, du: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """Rates of `Own`; nothing tells those of the second derivatives."""
    return u.velocity_surge, u.velocity_heave, 0.0, 0.0, 0.0, 0.0


def core(
    own: Own, u: Inputs, du: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value], Sequence[Value], Sequence[Value]]:
    """Velocities and forces and their derivatives; drag acts aft, the model's force is forward."""
    return (
        (u.velocity_surge, u.velocity_heave, -u.body_drag_change, u.body_lift_change),
        (du.velocity_surge, du.velocity_heave, -du.body_drag_change, du.body_lift_change),
        (own.velocity_surge_d2, own.velocity_heave_d2, -own.body_drag_change_d2, own.body_lift_change_d2),
    )


def observe(
    t: Value, own: Own, y: Sequence[Value], y_rate: Sequence[Value], u: Inputs, du: Inputs, growth: Value,
    p: Parameters, constants: Constants, ops: Ops,
) -> tuple[Outputs, tuple[Value, ...]]:  # fmt: skip
    """All observables, and the tensions of the segments, N."""
    slack, quadrant, tensions = linear_tow.profile(y, constants, ops)
    row, rate = Rows._make(y[:PROFILE]), Rows._make(y_rate[:PROFILE])
    surge, heave = u.velocity_surge, u.velocity_heave
    return Outputs(
        -row.force_surge, -row.force_heave, constants.tension_top + row.tension_top,
        constants.tension_body + row.tension_body, own.towpoint_surge + row.offset_surge,
        own.towpoint_heave + row.offset_heave, row.body_surge, row.body_heave,
        linear_tow.speed_margin(surge, heave, p.tow_speed, p.perturbation_limit, ops), slack,
        quadrant,
        1.0 - constants.model_error / p.tolerance, 1.0 - constants.inextensible_error / p.tolerance,
        -rate.force_surge, -rate.force_heave, rate.tension_top, rate.offset_surge + surge, rate.offset_heave + heave,
        rate.body_surge, rate.body_heave,
    ), tensions  # fmt: skip


def describe(p: Parameters, constants: Constants, ops: Ops) -> Calculated:
    """What was chosen and found at the start."""
    c = constants
    surge, coupling, _, heave = c.direct
    return Calculated(
        heave, surge, coupling, heave, c.tension_top, c.tension_body, c.body_surge, c.body_heave, c.states, c.segments,
        c.model_error, c.inextensible_error,
    )  # fmt: skip


@remembered
def chosen(p: Parameters) -> Chosen:
    """The state space that the parameters ask for, with its errors. Raises `CableError`."""
    return choose(tow_of(p), p.extensible > 0.5, p.band, p.tolerance, int(p.segments), p.reduced > 0.5, grading=p.grading)


def size(p: Parameters) -> Size:
    """As many segments as the parameters say or, where they leave it open, as were chosen."""
    segments, grading = linear_tow.divided(p, chosen)
    return Size(segments, p.extensible, grading)


def prepare(p: Parameters) -> Setup:
    """The chosen model, of numbers. Raises `CableError`."""
    made = chosen(p)
    return linear_tow.chosen_setup(_setup(made.model, made.full, made.full.chain.tow, numbers()), made)


LINEAR = LinearModel(
    "tow_system",
    "Tow cable and towed body, small perturbations from the steady tow",
    Parameters, Inputs, Outputs, Calculated, Size, Own,
    setup=setup, prepare=prepare, drive=drive, core=core, observe=observe, describe=describe, own_after=own_after,
    own_rates=own_rates, size=size, study=study, requirements=requirements, setup_requirements=linear_tow.setup_requirements,
    refusal=refusal_by(chosen), tuning_refusal=linear_tow.tuning_refusal, rates=PROFILE, extra=linear_tow.EXTRA,
)  # fmt: skip
TOW_SYSTEM = LINEAR.as_model()
