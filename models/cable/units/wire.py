"""Nonlinear wire: towpoint velocity and winch speed in, pull on the towpoint and motion of the body out.

    R_i(r, u, u') = 0 at free nodes,   r' = u,   pull on the ship = -R at the top             (``cable/wire/chain.py``)

From hanging at rest to towing in a turn, in the vertical plane or in space: one elastic wire, a tail below it, a clump at
their joint, a body at the end, current that falls with depth, wire paid out or hauled in. The frame moves with ``tow_speed``;
x forward, y to port, z up, the towpoint at z = 0 at rest. A communication step is divided into implicit steps by their error.

States: positions, velocities, accelerations of the nodes; the next internal step; where the kept factors were made; the
accelerations before the last step; wire paid out; displacement of the towpoint. They are all there is: a state that is set
back goes on to the last bit as before.

With ``body_port`` the body is a unit of its own: its velocity comes in, the wire's force on it goes out.

Assumptions: those of ``cable/wire/point.py``; (6) no surface and no bottom; (7) the body is a point; (8) drag coefficients do
not change with the Reynolds number. What (1), (6) and (8) leave out, ``margin_bending``, ``_surface`` and ``_drag`` bound.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...numeric.arrays import Array
from ...numeric.ops import FLOATS, Ops, Value
from ...protocol.model import AnyModel, Model, Requirement, remembered
from ..case import CableError
from ..parameters import integral, refusal_by
from ..wire.chain import Chain, Drive
from ..wire.elements import lagrange
from ..wire.grading import MOST_ELEMENTS, graded_mesh
from ..wire.jacobian import derivatives
from ..wire.mesh import Mesh
from ..wire.rest import Frame, equilibrium, march
from ..wire.stepper import State, Stepper
from . import wire_parameters
from .wire_parameters import Parameters, flow_of, wire_of
from .wire_ports import (
    BENDING_LIMIT,
    LEAST_ROOM,
    MOST_BENDING,
    REYNOLDS_LIMIT,
    STATIONS,
    VISCOSITY,
    Calculated,
    Inputs,
    Modes,
    Outputs,
)


def requirements(p: Parameters, ops: Ops) -> Sequence[Requirement]:
    """What the parameters must fulfil."""
    return wire_parameters.requirements(p, ops)


class Prepared(NamedTuple):
    """The chain and its stepper; the steady nodes (n, d), needed forces, N, tensions (least, largest, at the body), N; error
    of the mesh at rest; EI, N m2, and diameter, m, of its elements, (E, 1); see `stations`."""

    chain: Chain
    stepper: Stepper
    nodes: Array
    needed: Array
    tensions: tuple[float, float, float]
    error: float
    thickness: tuple[Array, Array]
    stations: Array


def stations(mesh: Mesh) -> Array:
    """Rows that take places of the nodes to those of `STATIONS` places in equal parts of the length, (STATIONS, n)."""
    ends = np.concatenate([[0.0], np.cumsum(mesh.lengths)])
    rows = np.zeros((STATIONS, mesh.nodes))
    for k in range(STATIONS):
        s = ends[-1] * (k + 1) / (STATIONS + 1)
        e = min(int(np.searchsorted(ends, s, side="right")) - 1, len(mesh.lengths) - 1)
        x = 2.0 * (s - ends[e]) / mesh.lengths[e] - 1.0
        rows[k, e * mesh.degree : e * mesh.degree + mesh.degree + 1] = lagrange(mesh.degree, np.array([x]))[0]
    return rows


@remembered
def prepare(p: Parameters) -> Prepared:
    """What follows from the parameters. Raises `CableError`."""
    wire, flow = wire_of(p), flow_of(p)
    d = flow.velocity.shape[1]
    zero = np.zeros(d)
    # the frame of the flow is that of the tow: at rest nothing moves in it
    frame, degree, count = Frame(zero), int(p.degree), int(p.elements)
    shape = march(wire, flow, frame, d)
    graded = graded_mesh(wire, shape, degree, count, p.tolerance)
    if not count and graded.error > p.tolerance:
        more = math.ceil(MOST_ELEMENTS * (graded.error / p.tolerance) ** (1.0 / (degree + 1.0)))
        raise CableError(
            f"elements: {MOST_ELEMENTS} of degree {degree} leave an error of {graded.error:.2g} of the length, about {more} "
            f"would reach tolerance = {p.tolerance:g}: raise degree or tolerance"
        )
    chain = Chain(wire, graded.mesh, flow, d)
    nodes = equilibrium(chain, frame, shape.position(graded.mesh.places))
    if p.body_port > 0.5:
        # from here on the lower end moves as the body's unit says
        chain = Chain(replace(wire, body=None), graded.mesh, flow, d)
    drive, still = Drive(zero, zero, zero), np.zeros_like(nodes)
    look = chain.look(nodes, still, still, drive)
    sizes = np.linalg.norm(look.pulls, axis=2)
    thick = tuple(np.array(each)[chain.mesh.section][:, None] for each in zip(*thickness(p)))
    return Prepared(
        chain, Stepper(chain, p.velocity_tolerance, p.largest_step), nodes, look.needed,
        (float(sizes.min()), float(sizes.max()), float(sizes[0, 0])), graded.error, (thick[0], thick[1]),
        stations(graded.mesh),
    )  # fmt: skip


def _packed(state: State, paid: float, top: Array) -> tuple[float, ...]:
    """The state of the unit."""
    zero = np.zeros_like(state.position)
    made = state.made or (zero, zero, zero, 0.0, (0.0, 0.0, 0.0))
    before = state.before or (0.0, zero)
    vectors = (state.position, state.velocity, state.acceleration, *made[:3], before[1])
    return (
        *np.concatenate([x.ravel() for x in vectors]).tolist(), state.step, made[3], *made[4], before[0], paid, *top.tolist(),
    )  # fmt: skip


def _unpacked(x: Sequence[float], nodes: int, d: int) -> tuple[State, float, Array]:
    """(State, wire paid out, displacement of the towpoint)."""
    size = nodes * d
    r, u, b, made_r, made_u, made_b, before = np.array(x[: 7 * size]).reshape(7, nodes, d)
    step, weight, paid0, paid1, paid2, before_step, paid, *top = x[7 * size :]
    made = (made_r, made_u, made_b, weight, (paid0, paid1, paid2)) if weight > 0.0 else None
    state = State(r, u, b, step, made, (before_step, before) if before_step > 0.0 else None)
    return state, paid, np.array(top)


def initial(p: Parameters, ops: Ops) -> tuple[tuple[float, ...], Modes]:
    """The steady tow."""
    nodes = prepare(p).nodes
    zero = np.zeros_like(nodes)
    return _packed(State(nodes, zero, zero), 0.0, zero[0]), Modes()


def vectors(u: Inputs | Sequence[Any], d: int) -> tuple[list[Any], Any, list[Any], list[Any]]:
    """(Velocity of the towpoint, winch speed, force on the body, velocity of the lower end): inputs, or their cubics, by
    component."""
    own = (0, 1, 2) if d == 3 else (0, 2)
    return [u[k] for k in own], u[3], [u[4 + k] for k in own], [u[7 + k] for k in own]


def _value(c: Sequence[float], s: float) -> float:
    return c[0] + s * (c[1] + s * (c[2] + s * c[3]))


def _rate(c: Sequence[float], s: float) -> float:
    return c[1] + s * (2.0 * c[2] + s * 3.0 * c[3])


def advance(
    t: float, h: float, x: Sequence[float], m: Modes, cubics: Inputs, p: Parameters, ops: Ops
) -> tuple[float, ...]:
    """Step of length ``h``, s. Raises `CableError` where an implicit step fails."""
    prepared = prepare(p)
    d = prepared.chain.dimensions
    state, paid, top = _unpacked(x, prepared.chain.mesh.nodes, d)
    velocity, winch, force, lower = vectors(cubics, d)
    start = state.position[0] if prepared.chain.wire.body is None else None

    def motion(s: float) -> Drive:
        held = None if start is None else (
            start + np.array([integral(s, c) for c in lower]), np.array([_value(c, s) for c in lower]),
            np.array([_rate(c, s) for c in lower]),
        )  # fmt: skip
        return Drive(
            top + np.array([integral(s, c) for c in velocity]), np.array([_value(c, s) for c in velocity]),
            np.array([_rate(c, s) for c in velocity]), (paid + integral(s, winch), _value(winch, s), _rate(winch, s)),
            np.array([_value(c, s) for c in force]), held,
        )  # fmt: skip

    state = prepared.stepper.advance(0.0, h, state, motion)
    return _packed(state, paid + integral(h, winch), motion(h).position)


def thickness(p: Parameters) -> list[tuple[float, float]]:
    """(EI, N m2; diameter, m) of the sections from the lower end."""
    tail = [(p.tail_bending_stiffness, p.tail_diameter)] if p.tail_length > 0.0 else []
    return [*tail, (p.wire_bending_stiffness, p.wire_diameter)]


class Seen(NamedTuple):
    """What outputs are made of: force needed at the top and at the lower end, N; tensions (least, largest, at the body), N; place
    of the body, m, its velocity, m/s, and the displacement of the towpoint, m, of d components; wire paid out, m; error of
    the shape; largest error of the tension by bending; largest diameter times speed of the water across the wire, m2/s;
    places of the shape's stations, m."""

    needed: Sequence[Value]
    lower: Sequence[Value]
    tensions: tuple[Value, Value, Value]
    body: Sequence[Value]
    velocity: Sequence[Value]
    top: Sequence[Value]
    paid: Value
    error: Value
    bending: Value
    flow: Value
    shape: Sequence[Sequence[Value]]


def observed(seen: Seen, prepared: Prepared, p: Parameters, ops: Ops) -> Outputs:
    """The outputs."""
    steady, rest, d = prepared.needed[-1].tolist(), prepared.nodes[0].tolist(), len(seen.top)
    least, most, at_body = seen.tensions

    def whole(vector: Sequence[Value]) -> tuple[Value, Value, Value]:
        """Of three components; a plane has none to port."""
        return vector[0], vector[1] if d == 3 else 0.0, vector[-1]

    needed, body, speed = whole(seen.needed), whole(seen.body), whole(seen.velocity)
    held = prepared.needed[0].tolist()
    excess, lower, away, moved = (
        whole([a - b for a, b in zip(one, other)])
        for one, other in ((seen.needed, steady), (held, seen.lower), (seen.body, seen.top), (seen.body, rest))
    )
    if prepared.chain.wire.body is not None:
        lower = (0.0, 0.0, 0.0)
    shape = [
        (seen.top[0] - point[0], point[1] - seen.top[1] if d == 3 else 0.0, -point[-1]) for point in seen.shape
    ]  # fmt: skip
    below = p.surface_height - rest[-1]
    level2 = needed[0] * needed[0] + needed[1] * needed[1]
    room = max(p.breaking_load - prepared.tensions[1], LEAST_ROOM)
    return Outputs(
        *excess, ops.sqrt(level2 + needed[2] * needed[2]), at_body, least, most, ops.atan2(needed[2], ops.sqrt(level2)),
        -body[2], -away[0], away[1], *(x for point in shape for x in point), *moved, *speed, *lower,
        prepared.chain.wire.length + seen.paid,
        ops.minimum(1.0, least / prepared.tensions[0]),
        (p.breaking_load - most) / room if p.breaking_load > 0.0 else 1.0,
        1.0 - seen.error / p.tolerance, 1.0 - ops.minimum(seen.bending, MOST_BENDING) / BENDING_LIMIT,
        ops.minimum(1.0, (p.surface_height - body[2]) / below) if below > 0.0 else 1.0,
        1.0 - seen.flow / (VISCOSITY * REYNOLDS_LIMIT), *speed,
    )  # fmt: skip


def outputs(
    t: float, x: Sequence[float], m: Modes, u: Inputs, du: Inputs, p: Parameters, ops: Ops
) -> Outputs:
    """All observables."""
    prepared = prepare(p)
    chain, d = prepared.chain, prepared.chain.dimensions
    state, paid, top = _unpacked(x, chain.mesh.nodes, d)
    velocity, winch, force, lower = vectors(u, d)
    change, winch_change, _, lower_change = vectors(du, d)
    drive = Drive(top, np.array(velocity), np.array(change), (paid, winch, winch_change), np.array(force))
    r, v, a = state.position, state.velocity.copy(), state.acceleration.copy()
    v[-1], a[-1] = drive.velocity, drive.acceleration
    if chain.wire.body is None:
        v[0], a[0] = lower, lower_change
    look = chain.look(r, v, a, drive)
    needed, sizes = look.needed, np.linalg.norm(look.pulls, axis=2)
    curvature2, across = chain.bends(look)
    stiff, diameter = prepared.thickness
    seen = Seen(
        needed[-1].tolist(), needed[0].tolist(), (float(sizes.min()), float(sizes.max()), float(sizes[0, 0])), r[0].tolist(),
        v[0].tolist(), top.tolist(), paid, chain.shape_error(r, drive.paid),
        float((stiff * curvature2 / (sizes + LEAST_ROOM)).max()), float((diameter * across).max()),
        (prepared.stations @ r).tolist(),
    )  # fmt: skip
    return observed(seen, prepared, p, FLOATS)


def calculated(p: Parameters, ops: Ops) -> Calculated:
    """Of the steady tow; ``port_mass``: of the node at the top, in heave."""
    prepared = prepare(p)
    chain, still = prepared.chain, np.zeros_like(prepared.nodes)
    mass = derivatives(chain, prepared.nodes, still, still)[2]
    return Calculated(
        float(mass[-1, -1, -1, -1, -1]), float(np.linalg.norm(prepared.needed[-1])), prepared.tensions[2],
        -float(prepared.nodes[0, -1]), float(len(chain.mesh.lengths)), prepared.error,
    )  # fmt: skip


def part(p: Parameters) -> AnyModel:
    """The wire of these parameters with rates of its states, for compositions."""
    from .wire_part import WirePart  # which is made of this module

    return WirePart(WIRE, p).model()


WIRE = Model(
    "wire",
    "Nonlinear wire with a body, hanging, towed or turning: large motions, slack, payout, in the plane or in space; no model "
    "exchange, since its number of states follows from its parameters (a scene of it as one unit has it)",
    Parameters, None, Modes, Inputs, Outputs, Calculated,
    initial=initial, advance=advance, outputs=outputs, calculated=calculated, requirements=requirements,
    refusal=refusal_by(prepare), numbers=wire_parameters.numbers, part=part,
    floats_only="its implicit steps are divided and iterated as the numbers demand, which a trace cannot follow",
)  # fmt: skip
