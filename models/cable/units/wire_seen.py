"""The unit ``wire``: what follows from its parameters, and its outputs from what is seen of a moment, for values of any kind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...numeric.arrays import Array
from ...numeric.ops import Ops, Value
from ...protocol.model import remembered
from ..case import CableError
from ..wire.chain import Chain, Drive
from ..wire.elements import lagrange
from ..wire.grading import MOST_ELEMENTS, graded_mesh
from ..wire.mesh import Mesh
from ..wire.rest import Frame, equilibrium, march
from ..wire.stepper import Stepper
from .wire_parameters import Parameters, flow_of, wire_of
from .wire_ports import BENDING_LIMIT, LEAST_ROOM, MOST_BENDING, REYNOLDS_LIMIT, STATIONS, VISCOSITY, Inputs, Outputs


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


def vectors(u: Inputs | Sequence[Any], d: int) -> tuple[list[Any], Any, list[Any], list[Any]]:
    """(Velocity of the towpoint, winch speed, force on the body, velocity of the lower end): inputs, or their cubics, by
    component."""
    own = (0, 1, 2) if d == 3 else (0, 2)
    return [u[k] for k in own], u[3], [u[4 + k] for k in own], [u[7 + k] for k in own]


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
    return Outputs._make((
        *excess, ops.sqrt(level2 + needed[2] * needed[2]), at_body, least, most, ops.atan2(needed[2], ops.sqrt(level2)),
        -body[2], -away[0], away[1], *(x for point in shape for x in point), *moved, *speed, *lower,
        prepared.chain.wire.length + seen.paid,
        ops.minimum(1.0, least / prepared.tensions[0]),
        (p.breaking_load - most) / room if p.breaking_load > 0.0 else 1.0,
        1.0 - seen.error / p.tolerance, 1.0 - ops.minimum(seen.bending, MOST_BENDING) / BENDING_LIMIT,
        ops.minimum(1.0, (p.surface_height - body[2]) / below) if below > 0.0 else 1.0,
        1.0 - seen.flow / (VISCOSITY * REYNOLDS_LIMIT), *speed,
    ))  # fmt: skip
