"""Nonlinear tow cable in time: elastic lumped masses, stepped implicitly. The linear models are judged by it.

    M(r) v' = f(r, v),   (r - r_N)' = v - v_N,   v_N(t) the velocity of the towpoint through the water

Forces and inertia are those of ``forces.py``, without linearisation: large angles, both quadrants and beyond,
slack (a segment never pushes). Drag of the body is D_B |v| v/c^2 where ``quadratic_drag``, else constant plus its
linear damping; v_N = (c, 0) plus the input. Positions are relative to the towpoint: nothing depends on where it is.

Stepping: two-stage singly diagonally implicit Runge-Kutta of order 2, gamma = 1 - 1/sqrt 2, stiffly accurate and
L-stable (Alexander 1977): the stiff, nearly undamped axial modes of the segments die out instead of limiting the step.
Newton's method per stage with the block-tridiagonal matrix M/(gamma h) + C + gamma h K from complex-step derivatives of
the segments; a stage that does not converge halves the step, at most `MAX_HALVINGS` times.

Assumptions: (1) to (4) of ``cable/case.py``; (5) no internal damping of the cable. Not to be confused with the
trapezoidal rule, which lets axial modes ring.

Source: R. Alexander, SIAM J. Numer. Anal. 14 (1977) p. 1006; model as MoorDyn's lines (``source/Line.cpp``) but
implicit and with ten-coefficient loading; compared with MoorDyn 2.7 for a 120 m tow at 6 kn.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array
from ..case import CableError, Tow
from .forces import COMPLEX_STEP, node_mass, segment_forces
from .lumped import Chain, equilibrium

GAMMA = 1.0 - 1.0 / math.sqrt(2.0)
MAX_ITERATIONS = 12
MAX_HALVINGS = 12
TOLERANCE = 1e-10
"""Newton's change of velocity over the tow speed."""

Motion = Callable[[float], Array]
"""Time, s -> inputs (v_x, v_y of the towpoint in the towing frame, m/s; f_x, f_y on the body, N), shape (4,)."""


@dataclass(frozen=True)
class NonlinearCable:
    """A discretised tow; ``chain`` is its equilibrium. Raises `CableError` without finite axial stiffness."""

    chain: Chain
    quadratic_drag: bool = True

    def __post_init__(self) -> None:
        if not math.isfinite(self.chain.tow.cable.axial_stiffness):
            raise CableError("the nonlinear cable is elastic: it needs a finite axial stiffness EA")

    def start(self) -> Array:
        """The equilibrium: (2, 2, N): positions relative to the towpoint, m, and velocities through the water, m/s."""
        chain = self.chain
        state = np.zeros((2, 2, chain.count))
        state[0] = (chain.nodes[:-1] - chain.nodes[-1]).T
        state[1, 0] = chain.tow.speed
        return state

    def body_force(self, velocity: Array, force: Array) -> tuple[Array, Array]:
        """(force on the body but for the cable's, N, (2,); its derivative by the velocity, (2, 2))."""
        tow, body = self.chain.tow, self.chain.tow.body
        buoyant = np.array([0.0, body.lift - body.weight]) + force
        if self.quadratic_drag:
            factor = body.drag / tow.speed**2
            size = math.hypot(*velocity)
            slope = -factor * (size * np.eye(2) + np.outer(velocity, velocity) / max(size, 1e-300))
            return buoyant - factor * size * velocity, slope
        damping = np.diag([body.damping_surge, body.damping_heave])
        return buoyant - np.array([body.drag, 0.0]) - damping @ (velocity - np.array([tow.speed, 0.0])), -damping

    def _ends(self, state: Array, top: Array) -> tuple[Array, Array, Array, Array]:
        positions = np.concatenate([state[0], np.zeros((2, 1))], axis=1)
        velocities = np.concatenate([state[1], top[:, None]], axis=1)
        return positions[:, :-1], positions[:, 1:], velocities[:, :-1], velocities[:, 1:]

    def mass(self, positions: Array) -> Array:
        """Inertia of the nodes (N+1, 2, 2), kg, body included, for their positions (2, N)."""
        chain, body = self.chain, self.chain.tow.body
        d = np.diff(np.concatenate([positions, np.zeros((2, 1))], axis=1), axis=1).T
        halves = node_mass(chain.tow, chain.segment, d / np.linalg.norm(d, axis=1, keepdims=True))
        total = np.zeros((chain.count + 1, 2, 2))
        total[:-1] += halves
        total[1:] += halves
        total[0] += np.diag([body.mass + body.added_mass_surge, body.mass + body.added_mass_heave])
        return total

    def node_forces(self, state: Array, top: Array, force: Array) -> Array:
        """Forces on the nodes (2, N+1), N; ``top``: velocity of the towpoint through the water, m/s."""
        lower, upper = segment_forces(self.chain.tow, self.chain.segment, *self._ends(state, top), None)
        total = np.zeros((2, self.chain.count + 1))
        total[:, :-1] += lower
        total[:, 1:] += upper
        total[:, 0] += self.body_force(state[1, :, 0], force)[0]
        return total

    def tensions(self, state: Array) -> Array:
        """Tension of every segment, N, (N,), from the body on."""
        d = np.diff(np.concatenate([state[0], np.zeros((2, 1))], axis=1), axis=1)
        stretch = np.hypot(d[0], d[1]) / self.chain.segment - 1.0
        pull: Array = self.chain.tow.cable.axial_stiffness * np.maximum(0.0, stretch)
        return pull

    def angles(self, state: Array) -> Array:
        """phi of every segment, rad, in (-pi, pi], (N,)."""
        d = self.chain.tow.sign * np.diff(np.concatenate([state[0], np.zeros((2, 1))], axis=1), axis=1)
        phi: Array = np.arctan2(d[1], d[0])
        return phi

    def stream_angles(self, state: Array) -> Array:
        """Angle of every segment from the direction of the stream, rad, (N,): phi in Quadrant I, pi - phi in II."""
        phi = self.angles(state)
        return phi if self.chain.tow.sign > 0.0 else math.pi - phi

    def towpoint_force(self, state: Array, inputs: Array, acceleration: Array) -> Array:
        """Force of the cable on the towpoint, N, (2,), for the inputs, and the acceleration of the towpoint, m/s2."""
        top = inputs[:2] + np.array([self.chain.tow.speed, 0.0])
        force: Array = self.node_forces(state, top, inputs[2:])[:, -1] - self.mass(state[0])[-1] @ acceleration
        return force

    def _jacobian(self, state: Array, top: Array, weight: float, mass: Array, rate: float) -> Array:
        """Banded matrix (7, 2N) of M rate + C + K weight, K and C from the segments."""
        n = self.chain.count
        ends = self._ends(state, top)
        stacked = [np.repeat(e.astype(complex), 4, axis=1) for e in ends]
        for which in range(4):
            # column k of a segment's four: node (lower, upper), component (x, y)
            node, component = divmod(which, 2)
            stacked[node][component, which::4] += 1j * COMPLEX_STEP * weight
            stacked[2 + node][component, which::4] += 1j * COMPLEX_STEP
        lower, upper = segment_forces(
            self.chain.tow, self.chain.segment, stacked[0], stacked[1], stacked[2], stacked[3], None
        )
        local = -np.stack([lower[0], lower[1], upper[0], upper[1]]).imag.reshape(4, n, 4) / COMPLEX_STEP
        banded = np.zeros((7, 2 * n + 2))
        index = 2 * np.arange(n)
        for row in range(4):
            for column in range(4):
                banded[3 + row - column, index + column] += local[row, :, column]
        for i in range(2):
            for j in range(2):
                banded[3 + i - j, 2 * np.arange(n + 1) + j] += rate * mass[:, i, j]
        slope = self.body_force(state[1, :, 0], np.zeros(2))[1]
        for i in range(2):
            for j in range(2):
                banded[3 + i - j, j] -= slope[i, j]
        trimmed: Array = banded[:, : 2 * n]
        return trimmed

    def _stage(self, start: Array, weight: float, inputs: Array) -> Array | None:
        """State z = start + weight * z'(z), or None where Newton's method fails."""
        from scipy.linalg import solve_banded  # loads slowly, see `exact_step`

        top = inputs[:2] + np.array([self.chain.tow.speed, 0.0])
        state = start.copy()
        state[0] += weight * (state[1] - inputs[:2, None] - np.array([[self.chain.tow.speed], [0.0]]))
        for _ in range(MAX_ITERATIONS):
            mass = self.mass(state[0])
            forces = self.node_forces(state, top, inputs[2:])[:, :-1]
            residual = np.einsum("nij,jn->in", mass[:-1], state[1] - start[1]) / weight - forces
            band = self._jacobian(state, top, weight, mass, 1.0 / weight)
            change = solve_banded((3, 3), band, residual.T.ravel(), check_finite=False).reshape(-1, 2).T
            if not np.all(np.isfinite(change)):
                return None
            state[1] -= change
            state[0] = start[0] + weight * (state[1] - top[:, None])
            if np.abs(change).max() < TOLERANCE * self.chain.tow.speed:
                return state
        return None

    def step(self, time: float, step: float, state: Array, motion: Motion, halvings: int = 0) -> Array:
        """State after ``step``, s. Raises `CableError` where Newton's method fails at the smallest step."""
        weight = GAMMA * step
        # an iteration may run away before it is given up
        with np.errstate(all="ignore"):
            first = self._stage(state, weight, motion(time + weight))
            if first is not None:
                slope = (first - state) / weight
                second = self._stage(state + (1.0 - GAMMA) * step * slope, weight, motion(time + step))
                if second is not None:
                    return second
        if halvings == MAX_HALVINGS:
            raise CableError(f"the cable's motion was not found at t = {time:g} s with steps of {step:.3g} s")
        half = 0.5 * step
        middle = self.step(time, half, state, motion, halvings + 1)
        return self.step(time + half, half, middle, motion, halvings + 1)


def nonlinear_cable(tow: Tow, count: int, quadratic_drag: bool = True) -> NonlinearCable:
    """The tow with ``count`` segments. Raises `CableError` as `equilibrium`."""
    return NonlinearCable(equilibrium(tow, count), quadratic_drag)
