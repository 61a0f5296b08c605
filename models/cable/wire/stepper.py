"""Motion of a chain in time: implicit steps whose size follows the error, Newton's method with kept factors.

    r' = u,   R(r, u, u', t) = 0    (``chain.py``);   stage:  u = u^ + w k,  r = r^ + w u,   R(r, u, k, t) = 0,  w = h gamma

Newton's method solves for the accelerations k with M + w C + w^2 K, factorised anew where an iteration falls by less than
`SLOW`, or where w changes. A stage that does not converge halves the step. The error of a step is that of the velocities by
the embedded method, taken through M (M + w C + w^2 K)^-1, so that modes too fast for the step do not shorten it.

A `State` is all there is: the same state, drive and step give the same result to the last bit. For that it names where its
factors were made; they are made again where they are not at hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...numeric.arrays import Array
from ..case import CableError
from .chain import Chain, Drive, Paid
from .jacobian import derivatives
from .matrix import Factors, factorised
from .tableaus import THIRD, Tableau

Motion = Callable[[float], Drive]
"""What is done to the wire at a time, s."""

Made = tuple[Array, Array, Array, float, Paid]
"""(Positions, velocities, accelerations, w, wire paid out) of factors."""

SLOW = 0.3
MAX_ITERATIONS = 10
MAX_HALVINGS = 20
NEWTON = 1e-3
"""Newton's change of velocity over the tolerance of the step."""
RUNAWAY, DIVERGING = 1e6, 2.0
"""A change of velocity, m/s, and a growth of changes at which an iteration is given up."""
SAFETY, LEAST, MOST = 0.85, 0.2, 3.0
"""The next step is the one that the error asks for times the first, a change between the others."""
LESS = 0.9
"""A step that is refused becomes shorter by this at least."""
NO_ERROR = 1e-12
"""An error over the tolerance below which a step grows no faster."""
ROUNDING, END = 1e-9, 1e-12
"""Shares of a step, and of a span, that are none."""
PATIENCE, PROGRESS = 10_000, 0.01
"""A span is given up where so many steps do less than this share of it: a million at most."""
WORTH = 1.2
"""A step that would grow by less keeps its factors."""


@dataclass(frozen=True)
class State:
    """``position``, m, ``velocity``, m/s, ``acceleration``, m/s2, of the nodes, (n, d); ``step``: the next one, s (0: not
    known); ``made``: where the kept factors are of; ``before``: length of the last step and accelerations before it."""

    position: Array
    velocity: Array
    acceleration: Array
    step: float = 0.0
    made: Made | None = None
    before: tuple[float, Array] | None = None


def _same(one: Made, other: Made) -> bool:
    return one is other or (one[3:] == other[3:] and all(np.array_equal(a, b) for a, b in zip(one[:3], other[:3])))


def _extrapolated(known: list[tuple[float, Array]], place: float) -> Array:
    """The polynomial through accelerations at places of the step, at another: a first guess."""
    total = np.zeros_like(known[0][1])
    for j, (x, values) in enumerate(known):
        total += values * math.prod((place - y) / (x - y) for i, (y, _) in enumerate(known) if i != j)
    return total


@dataclass
class Stepper:
    """Of ``chain``; ``tolerance``: error of the velocities a step, m/s; ``largest`` step, s. Counts what it did."""

    chain: Chain
    tolerance: float = 1e-4
    largest: float = math.inf
    tableau: Tableau = THIRD
    evaluations: int = 0
    factorisations: int = 0
    steps: int = 0
    failures: int = 0
    rejections: int = 0
    _kept: tuple[Made, Factors, Array] | None = None

    def _factorise(self, made: Made) -> bool:
        """Factors of a place; False where there are none."""
        stiff, damp, mass = derivatives(self.chain, *made[:3], made[4])
        weight = made[3]
        factors = factorised(mass + weight * (damp + weight * stiff), self.chain.free)
        self.factorisations += 1
        self._kept = None if factors is None else (made, factors, mass)
        return factors is not None

    def _placed(self, u0: Array, r0: Array, k: Array, weight: float, drive: Drive) -> tuple[Array, Array]:
        """(r, u) of a stage with accelerations k, the ends where the drive has them."""
        u = u0 + weight * k
        r = r0 + weight * u
        r[-1], u[-1], k[-1] = drive[:3]
        if drive.lower is not None:
            r[0], u[0], k[0] = drive.lower
        return r, u

    def _stage(
        self, r0: Array, u0: Array, guess: Array, weight: float, drive: Drive
    ) -> tuple[Array, Array, Array] | None:
        """(r, u, k), or None."""
        k, last, free, fresh = guess.copy(), math.inf, self.chain.free, 0
        target = NEWTON * self.tolerance
        for _ in range(MAX_ITERATIONS):
            r, u = self._placed(u0, r0, k, weight, drive)
            if self._kept is None and not self._factorise((r, u, k.copy(), weight, drive.paid)):
                return None
            assert self._kept is not None
            self.evaluations += 1
            change = self._kept[1].solve(self.chain.needed(r, u, k, drive)[free])
            size = float(np.abs(change).max()) * weight
            rate = size / last
            if not size < RUNAWAY or rate > DIVERGING:
                if fresh == 2:
                    return None
                # back, with factors of the first guess
                k, last, self._kept, fresh = guess.copy(), math.inf, None, 2
                continue
            k[free] -= change
            # what the iterations to come would still change
            left = 0.1 if last == math.inf else rate / (1.0 - rate) if rate < 0.5 else 1.0
            if size * left < target:
                return (*self._placed(u0, r0, k, weight, drive), k)
            if rate > SLOW and last < math.inf:
                self._kept = None
                last = math.inf
            else:
                last = size
        return None

    def _attempt(self, t: float, h: float, state: State, motion: Motion) -> tuple[State, float] | None:
        """(State after the step, error over the tolerance), or None where a stage failed."""
        table, weight = self.tableau, self.tableau.diagonal * h
        made = state.made
        if made is None or made[3] != weight:
            self._kept = None
        elif self._kept is None or not _same(self._kept[0], made):
            self._factorise(made)
        us, ks, known = [state.velocity], [state.acceleration], [(0.0, state.acceleration)]
        if state.before is not None:
            known = [(-state.before[0] / h, state.before[1]), *known]
        r, u, k = state.position, state.velocity, state.acceleration
        for place, row in zip(table.places, table.rows):
            k = _extrapolated(known[-3:], place)
            r0 = state.position + h * sum(a * x for a, x in zip(row, us))
            u0 = state.velocity + h * sum(a * x for a, x in zip(row, ks))
            stage = self._stage(r0, u0, k, weight, motion(t + place * h))
            if stage is None:
                return None
            r, u, k = stage
            us.append(u)
            ks.append(k)
            known.append((place, k))
        assert self._kept is not None
        made, factors, inertia = self._kept
        raw = h * np.tensordot(np.array(table.error), np.array(ks), 1)
        points = self.chain.gather(raw)
        size = points[0].size
        force = self.chain.scatter((inertia.reshape(-1, size, size) @ points.reshape(-1, size, 1)).reshape(points.shape))
        error = float(np.abs(factors.solve(force[self.chain.free])).max()) / self.tolerance
        return State(r, u, k, state.step, made, (h, state.acceleration)), error

    def step(self, t: float, h: float, state: State, motion: Motion) -> tuple[State, float]:
        """(State after one step of ``h``, s, at most; its length). Raises `CableError` where no step is found."""
        most, factorised_before = MOST, self.factorisations
        for _ in range(MAX_HALVINGS):
            with np.errstate(all="ignore"):
                tried = self._attempt(t, h, state, motion)
            if tried is None:
                self.failures += 1
                most, h = 1.0, 0.5 * h
                continue
            after, error = tried
            grow = SAFETY * max(error, NO_ERROR) ** (-1.0 / self.tableau.order)
            if error > 1.0:
                self.rejections += 1
                h *= min(LESS, max(LEAST, grow))
                continue
            self.steps += 1
            if self.factorisations > factorised_before + len(self.tableau.rows):
                # Newton's method is at its end
                most = 1.0
            return replace(after, step=h * min(most, grow)), h
        raise not_found(t, h)

    def advance(self, t: float, span: float, state: State, motion: Motion) -> State:
        """State after ``span``, s, in as many steps as the tolerance asks for. Raises `CableError` where no step is found, or
        only ones so short that they lead nowhere (`PATIENCE`)."""
        done, counted, reached = 0.0, 0, 0.0
        while done < span * (1.0 - END):
            left, before = span - done, state.step
            asked = min(before if before > 0.0 else 0.1 * left, self.largest)
            # equal steps to the end, so that factors are kept
            h = left / math.ceil(left / asked - ROUNDING)
            state, h = self.step(t + done, h, state, motion)
            done, counted = done + h, counted + 1
            if counted % PATIENCE == 0:
                if done - reached < PROGRESS * span:
                    raise not_found(t + done, h)
                reached = done
            wanted = min(state.step, self.largest)
            if wanted >= h:
                # shortened by the end of the span, or not worth new factors
                wanted = max(before, wanted) if h < asked else (wanted if wanted > WORTH * h else h)
            state = replace(state, step=wanted)
        return state


def not_found(t: float, h: float) -> CableError:
    """Of a motion at ``t`` whose last step was ``h``, s."""
    return CableError(
        f"the wire's motion was not found at t = {t:g} s, with steps down to {h:.3g} s: a tension or a speed changes "
        f"faster than that, or the wire is folded; give the wire internal damping, or make the motion smoother"
    )


def consistent(chain: Chain, r: Array, u: Array, drive: Drive) -> State:
    """State with the accelerations that positions and velocities ask for."""
    zero, free = np.zeros_like(r), chain.free
    mass = derivatives(chain, r, u, zero, drive.paid)[2]
    factors = factorised(mass, free)
    if factors is None:
        raise CableError("the wire has a node without mass")
    k = zero.copy()
    k[free] = -factors.solve(chain.needed(r, u, zero, drive)[free])
    k[-1] = drive.acceleration
    return State(r, u, k)
