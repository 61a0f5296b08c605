"""The response of a lift, a ship with a cradle on a line, over frequency: exact periodic orbits, not describing functions.

One orbit a frequency, followed from the lowest up; where the line goes slack on the way the curve is followed down again
too, because two motions may then exist for one sea (section 2 of the thesis; `models.heave.orbits`). Limits are the heave
of the ship at which the line just goes slack, and at which it just breaks: amplitudes are raised from small ones, so the
limit is that of the motion which a growing sea reaches.

Source: MIT thesis 1969, Figures 5, 6 and 8 and the table of Alvin, by integration instead of equivalent linearisation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from towage.errors import SceneError
from towage.frequency_response.response import save_rows
from towage.models.heave.orbits import Aperiodic, Orbit, OrbitError, at_frequency, attractors, response_from, steady
from towage.models.heave.system import System
from towage.models.numeric.integrate import IntegrationError
from towage.scene.monolithic import monolithic
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import select
from towage.units.store import locator

LOWEST, HIGHEST, POINTS = 0.02, 0.3, 40
"""Default frequencies: from, to, Hz, and how many, in equal ratios: the waves that a ship heaves in."""
LARGEST_HEAVE = 30.0
"""m: limits are looked for up to this heave of the ship, beyond any sea."""


@dataclass(frozen=True)
class Point:
    """The motion at one frequency. ``branch``: "up" or "down", from which side it was followed; ``period`` in periods of
    the ship; ``amplitude``, m, and ``lag``, rad, of the first harmonic of the cradle; ``transmissibility``: amplitude over
    the ship's; extremes, m and N; ``slack_fraction`` of the time; ``note``: why there is no motion to report."""

    frequency_hz: float
    branch: str
    period: int = 0
    stable: bool = False
    amplitude: float = math.nan
    transmissibility: float = math.nan
    lag: float = math.nan
    heave_max: float = math.nan
    heave_min: float = math.nan
    tension_max: float = math.nan
    slack_fraction: float = math.nan
    note: str = ""


@dataclass(frozen=True)
class Limit:
    """Amplitudes of the ship's heave, m, at which the line goes slack and at which it breaks; infinite beyond
    `LARGEST_HEAVE`; nan, with ``note``, where the motion could not be followed so far or the line has no breaking load."""

    frequency_hz: float
    slack: float
    breaking: float
    note: str = ""


@dataclass(frozen=True)
class LiftResponse:
    """The response of a lift at the heave of its ship, ``amplitude``, m."""

    amplitude: float
    points: tuple[Point, ...]
    limits: tuple[Limit, ...] = ()
    motions: tuple[Orbit | Aperiodic, ...] = ()

    def rows(self) -> list[dict[str, Any]]:
        """A row a frequency and branch, with the fields of `Point`; None for what is not known."""
        return [_known(point) for point in self.points]

    def limit_rows(self) -> list[dict[str, Any]]:
        """A row a frequency, with the fields of `Limit`; None for what is not known or beyond."""
        return [_known(limit) for limit in self.limits]

    def save(self, directory: Path) -> list[Path]:
        """Writes ``lift_response.csv`` and ``.svg``, and with limits ``lift_limits.csv``. Raises `TowageError`."""
        from towage.frequency_response.plots import lift_plot

        files = [directory / f"lift_{name}" for name in ("response.csv", "response.svg", "limits.csv")]
        save_rows(files[0], self.rows())
        lift_plot(files[1], self)
        if not self.limits:
            return files[:2]
        save_rows(files[2], self.limit_rows())
        return files

    def text(self, most: int = 16) -> str:
        """Tables for a terminal, of about ``most`` of the frequencies."""
        lines = [f"heave of the ship {self.amplitude:.4g} m",
                 "      Hz branch  over ship's  lag, rad   heave, m: max      min   tension, N  slack, %"]  # fmt: skip
        for p in self.points[:: max(1, len(self.points) // most)]:
            numbers = (
                f"{p.transmissibility:13.5g}{p.lag:10.4f}{p.heave_max:16.5g}{p.heave_min:9.4g}{p.tension_max:13.6g}"
                f"{100.0 * p.slack_fraction:10.3g}{'' if p.stable else '  unstable'}"
            )
            lines.append(f"{p.frequency_hz:8.4g} {p.branch:6s}{p.note or numbers}")
        if self.limits:
            lines += ["      Hz   slack from, m   breaks from, m"]
        lines += [f"{lim.frequency_hz:8.4g}{lim.slack:16.5g}{lim.breaking:17.5g}  {lim.note}" for lim in self.limits]
        return "\n".join([*lines, *map(_in_words, self.motions)])


def _known(record: Point | Limit) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in asdict(record).items()}


def _in_words(motion: Orbit | Aperiodic) -> str:
    if isinstance(motion, Aperiodic):
        kind = "chaotic" if motion.chaotic else "no orbit of at most 16 periods within 400"
        return f"a motion from {tuple(map(float, motion.initial_state))}: {kind}, Lyapunov exponent {motion.lyapunov:.3g}"
    return (
        f"a motion of {motion.period} period{'s' * (motion.period > 1)}: heave {motion.heave_min:.5g} to "
        f"{motion.heave_max:.5g} m, tension up to {motion.tension_max:.6g} N, "
        f"slack {100.0 * motion.slack_fraction:.3g} % of the time"
    )


def lift_response(
    scene: Scene | str | Path,
    case: str | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    frequencies: ArrayLike | None = None,
    limits: bool = False,
    starts: int = 0,
    fmus: str | Path | None = None,
) -> LiftResponse:
    """The response of a scene of a ship, a line and a cradle: what ``towage response`` does for a lift.

    ``scene``, ``case``, ``set`` and ``fmus`` as in `towage.response`. ``frequencies``: Hz, by default 40 from 0.02 to 0.3.
    ``limits``: the heave of the ship too at which the line goes slack and breaks, some 20 orbits a frequency. ``starts``:
    that many squared states, up to twice the heave of the ship and its velocity, are followed to their motions at the
    scene's own period. Raises `SceneError` for a scene of another kind, or one whose ship does not heave.
    """
    chosen = select(scene, case, set)
    system = monolithic(described(chosen, locator(Path(fmus) if fmus else None), open_ends=True))
    hertz = np.geomspace(LOWEST, HIGHEST, POINTS) if frequencies is None else np.atleast_1d(np.asarray(frequencies, float))
    if hertz.ndim != 1 or not len(hertz) or not (np.isfinite(hertz) & (hertz > 0.0)).all():
        raise SceneError("frequencies: expected finite numbers of Hz, above 0")
    heave = abs(float(system.ship.heave_amplitude))
    if not heave > 0.0:
        raise SceneError("the ship does not heave, so nothing responds: expected heave_amplitude above 0",
                         file=chosen.file, key="units.heave_amplitude")  # fmt: skip
    rising: list[float] = sorted(map(float, hertz))
    points = _curve(system, rising, "up")
    if any(point.slack_fraction > 0.0 or point.note for point in points):
        points += _curve(system, rising[::-1], "down")
    found = tuple(_limit(system, f) for f in rising) if limits else ()
    return LiftResponse(heave, tuple(points), found, _motions(system, starts) if starts else ())


def _curve(system: System, hertz: Sequence[float], branch: str) -> list[Point]:
    """One orbit a frequency, each begun at its neighbour's."""
    points, last = [], None
    for f in hertz:
        here = at_frequency(system, 2.0 * math.pi * f)
        try:
            orbit = steady(here) if last is None else response_from(here, last.state)
        except (OrbitError, IntegrationError) as error:
            points.append(Point(f, branch, note=str(error)))
            last = None
            continue
        points.append(
            Point(
                f, branch, orbit.period, orbit.stable, orbit.amplitude, orbit.amplitude / abs(system.ship.heave_amplitude),
                orbit.lag, orbit.heave_max, orbit.heave_min, orbit.tension_max, orbit.slack_fraction,
            )
        )  # fmt: skip
        last = orbit
    return points


def _limit(system: System, hertz: float) -> Limit:
    """Heave of the ship at which the line goes slack, and breaks, at one frequency."""
    here = at_frequency(system, 2.0 * math.pi * hertz)
    weight, bears = float(here.line.static_tension), float(here.line.breaking_load)
    # until it is slack the line is a spring that could push, and its orbit is symmetric
    rod = replace(here, line=replace(here.line, never_slack=1.0))
    notes = []

    def reached(kind: System, tension: float) -> float:
        try:
            heave = _amplitude_of(kind, tension)
        except (OrbitError, IntegrationError) as error:
            notes.append(str(error))
            return math.nan
        if heave == math.inf:
            notes.append(f"no tension of {tension:.4g} N up to {LARGEST_HEAVE:g} m of heave")
        return heave

    slack = reached(rod, 2.0 * weight) if weight > 0.0 else 0.0
    if not bears > 0.0:
        return Limit(hertz, slack, math.nan, "; ".join([*notes, "the line has no breaking load"]))
    return Limit(hertz, slack, reached(rod if bears <= 2.0 * weight else here, bears), "; ".join(notes))


def _amplitude_of(system: System, tension: float) -> float:
    """The ship's heave, m, at which the largest tension is ``tension``, N, raised from small motions in equal ratios and
    then narrowed by regula falsi on logarithms. Raises `OrbitError`."""
    from scipy.optimize import brentq

    start = 1e-3 * float(system.line.static_tension or tension) / system.stiffness
    last: list[Orbit] = []

    def excess(heave: float) -> float:
        here = replace(system, ship=replace(system.ship, heave_amplitude=heave))
        orbit = response_from(here, last[-1].state if last else (0.0,) * len(here.start()))
        last.append(orbit)
        return orbit.tension_max / tension - 1.0

    low, value = start, excess(start)
    if value >= 0.0:
        return 0.0
    while low < LARGEST_HEAVE:
        high = 2.0 * low
        if excess(high) >= 0.0:
            root: float = brentq(_of_logarithm(excess), math.log(low), math.log(high), xtol=1e-6)
            return math.exp(root)
        low = high
    return math.inf


def _of_logarithm(function: Callable[[float], float]) -> Callable[[float], float]:
    return lambda x: function(math.exp(x))


def _motions(system: System, starts: int) -> tuple[Orbit | Aperiodic, ...]:
    """The motions that ``starts`` squared states reach at the scene's own period."""
    speed = abs(system.ship.heave_amplitude) * 2.0 * math.pi / system.period
    sides = np.linspace(-2.0, 2.0, starts)
    states = [(y * abs(system.ship.heave_amplitude), v * speed) for y, v in itertools.product(sides, sides)]
    orbits, others = attractors(system, [(0.0, 0.0, *s) if system.two_way else s for s in states])
    return orbits + others
