"""Periodic motions by Newton shooting on the stroboscopic map.

    P(x) = x(t + n T; x),    P(x*) = x*,    multipliers = eigenvalues of P'(x*)

T is the period of the forcing; n = 1 for the ordinary steady motion, more for subharmonics of a line that goes slack.
P is the flow of a `System`, with its events; its derivative is integrated along with it. The rates of the model are
differentiated by complex steps (f(x + i e d) = f(x) + i e f'(x) d with e = 1e-100, exact to round-off), and since they
are continuous across every event (drag reversal, slack, taut) the derivative of the flow has no jump there.

A line that is never slack has the symmetry y(t + T/2) = -y(t); shooting then runs over half a period to -x, which
stays well conditioned at small drag except at its true resonances. Multipliers are those of the whole period.

Assumptions: the forcing is periodic (ramp and docking of the parameters are left out).
Source: section 2 of the spec of the MIT thesis 1969 (reference orbits); register rows 7 to 22.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace

import numpy as np

from ..numeric.integrate import Vector
from ..numeric.ops import Ops
from .system import Simulation, System

_STEP = 1e-100

TANGENTS = Ops(
    # |.|, max and min follow the real part; the imaginary part carries a derivative
    sin=lambda a: cmath.sin(a) if isinstance(a, complex) else math.sin(a),
    cos=lambda a: cmath.cos(a) if isinstance(a, complex) else math.cos(a),
    exp=lambda a: cmath.exp(a) if isinstance(a, complex) else math.exp(a),
    sqrt=lambda a: cmath.sqrt(a) if isinstance(a, complex) else math.sqrt(a),
    abs=lambda a: a if a.real >= 0.0 else -a,
    atan2=math.atan2,
    minimum=lambda a, b: a if a.real < b.real else b,
    maximum=lambda a, b: a if a.real > b.real else b,
    where=lambda condition, a, b: a if condition else b,
)


class OrbitError(ArithmeticError):
    """No periodic orbit: the message says what was tried and how far it came."""


@dataclass(frozen=True)
class Orbit:
    """A periodic motion. ``period``: in forcing periods; ``section``: its states at t = 0, T, 2 T, ..., the first is
    ``state``; extremes of the cradle's heave, m, and of the tension, N; ``slack_fraction`` of the time and
    ``slack_events`` per orbit; ``amplitude``, m, and ``lag``, rad in (-pi, pi], of the component at the forcing
    frequency, y = A sin(omega t - lag); ``residual``: |P(x) - x| over the scale of the motion."""

    period: int
    section: tuple[Vector, ...]
    multipliers: tuple[complex, ...]
    heave_max: float
    heave_min: float
    tension_max: float
    slack_fraction: float
    slack_events: int
    amplitude: float
    lag: float
    residual: float

    @property
    def state(self) -> Vector:
        """The state at t = 0."""
        return self.section[0]

    @property
    def stable(self) -> bool:
        """All multipliers inside the unit circle."""
        return max(map(abs, self.multipliers)) < 1.0


def flow(system: System, x: Vector, t: float, *, t_start: float = 0.0, rtol: float = 1e-13) -> Vector:
    """The state at ``t``, s."""
    return Simulation(system, t_start, x, rtol=rtol).advance(t)


def tangent_flow(
    system: System, x: Vector, t: float, directions: np.ndarray, *, rtol: float = 1e-13
) -> tuple[Vector, np.ndarray]:
    """(state at ``t``, derivative of it along the columns of ``directions``, to 1e-8)."""
    n, columns = len(x), directions.shape[1]
    modes: list[float] = [1.0, 0.0]
    rates = system.rates(modes, TANGENTS)

    def tail_rates(t: float, x: Vector, branch: list[float]) -> tuple[float, ...]:
        modes[:] = branch
        out: list[float] = []
        for j in range(columns):
            d = x[n + j * n : 2 * n + j * n]
            z = [complex(a, _STEP * b) for a, b in zip(x, d)]
            out.extend(value.imag / _STEP for value in rates(t, z))
        return tuple(out)

    start = tuple(map(float, directions.T.ravel()))
    run = Simulation(system, 0.0, x, rtol=rtol, tail=start, tail_rates=tail_rates)
    run.advance(t)
    return run.state, np.array(run.x[n:]).reshape(columns, n).T


def periodic(system: System) -> System:
    """Without ramp and docking: forced periodically from the start."""
    return replace(system, ship=replace(system.ship, ramp_time=0.0), cradle=replace(system.cradle, docking_time=-1.0))


def distance(system: System, a: Vector, b: Vector) -> float:
    """Largest difference of two states over the scales of their components."""
    scales = np.maximum(system.scales(a), system.scales(b))
    return float(np.max(np.abs(np.subtract(a, b)) / scales))


def shoot(system: System, x: Vector, period: int = 1, *, limit: int = 40) -> tuple[Vector, np.ndarray, float]:
    """(x*, derivative of the map over the whole orbit, residual) from the guess ``x`` by damped Newton steps, over
    ``period`` forcing periods. Raises `OrbitError` after ``limit`` steps or where no step helps."""
    system = periodic(system)
    mirrored = system.never_slack and period == 1 and system.line.static_tension == system.cradle.weight_in_water
    sign, length = (-1.0, 0.5 * system.period) if mirrored else (1.0, period * system.period)
    identity = np.eye(len(x))

    def defect(x: Vector) -> tuple[np.ndarray, np.ndarray, float]:
        end, slope = tangent_flow(system, x, length, identity)
        r = sign * np.array(end) - np.array(x)
        return r, sign * slope, float(np.max(np.abs(r) / system.scales(x)))

    r, slope, size = defect(x)
    for _ in range(limit):
        if size <= 1e-13:
            break
        try:
            step = np.linalg.solve(identity - slope, r)
        except np.linalg.LinAlgError as error:
            raise OrbitError(f"the map over {period} periods has a multiplier of exactly 1 at {x}") from error
        if size < 1e-7:  # one more step with this slope reaches round-off at the price of a plain flow
            trial = tuple(map(float, np.array(x) + step))
            r = sign * np.array(flow(system, trial, length)) - np.array(trial)
            refined = float(np.max(np.abs(r) / system.scales(trial)))
            if refined < 1e-3 * size or refined < 1e-12:
                return trial, slope @ slope if mirrored else slope, refined
        for share in (1.0, 0.5, 0.25, 0.1, 0.03, 0.01):
            trial = tuple(map(float, np.array(x) + share * step))
            r_new, slope_new, size_new = defect(trial)
            if size_new < (1.0 - 0.3 * share) * size:
                break
            if size < 1e-11:  # round-off: no step can help
                return x, slope @ slope if mirrored else slope, size
        else:
            raise OrbitError(
                f"shooting over {period} periods stalls at {x}: residual {size:.1e} of the motion's scale; begin nearer"
            )
        x, r, slope, size = trial, r_new, slope_new, size_new
    if size > 1e-9:
        raise OrbitError(f"{limit} shooting steps over {period} periods leave {size:.1e} of the motion's scale at {x}")
    return x, slope @ slope if mirrored else slope, size


def orbit_at(system: System, x: Vector, period: int = 1) -> Orbit:
    """The orbit next to the guess ``x``, of ``period`` forcing periods or a divisor of it."""
    system = periodic(system)
    x, slope, residual = shoot(system, x, period)
    t1, omega, at = system.period, 2.0 * math.pi / system.period, 2 if system.two_way else 0

    def harmonic(t: float, x: Vector, modes: list[float]) -> tuple[float, ...]:
        return x[at] * math.sin(omega * t), x[at] * math.cos(omega * t)

    run = Simulation(system, 0.0, x, tail=(0.0, 0.0), tail_atol=1e-13 * system.scales(x)[0], tail_rates=harmonic)
    section = [x]
    for k in range(1, period):
        section.append(run.advance(k * t1))
    for divisor in range(1, period):
        if period % divisor == 0 and distance(system, section[divisor], x) < 1e-8:
            return orbit_at(system, x, divisor)
    run.advance(period * t1)
    sine, cosine = (2.0 * value / (period * t1) for value in run.x[-2:])
    return Orbit(
        period=period,
        section=tuple(section),
        multipliers=tuple(map(complex, np.linalg.eigvals(slope))),
        heave_max=run.heave_max,
        heave_min=run.heave_min,
        tension_max=run.tension_max,
        slack_fraction=run.slack_time / (period * t1),
        slack_events=run.slack_events,
        amplitude=math.hypot(sine, cosine),
        lag=math.atan2(-cosine, sine),
        residual=residual,
    )
