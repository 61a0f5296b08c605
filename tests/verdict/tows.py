"""Random tows, and how wrong the linear theory is on them: the truth, by the nonlinear cable in time.

    python -m tests.verdict.tows 30 --seed 1        # a table of 30 tows, true error against bound, and the summary

Ranges: cable 50 to 3000 m, 0.3 to 8 m/s, body 30 to 5000 kg with 0.2 to 20 kN in water (at most 0.87 m g), 6 to 25 mm of
thickness, bare, faired or by the cross-flow principle; v/c of the towpoint 0.02 to 0.4, 0.05 to 0.3 Hz, heave, or surge
too; two in five are irregular. All but a few choices are log-uniform. Tows that do not hang inside the quadrant with the segments
of the truth are drawn again.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from towage.checks.linearity import margin_of
from towage.models.cable.case import Body, Cable, CableError, Tow
from towage.models.cable.loading import cross_flow, eames
from towage.models.cable.lumped.linear import tow_elastic
from towage.models.cable.lumped.linearity import Linearity, recorded
from towage.models.cable.lumped.lumped import equilibrium
from towage.models.cable.lumped.nonlinear import GAMMA, nonlinear_cable
from towage.models.protocol.physical import GRAVITY
from towage.result.records import Margin
from towage.result.result import Result

SEGMENTS, POINTS, RAMP, PERIODS, IRREGULAR_PERIODS = 20, 40, 4, 14, 30
"""Of the truth: segments, steps and periods of the ramp, of a regular and of an irregular run."""
TOLERANCE = 0.05
DENSITY = 1025.0


@dataclass(frozen=True)
class RandomTow:
    """A tow; velocity of its towpoint as complex amplitudes of (surge, heave), m/s, (k, 2), at ``omega``, rad/s, (k,)."""

    tow: Tow
    omega: np.ndarray
    amplitudes: np.ndarray

    @property
    def period(self) -> float:
        """s, of the middle component."""
        return 2.0 * math.pi / float(self.omega[len(self.omega) // 2])

    def drive(self, t: float) -> np.ndarray:
        """Velocity of the towpoint, m/s, and force on the body, N, (4,)."""
        s = min(1.0, t / (RAMP * self.period))
        wave = (self.amplitudes * np.exp(-1j * self.omega * t)[:, None]).sum(axis=0).real
        return np.array([*(s**3 * (10.0 - 15.0 * s + 6.0 * s * s) * wave), 0.0, 0.0])


@dataclass(frozen=True)
class Truth:
    """Relative errors of the linear model against the nonlinear cable, as `Linearity`, and the drive that they are of."""

    tension_top: float
    tension_body: float
    motion: float
    shift: float
    time: np.ndarray
    drive: np.ndarray
    settle: float

    @property
    def error(self) -> float:
        """The largest, but for the shift of the mean depth."""
        return max(self.tension_top, self.tension_body, self.motion)


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.random())


def draw(rng: np.random.Generator) -> RandomTow:
    """A tow that hangs inside its quadrant."""
    while True:
        tow = _tow(rng)
        try:
            equilibrium(tow, SEGMENTS)
        except CableError:
            continue
        return RandomTow(tow, *_drive(rng, tow.speed))


def _tow(rng: np.random.Generator) -> Tow:
    speed, mass, thickness = log_uniform(rng, 0.3, 8.0), log_uniform(rng, 30.0, 5000.0), log_uniform(rng, 0.006, 0.025)
    area, density = 0.25 * math.pi * thickness**2, log_uniform(rng, 2500.0, 6500.0)
    kind = rng.choice(["bare", "faired", "cross_flow"], p=[0.5, 0.2, 0.3])
    friction = log_uniform(rng, 0.02, 0.06)
    loading = cross_flow(friction) if kind == "cross_flow" else eames(0.35 if kind == "faired" else friction)
    drag_coefficient = 0.25 if kind == "faired" else log_uniform(rng, 1.0, 2.0)
    cable = Cable(
        log_uniform(rng, 50.0, 3000.0), density * area, (density - DENSITY) * GRAVITY * area, thickness, drag_coefficient,
        loading, axial_stiffness=log_uniform(rng, 2e10, 8e10) * area,
    )  # fmt: skip
    weight = log_uniform(rng, 200.0, min(20e3, 0.87 * mass * GRAVITY))
    drag = 0.5 * DENSITY * speed**2 * log_uniform(rng, 0.1, 1.0) * (mass / 2000.0) ** (2.0 / 3.0)
    surge, heave = log_uniform(rng, 0.05, 0.3) * mass, log_uniform(rng, 0.1, 0.8) * mass
    body = Body(mass, surge, heave, weight, 0.0, drag, 2.0 * drag / speed, drag / speed)
    return Tow(cable, body, speed, DENSITY)


def _drive(rng: np.random.Generator, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and amplitudes: one, or sixteen of a narrow spectrum with its significant amplitude as that of the one."""
    velocity, middle = speed * log_uniform(rng, 0.02, 0.4), 2.0 * math.pi * log_uniform(rng, 0.05, 0.3)
    turn = rng.choice([0.0, 0.3, 1.2]) * math.pi / 2.0
    direction = np.array([math.sin(turn) * np.exp(1j * rng.random()), math.cos(turn)])
    if rng.random() < 0.6:
        return np.array([middle]), velocity * direction[None, :]
    omega = middle * np.linspace(0.7, 1.5, 16)
    size = np.exp(-(((omega / middle - 1.0) / 0.2) ** 2))
    phases = np.exp(2j * math.pi * rng.random(16))
    return omega, (velocity / math.sqrt(2.0 * (size**2).sum()) * size * phases)[:, None] * direction


def truth(case: RandomTow, segments: int = SEGMENTS) -> Truth:
    """The linear and the nonlinear cable of these segments, side by side from the steady tow."""
    step = case.period / POINTS
    count = (PERIODS if len(case.omega) == 1 else IRREGULAR_PERIODS) * POINTS
    time = step * np.arange(count + 1)
    drive = np.array([case.drive(t) for t in time]).T
    settle = time[RAMP * POINTS]
    one, two = _nonlinear(case, segments, step, count), _linear(case, segments, step, count)
    late = time >= settle
    top = np.cumsum(drive[:2], axis=1) * step

    def share(change: np.ndarray, whole: np.ndarray) -> float:
        return float(np.linalg.norm(np.atleast_2d(change), axis=0).max() / np.linalg.norm(np.atleast_2d(whole), axis=0).max())

    def about(body: np.ndarray) -> np.ndarray:
        moved = (body + top)[:, late]
        return moved - moved.mean(axis=1, keepdims=True)

    shift = (one[3] - two[3])[late].mean() / np.abs(about(two[2:])[1]).max()
    return Truth(
        share((one[0] - two[0])[late], two[0][late]), share((one[1] - two[1])[late], two[1][late]),
        share(about(one[2:]) - about(two[2:]), about(two[2:])), float(abs(shift)), time, drive, float(settle),
    )  # fmt: skip


def _slope(case: RandomTow, t: float) -> np.ndarray:
    """Rate of the drive, (4,)."""
    small, before = 1e-4 * case.period, max(0.0, t - 1e-4 * case.period)
    return (case.drive(t + small) - case.drive(before)) / (t + small - before)


def _nonlinear(case: RandomTow, segments: int, step: float, count: int) -> np.ndarray:
    """(4, count+1): changes of tension at the top and of the first segment, N, body from the towpoint, m."""
    cable = nonlinear_cable(case.tow, segments)
    state, rows = cable.start(), []
    for k in range(count + 1):
        t = k * step
        force = cable.towpoint_force(state, case.drive(t), _slope(case, t)[:2])
        rows.append([math.hypot(*force), cable.tensions(state)[0], *state[0, :, 0]])
        state = cable.step(t, step, state, case.drive)
    found = np.array(rows).T
    return found - found[:, :1]


def _linear(case: RandomTow, segments: int, step: float, count: int) -> np.ndarray:
    """As `_nonlinear`, by the same two stages, so that only linearity differs."""
    model = tow_elastic(case.tow, segments)
    stage = np.linalg.inv(np.eye(len(model.a)) - GAMMA * step * model.a)
    x, rows = np.zeros(len(model.a)), []
    for k in range(count + 1):
        t = k * step
        rows.append((model.c @ x + model.d @ case.drive(t) + model.e @ _slope(case, t))[[7, 8, 4, 5]])
        first = stage @ (x + GAMMA * step * (model.b @ case.drive(t + GAMMA * step)))
        between = x + (1.0 - GAMMA) / GAMMA * (first - x)
        x = stage @ (between + GAMMA * step * (model.b @ case.drive(t + step)))
    return np.array(rows).T


def judged(case: RandomTow, found: Truth) -> tuple[float, str, Linearity]:
    """(bound, word, all errors) by the check of a run, for the drive of the truth."""
    errors = recorded(case.tow, True, found.time, found.drive, found.settle)
    return errors.bound, margin_of("tow", errors, TOLERANCE, ()).word, errors


def word_of(result: Result, unit: str = "tow") -> tuple[float, str]:
    """(bound of the error, word) that a run's premises give to the linear tow ``unit``."""
    margin: Margin = next(m for m in result.margins if m.variable == f"{unit}.margin_small_perturbation")
    limit = margin.limit or TOLERANCE
    return limit * (1.0 - margin.worst), margin.word


def sample(seed: int, count: int) -> Iterator[tuple[RandomTow, Truth, float, str]]:
    """Cases with their truth, bound and word; one whose truth fails is left out, and said on the error stream."""
    for k in range(count):
        case = draw(np.random.default_rng([seed, k]))
        try:
            found = truth(case)
        except CableError as error:
            print(f"{k}: no truth: {error}", file=sys.stderr)
            continue
        bound, word, _ = judged(case, found)
        yield case, found, bound, word


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description="Bounds of the linear tow against the nonlinear cable, on random tows.")
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    ratios, tally = [], dict.fromkeys(("false valid", "false invalid", "not judged", "marginal", "valid", "invalid"), 0)
    print("   L m   c m/s  m kg   W N  v/c   T s  kind       top   body  motion shift   true  bound word")
    for case, found, bound, word in sample(chosen.seed, chosen.count):
        tow, kind = case.tow, "regular" if len(case.omega) == 1 else "irregular"
        velocity = float(np.linalg.norm(found.drive[:2], axis=0).max())
        ratios.append(bound / found.error)
        tally[word] += 1
        tally["false valid"] += word == "valid" and found.error > TOLERANCE
        tally["false invalid"] += word == "invalid" and found.error < 0.5 * TOLERANCE
        print(
            f"{tow.cable.length:6.0f} {tow.speed:6.2f} {tow.body.mass:6.0f} {tow.body.weight:6.0f} {velocity / tow.speed:5.2f} "
            f"{case.period:5.1f} {kind:9s} {found.tension_top:6.3f} {found.tension_body:6.3f} {found.motion:6.3f} "
            f"{found.shift:6.3f} {found.error:6.3f} {bound:6.3f} {word}",
            flush=True,
        )
    print(f"{len(ratios)} tows: bound over true error {min(ratios):.2f} to {max(ratios):.2f}, "
          f"median {statistics.median(ratios):.2f}; {tally}")  # fmt: skip


if __name__ == "__main__":
    main()
