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
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from ...numeric.arrays import Array
from ...numeric.ops import Ops, Value
from ...protocol.model import Model, Requirement, remembered
from ...protocol.variables import Rate, calculated_parameter, margin, output, parameter
from ..lumped.lumped import equilibrium, steady_towpoint_force
from ..lumped.nonlinear import NonlinearCable
from ..parameters import ELASTIC, TowParameters, integral, refusal_by, tow_of, tow_requirements
from . import ports

Inputs = ports.TowpointInputs
TOWPOINT = ("velocity_surge", "velocity_heave")
"""What acts on the forces at once, by drag and inertia of the last half segment."""


@dataclass(frozen=True)
class Parameters(TowParameters):
    """The tow, and how it is divided in space and time."""

    axial_stiffness: Annotated[Value, ELASTIC]
    segments: Annotated[Value, parameter("1", 20.0, "Number of segments", min=1.0, max=400.0)]
    internal_step: Annotated[Value, parameter("s", 0.05, "Largest implicit step", min=1e-6)]


class Modes(NamedTuple):
    """No branches."""


class Outputs(NamedTuple):
    """As of ``tow_system.py``; ``tension_least`` over the segments."""

    reaction_surge: Annotated[Value, replace(ports.REACTION_SURGE, also=TOWPOINT)]
    reaction_heave: Annotated[Value, replace(ports.REACTION_HEAVE, also=TOWPOINT)]
    tension_top: Annotated[Value, replace(ports.TENSION_TOP, also=TOWPOINT)]
    tension_body: Annotated[Value, replace(ports.TENSION_BODY, also=TOWPOINT)]
    tension_least: Annotated[Value, output("N", "Least tension of the segments", display="lbf")]
    body_surge: ports.BodySurge
    body_heave: ports.BodyHeave
    body_velocity_surge: Annotated[Value, replace(ports.BODY_VELOCITY_SURGE, also=())]
    body_velocity_heave: Annotated[Value, replace(ports.BODY_VELOCITY_HEAVE, also=())]
    margin_slack: Annotated[Value, margin("least tension over steady tension of a segment, at most 1")]
    margin_quadrant: Annotated[
        Value, margin("least angle to the stream's direction over its steady value, at most 1")
    ]
    body_surge_rate: Rate
    body_heave_rate: Rate


class Calculated(NamedTuple):
    """Of the steady tow."""

    port_mass: Annotated[
        Value, calculated_parameter("kg", "Mass of half the last segment, in heave", tunable=True)
    ]
    steady_tension_top: ports.SteadyTensionTop
    steady_tension_body: ports.SteadyTensionBody


def requirements(p: Parameters, ops: Ops) -> tuple[Requirement, ...]:
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


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """The steady tow."""
    return (*prepare(p).cable.start().ravel().tolist(), 0.0, 0.0), Modes()


def _state(x: Sequence[float]) -> Array:
    return np.array(x[:-2]).reshape(2, 2, -1)


def advance(
    t: float, h: float, x: Sequence[float], m: Modes, cubics: Inputs, p: Parameters, ops: Ops
) -> tuple[float, ...]:
    """Step of length ``h``, s. Raises `CableError` where an implicit step fails."""
    cable = prepare(p).cable
    # drag acts aft
    c = np.array([
        cubics.velocity_surge, cubics.velocity_heave, [-a for a in cubics.body_drag_change], cubics.body_lift_change,
    ])  # fmt: skip

    def motion(s: float) -> Array:
        u: Array = c @ np.array([1.0, s, s * s, s**3])
        return u

    count = max(1, math.ceil(h / p.internal_step - 1e-9))
    state = _state(x)
    for k in range(count):
        state = cable.step(k * h / count, h / count, state, motion)
    moved = [s + integral(h, a) for s, a in zip(x[-2:], cubics)]
    return (*state.ravel().tolist(), *moved)


def outputs(
    t: float, x: Sequence[float], m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops
) -> Outputs:
    """All observables."""
    cable, steady, start = prepare(p)
    state = _state(x)
    inputs = np.array([u.velocity_surge, u.velocity_heave, -u.body_drag_change, u.body_lift_change])
    force = cable.towpoint_force(state, inputs, np.array([du.velocity_surge, du.velocity_heave]))
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


TOW_CABLE_NONLINEAR = Model(
    "tow_cable_nonlinear",
    "Tow cable and towed body, elastic lumped masses, large motions and slack",
    Parameters, None, Modes, Inputs, Outputs, Calculated,
    initial=initial, advance=advance, outputs=outputs, calculated=calculated, requirements=requirements,
    refusal=refusal_by(prepare),
    floats_only="its implicit steps are divided and iterated as the numbers demand, which a trace cannot follow",
)  # fmt: skip
