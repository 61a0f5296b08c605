"""Limits along a route, ``[[limits]]`` of a route file: what an answer to the sea may be at most.

    [[limits]]
    name = "cage"                       # of four kinds, each relative to the route file:
    table = "tension.csv"               # wave_height [m], wave_period [s], direction [deg] and a column of the answer
    value = "tension"
    limit = "450 kN"
    heights = "curve.csv"               # or limiting heights: wave_period [s], direction [deg], wave_height [m]
    direction = "to"                    # both: "to", 0 deg is a following sea; "from", 0 deg is a head sea
    responses = { file = "vessel.csv", phase = "lag", direction = "to" }     # or a motion by a table, as `ship_in_sea` takes it
    hull = { length = "80 m", breadth = "18 m", draught = "5 m", block_coefficient = 0.7 }      # or by the closed form
    motion = "z"                        # of ``point``: x, y, z; or surge, sway, heave, roll, pitch, yaw
    point = ["-35 m", "0 m", "8 m"]
    statistic = "most probable maximum" # in ``hours`` (3); or "significant amplitude", two standard deviations
    speed = "10 kn"                     # for which motions are computed; that in calm water if it is left out, which is told

Motions are those of a long-crested sea with the spectrum of Bretschneider, or of JONSWAP with ``peakedness``; m0 and m2 by the
components of `ship_in_sea`. Both sides are taken alike: the larger answer of the two counts.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from towage.data import columns, responses
from towage.fmus.declare.quantities import QuantityError, convert
from towage.models.route.hulls import TablePolar, WindWavePolar
from towage.models.route.limits import Limit
from towage.models.route.medium import OPS
from towage.models.route.polar import KNOT, Polar
from towage.models.sea.heave_response import Hull
from towage.models.sea.kernel import Answer, Ship, answers, by_hull, by_table
from towage.models.sea.motion import POINT, Sea, encounter
from towage.models.sea.response_table import DOFS, ResponseTable
from towage.models.sea.seas import Shape, sea_components
from towage.reading import Refused
from towage.routing.tables import RouteTables

Array = NDArray[np.float64]
MOTIONS = (*DOFS, "x", "y", "z")
PERIODS = np.geomspace(3.0, 25.0, 40)
HEADINGS = np.radians(np.arange(0.0, 181.0, 15.0))
COMPONENTS = 50
STATISTICS = ("significant amplitude", "most probable maximum")
KINDS = ("table", "heights", "responses", "hull")


def read_limit(
    reader: RouteTables, table: dict[str, Any], key: str, folder: Path, polar: Polar, notes: list[str]
) -> Limit:
    """One limit. Raises `SceneError`."""
    kinds = [kind for kind in KINDS if kind in table]
    if len(kinds) != 1:
        reader.fail(f"expected one of {', '.join(KINDS)}; got {' and '.join(kinds) or 'none'}", key)
    name = str(table.get("name", key))
    own: list[str] = []
    if kinds[0] in ("responses", "hull"):
        limit = _motion(reader, table, key, folder, polar, name, own)
    else:
        limit = _table(reader, table, key, folder / str(table[kinds[0]]), kinds[0], name)
    notes += [f"limit {name!r}: {note}" for note in own]
    return limit


def _table(reader: RouteTables, table: dict[str, Any], key: str, path: Path, kind: str, name: str) -> Limit:
    """Answers or limiting heights that a file holds over a grid."""
    where = f"{key}.{kind}"
    for other in ("motion", "point", "statistic", "hours", "speed", "peakedness", "value", "limit"):
        if other in table and (kind == "heights" or other not in ("value", "limit")):
            reader.fail(f"does not go with {kind}", f"{key}.{other}")
    sense = reader.choice(table, f"{key}.direction", ("to", "from"))
    try:
        found = {column.name: column for column in columns.read(path).columns}
        value = "wave_height" if kind == "heights" else str(table.get("value"))
        axes = ("wave_period", "direction") if kind == "heights" else ("wave_period", "direction", "wave_height")
        if missing := [column for column in (*axes, value) if column not in found]:
            raise Refused(f"no column {missing[0]!r}: there are {', '.join(found)}")
        units = {"wave_period": "s", "direction": "rad", "wave_height": "m"}
        data = {axis: _in(found[axis], units[axis]) for axis in axes}
        if kind == "heights":
            answer, text = 1.0 / _positive(_in(found[value], "m"), "wave_height"), "limiting height"
        else:
            unit = found[value].unit or "1"
            most = reader.positive(table, f"{key}.limit", unit)
            answer, text = found[value].values / most, f"{value} {most:g} {unit}"
        angle = np.mod(data["direction"] + (math.pi if sense == "from" else 0.0), 2.0 * math.pi)
        data["direction"] = np.asarray(np.round(np.minimum(angle, 2.0 * math.pi - angle), 9), dtype=float)
        return _grid(name, text, [data[axis] for axis in axes], answer)
    except Refused as refused:
        reader.fail(f"{path}: {refused}", where)
    except OSError as error:
        reader.fail(f"{path}: {error.strerror or error}", where)


def _in(column: columns.Column, unit: str) -> Array:
    """Values in ``unit``. Raises `Refused`."""
    try:
        return np.asarray(column.values * convert(1.0, column.unit, unit))
    except QuantityError as error:
        raise Refused(f"column {column.name!r}: {error}: expected its unit in brackets, as {column.name} [{unit}]") from None


def _positive(values: Array, name: str) -> Array:
    if (values <= 0.0).any():
        raise Refused(f"{name} in row {int(np.argmin(values)) + 1}: {values.min():g}: expected more than 0")
    return values


def _grid(name: str, text: str, axes: list[Array], answer: Array) -> Limit:
    """The grid of all rows, which has to be whole; of the same place (both sides) the larger answer. Raises `Refused`."""
    places = [np.unique(axis) for axis in axes]
    use = np.full([len(p) for p in places], -math.inf)
    index = tuple(np.searchsorted(p, axis) for p, axis in zip(places, axes))
    np.maximum.at(use, index, answer)
    if bad := np.argwhere(np.isinf(use)).tolist():
        at = ", ".join(f"{p[i]:g} {unit}" for p, i, unit in zip(places, bad[0], ("s", "rad", "m")))
        raise Refused(f"no row for {at}: expected every height, period and direction with every other")
    headings = places[1]
    if headings[0] > 1e-6 or headings[-1] < math.pi - 1e-6:
        reach = f"{math.degrees(headings[0]):g} to {math.degrees(headings[-1]):g}"
        raise Refused(f"directions from {reach} deg (0: following sea): expected 0 to 180 deg, or the whole circle")
    if len(axes) == 2:
        return Limit(name, text, places[0], headings, use[None])
    return Limit(name, text, places[0], headings, np.moveaxis(use, 2, 0), places[2])


def _motion(
    reader: RouteTables, table: dict[str, Any], key: str, folder: Path, polar: Polar, name: str, notes: list[str]
) -> Limit:
    """A motion of the ship for 1 m of height over periods and headings."""
    for other in ("value", "direction"):
        if other in table:
            reader.fail("goes with a table of answers: responses have their own options", f"{key}.{other}")
    motion = reader.choice(table, f"{key}.motion", MOTIONS, "heave")
    signal = MOTIONS.index(motion)
    point = (0.0, 0.0, 0.0)
    if "point" in table:
        given = reader.numbers(table, f"{key}.point", "m")
        if len(given) != 3 or signal < POINT:
            reader.fail("expected [ahead, to port, up], and motion x, y or z", f"{key}.point")
        point = (given[0], given[1], given[2])
    most = reader.positive(table, f"{key}.limit", "rad" if motion in DOFS[3:] else "m")
    statistic = reader.choice(table, f"{key}.statistic", STATISTICS)
    hours = reader.positive(table, f"{key}.hours", "h", 3.0)
    speed = reader.number(table, f"{key}.speed", "m/s", -1.0)
    if speed < 0.0:
        speed = calm_speed(polar)
        notes.append(f"motions are those at {speed / KNOT:.3g} kn, her speed in calm water; speed = ... for another")
    if "responses" in table:
        of = _by_file(reader, table, key, folder, point, notes)
    else:
        of = _by_hull(reader, table, key, point, motion)
    shape = Shape(components=COMPONENTS, peakedness=reader.number(table, f"{key}.peakedness", "1", 1.0))
    use = [[
        _amplitude(of, signal, Sea(1.0, 2.0 * math.pi / period, heading, speed), shape, statistic, hours) / most
        for heading in HEADINGS.tolist()
    ] for period in PERIODS.tolist()]  # fmt: skip
    text = f"{motion} {most:g} {'rad' if motion in DOFS[3:] else 'm'}, {statistic}"
    text += f" in {hours:g} h" if statistic == STATISTICS[1] else ""
    return Limit(name, text, PERIODS, HEADINGS, np.array([use]))


def _by_file(
    reader: RouteTables, table: dict[str, Any], key: str, folder: Path, point: tuple[float, float, float], notes: list[str]
) -> Answer:
    options = dict(reader.table(table["responses"], f"{key}.responses"))
    path = folder / str(options.pop("file", ""))
    try:
        found = ResponseTable(**responses.read(path, options, notes))
    except Refused as refused:
        _refuse(reader, f"{path}: {refused}", f"{key}.responses")
    except OSError as error:
        _refuse(reader, f"{path}: {error.strerror or error}", f"{key}.responses")
    return by_table(found, Ship(Hull(1.0, 1.0, 1.0), point))


def _by_hull(
    reader: RouteTables, table: dict[str, Any], key: str, point: tuple[float, float, float], motion: str
) -> Answer:
    hull = reader.known(table["hull"], f"{key}.hull", "limits.hull")
    if motion not in ("heave", "pitch", "z") or point[1] != 0.0:
        reader.fail("the closed form knows heave, pitch and z of a point on the centre line: give responses", f"{key}.motion")
    length, breadth, draught = (reader.positive(hull, f"{key}.hull.{k}", "m") for k in ("length", "breadth", "draught"))
    return by_hull(Ship(Hull(length, breadth * reader.positive(hull, f"{key}.hull.block_coefficient", "1"), draught), point))


def _refuse(reader: RouteTables, message: str, key: str) -> NoReturn:
    reader.fail(message, key)


def _amplitude(of: Answer, signal: int, at: Sea, shape: Shape, statistic: str, hours: float) -> float:
    """The larger of both sides: two standard deviations, or the most probable maximum, s sqrt(2 ln n) of n periods, n >= 1
    (M. S. Longuet-Higgins, J. Mar. Res. 11 (1952) 245-266)."""
    both = []
    for side in (1.0, -1.0):
        sea = at._replace(direction=side * at.direction)
        components = sea_components(shape, None, 0)
        energy = [0.5 * (a * abs(h)) ** 2 for a, h in zip(components.amplitude, answers(of, signal, sea, components))]
        m0, met = math.fsum(energy), encounter(sea, components)
        m2 = math.fsum(e * w * w for e, w in zip(energy, met))
        number = max(math.e, hours * 3600.0 * math.sqrt(m2 / m0) / (2.0 * math.pi)) if m0 > 0.0 else math.e
        both.append(math.sqrt(m0) * (2.0 if statistic == STATISTICS[0] else math.sqrt(2.0 * math.log(number))))
    return max(both)


def calm_speed(polar: Polar) -> float:
    """Largest speed where there are no waves, m/s; by the wind the largest of all winds."""
    if isinstance(polar, WindWavePolar):
        return float(polar.wind.values.max())
    if isinstance(polar, TablePolar):
        return float(polar.table.values[0 if polar.needs_waves else slice(None)].max())
    return float(polar.axes(0.0, OPS)[1])
