"""The ship of a route file: how fast she is in which sea and wind.

    [ship]               polar = "P2-S2-R2 (1957)", or speed, or tables:
    [ship.table]         heights, angles, speeds: over waves
    [ship.wind_table]    winds, angles, speeds: over the true wind; with it perhaps
    [ship.wave_factors]  heights, angles, factors: what waves leave of that speed

Angles count from where waves or wind come from. ``ends`` says what lies below the first angle and above the last:
"no-go", where a sailing boat does not sail but tacks, or "held", where a motor ship keeps the speed of the last angle.
"""

from __future__ import annotations

import math
from typing import Any

from towage.models.route.hulls import Ends, Table, TablePolar, WindWavePolar
from towage.models.route.polar import ConstantPolar, JamesPolar, Polar
from towage.routing.tables import RouteTables

_KINDS = {"table": ("heights", "m", "speeds", "m/s"), "wind_table": ("winds", "m/s", "speeds", "m/s"),
          "wave_factors": ("heights", "m", "factors", "1")}  # fmt: skip


def polar(reader: RouteTables, ship: dict[str, Any], notes: list[str]) -> Polar:
    """The polar diagram. Raises `SceneError`."""
    names = [name for name in ship if name != "wave_factors"]
    if len(names) != 1 or ("wave_factors" in ship and names != ["wind_table"]):
        reader.fail("expected exactly one of polar, speed and table, or a wind_table with or without wave_factors", "ship")
    if "polar" in ship:
        reader.choice(ship, "ship.polar", (JamesPolar().name,))
        return JamesPolar()
    if "speed" in ship:
        return ConstantPolar(reader.positive(ship, "ship.speed", "m/s"))
    (levels, angles, values, ends) = _table(reader, ship, names[0], notes)
    try:
        if "wave_factors" in ship:
            wave_levels, wave_angles, factors, wave_ends = _table(reader, ship, "wave_factors", notes)
            return WindWavePolar(Table(levels, angles, values, ends, level="winds"),
                                 Table(wave_levels, wave_angles, factors, wave_ends, value="factors"))  # fmt: skip
        return TablePolar(levels, angles, values, names[0], ends, "wind" if names[0] == "wind_table" else "waves")
    except ValueError as error:
        reader.fail(str(error), f"ship.{names[0]}")


def _table(
    reader: RouteTables, ship: dict[str, Any], name: str, notes: list[str]
) -> tuple[list[float], list[float], list[list[float]], Ends]:
    """(levels, angles, values, ends) of a table; what lies beyond its angles is told."""
    key = f"ship.{name}"
    table = reader.part(ship, key)
    level, level_unit, value, unit = _KINDS[name]
    levels = reader.numbers(table, f"{key}.{level}", level_unit)
    angles = reader.numbers(table, f"{key}.angles", "rad")
    rows = reader.rows(table, f"{key}.{value}", unit)
    said = "ends" in table or name == "wave_factors"
    usual = "held" if name == "wave_factors" else "no-go"
    ends: Ends = "no-go" if reader.choice(table, f"{key}.ends", ("no-go", "held"), usual) == "no-go" else "held"
    if angles and (angles[0] > 1e-9 or angles[-1] < math.pi - 1e-9):
        reach = f"{math.degrees(angles[0]):g} to {math.degrees(angles[-1]):g} deg"
        if ends == "held":
            notes.append(f"{key} goes from {reach}: beyond, the speed of its last angle is held")
        else:
            notes.append(f"{key} goes from {reach}: beyond, the ship does not sail but tacks"
                         + ("" if said else "; a motor ship needs ends = \"held\""))  # fmt: skip
    return levels, angles, rows, ends
