"""Steady motions of a system: orbits, response curves and their peaks, attractors, chaos.

    x(t + n T) = x(t)

An orbit is found by `shooting`, from a guess (equivalent linear drag, a neighbour on a curve) or from where a motion
settles. Where a line goes slack several motions may exist for one sea, and none of them need be periodic: `attractors`
follows each of a set of initial states to its orbit, or reports the largest Lyapunov exponent of the motion instead,
which tells chaos from a long transient. Finding all attractors is not claimed, only those of the states given.

Source: sections 2 and 5 of the spec of the MIT thesis 1969 (peak curve, attractors, chaos); register rows 7 to 22.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from ..numeric.integrate import IntegrationError, Vector
from ..numeric.ops import FLOATS
from . import cradle, linear
from .shooting import Orbit, OrbitError, distance, flow, orbit_at, periodic, shoot, tangent_flow
from .system import System

__all__ = [
    "CHAOS", "Aperiodic", "Orbit", "OrbitError", "at_frequency", "attractors", "lyapunov", "orbit_at", "peak",
    "response_curve", "steady",
]  # fmt: skip

CHAOS = 0.03
"""Lyapunov exponent per period beyond which a motion counts as chaotic (spec, section 2, attractors)."""


@dataclass(frozen=True)
class Aperiodic:
    """A motion without an orbit of the periods looked for: chaotic where ``lyapunov``, 1/period, exceeds `CHAOS`,
    else a transient longer than was followed."""

    initial_state: Vector
    state: Vector
    lyapunov: float

    @property
    def chaotic(self) -> bool:
        """Whether nearby motions separate."""
        return self.lyapunov > CHAOS


def at_frequency(system: System, omega: float) -> System:
    """``system`` with forcing at ``omega``, rad/s."""
    if system.two_way and system.force_amplitude != 0.0:
        return replace(system, force_frequency=omega)
    return replace(system, ship=replace(system.ship, heave_period=2.0 * math.pi / omega))


def _harmonic_guess(system: System) -> Vector:
    """The steady state of the equivalent linear drag."""
    mass, drag = cradle.calculated(system.cradle, FLOATS)
    x0, omega = system.ship.heave_amplitude, 2.0 * math.pi / system.period
    size, lag = linear.lorentz(mass, drag, system.stiffness, x0, omega)
    lag -= system.ship.heave_phase
    return -size * math.sin(lag), size * omega * math.cos(lag)


def steady(system: System, start: Vector | None = None, *, limit: int = 600) -> Orbit:
    """The orbit of one forcing period: next to ``start`` if given; else, for a line that is never slack, the symmetric
    one (harmonic guess, then continuation from larger drag); else the one that is reached from the start parameters,
    followed for up to ``limit`` periods. Raises `OrbitError`."""
    system = periodic(system)
    if start is not None:
        return orbit_at(system, start)
    if system.never_slack and not system.two_way:
        try:
            return orbit_at(system, _harmonic_guess(system))
        except (OrbitError, IntegrationError):
            return orbit_at(system, _from_larger_drag(system))
    found = _follow(system, system.start(), (), 1, limit)
    if isinstance(found, Aperiodic):
        kind = "chaotic" if found.chaotic else "no orbit of one period"
        raise OrbitError(
            f"from {system.start()} the motion is {kind} after {limit} periods "
            f"(Lyapunov exponent {found.lyapunov:.3g} per period); `attractors` looks for longer periods"
        )
    return found


def _from_larger_drag(system: System, factor: float = 2.0) -> Vector:
    mass, drag = cradle.calculated(system.cradle, FLOATS)
    number = drag * abs(system.ship.heave_amplitude) / mass
    if not number > 0.0:
        raise OrbitError("without drag there is no steady motion at a resonance, and none was found elsewhere")
    count = max(1, math.ceil(math.log(max(factor, 10.0 / number), factor)))
    x: Vector | None = None
    for k in range(count, -1, -1):
        denser = replace(system.cradle, water_density=system.cradle.water_density * factor**k)
        harder = replace(system, cradle=denser)
        x, _, _ = shoot(harder, _harmonic_guess(harder) if x is None else x)
    assert x is not None
    return x


def _follow(
    system: System, start: Vector, known: Sequence[Orbit], max_period: int, limit: int, chaos_periods: int = 150
) -> Orbit | Aperiodic:
    """The attractor that the motion from ``start`` reaches."""
    history = [start]
    next_try = 5
    for k in range(1, limit + 1):
        history.append(flow(system, history[-1], system.period, rtol=1e-10))
        x = history[-1]
        for orbit in known:
            if any(distance(system, x, point) < 1e-4 for point in orbit.section):
                return orbit
        if k < next_try:
            continue
        for period in range(1, min(max_period, k) + 1):
            if distance(system, x, history[-1 - period]) < 1e-2:
                next_try = k + 5
                try:
                    orbit = orbit_at(system, x, period)
                except (OrbitError, IntegrationError):
                    break
                near = min(distance(system, x, point) for point in orbit.section)
                if orbit.stable and near < 0.05:
                    return orbit
                break
    return Aperiodic(start, history[-1], lyapunov(system, history[-1], chaos_periods))


def lyapunov(system: System, x: Vector, periods: int) -> float:
    """Largest Lyapunov exponent per forcing period, averaged over ``periods`` from ``x``."""
    system = periodic(system)
    direction = np.ones((len(x), 1)) / math.sqrt(len(x))
    total = 0.0
    for _ in range(periods):
        x, grown = tangent_flow(system, x, system.period, direction, rtol=1e-10)
        size = float(np.linalg.norm(grown))
        total += math.log(size) if size > 0.0 else -700.0
        direction = grown / size if size > 0.0 else direction
    return total / periods


def attractors(
    system: System, initial_states: Sequence[Vector], *, max_period: int = 16, limit: int = 400
) -> tuple[tuple[Orbit, ...], tuple[Aperiodic, ...]]:
    """(distinct stable orbits, motions without one) reached from ``initial_states``, each followed for up to
    ``limit`` forcing periods and taken for an orbit of at most ``max_period`` of them."""
    system = periodic(system)
    orbits: list[Orbit] = []
    others: list[Aperiodic] = []
    for start in initial_states:
        found = _follow(system, tuple(map(float, start)), orbits, max_period, limit)
        if isinstance(found, Aperiodic):
            others.append(found)
        elif not any(distance(system, found.state, point) < 1e-6 for orbit in orbits for point in orbit.section):
            orbits.append(found)
    return tuple(orbits), tuple(others)


def response_curve(system: System, frequencies: Sequence[float]) -> list[Orbit]:
    """One orbit for each forcing frequency, rad/s, each begun at its neighbour's: a branch is followed as far as it
    goes, so that the curve may depend on the order of the frequencies. Where it ends `steady` begins anew."""
    orbits: list[Orbit] = []
    for omega in frequencies:
        here = at_frequency(system, omega)
        orbits.append(response_from(here, orbits[-1].state) if orbits else steady(here))
    return orbits


def peak(
    system: System,
    low: float,
    high: float,
    quantity: Callable[[Orbit], float] = lambda orbit: orbit.heave_max,
    *,
    points: int = 25,
) -> tuple[float, Orbit]:
    """(omega, orbit) with the largest ``quantity`` for forcing frequencies between ``low`` and ``high``, rad/s.

    ``points`` on a grid, then Brent's search, then the maximum of a Chebyshev interpolant of degree 10 over 1 % of the
    frequency, which gives the place to ten digits where the curve is smooth; at a kink Brent's place stays (1e-8)."""
    grid = [float(omega) for omega in np.linspace(low, high, points)]
    curve = response_curve(system, grid)
    best = max(range(points), key=lambda k: quantity(curve[k]))
    guess = curve[best].state

    def value(omega: float) -> float:
        return quantity(response_from(at_frequency(system, omega), guess))

    bounds = (grid[max(best - 1, 0)], grid[min(best + 1, points - 1)])
    omega = float(minimize_scalar(lambda w: -value(w), bounds=bounds, method="bounded", options={"xatol": 1e-5}).x)
    width = 0.005 * omega
    if bounds[0] < omega - width and omega + width < bounds[1]:
        fit: Any = np.polynomial.Chebyshev.interpolate(
            lambda nodes: np.array([value(float(w)) for w in nodes]), 10, (omega - width, omega + width)
        )
        roots = [w.real for w in fit.deriv().roots() if abs(w.imag) < 1e-9 and abs(w.real - omega) < 0.5 * width]
        if len(roots) == 1 and abs(fit(roots[0]) - value(roots[0])) < 1e-10 * abs(fit(roots[0])):
            omega = float(roots[0])
    return omega, response_from(at_frequency(system, omega), guess)


def response_from(system: System, guess: Vector) -> Orbit:
    """The orbit next to ``guess`` where there is one, else `steady`."""
    try:
        return steady(system, guess)
    except (OrbitError, IntegrationError):
        return steady(system)
