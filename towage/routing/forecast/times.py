"""Times of data files: their origin, calendar and zone (cftime), in s.

An instant of a calendar of this world (standard, gregorian, proleptic_gregorian, julian, utc) is counted in s from the
beginning of 1970, UTC; one of a model's calendar (noleap, all_leap, 360_day and their other names) in s of that calendar,
and a departure is the instant of that date in it.
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from towage.fmus.declare.quantities import QuantityError
from towage.routing.forecast.contents import Variable
from towage.routing.forecast.units import factor

Array = NDArray[np.float64]
WORLD = ("standard", "gregorian", "proleptic_gregorian", "julian", "utc")
MODEL = {"noleap": "noleap", "365_day": "noleap", "all_leap": "all_leap", "366_day": "all_leap", "360_day": "360_day"}
_EPOCH = 2440588
"""Day number of 1970-01-01."""


@dataclass(frozen=True)
class Times:
    """``seconds`` (n,) in ``calendar``: world, a model's, or relative where the file names no origin."""

    seconds: Array
    calendar: str


def read(variable: Variable) -> Times:
    """Instants of a time coordinate. Raises `SceneError` that names the attribute."""
    unit, values = variable.text("units"), np.atleast_1d(variable.load()).ravel()
    if not np.all(np.isfinite(values)):
        raise variable.fault("", f"{int(np.sum(~np.isfinite(values)))} of {len(values)} times are missing")
    if " since " not in unit:
        try:
            return Times(np.round(values * factor(unit, "s"), 3), "relative")
        except QuantityError as error:
            raise variable.fault("units", f"{unit!r}: expected 'hours since 2020-01-01' ({error})") from None
    import cftime

    calendar = variable.text("calendar").lower() or "standard"
    if calendar not in WORLD and calendar not in MODEL:
        raise variable.fault("calendar", f"{calendar!r}: expected one of: {', '.join((*WORLD, *MODEL))}")
    try:
        first, second = cftime.num2date([0, 1], unit, "standard" if calendar == "utc" else calendar)
    except (ValueError, OverflowError, TypeError) as error:  # TypeError: a date without a day
        raise variable.fault("units", f"{unit!r}: expected 'hours since 2020-01-01 00:00:00' ({error})") from error
    step = (second - first).total_seconds()
    return Times(np.round(instant(first) + values * step, 3), MODEL.get(calendar, "world"))


def instant(date: object) -> float:
    """Seconds of a cftime date from the beginning of 1970 of its calendar; of this world's calendars, of the world's."""
    day = date.toordinal() - _EPOCH  # type: ignore[attr-defined]
    clock = date.hour * 3600.0 + date.minute * 60.0 + date.second + 1e-6 * date.microsecond  # type: ignore[attr-defined]
    return float(day * 86400.0 + clock)


def departure_seconds(departure: datetime.datetime, calendar: str) -> float:
    """The instant of a departure, UTC where it has no zone. Raises ``ValueError`` for a date that the calendar lacks."""
    import cftime

    utc = departure.astimezone(datetime.UTC) if departure.tzinfo else departure
    named = "proleptic_gregorian" if calendar == "world" else calendar
    return instant(cftime.datetime(utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second, utc.microsecond,
                                   calendar=named))  # fmt: skip
