"""A tow cable as lumped masses on straight segments: loads, inertia, discrete equilibrium, linear matrices.

    M(r) r'' = f(r, r'),    M q'' + C q' + K q = excitation about the discrete equilibrium

Nodes 0 (body) to N (towpoint); segment k joins nodes k and k+1, has the unstretched length l = L/N, direction e_k and
tangent t_k = sigma e_k. Each segment gives half of its mass, weight, drag and added mass to each of its nodes; drag and
added mass use the node's velocity and the segment's own direction, so that no zig-zag of the nodes goes undamped.

    half drag   -(l/2) (F_L n + F_G t) at U = v.n, V = v.t           half inertia   (mu l/2)(1 + lam n n')
    momentum form of the added mass, in addition                     -(lam mu l/2) phi' (V n + U t)
    tension     T_k = EA max(0, |r_{k+1} - r_k|/l - 1), or the multiplier that keeps the segment's length

q (m) are displacements in the towing frame, v (m/s) velocities through the water, forces in N; symbols and assumptions
of ``cable_case.py``. The equilibrium is that of the discrete equations, found node by node from the body. Linearising
at the nodes of the *continuous* shape instead leaves residual forces, and with them a spurious unstable mode.

Source: small-perturbation report on towed cables, Equations [1]-[14], discretised here; the error is of second order in
1/N (tested).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .cable_case import CableError, Tow
from .cable_steady import Array, steady

COMPLEX_STEP = 1e-150


@dataclass(frozen=True)
class Chain:
    """Discrete equilibrium: positions of the nodes relative to the body, m, shape (N+1, 2), tensions of the segments,
    N, shape (N,), unstretched length of a segment, m."""

    tow: Tow
    nodes: Array
    tension: Array
    segment: float

    @property
    def count(self) -> int:
        """Number of segments N."""
        return len(self.tension)

    @property
    def directions(self) -> Array:
        """Unit vectors from node k to node k+1, shape (N, 2)."""
        d = np.diff(self.nodes, axis=0)
        unit: Array = d / np.linalg.norm(d, axis=1, keepdims=True)
        return unit


def node_load(tow: Tow, segment: float, tangent: tuple[Any, Any], velocity: tuple[Any, Any]) -> tuple[Any, Any]:
    """Drag, N, of half a segment with unit ``tangent`` on a node with ``velocity`` through the water, m/s; scalars or
    arrays, real or complex."""
    (tx, ty), (vx, vy) = tangent, velocity
    u, v = vx * ty - vy * tx, vx * tx + vy * ty
    # the load is odd in U and the tangential one odd in V: the mirror symmetry of the section
    sign_u, sign_v = 1.0 - 2.0 * (np.real(u) < 0.0), 1.0 - 2.0 * (np.real(v) < 0.0)
    loading, half = tow.cable.loading, 0.5 * segment * tow.drag_factor
    across = half * sign_u * loading.normal_load(sign_u * u, sign_v * v)
    along = half * sign_v * loading.tangential_load(sign_u * u, sign_v * v)
    return -(across * ty + along * tx), across * tx - along * ty


def equilibrium(tow: Tow, count: int) -> Chain:
    """Discrete equilibrium with ``count`` >= 1 segments. Raises `CableError` where Newton's method fails at a node, or
    where the chain leaves its quadrant."""
    if count < 1:
        raise CableError(f"{count} segments: expected at least 1")
    segment = tow.cable.length / count
    weight = tow.cable.weight * segment
    needed = np.array([tow.body.drag, tow.body.weight - tow.body.lift + 0.5 * weight])
    continuous = steady(tow)
    towards = 0.0 if tow.quadrant == 1 else math.pi
    position = np.zeros(2)
    nodes, tensions = [position], []
    for k in range(count):
        angle, tension = _direction(tow, segment, needed, continuous.at((k + 0.5) * segment)[0] + towards)
        along = np.array([math.cos(angle), math.sin(angle)])
        phi = angle - towards
        low = 0.0 if tow.quadrant == 1 else 0.5 * math.pi
        if not (tension > 0.0 and low - 1e-9 <= phi <= low + 0.5 * math.pi + 1e-9):
            raise CableError(
                f"segment {k} of {count} leaves the quadrant (angle {math.degrees(phi):.4g} deg) or is slack: expected "
                "more nodes, or a tow whose steady shape stays inside"
            )
        position = position + segment * (1.0 + tension / tow.cable.axial_stiffness) * along
        nodes.append(position)
        tensions.append(tension)
        drag = np.array(
            node_load(tow, segment, (tow.sign * along[0], tow.sign * along[1]), (tow.speed, 0.0)), dtype=float
        )
        # what the next segment must pull: this one's pull less both their loads, of which its own is still unknown
        needed = tension * along - drag + np.array([0.0, weight])
    return Chain(tow, np.array(nodes), np.array(tensions), segment)


def _direction(tow: Tow, segment: float, needed: Array, guess: float) -> tuple[float, float]:
    """(angle, rad, tension, N) of the segment that pulls ``needed`` less its own half drag."""
    angle = guess
    for _ in range(60):
        z = complex(angle, COMPLEX_STEP)
        along = np.cos(z), np.sin(z)
        drag = node_load(tow, segment, (tow.sign * along[0], tow.sign * along[1]), (tow.speed, 0.0))
        pull = complex(needed[0]) - drag[0], complex(needed[1]) - drag[1]
        residual = pull[0] * along[1] - pull[1] * along[0]
        slope = residual.imag / COMPLEX_STEP
        if slope == 0.0:
            break
        change = residual.real / slope
        angle -= max(-0.5, min(0.5, change))
        if abs(change) < 1e-15 * (1.0 + abs(angle)):
            break
        if abs(change) < 1e-13:
            size = abs(complex(pull[0])) + abs(complex(pull[1]))
            if abs(residual.real) < 4e-16 * size:
                break
    else:
        raise CableError("the discrete equilibrium was not found within 60 iterations at a node: expected more nodes")
    along_real = math.cos(angle), math.sin(angle)
    drag = node_load(tow, segment, (tow.sign * along_real[0], tow.sign * along_real[1]), (tow.speed, 0.0))
    return angle, float((needed[0] - drag[0]) * along_real[0] + (needed[1] - drag[1]) * along_real[1])


def segment_forces(
    tow: Tow,
    segment: float,
    lower: Array,
    upper: Array,
    lower_velocity: Array,
    upper_velocity: Array,
    tension: Array | None,
) -> tuple[Array, Array]:
    """Forces, N, of the segments on their lower (nearer the body) and upper nodes, shape (2, n) each: tension, drag,
    weight, convected added mass. Positions, m, and velocities through the water, m/s, of shape (2, n), real or complex;
    ``tension`` given: held at that; None: elastic."""
    cable = tow.cable
    d = upper - lower
    length = np.sqrt(d[0] * d[0] + d[1] * d[1])
    along = d / length
    tangent = tow.sign * along
    normal = np.stack([tangent[1], -tangent[0]])
    if tension is None:
        stretch = length / segment - 1.0
        # a slack segment pulls nothing
        tension = cable.axial_stiffness * stretch * (np.real(stretch) > 0.0)
    pull = tension * along
    weight = np.array([[0.0], [0.5 * cable.weight * segment]])
    relative = upper_velocity - lower_velocity
    turning = -tow.sign * (relative[0] * normal[0] + relative[1] * normal[1]) / length
    convected = 0.5 * segment * cable.mass * tow.added_mass_ratio * turning if cable.momentum_form else 0.0
    forces = []
    for sign, velocity in ((1.0, lower_velocity), (-1.0, upper_velocity)):
        load = np.stack(node_load(tow, segment, (tangent[0], tangent[1]), (velocity[0], velocity[1])))
        u = velocity[0] * normal[0] + velocity[1] * normal[1]
        v = velocity[0] * tangent[0] + velocity[1] * tangent[1]
        forces.append(sign * pull + load - weight - convected * (v * normal + u * tangent))
    return forces[0], forces[1]


def node_mass(tow: Tow, segment: float, directions: Array) -> Array:
    """Half of the inertia of segments with unit ``directions`` (N, 2): matrices (N, 2, 2), kg."""
    normal = np.stack([directions[:, 1], -directions[:, 0]], axis=1)
    half = 0.5 * tow.cable.mass * segment
    matrices: Array = half * (np.eye(2) + tow.added_mass_ratio * normal[:, :, None] * normal[:, None, :])
    return matrices


@dataclass(frozen=True)
class Matrices:
    """M, kg, C, N s/m, K, N/m, of the cable alone, over the displacements (x_0, y_0, x_1, ...) of all nodes, shape
    (2N+2, 2N+2); K without the axial stiffness where ``elastic`` is False. ``body_mass`` and ``body_damping`` (2, 2)
    are not in them."""

    chain: Chain
    mass: Array
    damping: Array
    stiffness: Array
    body_mass: Array
    body_damping: Array
    elastic: bool


def matrices(chain: Chain, elastic: bool) -> Matrices:
    """Linearisation at the equilibrium, exact to rounding (complex step)."""
    tow, n = chain.tow, chain.count
    if elastic and not math.isfinite(tow.cable.axial_stiffness):
        raise CableError("an elastic model needs a finite axial stiffness EA")
    size = 2 * (n + 1)
    mass, damping, stiffness = (np.zeros((size, size)) for _ in range(3))
    halves = node_mass(tow, chain.segment, chain.directions)
    position = chain.nodes.T.astype(complex)
    ends = [position[:, :-1], position[:, 1:]]
    velocity = np.zeros((2, n), dtype=complex)
    velocity[0] = tow.speed
    index = 2 * np.arange(n)
    for node in range(2):
        for i in range(2):
            for j in range(2):
                mass[index + 2 * node + i, index + 2 * node + j] += halves[:, i, j]
            for target, what in ((stiffness, 0), (damping, 1)):
                arguments = [ends[0].copy(), ends[1].copy(), velocity.copy(), velocity.copy()]
                arguments[2 * what + node][i] += 1j * COMPLEX_STEP
                found = segment_forces(
                    tow,
                    chain.segment,
                    arguments[0],
                    arguments[1],
                    arguments[2],
                    arguments[3],
                    None if elastic else chain.tension,
                )
                for other in range(2):
                    for j in range(2):
                        np.add.at(
                            target, (index + 2 * other + j, index + 2 * node + i), -found[other][j].imag / COMPLEX_STEP
                        )
    body = tow.body
    return Matrices(
        chain, mass, damping, stiffness,
        np.diag([body.mass + body.added_mass_surge, body.mass + body.added_mass_heave]),
        np.diag([body.damping_surge, body.damping_heave]), elastic,
    )  # fmt: skip
