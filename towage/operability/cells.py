"""The runs of an operability study: the seas of a scatter diagram from every heading, some seeds each.

The sea goes to the one unit of the scene with inputs `wave_height`, `wave_period`, `wave_direction` that nothing feeds, and
a parameter `seed` (`ship_in_sea`). A cell is a heading, a height and a period with a share of the time. All heights of a heading
and a period have the same seeds, so that limits do not jump from height to height by chance; no other cells share one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from towage.errors import SceneError
from towage.fmus.declare.quantities import QuantityError, parse_quantity
from towage.operability.scatter import Scatter, peak_over_mean
from towage.scene.resolve import ResolvedScene
from towage.sweeps.design import MOST, Design

Array = NDArray[np.float64]
SEA = ("wave_height", "wave_period", "wave_direction")
OTHER_SHAPE = {"order": 1.0, "second_share": 0.0}
"""Parameters that make another spectrum than one peak of JONSWAP's, and their values where they do not."""


@dataclass(frozen=True)
class Headings:
    """``angles``, rad, between the course and the waves' travel (pi: head sea), and their probabilities, adding to 1."""

    angles: tuple[float, ...]
    shares: tuple[float, ...]

    @property
    def degrees(self) -> tuple[float, ...]:
        """In whole tenths, for names."""
        return tuple(round(math.degrees(angle), 1) for angle in self.angles)


@dataclass(frozen=True)
class Cells:
    """``unit`` takes the sea; ``peaks``: peak periods, s, of the columns of ``scatter``; ``run``: of each heading, the one
    whose runs it takes (its own, or its mirror); ``places``: heading, height and period of every cell with runs, (cells, 3);
    ``note``: what was converted. ``seeds`` a cell, from ``first`` on; ``length`` of a record, s."""

    unit: str
    scatter: Scatter
    peaks: Array
    headings: Headings
    run: tuple[int, ...]
    places: NDArray[np.int64]
    seeds: int
    first: int
    length: float
    note: str

    def design(self) -> Design:
        """The runs, all seeds of a cell one after the other."""
        heading, height, period = self.places.T
        sea = np.stack(
            [self.scatter.heights[height], self.peaks[period], np.array(self.headings.angles)[heading]], axis=1
        )
        base = self.first + self.seeds * (heading * len(self.peaks) + period)
        seeds = base[:, None] + np.arange(self.seeds)
        points = np.concatenate([np.repeat(sea, self.seeds, axis=0), seeds.reshape(-1, 1)], axis=1)
        names = tuple(f"{self.unit}.{name}" for name in (*SEA, "seed"))
        if len(points) > MOST:
            raise SceneError(f"{len(points)} runs, more than {MOST}: take fewer headings or seeds", key="--seeds")
        text = f"{len(self.places)} cells, {self.seeds} seeds each"
        return Design(names, ("m", "s", "rad", "1"), points, (), (False,) * 4, text)

    @property
    def hours(self) -> float:
        """Simulated time of all runs without transients, h."""
        return len(self.places) * self.seeds * self.length / 3600.0


def headings(texts: Sequence[str]) -> Headings:
    """``["12"]``: so many, equally far apart from 0 on; else directions "180" or "180 deg" (a number is in degrees), each with
    "=PROBABILITY" or all without. Raises `SceneError`."""
    if len(texts) == 1 and texts[0].strip().isdecimal() and 1 <= int(texts[0]) <= 72:
        count = int(texts[0])
        return Headings(tuple(2.0 * math.pi * k / count for k in range(count)), (1.0 / count,) * count)
    expected = "expected a number of headings, as 12, or directions with or without probabilities, as '180=0.5,150=0.25,210=0.25'"
    angles, shares = [], []
    for text in (part.strip() for whole in texts for part in whole.split(",")):
        direction, equals, share = (part.strip() for part in text.partition("="))
        try:
            angles.append(_angle(direction) % (2.0 * math.pi))
            shares.append(float(share) if equals else math.nan)
            if equals and not 0.0 < shares[-1] < math.inf:
                raise ValueError
        except (ValueError, QuantityError):
            raise SceneError(f"{text!r}: {expected}", key="--headings") from None
    if len({round(angle, 9) for angle in angles}) < len(angles):
        raise SceneError("a heading is given twice", key="--headings")
    if len({math.isnan(share) for share in shares}) > 1:
        raise SceneError("some headings have a probability and some have none: give all or none", key="--headings")
    shares = [1.0] * len(shares) if math.isnan(shares[0]) else shares
    return Headings(tuple(angles), tuple(share / math.fsum(shares) for share in shares))


def _angle(text: str) -> float:
    try:
        return math.radians(float(text))
    except ValueError:
        return parse_quantity(text, "rad")


def cells(
    resolved: ResolvedScene,
    scatter: Scatter,
    chosen: Headings,
    seeds: int,
    first: int,
    length: float,
    mirror: bool = False,
) -> Cells:
    """The cells of a scene in these seas. ``mirror``: a heading whose mirror (2 pi - beta) is there too takes its runs, which
    `ensembles.mirrored` has to allow. Raises `SceneError`."""
    unit = sea_unit(resolved)
    peaks, note = _peaks(resolved, unit, scatter)
    run = tuple(_mirror(chosen.angles, k) if mirror else k for k in range(len(chosen.angles)))
    rows, columns = np.nonzero(scatter.share > 0.0)
    order = np.lexsort((rows, columns))
    own = [k for k in range(len(run)) if run[k] == k]
    places = np.array([(k, rows[i], columns[i]) for k in own for i in order], np.int64)
    return Cells(unit, scatter, peaks, chosen, run, places, seeds, first, length, note)


def _mirror(angles: Sequence[float], k: int) -> int:
    """The first heading that is this one or its mirror."""
    turn = 2.0 * math.pi
    for j in range(k):
        off = (angles[j] + angles[k]) % turn
        if min(off, turn - off) < 1e-9:
            return j
    return k


def sea_unit(resolved: ResolvedScene) -> str:
    """The unit that takes the sea. Raises `SceneError` where there is none, or more than one, or its sea is fed to it."""
    fed = {f"{c.target_unit}.{c.target}" for c in resolved.connections}
    found = []
    for name, unit in resolved.units.items():
        known = unit.description.by_name()
        if all(variable in known for variable in (*SEA, "seed")):
            found.append(name)
    if len(found) != 1:
        raise SceneError(
            f"{len(found)} units ({', '.join(found) or 'none'}) with inputs {', '.join(SEA)} and a parameter seed, as those of "
            "ship_in_sea: expected one, which takes the seas of the diagram",
            file=resolved.scene.file, key="units",
        )  # fmt: skip
    for variable in SEA:
        if f"{found[0]}.{variable}" in fed:
            raise SceneError(
                f"{found[0]}.{variable} is fed by another unit, so that it cannot take the seas of the diagram: leave the "
                "connection out",
                file=resolved.scene.file, key="connections",
            )  # fmt: skip
    return found[0]


def _peaks(resolved: ResolvedScene, unit: str, scatter: Scatter) -> tuple[Array, str]:
    """Peak periods of the columns, and how they were found."""
    if scatter.kind == "Tp":
        return scatter.periods, "periods of the diagram are peak periods"
    entry = resolved.units[unit]
    start = {v.name: v.start for v in entry.description.variables if v.causality == "parameter"}
    values = {**start, **entry.parameters}
    if "spectrum" in resolved.scene.units[unit].files or any(values.get(n, v) != v for n, v in OTHER_SHAPE.items()):
        raise SceneError(
            f"{unit} has a spectrum of its own shape, for which Tz of the diagram gives no peak period: give a diagram over Tp",
            file=resolved.scene.file, key="--scatter",
        )  # fmt: skip
    gamma = float(values["peakedness"])  # type: ignore[arg-type]
    factor = peak_over_mean(gamma)
    name = f"JONSWAP with gamma = {gamma:g}" if gamma > 1.0 else "Bretschneider (Pierson-Moskowitz)"
    return factor * scatter.periods, f"Tp = {factor:.4g} Tz, of the spectrum of {unit}: {name}"
