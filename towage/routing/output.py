"""What a computed route is written as: a table of the voyage, CSV (which the unit `playback` plays), GPX, the source's table.

A `Voyage` holds what the ship meets at instants of her route, SI and radians: heading clockwise from north (on a flat map
y is north), wave direction between course and travel of the waves, pi for head seas, both unwrapped.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage.errors import TowageError
from towage.files import atomic_write
from towage.models.route.maps import StereographicMap
from towage.models.route.problem import Problem, Route
from towage.routing.file import RouteFile

Array = NDArray[np.float64]
MILE, KNOT, HOUR = 1852.0, 1852.0 / 3600.0, 3600.0
ROWS = 101


@dataclass(frozen=True)
class Voyage:
    """What the ship meets, columns of shape (n,): time, s; place on the plane of the map, m; heading and wave direction, rad;
    speed, m/s; wave height, m, and period, s."""

    time: Array
    x: Array
    y: Array
    heading: Array
    speed: Array
    wave_height: Array
    wave_period: Array
    wave_direction: Array


def voyage_table(problem: Problem, route: Route, count: int) -> Voyage:
    """The voyage at ``count`` instants at equal distances in time."""
    medium = problem.medium
    time = np.linspace(0.0, route.duration, count)
    if len(route.time) < 2:
        x, y = np.full(count, route.x[0]), np.full(count, route.y[0])
        dx, dy = np.ones(count), np.zeros(count)
    else:
        from scipy.interpolate import CubicSpline

        kind = "natural" if len(route.time) < 4 else "not-a-knot"
        spline = CubicSpline(route.time, np.column_stack([route.x, route.y]), bc_type=kind)
        (x, y), (dx, dy) = spline(time).T, spline(time, 1).T
    angle = np.unwrap(np.arctan2(dy, dx))
    scale = medium.map.scale(x, y)[0]
    sea = medium.field.at(x, y, time)
    if isinstance(medium.map, StereographicMap):
        heading = np.unwrap(medium.map.bearing(x, y, angle))
    else:
        heading = 0.5 * math.pi - angle
    # k points to where the waves come from: they meet the ship head on where k lies along the course
    encounter = math.pi - np.unwrap(np.arctan2(sea.ky, sea.kx) - angle)
    return Voyage(
        time, x, y, heading, np.hypot(dx, dy) / scale if len(route.time) > 1 else 0.0 * x, sea.height,
        medium.period(sea, x, y, time), encounter,
    )  # fmt: skip


def write_csv(path: Path, problem: Problem, route: Route, count: int = ROWS) -> None:
    """The voyage as CSV: hours, nautical miles or degrees, knots, metres, seconds, degrees."""
    v = voyage_table(problem, route, count)
    plane = problem.medium.map
    if isinstance(plane, StereographicMap):
        a, b = (np.degrees(c) for c in plane.to_geographic(v.x, v.y))
        names = "latitude_deg,longitude_deg"
    else:
        a, b = v.x / MILE, v.y / MILE
        names = "x_nmi,y_nmi"
    columns = [
        v.time / HOUR, a, b, np.degrees(v.heading) % 360.0, v.speed / KNOT, v.wave_height, v.wave_period,
        np.degrees(v.wave_direction) % 360.0,
    ]  # fmt: skip
    head = f"time_h,{names},heading_deg,speed_kn,wave_height_m,wave_period_s,wave_direction_deg"
    _write_table(path, head, columns)


def write_gpx(path: Path, given: RouteFile, route: Route, count: int = ROWS) -> None:
    """The track as GPX 1.1 (Topografix), with times where the route file has a departure. Raises `TowageError`."""
    from xml.etree import ElementTree

    plane = given.problem.medium.map
    if not isinstance(plane, StereographicMap):
        raise TowageError(f'{given.path}: a track in GPX has latitudes and longitudes: it needs map.kind = "sphere"')
    v = voyage_table(given.problem, route, count)
    gpx = ElementTree.Element("gpx", version="1.1", creator="towage", xmlns="http://www.topografix.com/GPX/1/1")
    track = ElementTree.SubElement(gpx, "trk")
    ElementTree.SubElement(track, "name").text = given.title
    segment = ElementTree.SubElement(track, "trkseg")
    start = given.departure and (given.departure.astimezone(datetime.UTC) if given.departure.tzinfo else given.departure)
    for latitude, longitude, time in zip(*(np.degrees(c) for c in plane.to_geographic(v.x, v.y)), v.time.tolist()):
        point = ElementTree.SubElement(segment, "trkpt", lat=f"{latitude:.7f}", lon=f"{longitude:.7f}")
        if start:
            when = start + datetime.timedelta(seconds=round(time))
            ElementTree.SubElement(point, "time").text = when.strftime("%Y-%m-%dT%H:%M:%SZ")
    ElementTree.indent(gpx)
    with atomic_write(path) as stream:
        stream.write(ElementTree.tostring(gpx, encoding="utf-8", xml_declaration=True))


def write_source_table(path: Path, problem: Problem, route: Route) -> None:
    """Along an extremal, in the source's letters: LAMBDA, size of the adjoint vector, 1 at the start; S, distance sailed,
    nautical miles; J, the integral (20) of its iteration, nautical miles a radian; Q, direction of the adjoint vector, degrees
    counterclockwise from +x of the plane. Raises `TowageError`."""
    way = route.track
    if way is None:
        raise TowageError(f"the best route is no extremal but of kind {route.kind}: the source's table has no columns for it")
    scale = problem.medium.map.scale(way.x, way.y)[0]
    leg = np.hypot(np.diff(way.x), np.diff(way.y)) * 2.0 / (scale[1:] + scale[:-1])
    distance = np.concatenate([[0.0], np.cumsum(leg)])
    columns = [way.time / HOUR, way.x / MILE, way.y / MILE, way.adjoint, distance / MILE, way.j_seed / MILE]
    columns.append(np.degrees(way.normal))
    _write_table(path, "time_h,x_nmi,y_nmi,LAMBDA,S_nmi,J_nmi_per_rad,Q_deg", columns)


def _write_table(path: Path, head: str, columns: Sequence[Array]) -> None:
    """Columns as CSV."""
    lines = [head] + [",".join(f"{value:.9g}" for value in row) for row in zip(*columns)]
    with atomic_write(path) as stream:
        stream.write(("\n".join(lines) + "\n").encode())
