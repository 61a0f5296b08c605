"""The simplified method beside the simulation: most probable maxima of a linear response in a Gaussian sea.

    y/z = K/(K - M w^2 + i w c),   T - W = K (z - y),   c = c0 + sqrt(8/pi) b s_v
    x_max = s sqrt(2 ln n),   P(max <= x) = (1 - exp(-x^2/(2 s^2)))^n,   n = t/Tz,   Tz = 2 pi s/s'

| symbol | meaning | unit |
|---|---|---|
| z, y | heave of the point that holds the line, of the body | m |
| K, M, W | stiffness of the line, mass with added mass, weight in water | N/m, kg, N |
| c0, b | linear damping, drag per squared velocity | N s/m, kg/m |
| s, s', s_v | standard deviation of a response and of its rate; of the body's velocity | |
| w | frequency of encounter | rad/s |
| t, n | length of the record, number of its zero upcrossings | s, - |

Assumptions: (1) the line stays taut; (2) the line does not move the ship; (3) the drag is the linear one that takes the same
power from a Gaussian motion (stochastic linearisation), so that it is too small at the peaks; (4) peaks of a narrow band.

A sum of n components of fixed amplitudes a_i is not quite Gaussian: its excess of kurtosis is
k = -3/2 sum a_i^4 / (sum a_i^2)^2, and its extremes are lower, to the first order (Edgeworth, Cornish and Fisher) by
k (u^3 - 3 u)/24 standard deviations at u of them. `Screening.deficit` is that share at the quantile asked for, of the heave of
the point that holds the line; in `cage_300m` at 9 s it foretells 6.3 % for 100 components, where 1020 h of records show 6.5 %
(``benchmarks/extremes.py``).

It is made for a scene of ship_in_sea, spring_line and cradle, and for the ship's own motion; for any other criterion it says
that it was not. Source: DNV-RP-H103 (2011), section 5 (amplification of a lowered object) and most probable largest responses;
stochastic linearisation: T. K. Caughey, J. Acoust. Soc. Am. 35 (1963) 1706-1711.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from towage.models.sea.heave_response import Hull
from towage.models.sea.kernel import Ship, answers, by_hull, by_table
from towage.models.sea.motion import POINT, Sea, encounter
from towage.models.sea.seas import Shape, sea_components
from towage.operability.cells import Cells
from towage.operability.extremes import Extreme
from towage.operability.outcome import FAILS, HOLDS, Cell, Outcome
from towage.scene.files import declared
from towage.scene.resolve import ResolvedScene
from towage.sweeps.criteria import Criterion

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
LOOPS = 200
"""Of the linearisation: each takes the damping half way to what the velocity asks for."""


@dataclass(frozen=True)
class Screening:
    """``outcome``: cells and limits of the linear response for the criteria that it knows, in their order; None where it knows
    none. ``missing``: what was left out, and why. ``deficit``: by which share extremes of the point's heave are too low, as the
    sea has so few components: the mean over the time, and the largest of cells with a thousandth of it; NaN: not known."""

    outcome: Outcome | None
    missing: tuple[str, ...]
    deficit: tuple[float, float] = (math.nan, math.nan)


class Lift(NamedTuple):
    """The units of a lift, and K, M, c0, b, W."""

    line: str
    body: str
    stiffness: float
    mass: float
    damping: float
    drag: float
    weight: float


def screened(resolved: ResolvedScene, plan: Cells, criteria: Sequence[Criterion], probability: float) -> Screening:
    """The linear response in all cells of the plan."""
    lift = _lift(resolved, plan.unit)
    known = {f"{plan.unit}.heave", f"{plan.unit}.velocity"}
    if lift:
        known |= {f"{lift.line}.{name}" for name in ("tension", "reaction", "stretch", "margin_taut")}
        known |= {f"{lift.body}.{name}" for name in ("heave", "velocity")}
    able = tuple(one for one in criteria if one.name in known)
    reason = (
        "no linear response of it is known" if lift else "the scene is no lift of ship_in_sea, spring_line and cradle"
    )
    missing = tuple(f"{one.text}: {reason}" for one in criteria if one.name not in known)
    if "ship_in_sea" not in resolved.units[plan.unit].description.model_name:
        return Screening(None, ("the sea is not that of ship_in_sea",))
    waves = _Waves(resolved, plan)
    deficit = _deficit(waves, plan, probability)
    if not able:
        return Screening(None, missing, deficit)
    cells = []
    for heading, height, period in _all_places(plan):
        response = waves.at(heading, height, period)
        extremes = tuple(_extreme(response, lift, plan, one, probability) for one in able)
        passed = [one.text for one, e in zip(able, extremes) if not one.holds(e.quantile)]
        share = float(plan.scatter.share[height, period])
        word = FAILS if passed else HOLDS
        cells.append(Cell(heading, height, period, share, word, True, "; ".join(passed), extremes, math.nan, ""))
    return Screening(Outcome(plan, able, probability, tuple(cells)), missing, deficit)


def _deficit(waves: _Waves, plan: Cells, probability: float) -> tuple[float, float]:
    """Mean over the time and largest of the shares by which the sea's components lower the extremes of the heave."""
    mean, largest = 0.0, 0.0
    for heading, height, period in _all_places(plan):
        motion = waves.at(heading, height, period)
        squares = np.abs(motion.amplitude * motion.heave) ** 2
        deviation = motion.deviation(motion.heave)
        if not deviation > 0.0:
            continue
        kurtosis = -1.5 * float((squares**2).sum()) / float(squares.sum()) ** 2
        n = max(1.0, plan.length * motion.deviation(motion.heave, 1) / (2.0 * math.pi * deviation))
        u = math.sqrt(-2.0 * math.log(-math.expm1(math.log(probability) / n)))
        share = plan.headings.shares[heading] * float(plan.scatter.share[height, period])
        off = -kurtosis * (u * u - 3.0) / 24.0
        mean += share * off
        largest = max(largest, off if plan.scatter.share[height, period] >= 1e-3 else 0.0)
    return mean, largest


def _all_places(plan: Cells) -> list[tuple[int, int, int]]:
    own = plan.places.tolist()
    return [(k, i, j) for k, run in enumerate(plan.run) for of, i, j in own if of == run]


class _Motion(NamedTuple):
    """In one cell: frequencies of encounter, rad/s, amplitudes of the waves, m, and the point's heave per metre of wave."""

    omega: Array
    amplitude: Array
    heave: Complex

    def deviation(self, transfer: Complex, power: int = 0) -> float:
        """Standard deviation of a response or, with ``power`` 1, of its rate."""
        squares = (np.abs(self.omega) ** power * self.amplitude * np.abs(transfer)) ** 2
        return math.sqrt(0.5 * float(squares.sum()))


class _Waves:
    """The sea and the ship's answer to it, by heading and period; both are per metre of significant height."""

    def __init__(self, resolved: ResolvedScene, plan: Cells) -> None:
        self._plan = plan
        p = _values(resolved, plan.unit)
        kind = declared(resolved.scene, plan.unit).model.Parameters
        self._shape = Shape(*(float(p[name]) for name in Shape._fields))
        self._spectrum, table = getattr(kind, "spectrum", None), getattr(kind, "responses", None)
        hull = Hull(p["length"], p["breadth"] * p["block_coefficient"], p["draught"], p["smith_oblique"])
        ship = Ship(hull, (p["point_x"], p["point_y"], p["point_z"]))
        self._answer = by_table(table, ship) if table else by_hull(ship)
        self._speed = float(p["speed"])
        self._made: dict[tuple[int, int], _Motion] = {}

    def at(self, heading: int, height: int, period: int) -> _Motion:
        """The motion in a cell."""
        key = self._plan.run[heading], period
        if key not in self._made:
            direction = self._plan.headings.angles[key[0]]
            sea = Sea(1.0, 2.0 * math.pi / float(self._plan.peaks[period]), direction, self._speed)
            components = sea_components(self._shape, self._spectrum, 0)
            heave = np.array(answers(self._answer, POINT + 2, sea, components))
            self._made[key] = _Motion(np.array(encounter(sea, components)), np.array(components.amplitude), heave)
        one = self._made[key]
        return one._replace(amplitude=float(self._plan.scatter.heights[height]) * one.amplitude)


def _values(resolved: ResolvedScene, unit: str) -> dict[str, Any]:
    entry = resolved.units[unit]
    start = {v.name: v.start for v in entry.description.variables if v.causality in ("parameter", "input")}
    return {**start, **entry.parameters}


def _lift(resolved: ResolvedScene, ship: str) -> Lift | None:
    """The lift, if the scene is one."""
    kinds = {name: unit.description.model_name for name, unit in resolved.units.items()}
    lines = [name for name, kind in kinds.items() if kind == "spring_line"]
    bodies = [name for name, kind in kinds.items() if kind == "cradle"]
    if len(lines) != 1 or len(bodies) != 1:
        return None
    (line,), (body,) = lines, bodies
    joined = {str(c) for c in resolved.connections if not c.changed}
    wanted = {f"{ship}.heave -> {line}.heave_top", f"{body}.heave -> {line}.heave_bottom",
              f"{line}.tension -> {body}.line_tension"}  # fmt: skip
    if not wanted <= joined:
        return None
    k, m = _values(resolved, line), _values(resolved, body)
    stiffness = k["stiffness"] or k["axial_stiffness"] / k["length"]
    drag = 0.5 * m["water_density"] * m["drag_area"] * m["drag_coefficient"]
    return Lift(line, body, stiffness, m["mass"] + m["added_mass"], m["linear_damping"], drag, k["static_tension"])


def _body(motion: _Motion, lift: Lift) -> Complex:
    """The body's heave per metre of wave."""
    omega, damping = motion.omega, lift.damping
    heave: Complex = motion.heave
    for _ in range(LOOPS):
        heave = motion.heave * lift.stiffness / (lift.stiffness - lift.mass * omega**2 + 1j * omega * damping)
        wanted = lift.damping + math.sqrt(8.0 / math.pi) * lift.drag * motion.deviation(heave, 1)
        if abs(wanted - damping) <= 1e-9 * wanted:
            break
        damping = 0.5 * (damping + wanted)
    return heave


def _extreme(motion: _Motion, lift: Lift | None, plan: Cells, one: Criterion, probability: float) -> Extreme:
    """Most probable extreme and quantile of what a criterion looks at."""
    unit, _, variable = one.name.partition(".")
    mean, factor, power = 0.0, 1.0, 1 if variable == "velocity" else 0
    transfer = motion.heave
    if lift and unit == lift.body:
        transfer = _body(motion, lift)
    elif lift and unit == lift.line:
        transfer = lift.stiffness * (motion.heave - _body(motion, lift))
        mean = lift.weight if variable in ("tension", "stretch", "margin_taut") else 0.0
        factor = {"stretch": 1.0 / lift.stiffness, "margin_taut": 1.0 / (lift.weight or math.nan)}.get(variable, 1.0)
    deviation, rate = motion.deviation(transfer, power), motion.deviation(transfer, power + 1)
    if not deviation > 0.0:
        value = factor * mean
        passed = float(not one.holds(value))
        return Extreme(value, value, value, value, passed, passed, passed, math.nan, "linear")
    n = max(1.0, plan.length * rate / (2.0 * math.pi * deviation))
    side = 1.0 if one.upper else -1.0
    peak = deviation * math.sqrt(2.0 * math.log(n))
    # 1 - q^(1/n) without cancellation
    largest = deviation * math.sqrt(-2.0 * math.log(-math.expm1(math.log(probability) / n)))
    room = side * (one.limit / factor - mean) / deviation
    single = math.exp(-0.5 * room * room) if room > 0.0 else 1.0
    passed = -math.expm1(n * math.log1p(-single)) if single < 1.0 else 1.0
    quantile = factor * (mean + side * largest)
    return Extreme(
        factor * (mean + side * peak), quantile, quantile, quantile, passed, passed, passed, math.nan, "linear"
    )
