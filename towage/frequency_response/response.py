"""The response of a scene's tows to motion of the towpoint, or to forces on the body, over frequency.

Linear theory of the cable (`models.cable.steady`): complex amplitudes q of Re(q exp(-i omega t)), so that a phase is the
lag of a cosine, q = |q| cos(omega t - phase).

Source: the small-perturbation report on towed cables (programs OMWAY and OMFLO).
"""

from __future__ import annotations

import cmath
import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from towage.checks.towing import Gain, SceneTow, gains, tows
from towage.errors import SceneError
from towage.files import atomic_write
from towage.frequency_response.along import STATIONS, Row, along
from towage.frequency_response.excitation import excitation_of, in_words
from towage.models.cable.steady.perturbation import Excitation
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import select
from towage.units.store import locator

COLUMNS = ("tension_top", "tension_body", "body_surge", "body_heave")
"""Complex amplitudes of a `Gain`, N and m."""
LOWEST, HIGHEST, POINTS = 0.02, 1.0, 40
"""Default frequencies: from, to, Hz, and how many, in equal ratios: the waves that a ship answers to."""


@dataclass(frozen=True)
class Response:
    """The response of one tow to ``excitation``. ``gains``: one for each angular frequency, rad/s."""

    tow: SceneTow
    gains: tuple[Gain, ...]
    excitation: Excitation

    @property
    def name(self) -> str:
        """Of the unit in the scene."""
        return self.tow.name

    @property
    def per(self) -> str:
        """What the amplitudes are for: "1 m of heave of the towpoint"."""
        return in_words(self.excitation)

    def rows(self) -> list[dict[str, float | None]]:
        """A row a frequency: ``frequency_hz``; magnitude (N or m) and ``_phase`` (rad) of the tensions at the top and at
        the body and of the body's surge and heave; ``spring_heave``, the heave on a spring EA/L (None where that is not
        known, or infinite)."""
        table = []
        for gain in self.gains:
            row: dict[str, float | None] = {"frequency_hz": gain.omega / (2.0 * math.pi)}
            for name in COLUMNS:
                amplitude = getattr(gain, name)
                row[name], row[f"{name}_phase"] = abs(amplitude), cmath.phase(amplitude)
            row["spring_heave"] = gain.spring if gain.spring is None or math.isfinite(gain.spring) else None
            table.append(row)
        return table

    def second_rows(self) -> list[dict[str, float]]:
        """A row a frequency of what is of second order in `excitation`: ``_mean``, the shift of the mean, and ``_second`` and
        ``_second_phase``, magnitude and phase of what moves at twice the frequency, of the same tensions (N) and motions (m); the
        body's are from the towpoint. Raises `CableError` where they are not found."""
        from towage.models.cable.lumped.second_order import second_order

        quadratic, table = self.tow.parameters["body_quadratic_drag"] > 0.5, []
        for gain in self.gains:
            found = second_order(self.tow.tow, gain.omega, self.excitation, quadratic)
            row = {"frequency_hz": gain.omega / (2.0 * math.pi)}
            for name in COLUMNS:
                amplitude = getattr(found.second, name)
                row[f"{name}_mean"] = getattr(found.mean, name).real
                row[f"{name}_second"], row[f"{name}_second_phase"] = abs(amplitude), cmath.phase(amplitude)
            table.append(row)
        return table

    def text(self, most: int = 12) -> str:
        """A table for a terminal, of about ``most`` of the frequencies."""
        tow = self.tow.tow
        lines = [
            f"{self.name}: Quadrant {'I' * tow.quadrant}, {tow.cable.length:.4g} m at {tow.speed:.4g} m/s; for {self.per}",
            "      Hz    top tension, N, rad   body tension, N, rad     body heave, m, rad     body surge, m, rad    spring",
        ]
        for gain in self.gains[:: max(1, len(self.gains) // most)]:
            amplitudes = (gain.tension_top, gain.tension_body, gain.body_heave, gain.body_surge)
            cells = "".join(f"{abs(a):14.5g}{cmath.phase(a):9.4f}" for a in amplitudes)
            spring = "" if gain.spring is None else f"{gain.spring:10.4g}"
            lines.append(f"{gain.omega / (2.0 * math.pi):8.4g}{cells}{spring}")
        return "\n".join(lines)

    def along(self, hertz: float | None = None, stations: int = STATIONS) -> list[Row]:
        """Steady state and amplitudes along the cable (`along.along`) at ``hertz``, by default the frequency of the ship's
        heave, or the middle of the range without a ship."""
        return along(self.tow.tow, self._omega if hertz is None else 2.0 * math.pi * hertz, self.excitation, stations)

    @property
    def _omega(self) -> float:
        return self.tow.drive[1] if self.tow.drive else self.gains[len(self.gains) // 2].omega

    def save_csv(self, path: Path) -> None:
        """`rows` as CSV, empty where a value is None. Raises `TowageError` where it cannot be written."""
        save_rows(path, self.rows())

    def save_plots(self, directory: Path) -> tuple[Path, Path]:
        """Writes ``<unit>_response.svg``, magnitude and phase over frequency, and ``<unit>_cable.svg``, steady shape and
        motion along the cable at the frequency that `along` takes."""
        from towage.frequency_response.plots import cable_plot, response_plot

        over_frequency, along_cable = (directory / f"{self.name}_{kind}.svg" for kind in ("response", "cable"))
        response_plot(over_frequency, self.name, self.per, list(self.gains))
        cable_plot(along_cable, self.tow, self._omega, self.excitation)
        return over_frequency, along_cable


def save_rows(path: Path, table: Sequence[Mapping[str, Any]]) -> None:
    """Rows of the same names as CSV, empty where a value is None. Raises `TowageError` where it cannot be written."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    with atomic_write(path) as stream:
        stream.write(text.getvalue().encode())


def response(
    scene: Scene | str | Path,
    case: str | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    frequencies: ArrayLike | None = None,
    excitation: Mapping[str, float | complex | str] | None = None,
    fmus: str | Path | None = None,
) -> list[Response]:
    """The frequency response of every tow of a scene: what ``towage response`` does.

        (tow,) = towage.response("tow_600ft")
        tow.rows()[0]["tension_top"]

    ``scene``, ``case``, ``set`` and ``fmus`` as in `towage.run`, but the scene as it stands if it has cases and none is
    named. ``frequencies``: Hz, above 0, by default 40 from 0.02 to 1. ``excitation``: amplitudes by name, of ``surge`` and
    ``heave`` of the towpoint, m, or ``drag`` and ``lift`` on the body, N: numbers, complex ones of Re(q exp(-i omega t)), or
    texts such as "2 ft @ 40 deg"; by default 1 m of heave in Quadrant I, 1 N of lift in Quadrant II. Nothing is written.

    Raises `SceneError` where the scene has no tow, one that the theory of the steady cable refuses, or one that cannot be
    driven so.
    """
    chosen = select(scene, case, set)
    hertz = np.geomspace(LOWEST, HIGHEST, POINTS) if frequencies is None else np.atleast_1d(np.asarray(frequencies, float))
    if hertz.ndim != 1 or not len(hertz) or not (np.isfinite(hertz) & (hertz > 0.0)).all():
        raise SceneError("frequencies: expected finite numbers of Hz, above 0")
    omegas: Sequence[float] = (2.0 * np.pi * hertz).tolist()
    try:
        found = tows(described(chosen, locator(Path(fmus) if fmus else None), open_ends=True))
        answers = []
        for tow in found:
            drive = excitation_of(excitation or {}, tow.tow.quadrant)
            answers.append(Response(tow, tuple(gains(tow.tow, list(omegas), drive)), drive))
    except ValueError as error:
        raise SceneError(str(error), file=chosen.file, key="units") from error
    if not answers:
        expected = "expected a unit tow_system or tow_cable, or a ship with a cradle on a line"
        raise SceneError(f"no tow and no lift: {expected}", file=chosen.file, key="units")
    return answers
