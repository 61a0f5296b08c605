"""A scene of a ship, a line and a cradle as one system of equations, without an interface between them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from towage.errors import SceneError
from towage.models.heave import cradle, ship, spring_line
from towage.models.heave.system import System
from towage.scene.resolve import ResolvedScene


def monolithic(resolved: ResolvedScene) -> System:
    """The scene as one system. Raises `SceneError` if it is not a ship, a spring_line and a cradle (or a ship and a
    cradle_on_line)."""
    values: dict[str, dict[str, Any]] = {}
    for unit in resolved.units.values():
        start = {v.name: v.start for v in unit.description.variables if v.causality == "parameter"}
        values[unit.description.model_name] = {**start, **unit.parameters}
    joined = values.get("cradle_on_line")
    line, body, hull = values.get("spring_line", joined), values.get("cradle", joined), values.get("ship")
    if hull is None or line is None or body is None:
        raise SceneError(f"no monolithic solution for units {', '.join(values)}: expected a ship, a line and a cradle",
                         file=resolved.scene.file, key="units")  # fmt: skip
    if line is joined:
        line = {**line, "static_tension": line["weight_in_water"]}
    return System(
        ship=_parameters(ship.Parameters, hull),
        line=_parameters(spring_line.Parameters, line),
        cradle=_parameters(cradle.Parameters, body),
        two_way=any(c.target == "reaction" for c in resolved.connections),
        submersible_velocity=float(body.get("submersible_velocity", 0.0)),
    )


def _parameters(kind: type, values: dict[str, Any]) -> Any:
    return kind(**{f.name: values[f.name] for f in fields(kind)})
