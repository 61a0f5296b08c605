"""The paper on minimal-time ship routing: every figure, and what its programs do, of ``routing.toml``.

Its two voyages cannot be sailed again, for their seas are not printed; its programs are shown on the shipped route ``storm``.
"""

from __future__ import annotations

from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from towage.errors import TowageError
from towage.models.numeric.ops import FLOATS
from towage.models.route.grid import Axis, Layers
from towage.models.route.maps import EARTH_RADIUS, StereographicMap
from towage.models.route.polar import FOOT, KNOT, JamesPolar
from towage.reproduce import plots
from towage.reproduce.items import Answer, Column
from towage.routing.chart import draw as chart
from towage.routing.output import HOUR, MILE
from towage.routing.route import PlannedRoute, route

Array = NDArray[np.float64]
MESH = 381e3
"""At 60 degrees, m."""
FEET = (0.0, 10.0, 20.0, 30.0, 40.0)
NAME = "storm"
BY = "the extremal of the program and the Hamiltonian form by DOP853"
EVERY = 6.0
"""Hours between two maps."""


def figure_1() -> Answer:
    """Ellipses; the wave comes from the right."""
    angles = np.linspace(0.0, 2.0 * np.pi, 181)
    columns: dict[str, Column] = {"angle, deg": np.degrees(angles)}
    drawn = {}
    for feet in FEET:
        a, b, c = (float(v) / KNOT for v in JamesPolar().axes(feet * FOOT, FLOATS)[:3])
        along, across = a * np.cos(angles) - c, b * np.sin(angles)
        columns |= {f"along the waves, kn, {feet:g} ft": along, f"across, kn, {feet:g} ft": across}
        drawn[f"{feet:g} ft"] = (along, across)
    draw = partial(
        plots.loops, title="Speeds, the waves coming from the right", across="kn against the waves", up="kn", series=drawn
    )
    return Answer({}, columns, draw)


def figure_2() -> Answer:
    """v_h = a - c, v_b = b sqrt(1 - c^2/a^2), v_f = a + c."""
    feet = np.linspace(0.0, 48.0, 193)
    speeds = np.array([_speeds(float(h)) for h in feet])
    best = minimize_scalar(lambda h: -_speeds(h)[2], bounds=(0.0, 20.0), method="bounded", options={"xatol": 1e-10})
    columns: dict[str, Column] = {"height, ft": feet}
    columns |= {name: speeds[:, k] for k, name in enumerate(("head waves, kn", "beam waves, kn", "following waves, kn"))}
    draw = partial(plots.curves, title="P2-S2-R2", across="wave height, ft", up="speed, kn", columns=columns)
    note = f"In following waves of {best.x:.2f} ft; in calm water 19.3 kn."
    return Answer({"largest speed": complex(-best.fun)}, columns, draw, note=note)


def map() -> Answer:
    """From the mesh and the radius of the earth that belongs to it."""
    plane, earth = StereographicMap(), EARTH_RADIUS / MESH
    equator = earth * (1.0 + np.sin(np.pi / 3.0))
    numbers = {"radius of the equator": equator, "Re^2": equator**2, "2 Re R": 2.0 * equator * earth}
    scale = float(plane.scale(0.0, 5.0 * MESH)[0])
    other = (equator**2 + 25.0) / (2.0 * equator * earth)
    columns: dict[str, Column] = {"what": list(numbers), "computed": list(numbers.values())}
    by = "the program's map and equation (2)"
    return Answer({k: complex(v) for k, v in numbers.items()}, columns, None, abs(scale / other - 1.0), by)


def halved_corrections() -> Answer:
    """The source's iteration with all of its corrections, with half of them, and the safeguarded one."""
    names, hours, iterations = [], [], []
    for name, fraction in (("whole corrections", 1.0), ("halved corrections", 0.5)):
        names.append(name)
        try:
            best = route(NAME, method="seed", fraction=fraction).plan.best
            hours.append(best.duration / HOUR)
            iterations.append(float(best.iterations))
        except TowageError:  # it goes on in a divergent oscillation, as the paper says
            hours.append(np.nan)
            iterations.append(np.nan)
    best = _best().plan.best
    columns: dict[str, Column] = {
        "method": [*names, "safeguarded"], "voyage, h": [*hours, best.duration / HOUR],
        "iterations": [*iterations, float(best.iterations)],
    }  # fmt: skip
    note = (
        "nan: no convergence. The halved corrections find a local minimum "
        f"{hours[1] - best.duration / HOUR:.2f} h behind the best one."
    )
    return Answer({}, columns, None, _integrated(), BY, note)


def contours() -> Answer:
    """Wave height, the way the waves travel, and the tracks, every six hours."""
    found = _best()
    best = found.plan.best
    hours = np.arange(EVERY, best.duration / HOUR, EVERY)
    columns: dict[str, Column] = {
        "time, h": hours, "x, m": np.interp(hours * HOUR, best.time, best.x), "y, m": np.interp(hours * HOUR, best.time, best.y),
    }  # fmt: skip
    shown = tuple(hours[1::3])
    draw = partial(_draw, found=found, hours=shown)
    return Answer({}, columns, draw, note=f"The route {NAME}; drawn every {3 * EVERY:g} h, the table every {EVERY:g} h.")


def fronts() -> Answer:
    """Where extremals that leave the start in directions 3 degrees apart are after every six hours."""
    best = _best().plan.best
    assert best.track is not None
    middle = float(best.track.normal[0])
    times = np.arange(0.0, best.duration, EVERY * HOUR)
    fan = np.array([_extremal(middle + np.radians(turn), times) for turn in range(-60, 61, 3)])
    columns: dict[str, Column] = {"time, h": np.repeat(times / HOUR, len(fan))}
    columns |= {f"{name}, nmi": fan[:, k].T.ravel() / MILE for k, name in enumerate("xy")}
    series = {f"{t / HOUR:g} h": (fan[:, 0, k] / MILE, fan[:, 1, k] / MILE) for k, t in enumerate(times) if k}
    draw = partial(plots.loops, title="Places of equal time", across="x, nmi", up="y, nmi", series=series)
    note = "Where a front crosses itself the storm has focused the tracks: those beyond are no longer the fastest."
    return Answer({}, columns, draw, _integrated(), BY, note)


def straight() -> Answer:
    """The straight track and the geodesic beside the best one."""
    found = _best()
    plan = found.plan
    assert plan.straight and plan.geodesic
    kinds = {"straight": plan.straight, "geodesic": plan.geodesic, "best": plan.best}
    columns: dict[str, Column] = {"track": list(kinds), "voyage, h": [r.duration / HOUR for r in kinds.values()]}
    return Answer({}, columns, note=f"The best track saves {100.0 * (plan.saving or 0.0):.2f} % of the straight one's time.")


def interpolation() -> Answer:
    """P(x) F P'(y)/256 and P(t)/16 as printed, beside the program's interpolation, at random places of random fields."""
    chance = np.random.default_rng(1964)
    data = chance.uniform(0.0, 30.0, (4, 4, 4, 1))
    axis = Axis(-3.0, 2.0, 4)
    layers = Layers(axis, axis, axis, data)
    x, y, t = chance.uniform(-1.0, 1.0, (3, 200))
    here = np.ravel(layers.values(x, y, t)[0])
    printed = np.array([np.einsum("kji,i,j,k->", data[..., 0], _p(a), _p(b), _p(c)) for a, b, c in zip(x, y, t)])
    return Answer(
        {}, {"x": x, "y": y, "t": t, "as printed": printed, "computed": here}, None, float(np.max(np.abs(printed - here)) / 30.0),
        "the printed polynomials and the program's kernel",
    )  # fmt: skip


def _p(x: float) -> Array:
    """The printed P over 16."""
    return np.array([
        (1.0 - x) * (x * x - 1.0), (x - 1.0) * (3.0 * x * x + 2.0 * x - 9.0), (x + 1.0) * (9.0 + 2.0 * x - 3.0 * x * x),
        (x + 1.0) * (x * x - 1.0),
    ]) / 16.0  # fmt: skip


def _speeds(feet: float) -> tuple[float, float, float]:
    """In head, beam and following waves, kn."""
    a, b, c = (float(v) / KNOT for v in JamesPolar().axes(feet * FOOT, FLOATS)[:3])
    return a - c, b * float(np.sqrt(1.0 - (c / a) ** 2)), a + c


@lru_cache
def _best() -> PlannedRoute:
    return route(NAME)


def _rates(t: float, z: Array) -> list[float]:
    """Of (x, y, p) along an extremal of the route, in the compact Hamiltonian form: with A = p.k, B = p.k' and
    S = sqrt(a^2 A^2 + b^2 B^2) the Hamiltonian is -c A + S, and the velocity its derivative with respect to p."""
    field = _best().given.problem.medium.field
    height, height_x, height_y, kx, ky, angle_x, angle_y, _ = (float(v[0]) for v in field.at(z[:1], z[1:2], np.array([t])))
    a, b, c, da, db, dc = (float(v) for v in JamesPolar().axes(height, FLOATS))
    along, across = z[2] * kx + z[3] * ky, z[3] * kx - z[2] * ky
    size = np.hypot(a * along, b * across)
    u, w = -c + a * a * along / size, b * b * across / size
    by_height = -dc * along + (a * da * along**2 + b * db * across**2) / size
    by_angle = across * (-c + (a * a - b * b) * along / size)
    slope = -by_height * height_x - by_angle * angle_x, -by_height * height_y - by_angle * angle_y
    return [u * kx - w * ky, u * ky + w * kx, *slope]


def _extremal(course: float, times: Array) -> Array:
    """(x, y) at ``times`` (s, ascending from 0), of the extremal that begins with its adjoint vector along ``course``, rad."""
    x, y = _best().plan.best.x[0], _best().plan.best.y[0]
    start = [float(x), float(y), np.cos(course), np.sin(course)]
    found = solve_ivp(_rates, (0.0, times[-1]), start, method="DOP853", rtol=1e-12, atol=1e-6, t_eval=times)
    return np.asarray(found.y[:2])


def _integrated() -> float:
    """Difference of the end of the best extremal from that of `_extremal`, over the distance."""
    track = _best().plan.best.track
    assert track is not None
    end = _extremal(float(track.normal[0]), np.array([0.0, track.time[-1]]))[:, -1]
    return float(np.hypot(end[0] - track.x[-1], end[1] - track.y[-1]) / np.hypot(track.x[-1], track.y[-1]))


def _draw(path: Path, found: PlannedRoute, hours: tuple[float, ...]) -> None:
    chart(path, found.given.title, found.given.problem, found.plan, hours)
