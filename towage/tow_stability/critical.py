"""Critical tow speeds of a slender body, and maps of them over a parameter of its design.

A row of a map is computed once and kept in the cache, under a name made of all that it follows from: the body, the range
of speeds, and the code (`units.sources`).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.files import atomic_write, sealed, unsealed
from towage.models.slender import critical as slender_critical
from towage.models.slender.coefficients import Body
from towage.models.slender.modes import growth_rate, matrices
from towage.models.slender.tracking import Path as ModePath
from towage.models.slender.tracking import track
from towage.units.sources import code_digest
from towage.units.store import cache

Array = NDArray[np.float64]
Report = Callable[[float, str], None]
FUNCTIONS = 20
"""Shape functions of the maps: modes to 1e-8 up to u = 12."""
RANGES: dict[str, tuple[float, float, str]] = {
    "tail_cut": (0.02, 1.0, "tail cut, - (1 full, towards 0 flat)"),
    "rope_length": (0.1, 10.0, "rope length / body length"),
    "slenderness": (20.0, 100.0, "length / diameter"),
    "end_length": (0.013, 0.1, "length of nose and tail / body length"),
    "tail_length": (0.013, 0.1, "length of the tail / body length"),
    "friction": (0.2, 3.0, "friction coefficient times length / diameter"),
}
"""Parameters that a map may run over: default range and axis title."""


@dataclass(frozen=True)
class Row:
    """Critical speeds of one body, in u, and frequencies omega tau. ``yaw``: a real exponent passes zero; ``flutter``:
    (u, omega, whether growth begins above u); ``stable``: intervals (from, to) without a growing mode."""

    value: float
    yaw: tuple[float, ...]
    flutter: tuple[tuple[float, float, bool], ...]
    stable: tuple[tuple[float, float], ...]


def varied(body: Body, parameter: str, value: float) -> Body:
    """``body`` with another value of one of `RANGES`; lengths are over that of the body. With another slenderness the drag
    coefficients and the ratio of end length to body length stay; with another ``end_length`` the tail is as long. Raises
    ``ValueError`` where there is no such body."""
    if parameter == "slenderness":
        ratio = value / body.slenderness
        return replace(
            body, slenderness=value, friction=body.friction * ratio, normal_drag=body.normal_drag * ratio
        )
    if parameter == "end_length":
        return replace(body, end_length=value, tail_length=0.0)
    if parameter not in RANGES:
        raise ValueError(f"no map over {parameter!r}: expected one of {', '.join(RANGES)}")
    changed: dict[str, Any] = {parameter: value}
    return replace(body, **changed)


def row(body: Body, value: float = 0.0, u_max: float = 12.0, n: int = FUNCTIONS, step: float = 0.05) -> Row:
    """Critical speeds up to ``u_max`` and the stable intervals between them, in u = sqrt(M/EI) U L.

    ``n``: shape functions; ``step``: of u, in which a growing mode is looked for. ``value``: kept in the row."""
    yaw = slender_critical.yaw(body, u_max, n)
    flutter = slender_critical.oscillatory(body, u_max, n, step)
    edges = [0.0, *sorted([*yaw, *(c.u for c in flutter)]), u_max]
    stable: list[tuple[float, float]] = []
    for low, high in pairwise(edges):
        if high - low > 1e-9 and growth_rate(body, 0.5 * (low + high), n) < 0.0:
            joined = stable and stable[-1][1] == low
            stable[-1:] = [(stable[-1][0], high)] if joined else [*stable[-1:], (low, high)]
    return Row(value, tuple(yaw), tuple((c.u, c.omega, c.destabilising) for c in flutter), tuple(stable))


def default_values(body: Body, parameter: str, points: int) -> list[float]:
    """``points`` values over the parameter's range; rope lengths in equal ratios, slenderness from where the ends of the
    body are longer than hemispheres."""
    low, high, _ = RANGES[parameter]
    if parameter == "slenderness":
        low = max(low, 0.51 / body.end_length)
        high = max(high, 3.0 * low)
    if parameter in ("end_length", "tail_length"):
        low = max(low, 0.51 / body.slenderness)
        high = max(high, 3.0 * low)
    space = np.geomspace if parameter == "rope_length" else np.linspace
    return [float(v) for v in space(low, high, points)]


def stability_map(
    body: Body, parameter: str, values: Sequence[float], u_max: float = 12.0, report: Report | None = None
) -> list[Row]:
    """A row for each value of ``parameter``; ``report`` hears (share done, what). Raises ``ValueError`` where the theory
    has no such body."""
    say = report or (lambda share, text: None)
    rows = []
    for k, value in enumerate(values):
        say(k / len(values), f"{parameter} = {value:.4g}")
        rows.append(_kept(varied(body, parameter, value), float(value), u_max))
    say(1.0, "done")
    return rows


def _kept(body: Body, value: float, u_max: float) -> Row:
    """The row, from the cache if it is there; a cache that cannot be read or written is left alone."""
    key = hashlib.sha256(json.dumps([code_digest(__name__), asdict(body), u_max, FUNCTIONS]).encode()).hexdigest()[:32]
    path = cache() / "stability" / f"{key}.json"
    try:
        return _row_of(unsealed(path.read_bytes()), value)
    except (OSError, ValueError, KeyError, TypeError):
        pass
    made = row(body, value, u_max)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as stream:
            stream.write(sealed(asdict(made)))
    except OSError:
        pass
    return made


def _row_of(data: dict[str, Any], value: float) -> Row:
    return Row(
        value, tuple(data["yaw"]), tuple((u, w, bool(d)) for u, w, d in data["flutter"]),
        tuple((a, b) for a, b in data["stable"]),
    )  # fmt: skip


def argand(body: Body, speeds: Array, count: int = 6, n: int = 26) -> list[ModePath]:
    """The first ``count`` modes over ``speeds`` (u, ascending, from above 0): exponents s in 1/tau, omega = -i s. ``n``:
    shape functions."""
    return track(matrices(body, n), speeds, within=500.0, count=count)
