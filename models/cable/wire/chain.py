"""A wire divided into elements: forces that its motion asks for, their derivatives, and what acts on its ends.

    R_i = sum_q w_q D_qi n_q + w_i (l/2) q_i + fixtures        needed at node i; zero where nothing holds the node

n and q are those of ``point.py`` at the nodes of the element, w and D those of ``elements.py``; l is the element's
unstretched length, dr/ds = (2/l) D r. At the top, -R is the pull of the wire on the ship: the reaction of the weak form,
which converges as fast as the shape does. EA times the strain of the last element does not.

Payout: wire is added at the top of the last section, whose elements grow alike. A node moves over the material with
sigma = x L' (x its share of the section), hence for velocity u = dr/dt and acceleration b of a node

    v = u - sigma r',   a = b - 2 sigma u' + 2 sigma sigma' r' + sigma^2 r'' - x L'' r'       of the material, ' = d/ds

Shapes: (n, d) at nodes, from the lower end; (E, p+1, d) at points of elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...numeric.arrays import AnyArray, Array
from ...numeric.ops import FLOATS, Ops, arrays
from ..case import CableError
from .elements import Rule, legendre, rule
from .mesh import Mesh
from .parts import Flow, Wire
from .point import Fixture, Material, Vector, bent, fixture_load, load, pull

HAULED = 1e-3
"""Share of the last section that cannot be hauled in."""


Paid = tuple[float, float, float]
"""Wire paid out, m, its rate, m/s, and m/s2."""
NOTHING_PAID: Paid = (0.0, 0.0, 0.0)


class Drive(NamedTuple):
    """What is done to the wire: motion of the top (and of a held lower end: ``lower`` = position, velocity, acceleration),
    wire paid out, and force on the body, N. Vectors (d,)."""

    position: Array
    velocity: Array
    acceleration: Array
    paid: Paid = NOTHING_PAID
    force: Array | None = None
    lower: tuple[Array, Array, Array] | None = None


def components(vectors: AnyArray) -> Vector:
    """Of vectors (..., d), arrays (...)."""
    return tuple(vectors[..., k] for k in range(vectors.shape[-1]))


def joined(components: Vector) -> AnyArray:
    """The array of components, which may be numbers where others are arrays."""
    first = components[0]
    vectors: AnyArray = np.empty((*first.shape, len(components)), first.dtype)
    for k, component in enumerate(components):
        vectors[..., k] = component
    return vectors


def _spread(material: Sequence[Material], section: AnyArray) -> Material:
    return Material(*(np.array(column)[section][:, None] if any(column) else 0.0 for column in zip(*material)))


class Lengths(NamedTuple):
    """Half of the elements' lengths, m, (E, 1), and its share at points, (E, p+1, 1); movement of points over the material:
    sigma, m/s, (E, p+1), its slope over s, 1/s, (E, 1), and its rate, m/s2."""

    half: Array
    shares: Array
    slide: Array
    slide_slope: Array
    slide_rate: Array


class Look(NamedTuple):
    """What is read off a motion: forces ``needed`` at the nodes, N, (n, d); ``pulls`` at points, N, and d2r/ds2, 1/m,
    (E, p+1, d); ``parts``: dr/ds, its rate, velocity through the water, acceleration there."""

    needed: Array
    pulls: Array
    bend: Array
    parts: tuple[Array, ...]


@dataclass(frozen=True)
class Chain:
    """``wire`` divided by ``mesh`` in water that moves with ``flow``; ``dimensions`` 2 or 3."""

    wire: Wire
    mesh: Mesh
    flow: Flow
    dimensions: int
    ops: Ops = field(default_factory=arrays, compare=False)

    @cached_property
    def rule(self) -> Rule:
        """Of its elements."""
        return rule(self.mesh.degree)

    @cached_property
    def material(self) -> Material:
        """Of its elements, (E, 1) each."""
        return _spread([part.material(self.wire.density) for part in self.wire.sections], self.mesh.section)

    @cached_property
    def fixtures(self) -> tuple[AnyArray, Fixture]:
        """(Nodes with something fixed to them; what)."""
        parts = [] if self.wire.body is None else [(0.0, self.wire.body)]
        parts += sorted(self.wire.clumps, key=lambda item: item[0])
        nodes = np.array([int(np.abs(self.mesh.places - s).argmin()) for s, _ in parts], dtype=int)
        found = [mass.fixture(self.wire.density, self.dimensions) for _, mass in parts]
        masses = np.array([f.masses for f in found]).reshape(-1, self.dimensions)
        weight, drag, aft = np.array([f[1:] for f in found]).reshape(-1, 3).T
        return nodes, Fixture(components(masses), weight, drag, aft)

    @cached_property
    def fixed(self) -> list[tuple[int, Fixture]]:
        """The same one by one, of numbers."""
        nodes, all_of = self.fixtures
        return [
            (int(node), Fixture(tuple(float(m[k]) for m in all_of.masses), *(float(each[k]) for each in all_of[1:])))
            for k, node in enumerate(nodes)
        ]

    @cached_property
    def free(self) -> slice:
        """Nodes that nothing holds."""
        return slice(1 if self.wire.body is None else 0, -1)

    @cached_property
    def _shares(self) -> Array:
        """Share x of the last section below a point, (E, p+1); 0 below that section."""
        last = self.wire.sections[-1].length
        ends = np.concatenate([[0.0], np.cumsum(self.mesh.lengths)])
        s = ends[:-1, None] + 0.5 * self.mesh.lengths[:, None] * (self.rule.points + 1.0)
        return np.maximum(0.0, (s - (self.wire.length - last)) / last)

    def lengths(self, paid: Paid = NOTHING_PAID) -> Lengths:
        """With wire paid out. Raises `CableError` where the last section is hauled in."""
        return self._at_start if paid == NOTHING_PAID else self._lengths(paid)

    @cached_property
    def _at_start(self) -> Lengths:
        return self._lengths(NOTHING_PAID)

    def _lengths(self, paid: Paid) -> Lengths:
        last = self.wire.sections[-1].length
        added, rate, change = paid
        if last + added <= HAULED * last:
            raise CableError(f"the last section of {last:g} m is hauled in but for {last + added:.3g} m: give it more length")
        grows = (self.mesh.section == len(self.wire.sections) - 1)[:, None]
        factor = np.where(grows, 1.0 + added / last, 1.0)
        slope = np.where(grows, rate / (last + added), 0.0)
        half = 0.5 * factor * self.mesh.lengths[:, None]
        return Lengths(half, (self.rule.weights * half)[:, :, None], rate * self._shares, slope, change * self._shares)

    def gather(self, nodes: AnyArray) -> AnyArray:
        """Values at nodes (n, d) -> at points (E, p+1, d)."""
        p = self.mesh.degree
        nodes = np.ascontiguousarray(nodes)
        n, d = nodes.shape
        bytes_, width = nodes.strides
        # elements share their ends
        points: AnyArray = np.ndarray(((n - 1) // p, p + 1, d), nodes.dtype, nodes, 0, (p * bytes_, bytes_, width))
        return points

    def scatter(self, points: Array) -> Array:
        """Sums of points' values at nodes."""
        p, d = self.mesh.degree, self.dimensions
        total = np.zeros((self.mesh.nodes, d))
        total[:-1] = points[:, :p].reshape(-1, d)
        total[p::p] += points[:, p]
        return total

    def slope(self, points: Array, half: Array) -> Array:
        """d/ds of points' values (E, p+1, d)."""
        derivative: Array = self.rule.slopes @ points
        derivative /= half[:, :, None]
        return derivative

    def at_points(self, r: Array, u: Array, b: Array, sizes: Lengths, paid: bool) -> tuple[Array, ...]:
        """(g, its rate, velocity through the water, acceleration of the material) at points."""
        places, v, a = self.gather(r), self.gather(u), self.gather(b)
        g, rate = self.slope(places, sizes.half), self.slope(v, sizes.half)
        if paid:
            sigma = sizes.slide[:, :, None]
            stretch_rate = sizes.slide_slope[:, :, None]
            a = a - 2.0 * sigma * (rate - stretch_rate * g) + sigma**2 * self.slope(g, sizes.half)
            a = a - sizes.slide_rate[:, :, None] * g
            v = v - sigma * g
            rate = rate - stretch_rate * g
        return g, rate, v - self.water(places[..., -1]), a

    def water(self, z: AnyArray) -> Array:
        """Velocity of the water at heights, (..., d), or (d,) where it is the same at all."""
        if len(self.flow.z) == 1:
            everywhere: Array = self.flow.velocity[0]
            return everywhere
        z = np.asarray(z)
        return self.flow.at(z.ravel())[0].reshape(*z.shape, self.dimensions)

    def _point_loads(self, parts: tuple[Array, ...]) -> tuple[Array, Array]:
        """(n, q) at points."""
        g, rate, v, a = map(components, parts)
        n = joined(pull(g, rate, self.material, self.ops)[0])
        return n, joined(load(g, rate, v, a, self.material, self.ops))

    def pulls(self, r: Array, u: Array, b: Array, drive: Drive) -> Array:
        """n at points, N, (E, p+1, d), by the balance dn/ds = q from the lower end on: as exact as the reaction at the top."""
        return self.look(r, u, b, drive).pulls

    def look(self, r: Array, u: Array, b: Array, drive: Drive) -> Look:
        """All that is read off a motion."""
        sizes = self.lengths(drive.paid)
        parts = self.at_points(r, u, b, sizes, any(drive.paid[1:]))
        n, q = self._point_loads(parts)
        nodes, loads = self.fixture_loads(r, u, b, drive.force)
        needed = self._gathered(n, q, sizes, nodes, loads)
        within = sizes.half[:, :, None] * (self.rule.integrals @ q)
        start = np.zeros((len(within), self.dimensions))
        start[1:] = np.cumsum(within[:-1, -1], axis=0)
        if self.wire.body is None:
            start -= needed[0]
        for node, weight in zip(nodes, loads):
            start[node // self.mesh.degree :] += weight
        return Look(needed, start[:, None, :] + within, self.slope(parts[0], sizes.half), parts)

    def bends(self, look: Look) -> tuple[AnyArray, AnyArray]:
        """(Curvature squared, 1/m2; speed of the water across the wire, m/s) at points, (E, p+1)."""
        return bent(components(look.parts[0]), components(look.bend), components(look.parts[2]), self.ops)

    def shape_error(self, r: Array, paid: Paid = NOTHING_PAID) -> float:
        """Error of positions by the elements over the length, from the last two Legendre coefficients of dr/ds: their sizes
        taken as a geometric series, its next term; with degree 1 and 2, the last one, which is more than the error."""
        sizes, p = self.lengths(paid), self.mesh.degree
        g = self.slope(self.gather(r), sizes.half)
        last, before = (
            np.linalg.norm(legendre(k, p) @ g, axis=1) if k >= 0 else np.zeros(len(g)) for k in (p - 1, p - 2)
        )
        if p <= 2:
            before = last
        worst = (sizes.half[:, 0] * last * last / np.maximum(np.maximum(before, last), 1e-300)).max()
        return float(worst) / (self.wire.length + paid[0])

    def needed(self, r: Array, u: Array, b: Array, drive: Drive) -> Array:
        """R, N, (n, d), for positions, velocities and accelerations of the nodes."""
        sizes = self.lengths(drive.paid)
        n, q = self._point_loads(self.at_points(r, u, b, sizes, any(drive.paid[1:])))
        return self._gathered(n, q, sizes, *self.fixture_loads(r, u, b, drive.force))

    def _gathered(self, n: Array, q: Array, sizes: Lengths, nodes: AnyArray, loads: Array) -> Array:
        """R from loads at points and on what is fixed to nodes."""
        total = self.scatter(self._weighted @ n + sizes.shares * q)
        total[nodes] += loads
        return total

    @cached_property
    def _weighted(self) -> Array:
        """D' w."""
        weighted: Array = self.rule.slopes.T * self.rule.weights
        return weighted

    def fixture_loads(self, r: Array, u: Array, b: Array, force: Array | None) -> tuple[AnyArray, Array]:
        """(Nodes, resisting loads on them, N): what is fixed to the wire."""
        nodes = self.fixtures[0]
        loads = np.zeros((len(nodes), self.dimensions))
        for k, (node, fixture) in enumerate(self.fixed):
            v = u[node] - self.water(r[node, -1])
            loads[k] = fixture_load(tuple(v.tolist()), tuple(b[node].tolist()), fixture, FLOATS)
        if force is not None and self.wire.body is not None:
            loads[0] -= force
        return nodes, loads
