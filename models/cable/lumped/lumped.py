"""A tow cable as lumped masses on straight segments: discrete equilibrium and its linearisation.

    M(r) r'' = f(r, r'),    M q'' + C q' + K q = excitation about the discrete equilibrium

Nodes 0 (body) to N (towpoint); segment k joins nodes k and k+1, has the unstretched length l, direction e_k and tangent
t_k = sigma e_k; l is L/N, or grows from the body on (`shares`). Forces, inertia and what they depend on are those of
``forces.py``. The chain is found node by node from the body, in a frame mirrored in Quadrant II (y times sigma), where both
quadrants have one set of equations. Linearising at the nodes of the *continuous* shape instead leaves residual forces, and
with them a spurious unstable mode.

q (m) are displacements in the towing frame; symbols and assumptions of ``cable/case.py``. Numbers and CasADi symbols
alike: vectors of N and matrices in the spelling of ``numeric/matrix_ops.py``.

Source: small-perturbation report on towed cables, Equations [1]-[14], discretised here; the error is of second order in
1/N (tested).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...numeric.arrays import Array
from ...numeric.matrix_ops import Matrix, MatrixOps, numbers
from ...numeric.ops import Ops
from ..case import CableError, Tow
from ..loading import Loading

ITERATIONS = 16
"""Of Newton's method for the angle of a segment: 12 leave rounding in 400 tows of any proportion."""
BALANCE = 1e-9
"""Largest force across a segment over the forces on it in equilibrium; rounding leaves 1e-15."""
FEWEST, MOST = 10, 120
"""Segments to begin with, and at most, where nobody says how many."""
OUTSIDE = "leaves the quadrant or is slack: expected more segments, or a tow whose steady shape stays inside"


@dataclass(frozen=True)
class Chain:
    """Discrete equilibrium: positions of the nodes relative to the body, m, shape (N+1, 2), tensions of the segments,
    N, a vector of N, unstretched lengths of the segments, m, likewise; least tension, N, and largest force across a segment over
    the forces on it, vectors of N, of the segments so far: an equilibrium if the last are positive and below `BALANCE`."""

    tow: Tow
    nodes: Any
    tension: Any
    segment: Any
    least: Any = None
    imbalance: Any = None

    @property
    def count(self) -> int:
        """Number of segments N."""
        return int(self.tension.shape[0])

    @property
    def steps(self) -> tuple[Any, Any]:
        """(x, y) from node k to node k+1, m, vectors of N."""
        return self.nodes[1:, 0] - self.nodes[:-1, 0], self.nodes[1:, 1] - self.nodes[:-1, 1]


class Flow(NamedTuple):
    """Segments in the mirrored frame (y times sigma, so that Quadrant II looks like I) and the load on them there, over
    D: cosine and sine of their angle with the stream, stretched length, m, F_L, F_L', F_G, F_G'. Vectors of N."""

    cosine: Any
    sine: Any
    length: Any
    normal: Any
    normal_slope: Any
    tangential: Any
    tangential_slope: Any


def flow(chain: Chain) -> Flow:
    """`Flow` on a chain in steady tow."""
    x, y = chain.steps
    length = (x * x + y * y) ** 0.5
    cosine, sine = x / length, chain.tow.sign * y / length
    return Flow(cosine, sine, length, *chain.tow.cable.loading.gradients(sine, cosine))


def half_drag(chain: Chain) -> Any:
    """D l/2, N: what the loads of `Flow` are multiplied by on one node."""
    return 0.5 * chain.segment * chain.tow.drag_factor * chain.tow.speed**2


def shares(count: int, grading: float) -> Array:
    """Lengths of segments over that of the cable, from the body on: a geometric series, the last over the first ``grading``."""
    places = np.arange(count + 1) / count
    lengths: Array = np.diff(places if grading == 1.0 else np.expm1(places * math.log(grading)) / (grading - 1.0))
    return lengths


def equilibrium(tow: Tow, count: int, grading: float = 1.0) -> Chain:
    """Discrete equilibrium with ``count`` >= 1 segments, graded as `shares`. Raises `CableError` where the chain leaves its
    quadrant or is slack."""
    if count < 1:
        raise CableError(f"{count} segments: expected at least 1")
    chain = hang(tow, count, numbers(), grading)
    bad = np.flatnonzero(~((chain.least > 0.0) & (chain.imbalance < BALANCE)))
    if len(bad):
        raise CableError(f"segment {bad[0]} of {count} {OUTSIDE}")
    return chain


def hanging(tow: Tow, fewest: int = FEWEST) -> Chain:
    """The discrete equilibrium with the fewest segments, ``fewest`` times a power of 2, that hang inside the quadrant: a few do
    not where a light body hangs on a long cable. Raises `CableError` where none up to `MOST` does."""
    for doublings in range(int(math.log2(MOST / fewest))):
        try:
            return equilibrium(tow, fewest << doublings)
        except CableError:
            continue
    return equilibrium(tow, MOST)


def hang(tow: Tow, count: int, ops: MatrixOps, grading: float = 1.0) -> Chain:
    """The chain, whether or not it is in equilibrium."""
    cable, body, share = tow.cable, tow.body, shares(count, grading)
    segment = cable.length * ops.constant(share)
    # half of the segment and half of the next, where there is one
    weight = tow.sign * cable.weight * cable.length * ops.constant(0.5 * (share + np.append(share[1:], 0.0)))
    net = tow.sign * (body.weight - body.lift)
    half = 0.5 * segment * tow.drag_factor * tow.speed * tow.speed
    below = 0.5 * tow.sign * cable.weight * cable.length * float(share[0])
    start = (ops.scalars.atan2(net, body.drag), 1e300, body.drag, net + below, 0.0, 0.0, 1e300, 0.0)
    constants = (1.0 / cable.axial_stiffness, *cable.loading.normal, *cable.loading.tangential)
    _, tension, _, _, x, y, least, worst = ops.march(next_segment, start, constants, (segment, weight, half))
    nodes = ops.hstack([ops.column(x), ops.column(tow.sign * y)])
    return Chain(tow, ops.vstack([ops.zeros(1, 2), nodes]), tension, segment, least, worst)


def next_segment(state: tuple[Any, ...], constants: tuple[Any, ...], ops: Ops) -> tuple[Any, ...]:
    """(angle psi with the stream, T, the pull that its lower node needs (2), its upper node (2), least T, worst residual)
    of the next segment, in the mirrored frame.

        g(psi) = P_x sin psi - P_y cos psi + (l/2) F_L(psi) = 0,   T = P_x cos psi + P_y sin psi + (l/2) F_G(psi)

    for the pull P less the segment's own half drag. Newton's method, kept inside a bracket by bisection: g rises from
    psi = 0 to pi/2 wherever there is an equilibrium in the quadrant.
    """
    psi, _, pull_x, pull_y, x, y, least, worst = state
    segment, weight, half, compliance = constants[:4]
    loading = Loading(constants[4:9], constants[9:14])

    def at(angle: Any) -> tuple[Any, ...]:
        sine, cosine = ops.sin(angle), ops.cos(angle)
        normal, slope, tangential, _ = loading.gradients(sine, cosine)
        across = pull_x * sine - pull_y * cosine + half * normal
        turning = pull_x * cosine + pull_y * sine
        return across, turning + half * slope, turning + half * tangential, sine, cosine, normal, tangential

    low, high = 0.0, 0.5 * math.pi
    for _ in range(ITERATIONS):
        across, slope, *_rest = at(psi)
        above = across > 0.0
        low, high = ops.where(above, low, psi), ops.where(above, psi, high)
        trial = psi - across / ops.where(slope == 0.0, 1.0, slope)
        psi = ops.where((trial >= low) * (trial <= high), trial, 0.5 * (low + high))
    across, _, tension, sine, cosine, normal, tangential = at(psi)
    stretched = segment * (1.0 + tension * compliance)
    return (
        psi, tension,
        # what the next segment must pull: this one's pull less both their loads, of which its own is still unknown
        tension * cosine + half * (normal * sine + tangential * cosine),
        tension * sine + half * (tangential * sine - normal * cosine) + weight,
        x + stretched * cosine, y + stretched * sine, ops.minimum(least, tension),
        ops.maximum(worst, ops.abs(across) / (ops.abs(pull_x) + ops.abs(pull_y) + half)),
    )  # fmt: skip


def steady_towpoint_force(chain: Chain) -> tuple[Any, Any]:
    """Steady force of the cable on the towpoint, N, forward and up."""
    f, half, last = flow(chain), half_drag(chain), chain.count - 1
    along = chain.tension + half * f.tangential
    x = -along * f.cosine - half * f.normal * f.sine
    y = -along * f.sine + half * f.normal * f.cosine
    return x[last], chain.tow.sign * y[last] - 0.5 * chain.tow.cable.weight * chain.segment[last]


@dataclass(frozen=True)
class Matrices:
    """M, kg, C, N s/m, K, N/m, of the cable alone, over the displacements (x_0, y_0, x_1, ...) of all nodes, shape
    (2N+2, 2N+2); K without the axial stiffness where ``elastic`` is False. ``body_mass`` and ``body_damping`` (2, 2)
    are not in them."""

    chain: Chain
    mass: Matrix
    damping: Matrix
    stiffness: Matrix
    body_mass: Matrix
    body_damping: Matrix
    elastic: bool


def rows(x: Any, y: Any, ops: MatrixOps) -> Matrix:
    """The vectors (x_k, y_k) of segments as a matrix (N, 2N), segment k's in its own two columns of row k. Products of
    two, ``rows(a).T @ rows(b)``, hold a b' of every segment on their diagonal."""
    one = np.eye(x.shape[0])
    across = ops.diagonal(x) @ ops.constant(np.kron(one, [[1.0, 0.0]]))
    return across + ops.diagonal(y) @ ops.constant(np.kron(one, [[0.0, 1.0]]))


def ends(count: int, ops: MatrixOps) -> tuple[Matrix, Matrix]:
    """(lower, upper), shape (2N+2, 2N): where the nodes of the segments are among all nodes."""
    nodes = np.eye(count + 1)
    return ops.constant(np.kron(nodes[:, :-1], np.eye(2))), ops.constant(np.kron(nodes[:, 1:], np.eye(2)))


def matrices(chain: Chain, elastic: bool, ops: MatrixOps | None = None) -> Matrices:
    """Linearisation at a steady chain, in closed form. With n, t the normal and tangent of a segment, p = -n the way its
    end moves as it turns, d the displacement of its upper relative to its lower node:

        half drag, turned             -(D l/2) ((F_L' - F_G) n + (F_L + F_G') t) (p . d)/|d|
        half drag, at the velocity v  -(D l/2) (2 (F_L n + F_G t) v_x - (F_L' n + F_G' t) v_y)/c
        tension                       T p (p . d)/|d| + (EA/l) t (t . d)
    """
    ops = ops or numbers()
    tow, body, f = chain.tow, chain.tow.body, flow(chain)
    cable, sign, segment, half = tow.cable, tow.sign, chain.segment, half_drag(chain)
    lower, upper = ends(chain.count, ops)
    both, apart = lower + upper, upper - lower

    def pairs(along_normal: Any, along_tangent: Any) -> Matrix:
        """Rows of vectors with these components, back from the mirrored frame."""
        x = along_normal * f.sine + along_tangent * f.cosine
        return rows(x, sign * (along_tangent * f.sine - along_normal * f.cosine), ops)

    zero = 0.0 * f.length
    normals, tangents, turn = pairs(zero + 1.0, zero), pairs(zero, zero + 1.0), pairs(-1.0 / f.length, zero)
    inertia = 0.5 * cable.mass * segment
    across = normals.T @ ops.diagonal(inertia * (1.0 + tow.added_mass_ratio)) @ normals
    share = across + tangents.T @ ops.diagonal(inertia) @ tangents
    turned = pairs(half * (f.normal_slope - f.tangential), half * (f.normal + f.tangential_slope)).T @ turn
    tension, stiff = chain.tension, zero
    if elastic:
        # a slack segment pulls nothing
        taut = f.length > segment
        tension, stiff = chain.tension * taut, cable.axial_stiffness / segment * taut
    pull = normals.T @ ops.diagonal(tension / f.length) @ normals + tangents.T @ ops.diagonal(stiff) @ tangents
    slower = half / tow.speed
    faster = pairs(2.0 * slower * f.normal, 2.0 * slower * f.tangential).T @ rows(zero + 1.0, zero, ops)
    drag = faster - pairs(slower * f.normal_slope, slower * f.tangential_slope).T @ rows(zero, zero + sign, ops)
    carried = inertia * tow.added_mass_ratio * tow.speed * cable.momentum_form
    convected = pairs(carried * f.cosine, carried * f.sine).T @ turn
    return Matrices(
        chain,
        lower @ share @ lower.T + upper @ share @ upper.T,
        lower @ drag @ lower.T + upper @ drag @ upper.T + both @ convected @ apart.T,
        both @ turned @ apart.T + apart @ pull @ apart.T,
        ops.matrix([[body.mass + body.added_mass_surge, 0.0], [0.0, body.mass + body.added_mass_heave]]),
        ops.matrix([[body.damping_surge, 0.0], [0.0, body.damping_heave]]),
        elastic,
    )
