"""Derivatives of the forces that a chain's motion asks for, element by element, by complex steps."""

from __future__ import annotations

import numpy as np

from ...numeric.arrays import Array
from .chain import NOTHING_PAID, Chain, Paid, components, joined
from .point import fixture_load, load, pull

STEP = 1e-150
"""Complex step, exact to rounding."""


def derivatives(
    chain: Chain, r: Array, u: Array, b: Array, paid: Paid = NOTHING_PAID
) -> tuple[Array, Array, Array]:
    """(K, C, M): derivatives of R by positions, velocities and accelerations within elements, (E, p+1, d, p+1, d); those
    of fixtures are in the diagonal blocks of the elements' first nodes. Left out: how payout changes the acceleration, and
    the convected added mass by the rate of the slope."""
    sizes = chain.lengths(paid)
    d, p, e = chain.dimensions, chain.mesh.degree, len(chain.mesh.lengths)
    parts = chain.at_points(r, u, b, sizes, any(paid[1:]))
    # seeds: d of g, d of velocity and rate together (n knows no velocity, q no rate), d of acceleration
    seeded = [np.repeat(x.astype(complex)[None], 3 * d, axis=0) for x in parts]
    for k in range(d):
        seeded[0][k, ..., k] += 1j * STEP
        seeded[1][d + k, ..., k] += 1j * STEP
        seeded[2][d + k, ..., k] += 1j * STEP
        seeded[3][2 * d + k, ..., k] += 1j * STEP
    g, rate, v, a = (components(x) for x in seeded)
    n = joined(pull(g, rate, chain.material, chain.ops)[0]).imag / STEP
    q = joined(load(g, components(parts[1]), v, a, chain.material, chain.ops)).imag / STEP
    # (seed, E, point, component) -> (E, point, component, seed)
    n, q = np.moveaxis(n, 0, -1), np.moveaxis(q, 0, -1)
    slopes, weights = chain.rule.slopes, chain.rule.weights
    outer = (weights[:, None, None] * slopes[:, :, None] * slopes[:, None, :]).reshape(p + 1, -1).T
    scale = 1.0 / sizes.half
    local = (weights * sizes.half)[:, :, None, None] * q

    def within(by: Array) -> Array:
        """D' (w by/half) D."""
        joined = (outer @ by.reshape(e, p + 1, -1)) * scale[:, :, None]
        return np.moveaxis(joined.reshape(e, p + 1, p + 1, d, d), 2, 3).copy()

    stiff, damp = within(n[..., :d]), within(n[..., d : 2 * d])
    by_slope = local[..., :d] - sizes.slide[:, :, None, None] * local[..., d : 2 * d]
    stiff += slopes[:, None, :, None] * (by_slope * scale[:, :, None, None])[:, :, :, None, :]
    mass = np.zeros((e, p + 1, d, p + 1, d))
    each = np.arange(p + 1)
    mass[:, each, :, each, :] += np.moveaxis(local[..., 2 * d :], 1, 0)
    damp[:, each, :, each, :] += np.moveaxis(local[..., d : 2 * d], 1, 0)
    if len(chain.flow.z) > 1:
        sheared = chain.flow.at(chain.gather(r)[..., -1].ravel())[1].reshape(e, p + 1, d)
        by_height = -np.einsum("eiab,eib->eia", local[..., d : 2 * d], sheared)
        stiff[:, each, :, each, d - 1] += np.moveaxis(by_height, 1, 0)
    _of_fixtures(chain, r, u, stiff, damp, mass)
    return stiff, damp, mass


def _of_fixtures(chain: Chain, r: Array, u: Array, stiff: Array, damp: Array, mass: Array) -> None:
    """Add those of fixtures to the elements above them."""
    nodes, fixture = chain.fixtures
    if not len(nodes):
        return
    d = chain.dimensions
    flow, sheared = chain.flow.at(r[nodes, -1])
    v = np.repeat((u[nodes] - flow).astype(complex)[None], d, axis=0)
    sheared = np.broadcast_to(sheared, flow.shape)
    for k in range(d):
        v[k, :, k] += 1j * STEP
    slopes = joined(fixture_load(components(v), components(0.0 * v), fixture, chain.ops)).imag / STEP
    for k, node in enumerate(nodes):
        above = node // chain.mesh.degree
        damp[above, 0, :, 0, :] += slopes[:, k, :].T
        stiff[above, 0, :, 0, d - 1] -= slopes[:, k, :].T @ sheared[k]
        mass[above, 0, :, 0, :] += np.diag([float(m[k]) for m in fixture.masses])
