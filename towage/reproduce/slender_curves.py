"""What several figures of the thesis on the towed slender body are made of: loci, critical points, maps.

Roots and critical speeds are those of the Galerkin form (26 functions); each is found again as a zero of the determinant of the
power series about the middle (90 terms), from where `Answer.methods` is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from towage.models.slender.coefficients import Body
from towage.models.slender.critical import Critical, oscillatory
from towage.models.slender.series import MIDDLE, refine
from towage.models.slender.tracking import Path as ModePath
from towage.reproduce import plots
from towage.reproduce.items import Answer, Column
from towage.tow_stability.critical import Row, argand, default_values, row, stability_map, varied
from towage.tow_stability.plots import argand_plot, map_plot

Array = NDArray[np.float64]
TERMS = 90
"""Of the series about the middle: good to 1e-14 up to u = 12."""
BY = "Galerkin's form and the determinant of the series"
ROPES = (0.5, 1.0, 5.0, 10.0)
SPEEDS = np.linspace(0.05, 12.0, 240)
THESIS = Body()


def old_theory(f1: float, f2: float) -> Body:
    """The body with the tail cut at .7 under the old theory with these factors."""
    return replace(THESIS, theory="modified_old", tail_cut=0.7, nose_factor=f1, tail_factor=f2)


def second_mode(bodies: dict[str, Body], title: str) -> Answer:
    """Where the second mode of each body begins and ends to grow, and its locus."""
    numbers, paths, worst = {}, {}, 0.0
    for name, body in bodies.items():
        mode = onset_and_end(oscillatory(body, 12.0))
        for c in mode:
            numbers[f"{name}: grows {'from' if c.destabilising else 'up to'} u"] = complex(c.u)
        worst = max(worst, by_series(body, [(c.u, c.omega) for c in mode]))
        paths[name] = argand(body, SPEEDS)[2]
    return Answer(numbers, columns_of(paths), argand_picture(title, paths), worst, BY)


def onset_and_end(found: Sequence[Critical]) -> list[Critical]:
    """Of the second mode, by its band of frequencies, the first point at which growth begins, and the next at which it ends."""
    found = [c for c in found if 15.0 < c.omega < 60.0]
    begin = min((c for c in found if c.destabilising), key=lambda c: c.u)
    ends = [c for c in found if not c.destabilising and c.u > begin.u]
    return [begin, *sorted(ends, key=lambda c: abs(c.omega - begin.omega))[:1]]


def two_modes(rope: float) -> Answer:
    """Zeroth and first mode with a rope of so many lengths, and where the first grows."""
    body = replace(THESIS, rope_length=rope)
    answer = loci(body, slice(0, 2), f"Zeroth and first mode, Lam = {rope:g}")
    first = by_mode(rope)
    numbers = {"first mode: grows from u": first["first begins"].u, "first mode: grows up to u": first["first ends"].u}
    return replace(answer, numbers={name: complex(u) for name, u in numbers.items()})


def loci(body: Body, which: slice, title: str) -> Answer:
    """Modes over speed, compared with the series at twelve of the speeds."""
    paths = argand(body, SPEEDS)[which]
    places = range(5, len(SPEEDS), 20)
    worst = by_series(body, [(float(SPEEDS[k]), -1j * path.roots[k, 0]) for path in paths for k in places])
    names = [f"mode {k}" for k in range(*which.indices(9))]
    named = dict(zip(names, paths))
    return Answer({}, columns_of(named), argand_picture(title, named), worst, BY)


def argand_picture(title: str, paths: dict[str, ModePath]) -> Callable[[Path], None]:
    """Draws the loci."""
    return partial(
        argand_plot, title=title, speeds=SPEEDS, modes=list(paths.values()), speed_scale=1.0, names=list(paths), unit=""
    )


def columns_of(paths: dict[str, ModePath]) -> dict[str, Column]:
    """The loci as columns."""
    columns: dict[str, Column] = {"u": SPEEDS}
    for name, path in paths.items():
        for k, branch in enumerate(("", ", second branch")):
            omega = -1j * path.roots[:, k]
            columns |= {f"Re omega, {name}{branch}": omega.real, f"Im omega, {name}{branch}": omega.imag}
    return columns


def by_series(body: Body, points: Sequence[tuple[float, complex]]) -> float:
    """Largest difference between frequencies omega at tow speeds u and the zeros of the series next to them, relative to |omega|
    or 1."""
    worst = 0.0
    for u, omega in points:
        s = 1j * complex(omega)
        found = refine(body, u, s, TERMS, MIDDLE)
        worst = max(worst, abs(found - s) / max(1.0, abs(s)))
    return worst


@lru_cache
def by_mode(rope: float) -> dict[str, Critical]:
    """The first critical points of the first to fourth mode, told apart by the band of their frequency."""
    found = sorted(oscillatory(replace(THESIS, rope_length=rope), 12.0), key=lambda c: c.u)
    bands = {"first begins": (0.0, 10.0), "second": (15.0, 30.0), "third": (45.0, 70.0), "fourth": (90.0, 120.0)}
    first = {name: next(c for c in found if c.destabilising and a < c.omega < b) for name, (a, b) in bands.items()}
    return first | {"first ends": next(c for c in found if not c.destabilising and c.omega < 10.0)}


@lru_cache
def row_of(rope: float) -> Row:
    """Critical speeds with a rope of so many lengths."""
    return row(replace(THESIS, rope_length=rope), rope)


@lru_cache
def rows_over(parameter: str, body: Body = THESIS) -> list[Row]:
    """Critical speeds over the default range of a parameter."""
    return stability_map(body, parameter, default_values(body, parameter, 41))


def map_over(parameter: str, body: Body, numbers: dict[str, complex]) -> Answer:
    """A map, of which some rows are compared with the series."""
    rows = rows_over(parameter, body)
    points = [(r, u, 0.0) for r in rows for u in r.yaw] + [(r, u, w) for r in rows for u, w, _ in r.flutter]
    columns: dict[str, Column] = {
        parameter: [r.value for r, _, _ in points], "u": [u for _, u, _ in points], "omega tau": [w for _, _, w in points],
    }  # fmt: skip
    worst = 0.0
    for r in rows[:: max(1, len(rows) // 8)]:
        here = [(u, 0.0) for u in r.yaw] + [(u, w) for u, w, _ in r.flutter]
        worst = max(worst, by_series(varied(body, parameter, r.value), here))
    draw = partial(map_plot, title="Stability", parameter=parameter, rows=rows, u_max=12.0, speed_scale=1.0)
    return Answer(numbers, columns, draw, worst, BY)


def critical_over(rows: list[Row], kind: str, title: str, up: str) -> Answer:
    """Critical points over the rope, drawn by speed (``kind`` u) or by frequency (omega)."""
    whole = map_over("rope_length", THESIS, {})
    points = [(r.value, u, w, grows) for r in rows for u, w, grows in r.flutter]
    columns: dict[str, Column] = {
        "rope length / length": [p[0] for p in points], "u": [p[1] for p in points], "omega tau": [p[2] for p in points],
        "growth": ["begins" if p[3] else "ends" for p in points],
    }  # fmt: skip
    drawn = {"growth begins": True, "growth ends": False}
    series = {
        name: ([p[0] for p in points if p[3] == begins], [p[1 if kind == "u" else 2] for p in points if p[3] == begins])
        for name, begins in drawn.items()
    }
    draw = partial(plots.points, title=title, across="rope length / length", up=up, series=series, log=(True, False))
    return replace(whole, numbers={}, columns=columns, draw=draw)


