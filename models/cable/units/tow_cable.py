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
from typing import NamedTuple

from ...numeric.matrix_ops import MatrixOps, numbers
from ...numeric.ops import Ops, Value
from ...protocol.linear_model import remembered
from ...protocol.state_space import Reduction, Setup, Study
from ..case import CableError, Condition
from ..lumped.fidelity import choose, ends_together
from ..lumped.linear import BODY_VELOCITY, PROFILE, LinearModel, cable_model
from ..lumped.lumped import hang, matrices
from ..parameters import LinearParameters, Modes, integral, tow_of, tow_requirements, traced_tow
from . import tow_system
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
OFFSET = slice(2, 4)
"""Where the offset is among the inputs v."""
FEWEST = 2
"""Segments that a cable between two prescribed ends needs."""


@dataclass(frozen=True)
class Parameters(LinearParameters):
    """SI."""


class Size(NamedTuple):
    """What fixes the number of states."""

    segments: float = 20.0


STRUCTURE = Size._fields


class Own(NamedTuple):
    """Displacement of the body relative to the towpoint, m, and second derivatives of the inputs over the last step."""

    offset_surge: Value
    offset_heave: Value
    top_velocity_surge_d2: Value
    top_velocity_heave_d2: Value
    body_velocity_surge_d2: Value
    body_velocity_heave_d2: Value


class Inputs(NamedTuple):
    """Velocities in the towing frame, m/s, forward and up."""

    top_velocity_surge: float
    top_velocity_heave: float
    body_velocity_surge: float
    body_velocity_heave: float


class Outputs(NamedTuple):
    """Reactions: excess of the pull on the towpoint, aft and down; forces: change of the pull on the body, forward and
    up; N."""

    reaction_surge: float
    reaction_heave: float
    body_force_surge: float
    body_force_heave: float
    tension_top: float
    tension_body: float
    offset_surge: float
    offset_heave: float
    margin_small_perturbation: float
    margin_slack: float
    margin_flow: float
    margin_quadrant: float
    margin_resolution: float
    reaction_surge_rate: float
    reaction_heave_rate: float
    body_force_surge_rate: float
    body_force_heave_rate: float
    tension_top_rate: float


class Calculated(NamedTuple):
    """What was chosen and found at the start."""

    port_stiffness: float
    steady_tension_top: float
    steady_tension_body: float
    states: float
    segments_used: float
    model_error: float


def requirements(p: Parameters, ops: Ops) -> tuple[Condition, ...]:
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
    model = cable_model(matrices(hang(tow, int(size.segments), ops), True, ops), ops)
    return _setup(ends_together(model, ops), ops)


def _setup(model: LinearModel, ops: MatrixOps) -> Setup:
    return setup_of(model, model.d[BODY_VELOCITY, OFFSET], 4.0, ops)


def study(size: Size) -> Study:
    """Reduction, error of the segments."""
    direct = "direct", BODY_VELOCITY.start, OFFSET.start
    # with its body: between two given ends the error of the segments is not of second order
    towed = tow_system.Size(size.segments, 1.0)
    stand_in = tow_system.setup, towed
    comparisons = tuple(replace(each, stand_in=stand_in) for each in halved(towed, FEWEST))
    return Study(Reduction(True, "measured_inputs", "states", "model_error", direct), comparisons)


def drive(
    own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value], ...]:
    """Velocity of the towpoint, offset, of degree 4, and its rate."""
    rates = [[b - a for a, b in zip(top, body)] for top, body in zip(cubics[:2], cubics[2:])]
    offsets = [[start, *(a / k for k, a in enumerate(rate, 1))] for start, rate in zip(own, rates)]
    return *([*a, 0.0] for a in cubics[:2]), *offsets, *([*a, 0.0] for a in rates)


def own_after(
    h: Value, own: Sequence[Value], cubics: Sequence[Sequence[Value]], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """`Own` after a step of ``h``, s."""
    moved = [start + integral(h, body) - integral(h, top) for start, top, body in zip(own, cubics[:2], cubics[2:])]
    return (*moved, *(2.0 * a[2] + 6.0 * a[3] * h for a in cubics))


def own_rates(
    own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Value, ...]:
    """Rates of `Own`; nothing tells those of the second derivatives."""
    return u[2] - u[0], u[3] - u[1], 0.0, 0.0, 0.0, 0.0


def core(
    own: Sequence[Value], u: Sequence[Value], du: Sequence[Value], p: Parameters, constants: Constants, ops: Ops
) -> tuple[Sequence[Value], Sequence[Value], Sequence[Value]]:
    """Velocity of the towpoint, offset and its rate, and their derivatives."""
    rate, second, third = ((w[2] - w[0], w[3] - w[1]) for w in (u, du, own[2:]))
    return (u[0], u[1], own[0], own[1], *rate), (du[0], du[1], *rate, *second), (own[2], own[3], *second, *third)


def observe(
    t: Value, own: Sequence[Value], y: Sequence[Value], y_rate: Sequence[Value], u: Sequence[Value],
    du: Sequence[Value], growth: Value, p: Parameters, constants: Constants, ops: Ops,
) -> tuple[Outputs, tuple[Value, ...]]:  # fmt: skip
    """All observables, and the tensions of the segments, N."""
    slack, quadrant, tensions = profile(y, constants, ops)
    speeds = [speed_margin(end, p.tow_speed, p.perturbation_limit, ops) for end in (u[:2], u[2:])]
    return Outputs(
        -y[0], -y[1], y[2], y[3], constants.tension_top + y[7], constants.tension_body + y[6], own[0], own[1],
        ops.minimum(speeds[0], speeds[1]), slack, flow_margin(y, u, p.tow_speed, constants, ops), quadrant,
        1.0 - constants.model_error / p.tolerance, -y_rate[0], -y_rate[1], y_rate[2], y_rate[3], y_rate[7],
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
def prepare(p: Parameters) -> TowUnit:
    """The unit with the model that the parameters ask for. Raises `CableError`."""
    chosen = choose(tow_of(p), True, p.band, p.tolerance, int(p.segments), p.reduced > 0.5, with_body=False)
    made = chosen_setup(_setup(chosen.model, numbers()), chosen)
    return TowUnit(made, p, drive, own_after, core, observe, order=4, rates=PROFILE, chosen=chosen)


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
    """Exact step of length ``h``, s; the offset is a polynomial of degree 4 over it."""
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
