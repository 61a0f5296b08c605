"""A route file: from where to where, with which ship, through which sea. TOML; numbers may carry units (``"20 ft"``).

    title = "..."
    [route]       start, end: [x, y] on a flat map, [latitude, longitude] on a sphere; departure; method, and for "seed" the
                  fraction of its corrections
    [map]         kind = "flat" (default) or "sphere"
    [ship]        polar = "P2-S2-R2 (1957)", or speed, or tables over waves, wind or both (`ships`)
    [sea]         kind = "calm", "uniform", "storm" or "file" (`seas`), as [wind] and [current]
    [[forbidden]] centre and radius, or corners
    [[limits]]    of heave, tension and so on along the route (`limits`)

Angles of waves are those they come FROM: on a flat map counterclockwise from +x (``wave_angle``), in a file of data
clockwise from north. Every fault is a `SceneError` that names file and key.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from towage.models.route.areas import Area, Disc, Polygon
from towage.models.route.hulls import TablePolar, WindWavePolar
from towage.models.route.limits import Limit
from towage.models.route.maps import FlatMap, RouteMap, StereographicMap
from towage.models.route.medium import Medium
from towage.models.route.polar import Polar
from towage.models.route.problem import Problem
from towage.routing import ships
from towage.routing.forecast.read import Frame
from towage.routing.limits import read_limit
from towage.routing.seas import Surroundings, departure
from towage.routing.tables import RouteTables
from towage.scene.tables import find_file, read_toml

SHIPPED = Path(__file__).parents[1] / "routes"
METHODS = ("safeguarded", "seed", "graph")


@dataclass(frozen=True)
class RouteFile:
    """What a route file says; ``problem`` in SI on the plane of the map. ``fraction``: of the corrections of the
    method "seed". ``notes``: what its data files left open, and what was
    assumed, for people."""

    title: str
    problem: Problem
    method: str
    path: Path
    departure: datetime.datetime | None = None
    fraction: float = 1.0
    notes: tuple[str, ...] = ()


def load(given: str | Path) -> RouteFile:
    """The route of a file, or of a shipped name. Raises `SceneError`."""
    path = find_file(given, (SHIPPED,), "route")
    _, data = read_toml(path)
    return _Reader(path).route(data)


class _Reader(RouteTables):
    """Reads a whole route file."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.given = path

    def route(self, data: dict[str, Any]) -> RouteFile:
        """What the whole file says."""
        self.known(data, "")
        route, ship, sea = (self.part(data, key) for key in ("route", "ship", "sea"))
        wind, current = (self.part(data, key, needed=False) for key in ("wind", "current"))
        kind = self.choice(self.part(data, "map", needed=False), "map.kind", ("flat", "sphere"), "flat")
        method = self.choice(route, "route.method", METHODS, "safeguarded")
        plane: RouteMap = FlatMap()
        if kind == "sphere":
            plane, start, end = self.sphere(data, route)
        else:
            start, end = self.pair(route, "route.start", "m"), self.pair(route, "route.end", "m")
        areas, notes = list(self.areas(data, plane)), list[str]()
        leaves = departure(self, route.get("departure"))
        around = Surroundings(self, self.given, Frame(plane, start, end, leaves), areas, notes)
        polar = ships.polar(self, ship, notes)
        limits = tuple(limit for limit in self.limits(data, polar, notes))
        medium = Medium(plane, around.sea(sea), polar, around.current(current), around.wind(wind), limits)
        if isinstance(polar, (TablePolar, WindWavePolar)) and polar.needs_wind and medium.wind is None:
            self.fail("this table is missing: the ship has a wind_table", "wind")
        problem = Problem(medium, start, end, tuple(areas))
        fraction = self.number(route, "route.fraction", "1", 1.0)
        if fraction != 1.0 and method != "seed":
            self.fail('only the source\'s iteration takes a part of its corrections: method = "seed"', "route.fraction")
        if not 0.0 < fraction <= 1.0:
            self.fail(f"{fraction:g}: expected more than 0 and at most 1", "route.fraction")
        return RouteFile(str(data.get("title", self.given.stem)), problem, method, self.given, leaves, fraction,
                         tuple(dict.fromkeys(notes)))  # fmt: skip

    def sphere(
        self, data: dict[str, Any], route: dict[str, Any]
    ) -> tuple[StereographicMap, tuple[float, float], tuple[float, float]]:
        """The plane about the pole that is nearer, its x axis to the start, and both ends on it."""
        ends = []
        for name in ("start", "end"):
            latitude, longitude = self.pair(route, f"route.{name}", "rad")
            if abs(latitude) > 0.5 * math.pi + 1e-12:
                self.fail(f"latitude {latitude:g} rad: expected -90 deg to 90 deg ('35 deg')", f"route.{name}")
            ends.append((latitude, longitude))
        radius = self.number(self.part(data, "map", needed=False), "map.radius", "m", 6371.2e3)
        plane = StereographicMap(radius, south=ends[0][0] + ends[1][0] < 0.0)
        points = [tuple(float(v) for v in plane.to_plane(*end)) for end in ends]
        return plane, (points[0][0], points[0][1]), (points[1][0], points[1][1])

    def limits(self, data: dict[str, Any], polar: Polar, notes: list[str]) -> Iterable[Limit]:
        """What the sea may do to the ship."""
        given = data.get("limits", [])
        if not isinstance(given, list):
            self.fail("expected an array of tables, [[limits]]", "limits")
        for k, table in enumerate(given):
            yield read_limit(self, self.known(table, f"limits[{k}]", "limits"), f"limits[{k}]", self.given.parent, polar, notes)

    def areas(self, data: dict[str, Any], plane: RouteMap) -> Iterable[Area]:
        """Forbidden areas on the plane; corners as ``start`` is given."""
        given = data.get("forbidden", [])
        if not isinstance(given, list):
            self.fail("expected an array of tables, [[forbidden]]", "forbidden")
        for k, area in enumerate(given):
            key = f"forbidden[{k}]"
            self.known(area, "forbidden")
            name = str(area.get("name", f"area {k + 1}"))
            sphere = isinstance(plane, StereographicMap)
            if "corners" in area:
                corners = [self.pair({"corners": c}, f"{key}.corners", "rad" if sphere else "m") for c in area["corners"]]
                if isinstance(plane, StereographicMap):
                    corners = [tuple(float(v) for v in plane.to_plane(*c)) for c in corners]  # type: ignore[misc]
                try:
                    yield Polygon(corners, name)
                except ValueError as error:
                    self.fail(str(error), f"{key}.corners")
            elif sphere:
                self.fail("on a sphere an area is given by its corners", key)
            else:
                x, y = self.pair(area, f"{key}.centre", "m")
                yield Disc(x, y, self.positive(area, f"{key}.radius", "m"), name)
