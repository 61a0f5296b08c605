r"""Scatter diagrams: how often a sea of some significant height and period occurs, by month where that is known.

    # what follows a # is left out
    Hs [m] \ Tz [s], 3.5,  4.5,   5.5
    0.5,             1.3,  133.7, 865.6
    1.5,             0,    29.3,  986.0

Rows are classes of Hs, columns classes of Tp (peak period) or Tz (mean zero-upcrossing period), each named by its middle; heights
in m or ft. Values are counts or probabilities, whose sum is taken for the whole. With months, a first column `month` has 1 to 12
or names of months, and the heights repeat in each; months weigh by their sums, as they were counted.

A mean period becomes a peak period by the spectrum, Tp = Tz sqrt(m2/m0) with moments over all frequencies, for m0 = omega_p = 1:
1.408 for Bretschneider and Pierson-Moskowitz, 1.286 for JONSWAP with gamma = 3.3.
"""

from __future__ import annotations

import calendar
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage import reading
from towage.data.columns import named, split
from towage.errors import FileError, SceneError, suggest
from towage.files import reason
from towage.fmus.declare.quantities import QuantityError, convert
from towage.models.sea import waves
from towage.reading import Refused

Array = NDArray[np.float64]
STANDARD = {"north_atlantic": Path(__file__).with_name("north_atlantic.csv")}
"""Diagrams that are shipped, by name."""
MONTHS = tuple(name.lower() for name in calendar.month_name[1:])
MOST = 100
"""Rows of a month, and columns."""
HIGHEST, LONGEST = 40.0, 60.0
"""Of a height, m, and of a period, s: beyond, units of measure are mistaken."""


@dataclass(frozen=True)
class Scatter:
    """``heights``, m, and ``periods``, s, rising, of the classes; ``kind`` of the period: "Tp" or "Tz"; ``weights``: shares of
    the time, shape (months, heights, periods), adding to 1; ``months``: their names, one "" where there are none. ``total``: of
    the numbers in the file. ``source``: where they are from, in words."""

    heights: Array
    periods: Array
    kind: str
    weights: Array
    months: tuple[str, ...]
    total: float
    source: str

    @property
    def share(self) -> Array:
        """Shares of the year, shape (heights, periods)."""
        return np.asarray(self.weights.sum(axis=0))


def load(what: str) -> Scatter:
    """A shipped diagram by its name, or one from a CSV file. Raises `SceneError` for neither, `FileError` with file and line
    for what cannot be meant."""
    path = STANDARD.get(what, Path(what))
    if what not in STANDARD and not path.is_file():
        known = ", ".join(STANDARD)
        raise SceneError(
            f"{what!r} is no file and no shipped diagram ({known}){suggest(what, STANDARD)}", key="--scatter"
        )
    try:
        text = reading.content(path, reading.MAX_TEXT).decode("utf-8")
        return parsed(text, what)
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: expected UTF-8 text, byte {error.start} is none") from error
    except Refused as error:
        raise FileError(f"{path}: {error}") from error
    except OSError as error:
        raise FileError(f"{path}: {reason(error)}") from error


def parsed(text: str, source: str = "") -> Scatter:
    """The diagram in a CSV text. Raises `Refused` with the line."""
    lines = [(k, line.partition("#")[0].strip()) for k, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1)]
    lines = [(k, line) for k, line in lines if line]
    if len(lines) < 2:
        raise Refused("expected a line 'Hs [m] \\ Tp [s], period, period, ...' and a line a height")
    number, head = lines[0][0], split(lines[0][1])
    monthly = head[0].lower() == "month"
    kind, factor = _corner(head[monthly] if len(head) > monthly else "", f"line {number}")
    periods = [_number(cell, f"line {number}, a period", 0.1, LONGEST) for cell in head[1 + monthly :]]
    if not periods or len(periods) > MOST:
        raise Refused(f"line {number}: {len(periods)} periods; expected 1 to {MOST}")
    _rising(periods, f"line {number}: periods")
    months: dict[str, dict[float, list[float]]] = {}
    for k, line in lines[1:]:
        cells = split(line)
        if len(cells) != len(head):
            raise Refused(f"line {k}: {len(cells)} values for {len(head)} columns")
        rows = months.setdefault(_month(cells[0], k) if monthly else "", {})
        height = factor * _number(cells[monthly], f"line {k}, column 'Hs'", 1e-3, HIGHEST / factor)
        if height in rows or (rows and height < max(rows)):
            raise Refused(
                f"line {k}: Hs = {cells[monthly]} {'is there already' if height in rows else 'is out of order'}"
            )
        rows[height] = [
            _number(cell, f"line {k}, column {name}", 0.0, 1e12)
            for cell, name in zip(cells[1 + monthly :], head[1 + monthly :])
        ]
        reading.limited(len(rows), MOST, "heights")
    return _made(months, np.array(periods), kind, source)


def _made(months: dict[str, dict[float, list[float]]], periods: Array, kind: str, source: str) -> Scatter:
    """Months in the order of the year, with all heights that any of them has."""
    heights = sorted({height for rows in months.values() for height in rows})
    names = sorted(months, key=lambda name: MONTHS.index(name) if name else 0)
    none = [0.0] * len(periods)
    counts = np.array([[months[name].get(height, none) for height in heights] for name in names])
    total = float(counts.sum())
    if not total > 0.0:
        raise Refused("all values are 0: expected counts or probabilities")
    for name, of_month in zip(names, counts):
        if not of_month.any():
            raise Refused(f"{name}: all values are 0; leave out a month without data")
    return Scatter(np.array(heights), periods, kind, counts / total, tuple(names), total, source)


def _corner(text: str, where: str) -> tuple[str, float]:
    r"""Kind of the periods and factor from heights to m, of "Hs [m] \ Tz [s]"."""
    expected = (
        f"{where}: expected 'Hs [m] \\ Tp [s]' or 'Hs [m] \\ Tz [s]' at the head of the heights, got {text[:40]!r}"
    )
    parts = [named(part) for part in text.replace("/", "\\").split("\\")]
    if len(parts) != 2:
        raise Refused(expected)
    (height, unit), (period, of_period) = parts
    kinds = {kind.lower(): kind for kind in ("Tp", "Tz")}
    if height.lower() != "hs" or period.lower() not in kinds:
        raise Refused(expected)
    if of_period != "s":
        raise Refused(f"{where}: periods in {of_period or 'no unit'}: expected [s]")
    try:
        return kinds[period.lower()], convert(1.0, unit, "m")
    except QuantityError as error:
        raise Refused(f"{where}: heights: {error}; expected [m] or [ft]") from None


def _month(text: str, line: int) -> str:
    name = text.strip().strip('"').lower()
    if name.isdecimal() and 1 <= int(name) <= 12:
        return MONTHS[int(name) - 1]
    found = [month for month in MONTHS if len(name) >= 3 and month.startswith(name)]
    if len(found) != 1:
        raise Refused(f"line {line}, column 'month': expected 1 to 12 or the name of a month, got {text[:40]!r}")
    return found[0]


def _number(text: str, where: str, low: float, high: float) -> float:
    try:
        value = float(text)
    except ValueError:
        raise Refused(f"{where}: expected a number, got {text[:40]!r}") from None
    if not low <= value <= high:
        raise Refused(f"{where}: {text[:40]}: expected {low:g} to {high:g}")
    return value


def _rising(values: Sequence[float], what: str) -> None:
    for before, after in pairwise(values):
        if not after > before:
            raise Refused(f"{what}: {after:g} follows {before:g}; expected rising values")


def peak_over_mean(gamma: float) -> float:
    """Tp/Tz of a JONSWAP spectrum of this ``gamma``, 1: Bretschneider."""
    top = 20.0

    def moment(power: int) -> float:
        """Of x^power b(x), the tail beyond ``top`` in closed form: there b = C 5 x^-5 exp(-5/4 x^-4)."""
        body = waves.integrate(lambda x: x**power * waves.shape(x, gamma), 0.2, top)
        ratio = waves.shape(top, gamma) / waves.shape(top, 1.0)
        tail = 5.0 * top ** (power - 4) / (4 - power) - 6.25 * top ** (power - 8) / (8 - power)
        return body + ratio * tail

    return math.sqrt(moment(2) / moment(0))
