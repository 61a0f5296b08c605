"""Stability of the towed slender bodies of a scene over tow speed.

Speeds are dimensionless, u = sqrt(M/EI) U L (`models.slender.coefficients`); `Towed.speed_scale` turns them into m/s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from towage.errors import SceneError
from towage.files import atomic_write
from towage.fmus.slender_body import UNIT
from towage.models.slender import prepared as slender_prepared
from towage.models.slender import setup as slender_setup
from towage.models.slender.coefficients import Body
from towage.models.slender.rigid import neutral_tail_cut, yaw_criterion
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.scene.select import select
from towage.tow_stability.critical import RANGES, Report, Row, argand, default_values, row, stability_map
from towage.units.description import Value
from towage.units.store import locator

U_MAX = 12.0
"""Default range of u: 20 shape functions have its modes to 1e-8."""
POINTS = 41
"""Default number of rows of a map."""


@dataclass(frozen=True)
class Towed:
    """A unit `slender_body` of a scene: its name, SI parameters and the dimensionless body."""

    name: str
    parameters: slender_setup.Parameters
    body: Body

    @property
    def speed_scale(self) -> float:
        """Tow speed at u = 1, m/s."""
        return slender_prepared.prepare(self.parameters).speed

    @property
    def time_scale(self) -> float:
        """tau, s."""
        return slender_prepared.prepare(self.parameters).tau


def bodies(scene: Scene, fmus: Path | None = None) -> list[Towed]:
    """The slender bodies of a scene without cases. Raises `SceneError` if there is none, or if the theory has no such body."""
    resolved = described(scene, locator(fmus), open_ends=True)  # it finds the speeds itself
    towed = []
    for name, unit in resolved.units.items():
        if unit.description.model_name != UNIT.name:
            continue
        given: dict[str, Value] = unit.parameters
        values = {v.name: float(given.get(v.name, v.start or 0.0)) for v in UNIT.parameters}
        p = slender_setup.Parameters(**values)
        if refusal := slender_setup.refusal(p):
            raise scene.error(refusal, f"units.{name}.parameters")
        towed.append(Towed(name, p, slender_setup.body(p)))
    if not towed:
        raise SceneError(f"no unit of the scene is a {UNIT.name}", file=scene.file, key="units")
    return towed


@dataclass(frozen=True)
class Stability:
    """Of one body: ``limits``, its critical speeds up to ``u_max`` and the stable intervals; ``map``: the same for values
    of ``parameter``, if a map was asked for."""

    towed: Towed
    u_max: float
    limits: Row
    parameter: str | None = None
    map: tuple[Row, ...] = ()

    @property
    def name(self) -> str:
        """Of the unit in the scene."""
        return self.towed.name

    def document(self) -> dict[str, Any]:
        """Critical speeds and stable intervals, m/s and rad/s, as plain data."""
        v = self.towed.speed_scale
        return {
            "unit": self.name,
            "speed_scale_m_s": v,
            "time_scale_s": self.towed.time_scale,
            "yaw_m_s": [u * v for u in self.limits.yaw],
            "flutter": [
                {"tow_speed_m_s": u * v, "omega_rad_s": w / self.towed.time_scale, "growth_above": grows}
                for u, w, grows in self.limits.flutter
            ],
            "stable_m_s": [[a * v, b * v] for a, b in self.limits.stable],
        }

    def text(self) -> str:
        """A few lines for a terminal."""
        v, towed = self.towed.speed_scale, self.towed
        lines = [f"{self.name}: speeds up to {self.u_max * v:.4g} m/s (u = {self.u_max:g}; u = 1 is {v:.4g} m/s)"]
        lines += [f"  yaw      {u * v:9.4f} m/s  (u = {u:.6f})" for u in self.limits.yaw]
        lines += [
            f"  flutter  {u * v:9.4f} m/s  (u = {u:.6f}), {w / towed.time_scale:.4g} rad/s, "
            + ("begins" if grows else "ends")
            for u, w, grows in sorted(self.limits.flutter)
        ]
        windows = ", ".join(f"{a * v:.4g} to {b * v:.4g} m/s" for a, b in self.limits.stable) or "at no speed"
        lines.append(f"  stable   {windows}")
        if towed.body.theory != "modified_old":
            neutral = neutral_tail_cut(towed.body)
            rigid = "does not yaw away" if yaw_criterion(towed.body) > 0.0 else "yaws away at every speed"
            at = "" if neutral is None else f"; it is neutral with the tail cut at {neutral:.6f}"
            lines.append(f"  a rigid body of this shape {rigid}{at}")
        return "\n".join(lines)

    def save_csv(self, path: Path) -> None:
        """The map, a row a critical speed. Raises `TowageError` where it cannot be written."""
        v = self.towed.speed_scale
        lines = [f"{self.parameter},kind,u,tow_speed_m_s,omega_rad_s,growth_above"]
        for r in self.map:
            lines += [f"{r.value!r},yaw,{u!r},{u * v!r},0.0," for u in r.yaw]
            for u, omega, grows in r.flutter:
                lines.append(f"{r.value!r},flutter,{u!r},{u * v!r},{omega / self.towed.time_scale!r},{int(grows)}")
        with atomic_write(path) as stream:
            stream.write(("\n".join(lines) + "\n").encode())

    def save_plots(self, directory: Path) -> list[Path]:
        """Writes ``<unit>_argand.svg``, the modes over speed (computed now), and of a map ``<unit>_<parameter>.svg``."""
        from towage.tow_stability.plots import argand_plot, map_plot

        v = self.towed.speed_scale
        speeds = np.linspace(0.05, self.u_max, round(20 * self.u_max))
        files = [directory / f"{self.name}_argand.svg"]
        title = f"{self.name}: modes from {speeds[0] * v:.3g} to {speeds[-1] * v:.3g} m/s"
        argand_plot(files[0], title, speeds, argand(self.towed.body, speeds), v)
        if self.parameter:
            files.append(directory / f"{self.name}_{self.parameter}.svg")
            title = f"{self.name}: stability over {self.parameter}"
            map_plot(files[1], title, self.parameter, self.map, self.u_max, v)
        return files


def stability(
    scene: Scene | str | Path,
    case: str | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    u_max: float = U_MAX,
    map: str | None = None,
    values: Sequence[float] | int = POINTS,
    fmus: str | Path | None = None,
    report: Report | None = None,
) -> list[Stability]:
    """Critical tow speeds of every slender body of a scene: what ``towage stability`` does.

        (body,) = towage.stability("slender_flutter", map="tail_cut", values=[0.4, 0.9])
        body.document()["yaw_m_s"]

    ``scene``, ``case``, ``set`` and ``fmus`` as in `towage.run`, but the scene as it stands if it has cases and none is
    named. ``u_max``: largest dimensionless speed, above 0 and at most 14. ``map``: tail_cut, rope_length (over body length),
    slenderness, end_length, tail_length or friction, for ``values`` of which the critical speeds are computed too (a number:
    so many over the default range); rows of a map are kept in the cache. ``report``: told (share done, what) of a map. Nothing
    else is written.

    Raises `SceneError` where the scene has no slender body, where the theory has none of these values, and for a ``map``
    that there is not.
    """
    if map is not None and map not in RANGES:
        raise SceneError(f"{map!r}: expected one of {', '.join(RANGES)}", key="map")
    if not 0.0 < u_max <= 14.0:
        raise SceneError(f"{u_max}: expected a number above 0, at most 14", key="u_max")
    chosen = select(scene, case, set)
    answers = []
    for towed in bodies(chosen, Path(fmus) if fmus else None):
        try:
            limits, rows = row(towed.body, u_max=u_max), []
            if map:
                at = default_values(towed.body, map, values) if isinstance(values, int) else values
                rows = stability_map(towed.body, map, at, u_max, report)
        except ValueError as error:
            raise SceneError(str(error), file=chosen.file, key=f"units.{towed.name}.parameters") from error
        answers.append(Stability(towed, u_max, limits, map, tuple(rows)))
    return answers
