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

Source: discretisation of ``cable_lumped.py``; partitions and signs are our own, checked against the frequency domain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cable_case import CableError, Tow
from .cable_lumped import Chain, Matrices, equilibrium, matrices, node_load
from .cable_perturbation import ComplexArray
from .cable_steady import Array

FORCE = slice(0, 2)
"""Rows of y: force of the cable on the towpoint, N, forward and up."""
BODY_VELOCITY = slice(2, 4)
"""Rows of y: velocity of the body in the towing frame, m/s; in `cable_elastic` the cable's force on it, N."""
BODY_OFFSET = slice(4, 6)
"""Rows of y: displacement of the body relative to the towpoint, m."""
END_TENSION = slice(6, 8)
"""Rows of y: tension at the body and at the towpoint, N."""
PROFILE = 8
"""First of the rows of y with the segments' tensions, N, and then their angles, rad."""


@dataclass(frozen=True)
class LinearModel:
    """A state space of the cable; matrices of shapes (n, n), (n, m), (r, n), (r, m), (r, m)."""

    chain: Chain
    a: Array
    b: Array
    c: Array
    d: Array
    e: Array

    def response(self, omega: float, inputs: ComplexArray) -> ComplexArray:
        """Amplitudes of y for u = Re(inputs exp(-i omega t)), shape (r,) as inputs has shape (m,)."""
        s = -1j * omega
        x = np.linalg.solve(s * np.eye(len(self.a)) - self.a, self.b @ inputs)
        y: ComplexArray = self.c @ x + (self.d + s * self.e) @ inputs
        return y

    @property
    def apparent_mass(self) -> Array:
        """m_app, kg, (2, 2): the towpoint feels -m_app a at once."""
        mass: Array = -self.e[FORCE, :2]
        return mass


def _angles(chain: Chain) -> Array:
    """Rows (N, 2N+2) that take node displacements to the rotations of the segments, rad (counter-clockwise)."""
    n = chain.count
    lengths = np.linalg.norm(np.diff(chain.nodes, axis=0), axis=1)
    across = np.stack([-chain.directions[:, 1], chain.directions[:, 0]], axis=1) / lengths[:, None]
    rows = np.zeros((n, 2 * n + 2))
    for k in range(n):
        rows[k, 2 * k : 2 * k + 2] = -across[k]
        rows[k, 2 * k + 2 : 2 * k + 4] = across[k]
    return rows


def _end_directions(chain: Chain, m: Matrices) -> tuple[Array, Array]:
    """Unit vectors of the steady pull on the body and of the cable's pull on the towpoint."""
    tow = chain.tow
    body = np.array([tow.body.drag, tow.body.weight - tow.body.lift]) / tow.end_tension
    top = -steady_towpoint_force(chain)
    return body, -top / np.linalg.norm(top)


def steady_towpoint_force(chain: Chain) -> Array:
    """Steady force of the cable on the towpoint, N, forward and up."""
    tow = chain.tow
    along = chain.directions[-1]
    drag = np.array(
        node_load(tow, chain.segment, (tow.sign * along[0], tow.sign * along[1]), (tow.speed, 0.0)), dtype=float
    )
    force: Array = -chain.tension[-1] * along + drag - np.array([0.0, 0.5 * tow.cable.weight * chain.segment])
    return force


def tow_rigid(tow: Tow, count: int) -> LinearModel:
    """Cable of constant length with body: 2 N states, inputs (v_x, v_y of the towpoint, f_x, f_y on the body)."""
    chain = equilibrium(tow, count)
    return rigid_model(matrices(chain, elastic=False))


def rigid_model(m: Matrices) -> LinearModel:
    """`tow_rigid` from given matrices."""
    chain, n = m.chain, m.chain.count
    mass, damping, stiffness = m.mass.copy(), m.damping.copy(), m.stiffness
    mass[:2, :2] += m.body_mass
    damping[:2, :2] += m.body_damping
    steps = np.diff(chain.nodes, axis=0)
    z = np.zeros((2 * n + 2, n))
    for k in range(n):
        # turning segment k by eta moves the nodes on the body's side of it
        z[0 : 2 * k + 2 : 2, k], z[1 : 2 * k + 2 : 2, k] = steps[k, 1], -steps[k, 0]
    b_all = np.tile(np.eye(2), (n + 1, 1))
    f_body = np.zeros((2 * n + 2, 2))
    f_body[:2] = np.eye(2)
    inner = np.linalg.inv(z.T @ mass @ z)
    coupling = inner @ z.T @ mass @ b_all
    zero_n, zero_2 = np.zeros((n, n)), np.zeros((n, 2))
    # eta' = inner p - coupling v
    rate_x, rate_u = np.hstack([zero_n, inner]), np.hstack([-coupling, zero_2])
    qd_x, qd_u = z @ rate_x, z @ rate_u + np.hstack([b_all, np.zeros((2 * n + 2, 2))])
    pd_x = -z.T @ damping @ qd_x - np.hstack([z.T @ stiffness @ z, zero_n])
    pd_u = -z.T @ damping @ qd_u + np.hstack([zero_2, z.T @ f_body])
    qdd_x, qdd_u = z @ inner @ pd_x, z @ inner @ pd_u
    qdd_a = np.hstack([b_all - z @ coupling, np.zeros((2 * n + 2, 2))])
    # M q'' + C q' + K q - f_body, node by node: what the constraint forces and the towpoint supply
    need_x = mass @ qdd_x + damping @ qd_x + np.hstack([stiffness @ z, np.zeros((2 * n + 2, n))])
    need_u = mass @ qdd_u + damping @ qd_u - np.hstack([np.zeros((2 * n + 2, 2)), f_body])
    need_a = mass @ qdd_a
    cumulative = np.zeros((n, 2 * n + 2))
    for k in range(n):
        cumulative[k, 0 : 2 * k + 2 : 2], cumulative[k, 1 : 2 * k + 2 : 2] = chain.directions[k]
    body_along, top_along = _end_directions(chain, m)
    own_mass, own_damping = np.zeros_like(mass[:2]), np.zeros_like(mass[:2])
    own_mass[:, :2], own_damping[:, :2] = m.body_mass, m.body_damping
    pull_x = own_mass @ qdd_x + own_damping @ qd_x
    pull_u = own_mass @ qdd_u + own_damping @ qd_u - np.hstack([np.zeros((2, 2)), np.eye(2)])
    pull_a = own_mass @ qdd_a
    eta_x = np.hstack([np.eye(n), zero_n])
    zero_nu = np.zeros((n, 4))
    c = np.vstack([
        -b_all.T @ need_x, qd_x[:2], np.hstack([z[:2], np.zeros((2, n))]), body_along @ pull_x,
        -top_along @ b_all.T @ need_x, cumulative @ need_x, eta_x,
    ])  # fmt: skip
    d = np.vstack([
        -b_all.T @ need_u, qd_u[:2], np.zeros((2, 4)), body_along @ pull_u, -top_along @ b_all.T @ need_u,
        cumulative @ need_u, zero_nu,
    ])  # fmt: skip
    e = np.vstack([
        -b_all.T @ need_a, np.zeros((4, 4)), body_along @ pull_a, -top_along @ b_all.T @ need_a, cumulative @ need_a,
        zero_nu,
    ])  # fmt: skip
    return LinearModel(chain, np.vstack([rate_x, pd_x]), np.vstack([rate_u, pd_u]), c, d, e)


def tow_elastic(tow: Tow, count: int) -> LinearModel:
    """Elastic cable with body: 4 N states, inputs as `tow_rigid`."""
    m = matrices(equilibrium(tow, count), elastic=True)
    chain, n = m.chain, m.chain.count
    mass, damping = m.mass.copy(), m.damping.copy()
    mass[:2, :2] += m.body_mass
    damping[:2, :2] += m.body_damping
    f, free = 2 * n, slice(0, 2 * n)
    b_free = np.tile(np.eye(2), (n, 1))
    force = np.zeros((f, 2))
    force[:2] = np.eye(2)
    inverse = np.linalg.inv(mass[free, free])
    zero = np.zeros((f, f))
    a = np.block([[zero, np.eye(f)], [-inverse @ m.stiffness[free, free], -inverse @ damping[free, free]]])
    b = np.block([[-b_free, np.zeros((f, 2))], [-inverse @ damping[free, f:], inverse @ force]])
    body_x = np.hstack([np.zeros((2, f)), np.eye(2, f)])
    acceleration_x, acceleration_u = a[f : f + 2], b[f : f + 2]
    pull_x = m.body_mass @ acceleration_x + m.body_damping @ body_x
    pull_u = m.body_mass @ acceleration_u - np.hstack([np.zeros((2, 2)), np.eye(2)])
    top_x = np.hstack([m.stiffness[f:, free], damping[f:, free]])
    top_u = np.hstack([damping[f:, f:], np.zeros((2, 2))])
    top_a = np.hstack([mass[f:, f:], np.zeros((2, 2))])
    rows = _profile(chain)[:, free]
    return _assemble(m, a, b, (-top_x, -top_u, -top_a), (body_x, np.zeros((2, 4))), np.eye(2, 2 * f),
                     (pull_x, pull_u), np.hstack([rows, np.zeros_like(rows)]), None)  # fmt: skip


def _profile(chain: Chain) -> Array:
    """Rows (2N, 2N+2): tensions, N, and rotations, rad, of the segments of an elastic chain from node displacements."""
    n = chain.count
    stiffness = chain.tow.cable.axial_stiffness / chain.segment
    rows = np.zeros((n, 2 * n + 2))
    for k in range(n):
        rows[k, 2 * k : 2 * k + 2] = -stiffness * chain.directions[k]
        rows[k, 2 * k + 2 : 2 * k + 4] = stiffness * chain.directions[k]
    return np.vstack([rows, _angles(chain)])


def _assemble(
    m: Matrices,
    a: Array,
    b: Array,
    top: tuple[Array, Array, Array],
    second: tuple[Array, Array],
    offset: Array,
    pull: tuple[Array, Array],
    profile: Array,
    profile_u: Array | None,
) -> LinearModel:
    body_along, top_along = _end_directions(m.chain, m)
    inputs = b.shape[1]
    rows = len(profile)
    c = np.vstack([top[0], second[0], offset, body_along @ pull[0], top_along @ top[0], profile])
    d = np.vstack([
        top[1], second[1], np.zeros((2, inputs)), body_along @ pull[1], top_along @ top[1],
        np.zeros((rows, inputs)) if profile_u is None else profile_u,
    ])  # fmt: skip
    e = np.vstack([top[2], np.zeros((5, inputs)), top_along @ top[2], np.zeros((rows, inputs))])
    return LinearModel(m.chain, a, b, c, d, e)


def cable_elastic(tow: Tow, count: int) -> LinearModel:
    """Elastic cable alone, 4 (N-1) states; inputs (v_x, v_y of the towpoint, v_x, v_y of the body, offset x, y of the
    body from the towpoint, m, the integral of the difference). `BODY_VELOCITY` rows hold the force on the body.

    Raises `CableError` without a finite axial stiffness: a cable of constant length between two prescribed ends is
    over-determined as it straightens.
    """
    if count < 2:
        raise CableError(f"{count} segments: a cable between two prescribed ends needs at least 2")
    m = matrices(equilibrium(tow, count), elastic=True)
    chain, n = m.chain, m.chain.count
    mass, damping, stiffness = m.mass, m.damping, m.stiffness
    inner, f, last = slice(2, 2 * n), 2 * (n - 1), slice(2 * n, 2 * n + 2)
    b_inner = np.tile(np.eye(2), (n - 1, 1))
    inverse = np.linalg.inv(mass[inner, inner])
    a = np.block(
        [[np.zeros((f, f)), np.eye(f)], [-inverse @ stiffness[inner, inner], -inverse @ damping[inner, inner]]]
    )
    b = np.block([
        [-b_inner, np.zeros((f, 4))],
        [-inverse @ damping[inner, last], -inverse @ damping[inner, :2], -inverse @ stiffness[inner, :2]],
    ])  # fmt: skip
    ends = []
    for node in (last, slice(0, 2)):
        x = np.hstack([stiffness[node, inner], damping[node, inner]])
        u = np.hstack([damping[node, last], damping[node, :2], stiffness[node, :2]])
        acceleration = np.zeros((2, 6))
        acceleration[:, slice(0, 2) if node == last else slice(2, 4)] = mass[node, node]
        ends.append((-x, -u, -acceleration))
    rows = _profile(chain)
    profile_u = np.hstack([np.zeros((2 * n, 4)), rows[:, :2]])
    model = _assemble(m, a, b, ends[0], ends[1][:2], np.zeros((2, 2 * f)), ends[1][:2],
                      np.hstack([rows[:, inner], np.zeros((2 * n, f))]), profile_u)  # fmt: skip
    body_along = _end_directions(chain, m)[0]
    model.e[BODY_VELOCITY] = ends[1][2]
    model.e[6] = body_along @ ends[1][2]
    model.d[BODY_OFFSET, 4:] = np.eye(2)
    return model
