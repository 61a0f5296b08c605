"""Which variable of a file is which quantity: by the name a user gives, by its CF standard name, by the names that centres use.

A direction counts clockwise from north. Whether it is the one that waves come from or go to is said by the standard name, by
the words of ``long_name``, or by the name; the names of this table mean the direction they come from (currents: go to).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from towage.routing.forecast.contents import Contents, Variable

Sense = Literal["from", "to"]


@dataclass(frozen=True)
class Quantity:
    """``unit``: SI. ``standard``: CF standard names; ``names``: usual names of variables. Values outside ``low`` ... ``high``
    are impossible."""

    name: str
    unit: str
    standard: tuple[str, ...]
    names: tuple[str, ...]
    low: float
    high: float
    sense: Sense | None = None


_PEAK = "_at_variance_spectral_density_maximum"
_TURN = 2.0 * math.pi
WAVES = (
    Quantity("height", "m", ("sea_surface_wave_significant_height",),
             ("swh", "hs", "VHM0", "significant_wave_height", "wave_height", "height"), 0.0, 40.0),
    Quantity("direction", "rad", tuple(f"sea_surface_wave_{way}_direction{at}" for at in ("", _PEAK) for way in ("from", "to")),
             ("mwd", "VMDR", "dir", "wave_direction", "direction"), -_TURN, 2.0 * _TURN, "from"),
    Quantity("period", "s", (f"sea_surface_wave_period{_PEAK}",),
             ("pp1d", "VTPK", "tp", "peak_period", "wave_period", "period"), 0.0, 100.0),
)  # fmt: skip
WIND = (
    Quantity("u", "m/s", ("eastward_wind",), ("u10", "10u", "uwnd", "u_wind", "ugrd10m", "uas", "u"), -120.0, 120.0),
    Quantity("v", "m/s", ("northward_wind",), ("v10", "10v", "vwnd", "v_wind", "vgrd10m", "vas", "v"), -120.0, 120.0),
    Quantity("speed", "m/s", ("wind_speed",), ("wind_speed", "ws", "si10"), 0.0, 120.0),
    Quantity("direction", "rad", ("wind_from_direction", "wind_to_direction"), ("wind_direction", "wdir", "wdir10"),
             -_TURN, 2.0 * _TURN, "from"),
)  # fmt: skip
CURRENT = (
    Quantity("u", "m/s", ("eastward_sea_water_velocity", "surface_eastward_sea_water_velocity"),
             ("uo", "utotal", "water_u", "ucurr", "ucur", "u_current", "u"), -10.0, 10.0),
    Quantity("v", "m/s", ("northward_sea_water_velocity", "surface_northward_sea_water_velocity"),
             ("vo", "vtotal", "water_v", "vcurr", "vcur", "v_current", "v"), -10.0, 10.0),
    Quantity("speed", "m/s", ("sea_water_speed",), ("current_speed",), 0.0, 10.0),
    Quantity("direction", "rad", ("sea_water_velocity_to_direction", "direction_of_sea_water_velocity",
             "sea_water_velocity_from_direction"), ("current_direction",), -_TURN, 2.0 * _TURN, "to"),
)  # fmt: skip


@dataclass(frozen=True)
class Wishes:
    """What a route file says of a data file. ``variables``: names by quantity; ``units``: of measure, where the file has
    none; ``select``: value of a further dimension; ``sense``: whether directions are those waves come from or go to."""

    variables: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    select: Mapping[str, float] = field(default_factory=dict)
    sense: Sense | None = None


def find(contents: Contents, quantity: Quantity, wishes: Wishes) -> Variable | None:
    """The variable for a quantity; None if the file has none. Raises `SceneError` where several would do."""
    if quantity.name in wishes.variables:
        return contents.get(wishes.variables[quantity.name])
    by_standard = [v for v in contents.values() if _standard(v) in quantity.standard]
    named = [v for v in by_standard if v.name in quantity.names]
    for found in (named, by_standard):
        if len(found) == 1:
            return found[0]
    if by_standard:
        names = ", ".join(v.name for v in by_standard)
        raise by_standard[0].fault("standard_name", f"several variables are {_standard(by_standard[0])}: {names}; choose one "
                                   f"under variables.{quantity.name}")  # fmt: skip
    known = {name.lower(): v for name, v in contents.items() if not _standard(v)}
    return next((known[name.lower()] for name in quantity.names if name.lower() in known), None)


def missing(contents: Contents, quantity: Quantity, wishes: Wishes) -> str:
    """What was looked for, and what there is."""
    if quantity.name in wishes.variables:
        return f"no variable {wishes.variables[quantity.name]!r}; the file has {', '.join(sorted(contents))}"
    other = [f"{v.name} has standard_name {_standard(v)}" for v in contents.values()
             if v.name in quantity.names and _standard(v)]  # fmt: skip
    return (f"no variable for {quantity.name}: looked for standard_name {' or '.join(quantity.standard)} and for names "
            f"{', '.join(quantity.names)}; the file has {', '.join(sorted(contents))}"
            f"{'; ' + '; '.join(other) if other else ''}. Name it under variables.{quantity.name}")  # fmt: skip


def _standard(variable: Variable) -> str:
    """The standard name without a modifier; empty if there is none, or none that means anything."""
    name = variable.text("standard_name").partition(" ")[0]
    return "" if name == "unknown" else name


def sense(variable: Variable, quantity: Quantity, wishes: Wishes, notes: list[str]) -> Sense:
    """Whether a direction is the one that waves, wind or water come from or go to. Raises `SceneError` where the attributes
    contradict each other."""
    if wishes.sense:
        return wishes.sense
    standard = _standard(variable)
    said: dict[str, Sense | None] = {
        "standard_name": _word(standard.replace("_", " ")) or ("to" if standard.startswith("direction_of_") else None),
        "long_name": _word(variable.text("long_name")),
        "name": _word(variable.name.replace("_", " ")),
    }
    known: list[tuple[str, Sense]] = [(where, word) for where, word in said.items() if word]
    if len({word for _, word in known}) > 1:
        raise variable.fault(" and ".join(where for where, _ in known), "one says that the direction is the one they come "
                             "from, the other that it is the one they go to; write direction_is")  # fmt: skip
    if known:
        return known[0][1]
    usual: Sense = quantity.sense or "from"
    if variable.name.lower() not in {name.lower() for name in quantity.names}:
        notes.append(f"{variable.file.name}: {variable.name}: nothing says whether this direction is the one they come from or "
                     f"go to: taken as {usual}")  # fmt: skip
    return usual


def _word(text: str) -> Sense | None:
    """What the words of a text say."""
    source = re.search(r"\b(from|coming)\b", re.sub(r"(clockwise|measured|relative)\s+from", "", text.lower()))
    goal = re.search(r"\b(to|toward|towards|going|heading)\b", re.sub(r"relative\s+to", "", text.lower()))
    if bool(source) == bool(goal):
        return None
    return "from" if source else "to"
