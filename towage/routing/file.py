"""A route file: from where to where, with which ship, through which sea. TOML; numbers may carry units (``"20 ft"``).

    title = "..."
    [route]       start, end: [x, y] on a flat map, [latitude, longitude] on a sphere; method
    [map]         kind = "flat" (default) or "sphere"
    [ship]        polar = "P2-S2-R2 (1957)", or speed, or table = { heights, angles, speeds }
    [sea]         kind = "calm", "uniform", "storm" or "file"
    [[forbidden]] centre and radius, or corners

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

from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.models.route.areas import Area, Disc, Polygon
from towage.models.route.fields import Field, StormField, UniformField
from towage.models.route.maps import FlatMap, RouteMap, StereographicMap
from towage.models.route.medium import Medium
from towage.models.route.plan import Problem
from towage.models.route.polar import ConstantPolar, JamesPolar, Polar, TablePolar
from towage.scene.tables import Tables, find_file, read_toml

SHIPPED = Path(__file__).parents[1] / "routes"
KEYS = {
    "": ("title", "description", "route", "map", "ship", "sea", "forbidden"),
    "route": ("start", "end", "method", "departure"),
    "map": ("kind", "radius"),
    "ship": ("polar", "speed", "table"),
    "ship.table": ("heights", "angles", "speeds"),
    "sea": ("kind", "height", "wave_angle", "background", "peak", "centre", "sigma", "velocity", "swirl", "file",
            "variables"),
    "forbidden": ("name", "centre", "radius", "corners"),
}  # fmt: skip


@dataclass(frozen=True)
class RouteFile:
    """What a route file says; ``problem`` in SI on the plane of the map."""

    title: str
    problem: Problem
    method: str
    path: Path


def load(given: str | Path) -> RouteFile:
    """The route of a file, or of a shipped name. Raises `SceneError`."""
    path = find_file(given, (SHIPPED,), "route")
    _, data = read_toml(path)
    return _Reader(path).route(data)


class _Reader(Tables):
    """Reads the tables of a route file."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.given = path

    def part(self, data: dict[str, Any], key: str, needed: bool = True) -> dict[str, Any]:
        """The table ``key``, with no unknown keys; empty if it is missing and not ``needed``."""
        name = key.rpartition(".")[2]
        if needed and name not in data:
            self.fail("this table is missing", key)
        return self.known(data.get(name, {}), key)

    def known(self, value: object, key: str) -> dict[str, Any]:
        """The table itself, if it has no unknown keys."""
        table = self.table(value, key)
        for name in table:
            if name not in KEYS[key]:
                self.unknown(name, KEYS[key], key)
        return table

    def number(self, table: dict[str, Any], key: str, unit: str, default: float | None = None) -> float:
        """A number, in ``unit`` if it is a text with a unit."""
        name = key.rpartition(".")[2]
        if name not in table:
            if default is None:
                self.fail("this value is missing", key)
            return default
        return self.value(table[name], key, unit)

    def value(self, value: object, key: str, unit: str) -> float:
        """A number or a text with a unit, finite."""
        if isinstance(value, str):
            try:
                return parse_quantity(value, unit)
            except QuantityError as error:
                self.fail(str(error), key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self.fail(f"expected a finite number or a text with a unit, got {value!r}", key)
        return float(value)

    def pair(self, table: dict[str, Any], key: str, unit: str) -> tuple[float, float]:
        """Two numbers."""
        value = table.get(key.rpartition(".")[2])
        if not isinstance(value, list) or len(value) != 2:
            self.fail(f"expected two numbers, got {value!r}", key)
        return self.value(value[0], key, unit), self.value(value[1], key, unit)

    def choice(self, table: dict[str, Any], key: str, allowed: Iterable[str], default: str | None = None) -> str:
        """One of a few words."""
        value = table.get(key.rpartition(".")[2], default)
        if value not in (names := list(allowed)):
            self.fail(f"expected one of: {', '.join(names)}; got {value!r}", key)
        return str(value)

    def route(self, data: dict[str, Any]) -> RouteFile:
        """What the whole file says."""
        self.known(data, "")
        route, ship, sea = (self.part(data, key) for key in ("route", "ship", "sea"))
        kind = self.choice(self.part(data, "map", needed=False), "map.kind", ("flat", "sphere"), "flat")
        method = self.choice(route, "route.method", ("safeguarded", "seed", "graph"), "safeguarded")
        plane: RouteMap = FlatMap()
        if kind == "sphere":
            plane, start, end = self.sphere(data, route)
        else:
            start, end = self.pair(route, "route.start", "m"), self.pair(route, "route.end", "m")
        areas = list(self.areas(data, plane))
        field, no_data = self.sea(sea, plane, start, end, route.get("departure"))
        if no_data is not None:
            areas.append(no_data)
        problem = Problem(Medium(plane, field, self.polar(ship)), start, end, tuple(areas))
        return RouteFile(str(data.get("title", self.given.stem)), problem, method, self.given)

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

    def polar(self, ship: dict[str, Any]) -> Polar:
        """The polar diagram."""
        if len(ship) != 1:
            self.fail("expected exactly one of polar, speed and table", "ship")
        if "polar" in ship:
            self.choice(ship, "ship.polar", (JamesPolar().name,))
            return JamesPolar()
        if "speed" in ship:
            speed = self.number(ship, "ship.speed", "m/s")
            if speed <= 0.0:
                self.fail(f"{speed} m/s: expected more than 0", "ship.speed")
            return ConstantPolar(speed)
        table = self.part(ship, "ship.table")
        lists = {}
        for name, unit in (("heights", "m"), ("angles", "rad")):
            values = table.get(name)
            if not isinstance(values, list):
                self.fail("expected a list", f"ship.table.{name}")
            lists[name] = [self.value(v, f"ship.table.{name}", unit) for v in values]
        rows = table.get("speeds")
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            self.fail("expected a list of lists, one a height", "ship.table.speeds")
        try:
            return TablePolar(
                lists["heights"], lists["angles"],
                [[self.value(v, "ship.table.speeds", "m/s") for v in row] for row in rows],
            )  # fmt: skip
        except ValueError as error:
            self.fail(str(error), "ship.table")

    def sea(
        self, sea: dict[str, Any], plane: RouteMap, start: tuple[float, float], end: tuple[float, float], departure: object
    ) -> tuple[Field, Area | None]:
        """The wave field, and where it has no data."""
        kind = self.choice(sea, "sea.kind", ("calm", "uniform", "storm", "file"))
        angle = self.number(sea, "sea.wave_angle", "rad", 0.0)
        if kind == "calm":
            return UniformField(), None
        if kind == "uniform":
            return UniformField(self.number(sea, "sea.height", "m"), angle), None
        if kind == "storm":
            sigma = self.number(sea, "sea.sigma", "m")
            if sigma <= 0.0:
                self.fail(f"{sigma} m: expected more than 0", "sea.sigma")
            velocity = self.pair(sea, "sea.velocity", "m/s") if "velocity" in sea else (0.0, 0.0)
            return StormField(
                self.number(sea, "sea.background", "m", 0.0), self.number(sea, "sea.peak", "m"),
                self.pair(sea, "sea.centre", "m"), sigma, velocity, angle, bool(sea.get("swirl", False)),
            ), None  # fmt: skip
        from towage.routing.data import read

        if not isinstance(sea.get("file"), str):
            self.fail("expected the path of a netCDF file, relative to this one", "sea.file")
        if departure is not None and not isinstance(departure, datetime.datetime):
            self.fail(f"expected a date and time, got {departure!r}", "route.departure")
        return read(self.given.parent / sea["file"], plane, start, end, departure, sea.get("variables", {}))

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
                radius = self.number(area, f"{key}.radius", "m")
                if radius <= 0.0:
                    self.fail(f"{radius} m: expected more than 0", f"{key}.radius")
                yield Disc(x, y, radius, name)
