"""How wrong the linear tow is: the nonlinear equations solved from its motion, over a time that repeats.

    R(y) = M(r) r'' - f(r, r') = 0,   y = (angle, rad, and tension, N, of every segment),   r_j = r_N - sum l (1 + T/EA) e
    L y1 = -(M v_N' + C v_N) + f_body                the linear tow
    L (y_{k+1} - y_k) = -R(y_k)                      its correction, L at every frequency of the time that repeats

R is that of ``forces.py`` at large angles, drag in any direction, slack. L is the linearisation of ``lumped.py``. The first
correction holds all terms of second order (mean shift, second harmonic, sums and differences of frequencies) and a part of
the higher ones; further ones converge to the nonlinear motion wherever the motion is small enough. Angles and tensions
as unknowns keep EA, which may be infinite, out of the products.

Assumptions: (1) to (4) of ``cable/case.py``; (5) no internal damping of the cable; (6) the motion repeats.

Not to be confused with Newton's method in time (``cable/wire/stepper.py``): L is factorised once a frequency.

Source: Picard's iteration as in harmonic balance with a constant operator; equations of the small-perturbation report on
towed cables, discretised as in ``forces.py``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array, ComplexArray
from ..case import Tow
from .forces import node_mass, segment_forces
from .lumped import Chain, matrices, steady_towpoint_force

KEPT = 2.0 / 3.0
"""Share of the frequencies that corrections have: products of the others would be taken for lower ones."""
DIVERGED = 10.0
"""Size of a correction, over the linear amplitude, that is given up."""


@dataclass(frozen=True)
class Motion:
    """Changes from the steady tow at the times of the drive: tensions at both ends, N, (n,), and position of the body from the
    towpoint, forward and up, m, (2, n)."""

    tension_top: Array
    tension_body: Array
    body: Array


@dataclass(frozen=True)
class Corrections:
    """The ``linear`` motion and the nonlinear one after one correction and more; ``last``: size of the last one over the
    linear amplitude (`apart`), ``shrinks``: over the one before it, below 1 where they converge."""

    linear: Motion
    corrected: tuple[Motion, ...]
    last: float
    shrinks: float


class Picard:
    """A tow of ``chain`` driven at the times 0, ``step``, ... (s; ``times`` of them), after which all repeats, smaller by the
    ``decay``, 1/s, of the whole time: with enough of it a tow starts from rest, however slightly damped."""

    def __init__(self, chain: Chain, quadratic_drag: bool, step: float, times: int, decay: float = 0.0) -> None:
        self.chain, self.quadratic, self.times = chain, quadratic_drag, times
        self.decay = decay * step
        self.weight = np.exp(-self.decay * np.arange(times))
        self.rates = decay + 2j * math.pi * np.fft.rfftfreq(times, step)
        self.kept = int(KEPT * len(self.rates))
        x, y = chain.steps
        self.angle, self.tension = np.arctan2(y, x), chain.tension
        self.compliance = chain.segment / chain.tow.cable.axial_stiffness
        moves, pulls = self._unknowns(np.hypot(x, y))
        m, n = matrices(chain, elastic=False), chain.count
        mass, damping, everywhere = m.mass.copy(), m.damping.copy(), np.tile(np.eye(2), (n + 1, 1))
        mass[:2, :2] += m.body_mass
        damping[:2, :2] += m.body_damping
        s = self.rates[: self.kept, None, None]
        whole = s * s * (mass @ moves) + s * (damping @ moves) + (m.stiffness @ moves + pulls)
        driven = s * (mass @ everywhere) + damping @ everywhere
        self.inverse = np.linalg.inv(whole[:, :-2])
        self.driven, self.top, self.top_driven, self.moves = driven[:, :-2], whole[:, -2:], driven[:, -2:], moves[:2]
        self.steady = np.array(steady_towpoint_force(chain))

    def _unknowns(self, length: Array) -> tuple[Array, Array]:
        """(2N+2, 2N) each: displacements of the nodes by angles, rad, and tensions, N, and what the tensions take from R."""
        n = self.chain.count
        along = np.stack([np.cos(self.angle), np.sin(self.angle)])
        across = np.stack([-along[1], along[0]])
        moves, pulls = np.zeros((2, 2 * n + 2, 2 * n))
        for k in range(n):
            moves[: 2 * k + 2, k] = np.tile(-length[k] * across[:, k], k + 1)
            moves[: 2 * k + 2, n + k] = np.tile(-self.compliance[k] * along[:, k], k + 1)
            pulls[2 * k : 2 * k + 4, n + k] = np.concatenate([-along[:, k], along[:, k]])
        return moves, pulls

    def _spectrum(self, values: Array) -> ComplexArray:
        """(kept, m) of values in time (m, n)."""
        spectrum: ComplexArray = np.fft.rfft(values * self.weight)[:, : self.kept].T
        return spectrum

    def _values(self, spectrum: ComplexArray) -> Array:
        """(m, n) in time of (kept, m)."""
        values: Array = np.fft.irfft(spectrum.T, self.times) / self.weight
        return values

    def _rate(self, values: Array) -> Array:
        rate: Array = np.fft.irfft(self.rates * np.fft.rfft(values * self.weight), self.times) / self.weight
        return rate

    def residual(self, y: Array, drive: Array) -> tuple[Array, Array]:
        """(R of all nodes (2, N+1, n), N, the last: minus the force on the towpoint; the body from the towpoint (2, n), m) for
        changes y (2N, n) and the ``drive`` (4, n): velocity of the towpoint, m/s, force on the body, N."""
        chain, n = self.chain, self.chain.count
        angle, tension = self.angle[:, None] + y[:n], self.tension[:, None] + y[n:]
        direction = np.stack([np.cos(angle), np.sin(angle)])
        stretched = direction * (chain.segment[:, None] + self.compliance[:, None] * tension)
        nodes = np.concatenate([-np.cumsum(stretched[:, ::-1], axis=1)[:, ::-1], np.zeros((2, 1, self.times))], axis=1)
        steady = (chain.nodes - chain.nodes[-1]).T
        velocity = self._rate(nodes - steady[:, :, None]) + drive[:2, None]
        acceleration = self._rate(velocity)
        velocity[0] += chain.tow.speed
        ends = (nodes[:, :-1], nodes[:, 1:], velocity[:, :-1], velocity[:, 1:])
        lower, upper, lower_velocity, upper_velocity = (part.reshape(2, -1) for part in ends)
        # a slack segment pulls nothing
        pull = np.maximum(0.0, tension).ravel()
        segment = np.repeat(chain.segment, self.times)
        forces = segment_forces(chain.tow, segment, lower, upper, lower_velocity, upper_velocity, pull)
        halves = node_mass(chain.tow, segment, direction.reshape(2, -1).T).reshape(n, self.times, 2, 2)
        r = np.zeros((2, n + 1, self.times))
        for part, force in zip((slice(None, -1), slice(1, None)), forces):
            r[:, part] += np.einsum("ktij,jkt->ikt", halves, acceleration[:, part]) - force.reshape(2, n, -1)
        body = chain.tow.body
        inertia = np.array([[body.mass + body.added_mass_surge], [body.mass + body.added_mass_heave]])
        r[:, 0] += inertia * acceleration[:, 0] - body_force(chain.tow, self.quadratic, velocity[:, 0], drive[2:])
        return r, nodes[:, 0]

    def between(self, values: Array, parts: int) -> Array:
        """Values at the times (..., n) as they are at ``parts`` times as many: peaks lie between the times."""
        count = parts * self.times
        fine = np.fft.irfft(np.fft.rfft(values * self.weight), count) * parts
        found: Array = fine * np.exp(self.decay / parts * np.arange(count))
        return found

    def run(self, drive: Array, most: int = 8, enough: float = 1e-3) -> Corrections:
        """Corrections until one changes tensions and body by less than ``enough`` of the linear amplitude, at most ``most``.
        ``drive`` (4, n): velocity of the towpoint, m/s, forward and up, and force on the body, N."""
        n, (top, force) = self.chain.count, (self._spectrum(drive[:2]), self._spectrum(drive[2:]))
        sides = -np.einsum("fij,fj->fi", self.driven, top)
        sides[:, :2] += force
        spectrum = np.einsum("fij,fj->fi", self.inverse, sides)
        pull = -np.einsum("fij,fj->fi", self.top, spectrum) - np.einsum("fij,fj->fi", self.top_driven, top)
        size, y = np.hypot(*self.steady), self._values(spectrum)
        linear = Motion((self.steady / size) @ self._values(pull), y[n], self._values(spectrum @ self.moves.T))
        start = (self.chain.nodes[0] - self.chain.nodes[-1])[:, None]
        found, sizes = [linear], [math.inf]
        r, _ = self.residual(y, drive)
        while len(found) <= most and (len(sizes) < 3 or sizes[-1] >= enough):
            off = self._spectrum(r[:, :-1].swapaxes(0, 1).reshape(2 * n, -1))
            spectrum = spectrum - np.einsum("fij,fj->fi", self.inverse, off)
            y = self._values(spectrum)
            r, body = self.residual(y, drive)
            found.append(Motion(np.hypot(*r[:, -1]) - size, y[n], body - start))
            sizes.append(max(apart(found[-1], found[-2], linear)))
            if not sizes[-1] < DIVERGED:
                break
        return Corrections(linear, tuple(found[1:]), sizes[-1], sizes[-1] / sizes[-2] if sizes[-2] else 0.0)


def body_force(tow: Tow, quadratic_drag: bool, velocity: Array, force: Array) -> Array:
    """Force on the body but for the cable's, N, (2, n)."""
    body, c = tow.body, tow.speed
    buoyant = np.array([[0.0], [body.lift - body.weight]]) + force
    slope = np.array([[body.damping_surge], [body.damping_heave]])
    drag: Array = np.array([[body.drag], [0.0]]) + slope * (velocity - np.array([[c], [0.0]]))
    if quadratic_drag:
        drag = body.drag / (c * c) * np.hypot(*velocity) * velocity
    total: Array = buoyant - drag
    return total


def apart(one: Motion, two: Motion, linear: Motion) -> tuple[float, float, float]:
    """Largest difference of tension at the top, tension at the body and position of the body, each over the largest linear."""

    def share(a: Array, b: Array, whole: Array) -> float:
        size = float(np.abs(whole).max()) if whole.ndim == 1 else float(np.hypot(*whole).max())
        gap = float(np.abs(a - b).max()) if whole.ndim == 1 else float(np.hypot(*(a - b)).max())
        return gap / size if size else (math.inf if gap else 0.0)

    return (
        share(one.tension_top, two.tension_top, linear.tension_top),
        share(one.tension_body, two.tension_body, linear.tension_body),
        share(one.body, two.body, linear.body),
    )
