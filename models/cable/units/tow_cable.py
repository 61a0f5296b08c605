"""Elastic tow cable alone: velocities of both ends in, forces on both ends out.

    x' = A x + B v,  v = (u_top, d, d'),  d' = u_body - u_top,  y = C x + D v + E v'        (``cable/lumped/linear.py``)

| symbol | meaning | unit |
|---|---|---|
| u | velocities of towpoint and body in the towing frame | m/s |
| d | displacement of the body relative to the towpoint, integrated inside | m |
| y | change of the force on the towpoint and on the body | N |

Steady tow plus small perturbation; the steady state is that of the cable with the body that the parameters describe.
Steps are exact for velocities that are cubics of time. A cable of constant length between two prescribed ends is not
offered: it is over-determined as it straightens, and finite EA governs there.

States: x (modal where reduced), d (2), and u''.

Assumptions: (1) small perturbations, margins tell how small; (2) of ``cable/case.py``.

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
from ...protocol.state_space import Reduction, Setup, Study
from ...protocol.variables import EVERY_INPUT, Rate, calculated_parameter, input_variable, output
from ..lumped.fidelity import Chosen, choose, ends_together
from ..lumped.linear import BODY_VELOCITY, PROFILE, Rows, StateSpace, cable_model
from ..lumped.lumped import hang, matrices
from ..parameters import ELASTIC, Choice, TowParameters, integral, refusal_by, tow_of, tow_requirements, traced_tow
from . import linear_tow, ports, tow_system
from .linear_tow import Constants
from .ports import second_derivative

OFFSET = slice(2, 4)
"""Where the offset is among the inputs v."""
FEWEST = 2
"""Segments that a cable between two prescribed ends needs."""


@dataclass(frozen=True)
class Parameters(Choice, TowParameters):
    """The tow first, then how it is modelled."""

    axial_stiffness: Annotated[Value, ELASTIC]


class Size(NamedTuple):
    """What fixes the number of states."""

    segments: float = 24.0
    grading: float = 1.0


class Own(NamedTuple):
    """Displacement of the body relative to the towpoint, and second derivatives of the inputs over the last step."""

    offset_surge: Value
    offset_heave: Value
    top_velocity_surge_d2: Annotated[Value, second_derivative("top_velocity_surge", "m/s")]
    top_velocity_heave_d2: Annotated[Value, second_derivative("top_velocity_heave", "m/s")]
    body_velocity_surge_d2: Annotated[Value, second_derivative("body_velocity_surge", "m/s")]
    body_velocity_heave_d2: Annotated[Value, second_derivative("body_velocity_heave", "m/s")]


class Inputs(NamedTuple):
    """Velocities of both ends: the towpoint may not heave or its heave was forgotten, that of the body answers the cable."""

    top_velocity_surge: Annotated[
        Value,
        input_variable(
            "m/s", "Velocity of the top end in the towing frame, forward", display="ft/s",
            unset="the top end does not surge",
        ),
    ]  # fmt: skip
    top_velocity_heave: Annotated[
        Value, input_variable("m/s", "Velocity of the top end in the towing frame, up", display="ft/s")
    ]
    body_velocity_surge: Annotated[
        Value,
        input_variable("m/s", "Velocity of the body end in the towing frame, forward", display="ft/s", needed=True),
    ]
    body_velocity_heave: Annotated[
        Value, input_variable("m/s", "Velocity of the body end in the towing frame, up", display="ft/s", needed=True)
    ]


class Outputs(NamedTuple):
    """Forces on both ends, the offset between them, margins."""

    reaction_surge: Annotated[Value, ports.REACTION_SURGE]
    reaction_heave: Annotated[Value, ports.REACTION_HEAVE]
    body_force_surge: Annotated[
        Value, output("N", "Change of the pull on the body, forward", display="lbf", also=EVERY_INPUT)
    ]
    body_force_heave: Annotated[
        Value, output("N", "Change of the pull on the body, up", display="lbf", also=EVERY_INPUT)
    ]
    tension_top: Annotated[Value, ports.TENSION_TOP]
    tension_body: Annotated[Value, ports.TENSION_BODY]
    offset_surge: Annotated[
        Value, output("m", "Displacement of the body relative to the towpoint, forward", display="ft")
    ]
    offset_heave: Annotated[
        Value, output("m", "Displacement of the body relative to the towpoint, up", display="ft")
    ]
    margin_small_perturbation: ports.MarginSmallPerturbation
    margin_slack: ports.MarginSlack
    margin_quadrant: ports.MarginQuadrant
    margin_resolution: ports.MarginResolution
    reaction_surge_rate: Rate
    reaction_heave_rate: Rate
    body_force_surge_rate: Rate
    body_force_heave_rate: Rate
    tension_top_rate: Rate


class Calculated(NamedTuple):
    """What was chosen and found at the start."""

    port_stiffness: Annotated[
        Value,
        calculated_parameter("N/m", "Largest force on the body at once per displacement of it", tunable=True),
    ]
    steady_tension_top: ports.SteadyTensionTop
    steady_tension_body: ports.SteadyTensionBody
    states: ports.States
    segments_used: ports.SegmentsUsed
    model_error: ports.ModelError


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
    """What the parameters must fulfil."""
    elastic = (
        p.axial_stiffness,
        "axial_stiffness is 0: a cable of constant length between two prescribed ends is over-determined as it "
        "straightens; expected a positive axial stiffness EA, or the unit tow_system",
    )
    return elastic, *tow_requirements(p, ops)


def setup(p: Parameters, size: Size, ops: MatrixOps) -> Setup:
    """The full model of ``size``."""
    tow = traced_tow(p, ops.scalars)
    model = cable_model(matrices(hang(tow, int(size.segments), ops, size.grading), True, ops), ops)
    return _setup(ends_together(model, ops), ops)


def _setup(model: StateSpace, ops: MatrixOps) -> Setup:
    return linear_tow.setup_of(model, model.d[BODY_VELOCITY, OFFSET], 4.0, ops)


def study(size: Size) -> Study:
    """Reduction, error of the segments."""
    direct = "direct", BODY_VELOCITY.start, OFFSET.start
    # with its body: between two given ends the error of the segments is not of second order
    towed = tow_system.Size(size.segments, 1.0, size.grading)
    stand_in = tow_system.setup, towed
    comparisons = tuple(replace(each, stand_in=stand_in) for each in linear_tow.halved(towed, FEWEST))
    return Study(Reduction(True, "measured_inputs", "states", "model_error", direct), comparisons)


def drive(own: Own, cubics: Inputs, p: Parameters, constants: Constants, ops: Ops) -> tuple[Sequence[Value], ...]:
    """Velocity of the towpoint, offset, of degree 4, and its rate."""
    top_surge, top_heave, body_surge, body_heave = cubics
    surge = [b - a for a, b in zip(top_surge, body_surge)]
    heave = [b - a for a, b in zip(top_heave, body_heave)]
    offsets = [
        [start, *(a / k for k, a in enumerate(rate, 1))]
        for start, rate in ((own.offset_surge, surge), (own.offset_heave, heave))
    ]
    return [*top_surge, 0.0], [*top_heave, 0.0], *offsets, [*surge, 0.0], [*heave, 0.0]


def own_after(
    h: Value, own: Own, cubics: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """`Own` after a step of ``h``, s."""
    surge = own.offset_surge + integral(h, cubics.body_velocity_surge) - integral(h, cubics.top_velocity_surge)
    heave = own.offset_heave + integral(h, cubics.body_velocity_heave) - integral(h, cubics.top_velocity_heave)
    return (surge, heave, *(2.0 * c2 + 6.0 * c3 * h for _, _, c2, c3 in cubics))


def _relative(w: Inputs) -> tuple[Value, Value]:
    """Velocity of the body relative to the towpoint, or a derivative of it."""
    return w.body_velocity_surge - w.top_velocity_surge, w.body_velocity_heave - w.top_velocity_heave


def own_rates(
    own: Own, u: Inputs, du: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """Rates of `Own`; nothing tells those of the second derivatives."""
    return (*_relative(u), 0.0, 0.0, 0.0, 0.0)


def core(
    own: Own, u: Inputs, du: Inputs, p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value], Sequence[Value], Sequence[Value]]:
    """Velocity of the towpoint, offset and its rate, and their derivatives."""
    _, _, *remembered_inputs = own
    ddu = Inputs(*remembered_inputs)
    rate, second, third = _relative(u), _relative(du), _relative(ddu)
    return (
        (u.top_velocity_surge, u.top_velocity_heave, own.offset_surge, own.offset_heave, *rate),
        (du.top_velocity_surge, du.top_velocity_heave, *rate, *second),
        (own.top_velocity_surge_d2, own.top_velocity_heave_d2, *second, *third),
    )


def observe(
    t: Value, own: Own, y: Sequence[Value], y_rate: Sequence[Value], u: Inputs, du: Inputs, growth: Value,
    p: Parameters, constants: Constants, ops: Ops,
) -> tuple[Outputs, tuple[Value, ...]]:  # fmt: skip
    """All observables, and the tensions of the segments, N."""
    slack, quadrant, tensions = linear_tow.profile(y, constants, ops)
    row, rate = Rows._make(y[:PROFILE]), Rows._make(y_rate[:PROFILE])
    surge, heave = u.top_velocity_surge, u.top_velocity_heave
    top = linear_tow.speed_margin(surge, heave, p.tow_speed, p.perturbation_limit, ops)
    body = linear_tow.speed_margin(u.body_velocity_surge, u.body_velocity_heave, p.tow_speed, p.perturbation_limit, ops)
    return Outputs(
        -row.force_surge, -row.force_heave, row.body_surge, row.body_heave, constants.tension_top + row.tension_top,
        constants.tension_body + row.tension_body, own.offset_surge, own.offset_heave, ops.minimum(top, body), slack,
        quadrant, 1.0 - constants.model_error / p.tolerance, -rate.force_surge, -rate.force_heave, rate.body_surge,
        rate.body_heave, rate.tension_top,
    ), tensions  # fmt: skip


def describe(p: Parameters, constants: Constants, ops: Ops) -> Calculated:
    """``port_stiffness``: the largest force on the body at once per displacement of it."""
    c = constants
    xx, xy, yx, yy = c.direct
    # largest singular value
    turning, stretching = (xx + yy, xy - yx), (xx - yy, xy + yx)
    largest = sum(ops.sqrt(a * a + b * b) for a, b in (turning, stretching))
    return Calculated(0.5 * largest, c.tension_top, c.tension_body, c.states, c.segments, c.model_error)


@remembered
def chosen(p: Parameters) -> Chosen:
    """The state space that the parameters ask for, with its errors. Raises `CableError`."""
    return choose(tow_of(p), True, p.band, p.tolerance, int(p.segments), p.reduced > 0.5, with_body=False, grading=p.grading)


def size(p: Parameters) -> Size:
    """As many segments as the parameters say or, where they leave it open, as were chosen."""
    return Size(*linear_tow.divided(p, chosen))


def prepare(p: Parameters) -> Setup:
    """The chosen model, of numbers. Raises `CableError`."""
    made = chosen(p)
    return linear_tow.chosen_setup(_setup(made.model, numbers()), made)


LINEAR = LinearModel(
    "tow_cable",
    "Elastic tow cable between two units, small perturbations from the steady tow",
    Parameters, Inputs, Outputs, Calculated, Size, Own,
    setup=setup, prepare=prepare, drive=drive, core=core, observe=observe, describe=describe, own_after=own_after,
    own_rates=own_rates, size=size, study=study, requirements=requirements, setup_requirements=linear_tow.setup_requirements,
    refusal=refusal_by(chosen), tuning_refusal=linear_tow.tuning_refusal, order=4, rates=PROFILE, extra=linear_tow.EXTRA,
)  # fmt: skip
TOW_CABLE = LINEAR.as_model()
