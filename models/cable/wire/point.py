"""Physics of one point of a wire, and of what is fixed to it: pull of the wire and resisting load, written once.

    n = T t,   T = EA max(0, |g| - 1) + B (t . g'),   t = g/|g|,   g = dr/ds           pull along the wire, N
    q = w e_z + D(v, t) + m a + m_a (a - (a . t) t) - m_c (V t' + (v . t') t)           load per unstretched length, N/m

The wire obeys dn/ds = q. Loads are resisting: q points where the point would have to be pushed. Vectors are tuples of two
(x forward, z up) or three components (x, y to port, z up); the last points up.

| symbol | meaning | unit |
|---|---|---|
| s | unstretched length from the lower end | m |
| v, a | velocity of the material through the water, its acceleration | m/s, m/s2 |
| V, U | components of v along and across t; q_v = |v| | m/s |
| D | (N/|U|) U + G t, N and G of ten coefficients, below | N/m |
| EA, B | axial stiffness, internal damping (acts in tension only) | N, N s |
| m, m_a, w | mass, added mass across t, weight in water, per length | kg/m, kg/m, N/m |
| m_c | 0: Morison's form of the added mass; m_a: that of momentum, m_a d/dt of v across t | kg/m |

    N = c_vv V^2 + c_uu U^2 + c_q (|V| q_v c_1 + U q_v c_3) + c_uv U |V|, likewise G times the sign of V

Assumptions: (1) no bending, no twist; (2) loads per unstretched length, diameter not reduced by stretch; (3) a slack wire
never pushes; (4) loads depend on the local velocity only; (5) drag of a body is the vector |v| v, added mass is diagonal.

Source: small-perturbation report on towed cables, Equations [11]-[14] (ten coefficients, see ``cable/loading.py``); the
rest as MoorDyn's lines (``source/Line.cpp``), with the drag of the material instead of that of the nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...numeric.ops import Ops, Value
from ..loading import Loading

Vector = tuple[Value, ...]

SMALL_SPEED2 = 1e-12
"""Added under the root of a speed, (m/s)^2, so that it has a derivative at rest."""
NO_LENGTH2 = 1e-30
"""The same of the stretched length, for a wire that is folded to nothing."""


class Material(NamedTuple):
    """What a point is made of, per unstretched length; numbers, or arrays that fit the vectors (0.0 where all are)."""

    stiffness: Value
    damping: Value
    mass: Value
    added_mass: Value
    convected: Value
    weight: Value
    normal_vv: Value
    normal_uu: Value
    normal_qv: Value
    normal_qu: Value
    normal_uv: Value
    tangential_vv: Value
    tangential_uu: Value
    tangential_qv: Value
    tangential_qu: Value
    tangential_uv: Value


class Fixture(NamedTuple):
    """What is fixed to a node: masses, kg (per component), weight in water, N, drag rho A/2, N s2/m2, and a constant force
    aft, N."""

    masses: Vector
    weight: Value
    drag: Value
    aft: Value


def drag_terms(loading: Loading, factor: float) -> tuple[float, ...]:
    """The last ten fields of `Material` for ten coefficients times ``factor`` = rho h C_D/2, N s2/m3."""
    return tuple(
        factor * term
        for a0, a1, a2, b1, b2 in (loading.normal, loading.tangential)
        for term in (a0 + a2, a0 - a2, a1, b1, 2.0 * b2)
    )


def dot(a: Vector, b: Vector) -> Value:
    """Inner product."""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:]):
        total = total + x * y
    return total


def absent(coefficient: Value) -> bool:
    """Whether it is the number 0, so that nothing that it multiplies need be computed."""
    return type(coefficient) is float and coefficient == 0.0


def _present(*terms: tuple[Value, Callable[[], Value]]) -> Value:
    """Sum of coefficients times what is computed for those that are not absent."""
    total: Value = 0.0
    for coefficient, term in terms:
        if not absent(coefficient):
            one = coefficient * term()
            total = one if absent(total) else total + one
    return total


def pull(g: Vector, g_rate: Vector, k: Material, ops: Ops) -> tuple[Vector, Value]:
    """(n, N; stretched over unstretched length) for dr/ds and its rate, 1/s."""
    stretch = ops.sqrt(dot(g, g) + NO_LENGTH2)
    tension = k.stiffness * (stretch - 1.0)
    if absent(k.damping):
        tension = ops.maximum(tension, 0.0)
    else:
        tension = tension + k.damping * dot(g, g_rate) / stretch
        # a slack wire carries nothing, whatever the damping says
        tension = ops.where(stretch > 1.0, ops.where(tension > 0.0, tension, 0.0), 0.0)
    factor = tension / stretch
    return tuple(factor * c for c in g), stretch


def load(g: Vector, g_rate: Vector, v: Vector, a: Vector, k: Material, ops: Ops) -> Vector:
    """q, N/m."""
    inverse = 1.0 / ops.sqrt(dot(g, g) + NO_LENGTH2)
    t = tuple(inverse * c for c in g)
    along = dot(v, t)
    across = tuple(c - along * e for c, e in zip(v, t))
    u2, v2 = dot(across, across) + SMALL_SPEED2, along * along + SMALL_SPEED2
    u_size, v_size = ops.sqrt(u2), ops.sqrt(v2)
    mixed = (k.normal_qv, k.normal_qu, k.tangential_qv, k.tangential_qu)
    q = 0.0 if all(map(absent, mixed)) else ops.sqrt(u2 + v2)
    normal = _present(
        (k.normal_vv, lambda: v2 / u_size), (k.normal_uu, lambda: u_size), (k.normal_qv, lambda: q * v_size / u_size),
        (k.normal_qu, lambda: q), (k.normal_uv, lambda: v_size),
    )  # fmt: skip
    tangential = _present(
        (k.tangential_vv, lambda: v_size), (k.tangential_uu, lambda: u2 / v_size), (k.tangential_qv, lambda: q),
        (k.tangential_qu, lambda: q * u_size / v_size), (k.tangential_uv, lambda: u_size),
    )  # fmt: skip
    tangential = tangential * along - k.added_mass * dot(a, t)
    inertia = k.mass + k.added_mass
    if absent(k.convected):
        q_vector = tuple(normal * c + tangential * e + inertia * b for c, e, b in zip(across, t, a))
    else:
        stretching = dot(g_rate, t)
        turning = tuple(inverse * (c - stretching * e) for c, e in zip(g_rate, t))
        tangential, convected = tangential - k.convected * dot(v, turning), k.convected * along
        q_vector = tuple(
            normal * c + tangential * e + inertia * b - convected * f for c, e, b, f in zip(across, t, a, turning)
        )
    return (*q_vector[:-1], q_vector[-1] + k.weight)


def bent(g: Vector, bend: Vector, v: Vector, ops: Ops) -> tuple[Value, Value]:
    """(Curvature squared, 1/m2; speed of the water across the wire, m/s), ``bend`` = d2r/ds2: what the model leaves out or
    takes as given depends on them."""
    square, along = dot(g, g) + NO_LENGTH2, dot(g, bend)
    curvature2 = (square * dot(bend, bend) - along * along) / (square * square * square)
    v_along = dot(v, g)
    return curvature2, ops.sqrt(ops.maximum(dot(v, v) - v_along * v_along / square, 0.0) + SMALL_SPEED2)


def fixture_load(v: Vector, a: Vector, k: Fixture, ops: Ops) -> Vector:
    """The same of a body, clump or buoy, N."""
    factor = k.drag * ops.sqrt(dot(v, v) + SMALL_SPEED2)
    total = tuple(m * b + factor * c for m, b, c in zip(k.masses, a, v))
    return (total[0] + k.aft, *total[1:-1], total[-1] + k.weight)
