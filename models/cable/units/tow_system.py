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
from dataclasses import dataclass
from typing import NamedTuple

from ...numeric.matrix_ops import MatrixOps, numbers
from ...numeric.ops import Ops, Value
from ...protocol.linear_model import remembered
from ...protocol.state_space import Comparison, Reduction, Setup, Study
from ..case import CableError, Condition, Tow
from ..lumped.fidelity import choose
from ..lumped.linear import PROFILE, LinearModel, elastic_model, rigid_model
from ..lumped.lumped import hang, matrices
from ..parameters import LinearParameters, Modes, TowpointInputs, integral, tow_of, tow_requirements, traced_tow
from .linear_tow import (
    EXTRA,
    Constants,
    TowUnit,
    chosen_setup,
    flow_margin,
    halved,
    profile,
    setup_of,
    setup_requirements,
    speed_margin,
    untunable,
)

__all__ = ["EXTRA", "Constants", "Modes", "setup_requirements", "untunable"]
Inputs = TowpointInputs


@dataclass(frozen=True)
class Parameters(LinearParameters):
    """SI. ``extensible`` 1: with EA."""

    extensible: float


class Size(NamedTuple):
    """What fixes the number of states. 20 segments: 1 % of the force at 0.2 Hz on a cable of 120 m."""

    segments: float = 20.0
    extensible: float = 0.0


STRUCTURE = Size._fields


class Own(NamedTuple):
    """Displacement of the towpoint, m, and second derivatives of the inputs over the last step."""

    towpoint_surge: Value
    towpoint_heave: Value
    velocity_surge_d2: Value
    velocity_heave_d2: Value
    body_drag_change_d2: Value
    body_lift_change_d2: Value


class Outputs(NamedTuple):
    """Reactions: excess of the cable's pull over its steady value, aft and down on the towpoint, N."""

    reaction_surge: float
    reaction_heave: float
    tension_top: float
    tension_body: float
    body_surge: float
    body_heave: float
    body_velocity_surge: float
    body_velocity_heave: float
    margin_small_perturbation: float
    margin_slack: float
    margin_flow: float
    margin_quadrant: float
    margin_resolution: float
    margin_inextensible: float
    reaction_surge_rate: float
    reaction_heave_rate: float
    tension_top_rate: float
    body_surge_rate: float
    body_heave_rate: float
    body_velocity_surge_rate: float
    body_velocity_heave_rate: float


class Calculated(NamedTuple):
    """What was chosen and found at the start."""

    port_mass: float
    apparent_mass_surge: float
    apparent_mass_coupling: float
    apparent_mass_heave: float
    steady_tension_top: float
    steady_tension_body: float
    steady_body_surge: float
    steady_body_heave: float
    states: float
    segments_used: float
    model_error: float
    inextensible_error: float


def requirements(p: Parameters, ops: Ops) -> tuple[Condition, ...]:
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
    found = matrices(hang(tow, int(size.segments), ops), elastic, ops)
    model = elastic_model(found, ops) if elastic else rigid_model(found, ops)
    return _setup(model, model, tow, ops)


def _setup(model: LinearModel, full: LinearModel, tow: Tow, ops: MatrixOps) -> Setup:
    """``full``: ``model`` before reduction."""
    # in Quadrant I the towpoint drives the tow, in II forces on the body do too
    return setup_of(model, full.apparent_mass, 3.0 - tow.sign, ops)


def study(size: Size) -> Study:
    """Reduction, error of the segments, error of leaving EA out."""
    elastic = size.extensible > 0.5
    stretched = Comparison(
        size._replace(extensible=1.0), 1.0, "inextensible_error", truer=True, when=lambda p, ops: p.axial_stiffness
    )
    return Study(
        Reduction(elastic, "measured_inputs", "states", "model_error"),
        halved(size, 1) + (() if elastic else (stretched,)),
    )


def _signed(u: Sequence[Value]) -> tuple[Value, ...]:
    # drag acts aft: the model's force is forward
    return u[0], u[1], -u[2], u[3]


def drive(
    own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value], ...]:
    """Velocities and forces."""
    surge, heave, drag, lift = cubics
    return surge, heave, [-a for a in drag], lift


def own_after(
    h: Value, own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """`Own` after a step of ``h``, s."""
    moved = (own[0] + integral(h, cubics[0]), own[1] + integral(h, cubics[1]))
    return (*moved, *(2.0 * a[2] + 6.0 * a[3] * h for a in cubics))


def own_rates(
    own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """Rates of `Own`; nothing tells those of the second derivatives."""
    return u[0], u[1], 0.0, 0.0, 0.0, 0.0


def core(
    own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value], Sequence[Value], Sequence[Value]]:
    """Velocities and forces and their derivatives."""
    return _signed(u), _signed(du), _signed(own[2:])


def observe(
    t: Value, own: Sequence[Value], y: Sequence[Value], y_rate: Sequence[Value], u: Sequence[Value],
    du: Sequence[Value], growth: Value, p: Parameters, constants: Constants, ops: Ops,
) -> tuple[Outputs, tuple[Value, ...]]:  # fmt: skip
    """All observables, and the tensions of the segments, N."""
    slack, quadrant, tensions = profile(y, constants, ops)
    return Outputs(
        -y[0], -y[1], constants.tension_top + y[7], constants.tension_body + y[6], own[0] + y[4], own[1] + y[5], y[2],
        y[3], speed_margin(u, p.tow_speed, p.perturbation_limit, ops), slack,
        flow_margin(y, u, p.tow_speed, constants, ops), quadrant,
        1.0 - constants.model_error / p.tolerance, 1.0 - constants.inextensible_error / p.tolerance,
        -y_rate[0], -y_rate[1], y_rate[7], y_rate[4] + u[0], y_rate[5] + u[1], y_rate[2], y_rate[3],
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
def prepare(p: Parameters) -> TowUnit:
    """The unit with the model that the parameters ask for. Raises `CableError`."""
    tow = tow_of(p)
    chosen = choose(tow, p.extensible > 0.5, p.band, p.tolerance, int(p.segments), p.reduced > 0.5)
    made = chosen_setup(_setup(chosen.model, chosen.full, tow, numbers()), chosen)
    return TowUnit(made, p, drive, own_after, core, observe, rates=PROFILE, chosen=chosen)


def problem(p: Parameters) -> str:
    """Why there is no such tow; empty if there is."""
    try:
        prepare(p)
    except CableError as error:
        return str(error)
    return ""


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """The steady tow."""
    return (0.0,) * (prepare(p).states + len(Own._fields)), Modes()


def advance(
    t: float, h: float, x: Sequence[float], m: Modes, coefficients: Sequence[Sequence[float]], p: Parameters, ops: Ops
) -> tuple[float, ...]:
    """Exact step of length ``h``, s."""
    return prepare(p).advance(h, x, coefficients)


def outputs(
    t: float, x: Sequence[float], m: Modes, u: Sequence[float], du: Sequence[float], p: Parameters, ops: Ops
) -> Outputs:
    """All observables."""
    found: Outputs = prepare(p).outputs(t, x, u, du)[0]
    return found


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """What was chosen and found at the start."""
    return describe(p, prepare(p).setup.constants, ops)
