"""Sea, wind and current of a route file.

    [sea]      kind = "calm", "uniform" (height, wave_angle), "storm" (background, wave_angle and peak, centre, sigma, velocity,
               swirl of one storm, or of several in [[sea.storms]]), or "file"
    [wind]     kind = "uniform" (speed, wind_angle) or "file"
    [current]  kind = "linear" (velocity, gradient: u = velocity + gradient (x, y)) or "file"

With kind "file": ``file``, a path or several, netCDF or GRIB; ``variables``, ``units``, ``select`` and ``direction_is`` where
the file does not say enough (`towage.routing.forecast`).
"""

from __future__ import annotations

import datetime
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from towage.models.route.areas import Area, Cells
from towage.models.route.fields import Current, Field, LinearCurrent, StormField, Storms, UniformField
from towage.models.route.maps import FlatMap
from towage.models.route.medium import STILL
from towage.routing.forecast import meaning
from towage.routing.forecast.meaning import Quantity, Sense, Wishes
from towage.routing.forecast.read import Frame
from towage.routing.tables import RouteTables

F = TypeVar("F")
_Read = Callable[[list[Path], Wishes, Frame, list[str]], tuple[F, Cells | None]]


class Surroundings:
    """Reads sea, wind and current in ``frame``; ``areas`` without data and ``notes`` are added to."""

    def __init__(self, reader: RouteTables, path: Path, frame: Frame, areas: list[Area], notes: list[str]) -> None:
        self.reader, self.path, self.frame, self.areas, self.notes = reader, path, frame, areas, notes

    def sea(self, table: dict[str, Any]) -> Field:
        """The waves."""
        reader = self.reader
        kind = reader.choice(table, "sea.kind", ("calm", "uniform", "storm", "file"))
        angle = reader.number(table, "sea.wave_angle", "rad", 0.0)
        if kind == "calm":
            return UniformField()
        if kind == "uniform":
            return UniformField(reader.number(table, "sea.height", "m"), angle)
        if kind == "storm":
            background = reader.number(table, "sea.background", "m", 0.0)
            if "storms" not in table:
                return self.storm(table, "sea", background, angle)
            several = table["storms"]
            if not isinstance(several, list) or not several or table.keys() & {"peak", "centre", "sigma", "velocity", "swirl"}:
                reader.fail("expected an array of tables, [[sea.storms]], and no peak, centre, sigma, velocity, swirl beside it",
                            "sea.storms")  # fmt: skip
            storms = [
                self.storm(reader.known(each, f"sea.storms[{k}]", "sea.storms"), f"sea.storms[{k}]", 0.0, angle)
                for k, each in enumerate(several)
            ]
            return Storms(background, tuple(storms), angle)
        from towage.routing.forecast.read import waves

        return self.file(table, "sea", meaning.WAVES, waves)

    def storm(self, table: dict[str, Any], key: str, background: float, angle: float) -> StormField:
        """One storm."""
        reader = self.reader
        velocity = reader.pair(table, f"{key}.velocity", "m/s") if "velocity" in table else (0.0, 0.0)
        return StormField(
            background, reader.number(table, f"{key}.peak", "m"), reader.pair(table, f"{key}.centre", "m"),
            reader.positive(table, f"{key}.sigma", "m"), velocity, angle, bool(table.get("swirl", False)),
        )  # fmt: skip

    def wind(self, table: dict[str, Any]) -> Field | None:
        """The true wind, if there is one."""
        if not table:
            return None
        if self.reader.choice(table, "wind.kind", ("uniform", "file")) == "uniform":
            speed = self.reader.number(table, "wind.speed", "m/s")
            return UniformField(speed, self.reader.number(table, "wind.wind_angle", "rad", 0.0))
        from towage.routing.forecast.read import wind

        return self.file(table, "wind", meaning.WIND, wind)

    def current(self, table: dict[str, Any]) -> Current:
        """The surface current."""
        if not table:
            return STILL
        if self.reader.choice(table, "current.kind", ("linear", "file")) == "linear":
            if not isinstance(self.frame.plane, FlatMap):
                self.reader.fail("on a sphere a current comes from a file", "current.kind")
            velocity = self.reader.pair(table, "current.velocity", "m/s") if "velocity" in table else (0.0, 0.0)
            rows = self.reader.rows(table, "current.gradient", "1/s") if "gradient" in table else [[0.0, 0.0], [0.0, 0.0]]
            if [len(row) for row in rows] != [2, 2]:
                self.reader.fail("expected [[du/dx, du/dy], [dv/dx, dv/dy]]", "current.gradient")
            return LinearCurrent(velocity, ((rows[0][0], rows[0][1]), (rows[1][0], rows[1][1])))
        from towage.routing.forecast.read import current

        return self.file(table, "current", meaning.CURRENT, current)

    def file(self, table: dict[str, Any], key: str, quantities: tuple[Quantity, ...], read: _Read[F]) -> F:
        """What data files say."""
        given = table.get("file")
        names: list[Any] = given if isinstance(given, list) else [given]
        if not names or not all(isinstance(name, str) for name in names):
            self.reader.fail("expected the path of a netCDF or GRIB file, relative to this one, or several", f"{key}.file")
        paths = [self.path.parent / str(name) for name in names]
        found, area = read(paths, self.wishes(table, key, quantities), self.frame, self.notes)
        if area is not None:
            self.areas.append(area)
        return found

    def wishes(self, table: dict[str, Any], key: str, quantities: tuple[Quantity, ...]) -> Wishes:
        """What the route file says of a data file."""
        texts: dict[str, dict[str, str]] = {}
        known = tuple(quantity.name for quantity in quantities)
        for part in ("variables", "units"):
            given = self.reader.table(table.get(part, {}), f"{key}.{part}")
            for name, value in given.items():
                if name not in known:
                    self.reader.unknown(name, known, f"{key}.{part}")
                if not isinstance(value, str):
                    self.reader.fail(f"expected a text, got {value!r}", f"{key}.{part}.{name}")
            texts[part] = given
        chosen = self.reader.table(table.get("select", {}), f"{key}.select")
        select = {name: self.reader.value(value, f"{key}.select.{name}", "1") for name, value in chosen.items()}
        senses: dict[str, Sense] = {"from": "from", "to": "to"}
        sense = senses[self.reader.choice(table, f"{key}.direction_is", senses)] if "direction_is" in table else None
        return Wishes(texts["variables"], texts["units"], select, sense)


def departure(reader: RouteTables, given: object) -> datetime.datetime | None:
    """The departure, if there is one."""
    if given is not None and not isinstance(given, datetime.datetime):
        reader.fail(f"expected a date and time, got {given!r}", "route.departure")
    return given
