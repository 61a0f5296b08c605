"""Tow cable as a linear system in time: three state spaces of the lumped model.

    x' = A x + B u,    y = C x + D u + E u'

* `tow_rigid`, cable that keeps its length, with body. Inputs: velocity of the towpoint, m/s, force on the body, N.
  States: rotations eta of the segments, rad, and momenta p = Z'M q'.
* `tow_elastic`, elastic cable with body. The same inputs. States: displacements relative to the towpoint, m, and
  velocities, m/s, of all nodes but the towpoint.
* `cable_elastic`, elastic cable alone. Inputs: velocities of towpoint and body, m/s, and the offset of the body from
  the towpoint, m. States as before, of the inner nodes.

All are perturbations from the steady tow. Velocities are the only motion that comes in: position and velocity
interpolated separately contradict each other, which was measured to cost 20 % of the force at steps of 0.1 s. The load
does not depend on the position, so displacements relative to the towpoint suffice. Accelerations u' act only through
the apparent mass: the force at the towpoint contains m_app a.

In the rigid model q = B x_N + Z eta with Z of full rank N; the momenta p make the state equations free of u'. Its
tensions are the constraint forces, e_k . (sum of M q'' + C q' + K q over the nodes on the body's side).

Source: discretisation of ``lumped.py``; partitions and signs are our own, checked against the frequency domain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...numeric.arrays import ComplexArray
from ...numeric.matrix_ops import Matrix, MatrixOps, numbers
from ...numeric.ops import Value
from ..case import CableError, Tow
from .lumped import Chain, Matrices, ends, equilibrium, matrices, rows, steady_towpoint_force

FORCE = slice(0, 2)
"""Rows of y: force of the cable on the towpoint, N, forward and up."""
BODY_VELOCITY = slice(2, 4)
"""Rows of y: velocity of the body in the towing frame, m/s; in `cable_elastic` the cable's force on it, N."""
BODY_OFFSET = slice(4, 6)
"""Rows of y: displacement of the body relative to the towpoint, m."""
END_TENSION = slice(6, 8)
"""Rows of y: tension at the body and at the towpoint, N."""


class Rows(NamedTuple):
    """The first rows of y by name. ``body_surge`` and ``body_heave``: `BODY_VELOCITY`."""

    force_surge: Value
    force_heave: Value
    body_surge: Value
    body_heave: Value
    offset_surge: Value
    offset_heave: Value
    tension_body: Value
    tension_top: Value


PROFILE = len(Rows._fields)
"""First of the rows of y with the segments' tensions, N, and then their angles, rad."""


@dataclass(frozen=True)
class StateSpace:
    """A state space of the cable; matrices of shapes (n, n), (n, m), (r, n), (r, m), (r, m)."""

    chain: Chain
    a: Matrix
    b: Matrix
    c: Matrix
    d: Matrix
    e: Matrix

    def response(self, omega: float, inputs: ComplexArray, rows: slice = slice(None)) -> ComplexArray:
        """Amplitudes of y, or of ``rows`` of it, for u = Re(inputs exp(-i omega t)); inputs of shape (m,) or, several, (m, k)."""
        s = -1j * omega
        x = np.linalg.solve(s * np.eye(len(self.a)) - self.a, self.b @ inputs)
        y: ComplexArray = self.c[rows] @ x + (self.d[rows] + s * self.e[rows]) @ inputs
        return y

    @property
    def apparent_mass(self) -> Matrix:
        """m_app, kg, (2, 2): the towpoint feels -m_app a at once."""
        return -self.e[FORCE, :2]


def tow_rigid(tow: Tow, count: int, grading: float = 1.0) -> StateSpace:
    """Cable of constant length with body: 2 N states, inputs (v_x, v_y of the towpoint, f_x, f_y on the body)."""
    return rigid_model(matrices(equilibrium(tow, count, grading), elastic=False))


def tow_elastic(tow: Tow, count: int, grading: float = 1.0) -> StateSpace:
    """Elastic cable with body: 4 N states, inputs as `tow_rigid`."""
    return elastic_model(_elastic(tow, count, grading))


def cable_elastic(tow: Tow, count: int, grading: float = 1.0) -> StateSpace:
    """Elastic cable alone, 4 (N-1) states; inputs (v_x, v_y of the towpoint, v_x, v_y of the body, offset x, y of the
    body from the towpoint, m, the integral of the difference). `BODY_VELOCITY` rows hold the force on the body.

    Raises `CableError` without a finite axial stiffness: a cable of constant length between two prescribed ends is
    over-determined as it straightens.
    """
    if count < 2:
        raise CableError(f"{count} segments: a cable between two prescribed ends needs at least 2")
    return cable_model(_elastic(tow, count, grading))


def _elastic(tow: Tow, count: int, grading: float) -> Matrices:
    if not math.isfinite(tow.cable.axial_stiffness):
        raise CableError("an elastic model needs a finite axial stiffness EA")
    return matrices(equilibrium(tow, count, grading), elastic=True)


class _Rows(NamedTuple):
    """What states, inputs and u' contribute to some components of y."""

    x: Matrix
    u: Matrix
    du: Matrix

    def times(self, matrix: Matrix) -> _Rows:
        """``matrix`` times these."""
        return _Rows(matrix @ self.x, matrix @ self.u, matrix @ self.du)


def _model(chain: Chain, a: Matrix, b: Matrix, parts: list[_Rows], ops: MatrixOps) -> StateSpace:
    c, d, e = (ops.vstack(list(part)) for part in zip(*parts))
    return StateSpace(chain, a, b, c, d, e)


def _end_directions(chain: Chain, ops: MatrixOps) -> tuple[Matrix, Matrix]:
    """Rows (1, 2): unit vectors of the steady pull on the body and of the cable's pull on the towpoint."""
    body, tension = chain.tow.body, chain.tow.end_tension
    x, y = steady_towpoint_force(chain)
    size = ops.scalars.sqrt(x * x + y * y)
    pull = ops.matrix([[body.drag / tension, (body.weight - body.lift) / tension]])
    return pull, ops.matrix([[x / size, y / size]])


def _with_body(m: Matrices, ops: MatrixOps) -> tuple[Matrix, Matrix, Matrix]:
    """(M, C) with the body, and its columns (2N+2, 2) among the nodes."""
    first = ops.constant(np.eye(2 * m.chain.count + 2, 2))
    return m.mass + first @ m.body_mass @ first.T, m.damping + first @ m.body_damping @ first.T, first


def _second_order(mass: Matrix, sides: list[Matrix], velocity_u: Matrix, ops: MatrixOps) -> tuple[Matrix, Matrix]:
    """(A, B) of q' = v + velocity_u u, mass v' = -(the sides, of q, v and u in turn)."""
    f = mass.shape[0]
    rates = -ops.solve(mass, ops.hstack(sides))
    a = ops.vstack([ops.hstack([ops.zeros(f, f), ops.eye(f)]), rates[:, : 2 * f]])
    return a, ops.vstack([velocity_u, rates[:, 2 * f :]])


def _body_side(count: int, ops: MatrixOps) -> Matrix:
    """(2N+2, 2N): the nodes on the body's side of each segment."""
    return ops.constant(np.kron(np.triu(np.ones((count + 1, count))), np.eye(2)))


def rigid_model(m: Matrices, ops: MatrixOps | None = None) -> StateSpace:
    """`tow_rigid` from given matrices."""
    ops = ops or numbers()
    chain, n = m.chain, m.chain.count
    size = 2 * n + 2
    mass, damping, first = _with_body(m, ops)
    everywhere = ops.constant(np.tile(np.eye(2), (n + 1, 1)))
    x, y = chain.steps
    side = _body_side(n, ops)
    # turning segment k by eta moves the nodes on the body's side of it
    z = side @ rows(y, -x, ops).T
    inner = ops.solve(z.T @ mass @ z, ops.eye(n))
    coupling = inner @ (z.T @ (mass @ everywhere))
    none, two, force = ops.zeros(n, n), ops.zeros(n, 2), ops.zeros(size, 2)
    # eta' = inner p - coupling v
    rate_x, rate_u = ops.hstack([none, inner]), ops.hstack([-coupling, two])
    eta_x = ops.hstack([ops.eye(n), none])
    velocity = _Rows(z @ rate_x, z @ rate_u + ops.hstack([everywhere, force]), ops.zeros(size, 4))
    on_body = ops.hstack([force, first])
    pd_x = -z.T @ (damping @ velocity.x + m.stiffness @ z @ eta_x)
    pd_u = -z.T @ (damping @ velocity.u - on_body)
    turning = z @ inner
    acceleration = _Rows(turning @ pd_x, turning @ pd_u, ops.hstack([everywhere - z @ coupling, force]))
    # M q'' + C q' + K q - f_body, node by node: what the constraint forces and the towpoint supply
    need = _Rows(
        mass @ acceleration.x + damping @ velocity.x + m.stiffness @ z @ eta_x,
        mass @ acceleration.u + damping @ velocity.u - on_body,
        mass @ acceleration.du,
    )
    body_velocity, body_acceleration = velocity.times(first.T), acceleration.times(first.T)
    pull = _pull(m, body_velocity, body_acceleration, ops)
    body_along, top_along = _end_directions(chain, ops)
    top = need.times(-everywhere.T)
    length = (x * x + y * y) ** 0.5
    tensions = need.times(rows(x / length, y / length, ops) @ side.T)
    parts = [
        top, body_velocity, _Rows(z[:2, :] @ eta_x, ops.zeros(2, 4), ops.zeros(2, 4)), pull.times(body_along),
        top.times(top_along), tensions, _Rows(eta_x, ops.zeros(n, 4), ops.zeros(n, 4)),
    ]  # fmt: skip
    return _model(chain, ops.vstack([rate_x, pd_x]), ops.vstack([rate_u, pd_u]), parts, ops)


def _pull(m: Matrices, velocity: _Rows, acceleration: _Rows, ops: MatrixOps) -> _Rows:
    """Force of the cable on the body, from the body's motion."""
    return _Rows(
        m.body_mass @ acceleration.x + m.body_damping @ velocity.x,
        m.body_mass @ acceleration.u + m.body_damping @ velocity.u - ops.hstack([ops.zeros(2, 2), ops.eye(2)]),
        m.body_mass @ acceleration.du,
    )


def elastic_model(m: Matrices, ops: MatrixOps | None = None) -> StateSpace:
    """`tow_elastic` from given matrices."""
    ops = ops or numbers()
    chain, n = m.chain, m.chain.count
    f = 2 * n
    mass, damping, first = _with_body(m, ops)
    sides = [m.stiffness[:f, :f], damping[:f, :f], damping[:f, f:], -first[:f, :]]
    everywhere = ops.constant(np.tile(np.eye(2), (n, 1)))
    a, b = _second_order(mass[:f, :f], sides, ops.hstack([-everywhere, ops.zeros(f, 2)]), ops)
    still = ops.zeros(2, 4)
    offset = _Rows(ops.constant(np.eye(2, 2 * f)), still, still)
    velocity = _Rows(ops.constant(np.eye(2, 2 * f, f)), still, still)
    pull = _pull(m, velocity, _Rows(a[f : f + 2, :], b[f : f + 2, :], still), ops)
    top = _Rows(
        -ops.hstack([m.stiffness[f:, :f], damping[f:, :f]]),
        -ops.hstack([damping[f:, f:], ops.zeros(2, 2)]),
        -ops.hstack([mass[f:, f:], ops.zeros(2, 2)]),
    )
    body_along, top_along = _end_directions(chain, ops)
    profile = _profile(chain, ops)[:, :f]
    fixed = ops.zeros(2 * n, 4)
    parts = [
        top, velocity, offset, pull.times(body_along), top.times(top_along),
        _Rows(ops.hstack([profile, ops.zeros(2 * n, f)]), fixed, fixed),
    ]  # fmt: skip
    return _model(chain, a, b, parts, ops)


def _profile(chain: Chain, ops: MatrixOps) -> Matrix:
    """Rows (2N, 2N+2): tensions, N, and rotations, rad, of the segments of an elastic chain from node displacements."""
    x, y = chain.steps
    square = x * x + y * y
    stiffness = chain.tow.cable.axial_stiffness / chain.segment / square**0.5
    lower, upper = ends(chain.count, ops)
    return ops.vstack([rows(stiffness * x, stiffness * y, ops), rows(-y / square, x / square, ops)]) @ (upper - lower).T


def cable_model(m: Matrices, ops: MatrixOps | None = None) -> StateSpace:
    """`cable_elastic` from given matrices."""
    ops = ops or numbers()
    chain, n = m.chain, m.chain.count
    mass, damping, stiffness = m.mass, m.damping, m.stiffness
    f, last = 2 * (n - 1), 2 * n
    inner = slice(2, last)
    sides = [each[inner, inner] for each in (stiffness, damping)]
    sides += [damping[inner, last:], damping[inner, :2], stiffness[inner, :2]]
    everywhere = ops.constant(np.tile(np.eye(2), (n - 1, 1)))
    a, b = _second_order(mass[inner, inner], sides, ops.hstack([-everywhere, ops.zeros(f, 4)]), ops)

    def force(node: slice, accelerates: list[Matrix]) -> _Rows:
        return _Rows(
            -ops.hstack([stiffness[node, inner], damping[node, inner]]),
            -ops.hstack([damping[node, last:], damping[node, :2], stiffness[node, :2]]),
            -ops.hstack([*accelerates, ops.zeros(2, 2)]),
        )

    none = ops.zeros(2, 2)
    top = force(slice(last, last + 2), [mass[last:, last:], none])
    body = force(slice(0, 2), [none, mass[:2, :2]])
    offset = _Rows(ops.zeros(2, 2 * f), ops.constant(np.eye(2, 6, 4)), ops.zeros(2, 6))
    body_along, top_along = _end_directions(chain, ops)
    profile = _profile(chain, ops)
    parts = [
        top, body, offset, body.times(body_along), top.times(top_along),
        _Rows(ops.hstack([profile[:, inner], ops.zeros(2 * n, f)]), ops.hstack([ops.zeros(2 * n, 4), profile[:, :2]]),
              ops.zeros(2 * n, 6)),
    ]  # fmt: skip
    return _model(chain, a, b, parts, ops)
