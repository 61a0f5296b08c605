"""Forces on the nodes of a tow cable of lumped masses and straight segments, and their inertia, for any motion.

Each segment gives half of its mass, weight, drag and added mass to each of its nodes; drag and added mass use the node's
velocity and the segment's own direction, so that no zig-zag of the nodes goes undamped.

    half drag   -(l/2) (F_L n + F_G t) at U = v.n, V = v.t           half inertia   (mu l/2)(1 + lam n n')
    momentum form of the added mass, in addition                     -(lam mu l/2) phi' (V n + U t)
    tension     T_k = EA max(0, |r_{k+1} - r_k|/l - 1), or the multiplier that keeps the segment's length

v (m/s) are velocities through the water, forces in N; symbols and assumptions of ``cable/case.py``. All functions take
complex numbers: their derivatives by the complex step are exact to rounding.

Source: small-perturbation report on towed cables, Equations [1]-[14], discretised here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...numeric.arrays import Array
from ..case import Tow

COMPLEX_STEP = 1e-150


def node_load(tow: Tow, segment: Array, tangent: tuple[Any, Any], velocity: tuple[Any, Any]) -> tuple[Any, Any]:
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


def segment_forces(
    tow: Tow,
    segment: Array,
    lower: Array,
    upper: Array,
    lower_velocity: Array,
    upper_velocity: Array,
    tension: Array | None,
) -> tuple[Array, Array]:
    """Forces, N, of the segments on their lower (nearer the body) and upper nodes, shape (2, n) each: tension, drag,
    weight, convected added mass. Positions, m, and velocities through the water, m/s, of shape (2, n), real or complex;
    ``segment``: unstretched lengths, m, (n,);
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
    weight = np.stack([0.0 * segment, 0.5 * cable.weight * segment])
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


def node_mass(tow: Tow, segment: Array, directions: Array) -> Array:
    """Half of the inertia of segments with unit ``directions`` (N, 2): matrices (N, 2, 2), kg."""
    normal = np.stack([directions[:, 1], -directions[:, 0]], axis=1)
    half = 0.5 * tow.cable.mass * segment[:, None, None]
    matrices: Array = half * (np.eye(2) + tow.added_mass_ratio * normal[:, :, None] * normal[:, None, :])
    return matrices
