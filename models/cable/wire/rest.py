"""Where a chain is at rest in a frame that moves on and turns: hanging, towed steadily, or on a steady circle.

    u_i = W + Omega x r_i,   a_i = Omega x u_i,   R(r, u, a) = 0        r relative to the top, Omega about the vertical

The first shape is that of the wire itself, from dn/ds = q and dr/ds = g(n) upwards from the body, whose load is known
(``march``); the chain's own equilibrium, from which a motion starts, follows by Newton's method with pseudo-time where the
first shape is far away. A circle is reached from the straight tow by turning more and more.

Source: pseudo-transient continuation as C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) p. 508.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array
from ...numeric.ops import FLOATS
from ..case import CableError
from .chain import Chain, Drive
from .jacobian import derivatives
from .matrix import factorised
from .parts import Flow, Wire
from .point import fixture_load, load

TOLERANCE = 1e-9
"""Newton's last change of positions over the length of the wire."""
MARCHED = 1e-6
"""Miss of the top over the length at which the end of a march is near enough."""
FAR, ARRIVED = 0.3, 1e-7
"""Newton's change over the length that is never taken, and one that is taken whatever the forces do."""
FIRST_TIME, SHORTER, SHORTEST = 1.0, 0.25, 1e-9
"""Pseudo-time, s, when Newton's method goes astray at first, its change when it does again, and when it is given up."""
NO_TENSION = 1e-30
"""Added to a tension, N, so that a free end without load has a direction."""
MAX_NEWTON = 200
MAX_MARCHES = 60


@dataclass(frozen=True)
class Frame:
    """Velocity of the top, m/s, (d,), rate of turning about the vertical, rad/s (positive to port); ``lower``: place of a
    held lower end relative to the top, m."""

    velocity: Array
    turning: float = 0.0
    lower: Array | None = None

    @property
    def spin(self) -> Array:
        """Omega x as a matrix (d, d)."""
        matrix = np.zeros((len(self.velocity), len(self.velocity)))
        if self.turning:
            matrix[0, 1], matrix[1, 0] = -self.turning, self.turning
        return matrix

    def motion(self, r: Array) -> tuple[Array, Array]:
        """(Velocities, accelerations) of points at ``r`` relative to the top."""
        u = self.velocity + r @ self.spin.T
        return u, u @ self.spin.T


@dataclass(frozen=True)
class Shape:
    """A marched wire: ``position`` relative to the top, and ``pull`` n, N, over s; each takes (m,), gives (m, d)."""

    position: Callable[[Array], Array]
    pull: Callable[[Array], Array]


def march(wire: Wire, flow: Flow, frame: Frame, dimensions: int, rtol: float = 1e-8, start: Array | None = None) -> Shape:
    """The steady shape, marched from the lower end; its place (or the pull there, of a held end) sought until the last end
    is at the top: at once for a body in still water, or where the body's place ``start`` is known. Raises `CableError`."""
    if wire.body is None:
        return _between(wire, flow, frame, rtol)
    if start is not None:
        return _shape(_marched(wire, flow, frame, start, rtol), np.zeros(dimensions), dimensions)
    start, size = np.zeros(dimensions), wire.length
    depends = len(flow.z) > 1 or frame.turning != 0.0
    for _ in range(MAX_MARCHES):
        pieces = _marched(wire, flow, frame, start, rtol)
        end = pieces[-1][2](pieces[-1][1])[:dimensions]
        if not depends or np.abs(end).max() < MARCHED * size:
            break
        start = start - end
    return _shape(pieces, end, dimensions)


Piece = tuple[float, float, Callable[[float | Array], Array]]
"""s from and to, and (r, n) between them."""


def _shape(pieces: list[Piece], end: Array, d: int) -> Shape:
    def values(s: Array) -> Array:
        s = np.asarray(s, float)
        table = np.empty((len(s), 2 * d))
        for low, high, at in pieces:
            inside = (s >= low) & (s <= high + 1e-9)
            if inside.any():
                table[inside] = at(s[inside]).T
        return table

    return Shape(lambda s: values(s)[:, :d] - end, lambda s: values(s)[:, d:])


def _between(wire: Wire, flow: Flow, frame: Frame, rtol: float) -> Shape:
    """Of a wire held at both ends: Newton's method for the pull on the lower end, from that of a flat parabola."""
    assert frame.lower is not None
    lower, d = frame.lower, len(frame.lower)
    chord, span = -lower / np.linalg.norm(lower), float(np.linalg.norm(lower))
    loads, stiffness = np.zeros(d), wire.length / sum(k.length / k.axial_stiffness for k in wire.sections)
    for part in wire.sections:
        v = frame.velocity - flow.at(lower[-1:])[0][0]
        k = part.material(wire.density)
        loads += part.length * np.array(load(tuple(chord), (0.0,) * d, tuple(v), (0.0,) * d, k, FLOATS))
    across = float(np.linalg.norm(loads - (loads @ chord) * chord))
    low, high = 1e-9 * stiffness, 10.0 * stiffness
    for _ in range(100):
        middle = math.sqrt(low * high)
        # longer than the chord by sag, shorter than it is when stretched
        if wire.length * (1.0 + middle / stiffness) / span - 1.0 < (across / middle) ** 2 / 24.0:
            low = middle
        else:
            high = middle
    pull = low * chord - 0.5 * loads

    def miss(pull: Array) -> tuple[list[Piece], Array]:
        pieces = _marched(wire, flow, frame, lower, rtol, pull)
        return pieces, pieces[-1][2](pieces[-1][1])[:d]

    pieces, end = miss(pull)
    for _ in range(MAX_MARCHES):
        size = float(np.linalg.norm(end))
        if size < 1e-8 * wire.length:
            return _shape(pieces, end, d)
        step = 1e-4 * (float(np.linalg.norm(pull)) + 1e-6 * stiffness)
        columns = [(miss(pull + step * e)[1] - end) / step for e in np.eye(d)]
        change = np.linalg.solve(np.array(columns).T, end)
        share = 1.0
        while share > 1e-4:
            trial, there = miss(pull - share * change)
            if np.linalg.norm(there) < size:
                break
            share *= 0.5
        pull, pieces, end = pull - share * change, trial, there
    raise CableError(f"the steady shape between the ends was not found: it misses the top by {size:.3g} m")


def _marched(
    wire: Wire, flow: Flow, frame: Frame, start: Array, rtol: float, pull: Array | None = None
) -> list[Piece]:
    """Section by section from the lower end at ``start``, where the wire pulls a held end with ``pull``."""
    from scipy.integrate import solve_ivp  # loads slowly

    d, spin = len(start), frame.spin

    def through(r: Array) -> tuple[Array, Array]:
        u = frame.velocity + spin @ r
        return u - flow.at(r[-1:])[0][0], spin @ u

    fixed = [*wire.clumps] if wire.body is None else [(0.0, wire.body), *wire.clumps]
    y, s, pieces = np.concatenate([start, np.zeros(d) if pull is None else pull]), 0.0, []
    for part in wire.sections:
        for place, mass in fixed:
            if abs(place - s) < 1e-9 * wire.length:
                v, a = through(y[:d])
                y[d:] += fixture_load(tuple(v), tuple(a), mass.fixture(wire.density, d), FLOATS)
        material = part.material(wire.density)

        def slopes(_: float, y: Array, k=material) -> Array:  # type: ignore[no-untyped-def]
            r, n = y[:d], y[d:]
            tension = math.sqrt(float(n @ n)) + NO_TENSION
            g = tuple(((1.0 / tension + 1.0 / k.stiffness) * n).tolist())
            v, a = through(r)
            return np.array([*g, *load(g, tuple((spin @ g).tolist()), tuple(v.tolist()), tuple(a.tolist()), k, FLOATS)])

        # a layer of a few metres at the end of a long wire is stiff beyond it
        size = 1e-3 * rtol * np.array([wire.length] * d + [np.linalg.norm(y[d:]) + abs(part.weight) * part.length + 1.0] * d)
        found = solve_ivp(slopes, (s, s + part.length), y, "LSODA", rtol=rtol, atol=size, dense_output=True)
        if not found.success or not np.all(np.isfinite(found.y[:, -1])):
            raise CableError(f"the steady shape of the wire was not found beyond s = {found.t[-1]:g} m: {found.message}")
        pieces.append((s, s + part.length, found.sol))
        y, s = found.y[:, -1].copy(), s + part.length
    return pieces


def equilibrium(chain: Chain, frame: Frame, first: Array) -> Array:
    """Positions of the nodes relative to the top, (n, d), from a ``first`` shape. Raises `CableError`."""
    free, size = chain.free, chain.wire.length
    r = first.copy()
    if frame.lower is not None:
        r[0] = frame.lower
    r[-1] = 0.0
    zero = np.zeros(chain.dimensions)
    drive = Drive(zero, frame.velocity, zero)
    spin = frame.spin

    def unbalanced(r: Array) -> Array:
        return chain.needed(r, *frame.motion(r), drive)[free]

    residual = unbalanced(r)
    pseudo = math.inf
    norm = float(np.linalg.norm(residual))
    with np.errstate(all="ignore"):
        for _ in range(MAX_NEWTON):
            stiff, damp, mass = derivatives(chain, r, *frame.motion(r))
            matrix = stiff
            if frame.turning:
                matrix = matrix + damp @ spin + mass @ (spin @ spin)
            if pseudo < math.inf:
                matrix = matrix + damp / pseudo + mass / pseudo**2
            factors = factorised(matrix, free)
            trial, change = r.copy(), np.full_like(residual, math.nan)
            if factors is not None:
                change = factors.solve(residual)
                trial[free] -= change
            moved = float(np.abs(change).max())
            after = unbalanced(trial) if moved < FAR * size else np.full_like(residual, math.nan)
            after_norm = float(np.linalg.norm(after))
            if not after_norm < (2.0 if pseudo < math.inf else 1.0) * norm and not moved < ARRIVED * size:
                # too far for Newton's method: a short time of motion that dies out at once
                pseudo = FIRST_TIME if pseudo == math.inf else SHORTER * pseudo
                if pseudo < SHORTEST:
                    break
                continue
            r, residual = trial, after
            if pseudo == math.inf and moved < TOLERANCE * size:
                return r
            pseudo *= min(10.0, max(1.5, norm / max(after_norm, 1e-300)))
            if pseudo > 1e4:
                pseudo = math.inf
            norm = after_norm
    raise CableError(f"the wire's equilibrium was not found: the forces on its nodes still differ by {norm:.3g} N")


def circled(chain: Chain, frame: Frame, r: Array, turning: float) -> tuple[Frame, Array]:
    """(Frame, nodes) of the steady circle with ``turning``, rad/s, from the straight tow. Raises `CableError`."""
    done, share = 0.0, 0.25
    before, there = r, 0.0
    while done < 1.0:
        aim = min(1.0, done + share)
        trial = Frame(frame.velocity, aim * turning, frame.lower)
        # on along the branch
        guess = r + (r - before) * ((aim - done) / (done - there)) if done > there else r
        try:
            found = equilibrium(chain, trial, guess)
        except CableError:
            share *= 0.5
            if share < 1e-4:
                raise
            continue
        before, there, r, done = r, done, found, aim
        share *= 1.5
    return Frame(frame.velocity, turning, frame.lower), r
