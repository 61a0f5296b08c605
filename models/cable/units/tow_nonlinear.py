"""Nonlinear tow: elastic lumped cable and body, towpoint velocity in, its force and the body's motion out.

    M(r) v' = f(r, v),   (r - r_N)' = v - v_N                                       (``cable/lumped/nonlinear.py``)

For scenes that leave the small-perturbation range. Ports as ``tow_system.py``, forces as changes from the steady
tow. A communication step is divided into implicit steps of at most ``internal_step``, s, of order 2.

States: positions relative to the towpoint, m, velocities through the water, m/s, displacement of the towpoint, m.

Assumptions: those of ``cable/lumped/nonlinear.py``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...numeric.ops import Ops
from ...protocol.linear_model import remembered
from ..case import CableError, Condition
from ..lumped.lumped import equilibrium, steady_towpoint_force
from ..lumped.nonlinear import NonlinearCable
from ..parameters import Modes, TowParameters, TowpointInputs, integral, tow_of, tow_requirements
from ..steady.steady import Array

Inputs = TowpointInputs


@dataclass(frozen=True)
class Parameters(TowParameters):
    """SI."""

    segments: float
    internal_step: float


class Outputs(NamedTuple):
    """As of ``tow_system.py``; ``tension_least`` over the segments."""

    reaction_surge: float
    reaction_heave: float
    tension_top: float
    tension_body: float
    tension_least: float
    body_surge: float
    body_heave: float
    body_velocity_surge: float
    body_velocity_heave: float
    margin_slack: float
    margin_quadrant: float
    body_surge_rate: float
    body_heave_rate: float


class Calculated(NamedTuple):
    """Of the steady tow."""

    port_mass: float
    steady_tension_top: float
    steady_tension_body: float


def requirements(p: Parameters, ops: Ops) -> tuple[Condition, ...]:
    """What the parameters must fulfil."""
    return (*tow_requirements(p, ops), (p.internal_step, "internal_step: expected a positive number of seconds"))


class Prepared(NamedTuple):
    """The discretised tow; its steady force on the towpoint, N, (2,), and least angle to the stream, rad."""

    cable: NonlinearCable
    steady: Array
    room: float


@remembered
def prepare(p: Parameters) -> Prepared:
    """What follows from the parameters. Raises `CableError`."""
    cable = NonlinearCable(equilibrium(tow_of(p), int(p.segments)), p.body_quadratic_drag > 0.5)
    return Prepared(
        cable, np.array(steady_towpoint_force(cable.chain)), float(cable.stream_angles(cable.start()).min())
    )


def problem(p: Parameters) -> str:
    """Why there is no such tow; empty if there is."""
    try:
        prepare(p)
    except CableError as error:
        return str(error)
    return ""


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """The steady tow."""
    return (*prepare(p).cable.start().ravel().tolist(), 0.0, 0.0), Modes()


def _state(x: Sequence[float]) -> Array:
    return np.array(x[:-2]).reshape(2, 2, -1)


def advance(
    t: float, h: float, x: Sequence[float], m: Modes, coefficients: Sequence[Sequence[float]], p: Parameters, ops: Ops
) -> tuple[float, ...]:
    """Step of length ``h``, s. Raises `CableError` where an implicit step fails."""
    cable = prepare(p).cable
    c = np.array(coefficients)
    # drag acts aft
    c[2] *= -1.0

    def motion(s: float) -> Array:
        u: Array = c @ np.array([1.0, s, s * s, s**3])
        return u

    count = max(1, math.ceil(h / p.internal_step - 1e-9))
    state = _state(x)
    for k in range(count):
        state = cable.step(k * h / count, h / count, state, motion)
    moved = [s + integral(h, a) for s, a in zip(x[-2:], coefficients)]
    return (*state.ravel().tolist(), *moved)


def outputs(
    t: float, x: Sequence[float], m: Modes, u: Sequence[float], du: Sequence[float], p: Parameters, ops: Ops
) -> Outputs:
    """All observables."""
    cable, steady, start = prepare(p)
    state = _state(x)
    force = cable.towpoint_force(state, np.array([u[0], u[1], -u[2], u[3]]), np.array([du[0], du[1]]))
    tensions = cable.tensions(state)
    room = float(cable.stream_angles(state).min())
    velocity = state[1, :, 0] - np.array([cable.chain.tow.speed, 0.0])
    offset = state[0, :, 0] - (cable.chain.nodes[0] - cable.chain.nodes[-1])
    least = float((tensions / cable.chain.tension).min())
    return Outputs(
        float(steady[0] - force[0]), float(steady[1] - force[1]), float(np.linalg.norm(force)), float(tensions[0]),
        float(tensions.min()), x[-2] + float(offset[0]), x[-1] + float(offset[1]), float(velocity[0]),
        float(velocity[1]), least if least < 1.0 else 1.0, min(1.0, room / start), float(velocity[0]),
        float(velocity[1]),
    )  # fmt: skip


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Of the steady tow; ``port_mass``: half of the last segment."""
    cable, steady, _ = prepare(p)
    mass = cable.mass(cable.start()[0])[-1]
    return Calculated(float(mass[1, 1]), float(np.linalg.norm(steady)), cable.chain.tow.end_tension)
