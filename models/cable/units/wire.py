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

from collections.abc import Sequence

import numpy as np

from ...numeric.arrays import Array
from ...numeric.ops import FLOATS, Ops
from ...protocol.model import AnyModel, Model, Requirement
from ..parameters import integral, refusal_by
from ..wire.chain import Drive
from ..wire.jacobian import derivatives
from ..wire.stepper import State
from . import wire_parameters
from .wire_parameters import Parameters
from .wire_part import WirePart
from .wire_ports import LEAST_ROOM, Calculated, Inputs, Modes, Outputs
from .wire_seen import Seen, observed, prepare, vectors


def requirements(p: Parameters, ops: Ops) -> Sequence[Requirement]:
    """What the parameters must fulfil."""
    return wire_parameters.requirements(p, ops)


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
