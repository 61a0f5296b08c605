"""A chain written out value by value: the same equations as ``chain.py`` for one kind of value, symbols among them.

    M_i a_i = -R_i(r, u, 0)        at free nodes: the mass of a node is a block of its own, so that rates are explicit

For traces and compositions, where elements are known and arrays of numbers are not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ...numeric.ops import Ops, Value
from .chain import Chain
from .elements import legendre
from .point import Material, Vector, dot, fixture_load, load, pull

Vectors = Sequence[Vector]


class Drive(NamedTuple):
    """As `chain.Drive`, of one kind of value: velocity and acceleration of the top, wire paid out with its two rates, force on
    the body."""

    velocity: Vector
    acceleration: Vector
    paid: tuple[Value, Value, Value]
    force: Vector


class Point(NamedTuple):
    """A point of an element: dr/ds, d2r/ds2, velocity through the water, n, q and its share w l/2 of the element."""

    g: Vector
    bend: Vector
    through: Vector
    n: Vector
    q: Vector
    share: Value


class Look(NamedTuple):
    """Forces of a moment: (n, d) needed at the nodes, those of what is fixed to nodes, points of all elements."""

    needed: list[Vector]
    fixtures: list[tuple[int, Vector]]
    points: list[list[Point]]
    half: list[Value]


def _sum(terms: Sequence[Value]) -> Value:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def combined(row: Sequence[float], vectors: Vectors, scale: Value = 1.0) -> Vector:
    """scale times the sum of vectors with the weights of ``row``."""
    return tuple(
        scale * _sum([w * v[c] for w, v in zip(row, vectors) if w != 0.0] or [0.0]) for c in range(len(vectors[0]))
    )


def _plus(a: Vector, b: Vector, factor: Value = 1.0) -> Vector:
    return tuple(x + factor * y for x, y in zip(a, b))


def solved(matrix: list[list[Value]], right: Vector) -> Vector:
    """Of a small positive definite system, without pivots."""
    a, x, n = [list(row) for row in matrix], list(right), len(right)
    for k in range(n):
        for i in range(k + 1, n):
            share = a[i][k] / a[k][k]
            a[i] = [p - share * q for p, q in zip(a[i], a[k])]
            x[i] = x[i] - share * x[k]
    for k in reversed(range(n)):
        x[k] = _sum([x[k], *(-(a[k][j] * x[j]) for j in range(k + 1, n))]) / a[k][k]
    return tuple(x)


class Written:
    """``chain`` for values that ``ops`` knows. Its last node is driven, its first one where there is no body."""

    def __init__(self, chain: Chain, ops: Ops) -> None:
        self.chain, self.ops = chain, ops
        rule = chain.rule
        self._weights, self._slopes, self._integrals = rule.weights.tolist(), rule.slopes.tolist(), rule.integrals.tolist()
        parts = [part.material(chain.wire.density) for part in chain.wire.sections]
        self._materials = [Material(*map(float, parts[k])) for k in chain.mesh.section]
        last = len(chain.wire.sections) - 1
        self._grows = [int(k) == last for k in chain.mesh.section]
        self._shares, self._half = chain._shares.tolist(), (0.5 * chain.mesh.lengths).tolist()
        self._fixtures = chain.fixed

    def _water(self, z: Value) -> Vector:
        flow = self.chain.flow
        velocity: Vector = tuple(flow.velocity[0].tolist())
        for k in range(len(flow.z) - 1):
            low, high = float(flow.z[k]), float(flow.z[k + 1])
            share = (self.ops.minimum(self.ops.maximum(z, low), high) - low) * (1.0 / (high - low))
            velocity = _plus(velocity, tuple((flow.velocity[k + 1] - flow.velocity[k]).tolist()), share)
        return velocity

    def look(self, r: Vectors, u: Vectors, b: Vectors, drive: Drive) -> Look:
        """All forces for positions, velocities and accelerations of the nodes."""
        degree, d = self.chain.mesh.degree, self.chain.dimensions
        needed: list[Vector] = [(0.0,) * d for _ in r]
        elements, halves = [], []
        for e in range(len(self._half)):
            points, half = self._element(e, r, u, b, drive.paid)
            for i in range(degree + 1):
                total = combined(
                    [w * row[i] for w, row in zip(self._weights, self._slopes)], [point.n for point in points]
                )
                at = e * degree + i
                needed[at] = _plus(needed[at], _plus(total, points[i].q, points[i].share))
            elements.append(points)
            halves.append(half)
        fixtures = []
        for k, (node, fixture) in enumerate(self._fixtures):
            resists = fixture_load(_plus(u[node], self._water(r[node][-1]), -1.0), b[node], fixture, self.ops)
            if k == 0 and self.chain.wire.body is not None:
                resists = _plus(resists, drive.force, -1.0)
            needed[node] = _plus(needed[node], resists)
            fixtures.append((node, resists))
        return Look(needed, fixtures, elements, halves)

    def _element(
        self, e: int, r: Vectors, u: Vectors, b: Vectors, paid: tuple[Value, Value, Value]
    ) -> tuple[list[Point], Value]:
        """(Points of an element, half its length)."""
        degree, material, half = self.chain.mesh.degree, self._materials[e], self._half[e]
        own = slice(e * degree, e * degree + degree + 1)
        length, stretch = half, 0.0
        if self._grows[e]:
            last = self.chain.wire.sections[-1].length
            length, stretch = half * (1.0 + paid[0] * (1.0 / last)), paid[1] / (last + paid[0])
        scale = 1.0 / length
        gs = [combined(row, r[own], scale) for row in self._slopes]
        points = []
        for i, row in enumerate(self._slopes):
            g, v, a = gs[i], _plus(u[own][i], self._water(r[own][i][-1]), -1.0), b[own][i]
            rate, bend = combined(row, u[own], scale), combined(row, gs, scale)
            if self._grows[e]:
                share = self._shares[e][i]
                sigma = paid[1] * share
                rate = _plus(rate, g, -1.0 * stretch)
                a = _plus(_plus(a, rate, -2.0 * sigma), bend, sigma * sigma)
                a, v = _plus(a, g, -share * paid[2]), _plus(v, g, -1.0 * sigma)
            n = pull(g, rate, material, self.ops)[0]
            points.append(Point(g, bend, v, n, load(g, rate, v, a, material, self.ops), self._weights[i] * length))
        return points, length

    def accelerations(self, look: Look, top: Vector, lower: Vector) -> list[Vector]:
        """Of all nodes, from a look without any; ``top`` is that of the last, ``lower`` that of the first if it is driven."""
        d = self.chain.dimensions
        masses: list[list[list[Value]]] = [[[0.0] * d for _ in range(d)] for _ in look.needed]
        for node, point, k in self._places(look):
            own = masses[node]
            inverse = k.added_mass / dot(point.g, point.g)
            for i in range(d):
                for j in range(d):
                    along = inverse * (point.g[i] * point.g[j])
                    own[i][j] = own[i][j] + point.share * (k.mass + k.added_mass - along if i == j else -1.0 * along)
        for node, fixture in self._fixtures:
            for c in range(d):
                masses[node][c][c] = masses[node][c][c] + fixture.masses[c]
        free = self.chain.free
        found = [solved(matrix, tuple(-1.0 * x for x in f)) for matrix, f in zip(masses[free], look.needed[free])]
        return [*([lower] if free.start else []), *found, top]

    def accelerated(self, look: Look, b: Vectors) -> Look:
        """A look without accelerations, with those of the nodes; needed of the ends alone."""
        last, needed, points = len(look.needed) - 1, [*look.needed], [list[Point]() for _ in look.points]
        for (node, point, k), e in zip(self._places(look), (e for e, each in enumerate(look.points) for _ in each)):
            along = k.added_mass * dot(b[node], point.g) / dot(point.g, point.g)
            more = tuple((k.mass + k.added_mass) * c - along * g for c, g in zip(b[node], point.g))
            points[e].append(point._replace(q=_plus(point.q, more)))
            if node in (0, last):
                needed[node] = _plus(needed[node], more, point.share)
        fixtures = [
            (node, _plus(resists, tuple(m * c for m, c in zip(fixture.masses, b[node]))))
            for (node, resists), (_, fixture) in zip(look.fixtures, self._fixtures)
        ]
        return Look(needed, fixtures, points, look.half)

    def _places(self, look: Look) -> Iterator[tuple[int, Point, Material]]:
        """(Node, point, material) of all points."""
        for e, points in enumerate(look.points):
            for i, point in enumerate(points):
                yield e * self.chain.mesh.degree + i, point, self._materials[e]

    def sizes(self, look: Look) -> list[Value]:
        """Tensions at the points, N, from the lower end, by the balance dn/ds = q."""
        at, found = (0.0,) * self.chain.dimensions, []
        if self.chain.wire.body is None:
            at = tuple(-1.0 * x for x in look.needed[0])
        fixed = dict(look.fixtures)
        for e, (points, half) in enumerate(zip(look.points, look.half)):
            if (resists := fixed.get(e * self.chain.mesh.degree)) is not None:
                at = _plus(at, resists)
            within = [combined(row, [point.q for point in points], half) for row in self._integrals]
            pulls = [_plus(at, each) for each in within]
            found += [self.ops.sqrt(dot(n, n)) for n in pulls]
            at = pulls[-1]
        return found

    def shape_error(self, look: Look, added: Value) -> Value:
        """As `Chain.shape_error`."""
        p, worst = self.chain.mesh.degree, None
        for points, half in zip(look.points, look.half):
            last, before = (self._coefficient(k, points) if k >= 0 else 0.0 for k in (p - 1, p - 2))
            if p <= 2:
                before = last
            largest = self.ops.maximum(self.ops.maximum(before, last), 1e-300)
            own = half * last * (last / largest)
            worst = own if worst is None else self.ops.maximum(worst, own)
        return worst / (self.chain.wire.length + added)

    def _coefficient(self, k: int, points: Sequence[Point]) -> Value:
        c = combined(legendre(k, self.chain.mesh.degree).tolist(), [point.g for point in points])
        return self.ops.sqrt(dot(c, c))
