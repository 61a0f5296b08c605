"""A scene handed over to be built as one unit: its equations joined, instead of its units coupled by the master."""

from __future__ import annotations

import re
from pathlib import Path

from towage.errors import SceneError
from towage.fmus import UNITS
from towage.fmus.declare.scene_unit import Part
from towage.fmus.declare.scene_unit import scene_unit as declared
from towage.fmus.declare.unit import Unit
from towage.models.compose.plan import CompositionError, Connection
from towage.scene.files import declared as unit_in
from towage.scene.resolve import ResolvedScene, described
from towage.scene.select import select
from towage.units.store import locator


def scene_unit(path_or_name: str | Path, case: str | None = None) -> Unit:
    """The scene of a file, or a shipped one, as a unit; ``case`` sets the start values of its parameters. Raises
    `SceneError`, also for a scene that cannot be composed."""
    return unit_of(described(select(path_or_name, case), locator(), open_ends=True), Path(path_or_name).stem)


def unit_of(resolved: ResolvedScene, name: str) -> Unit:
    """The resolved scene as a unit called ``name``, which becomes a C identifier."""
    scene = resolved.scene
    parts = []
    for part, entry in scene.units.items():
        if entry.fmu not in UNITS:
            raise scene.error(f"{entry.fmu} is an FMU: only the shipped units can be composed", f"units.{part}.fmu")
        given = resolved.units[part].parameters
        values = {name: value for name, value in given.items() if isinstance(value, float)}
        parts.append(Part(part, unit_in(scene, part), values))
    if changed := [c for c in resolved.connections if c.offset or c.values]:
        raise scene.error(f"{changed[0]} adds an offset or looks values up, which cannot be composed", "connections")
    connections = [
        Connection((c.source_unit, c.source), (c.target_unit, c.target), c.factor) for c in resolved.connections
    ]
    try:
        return declared(re.sub(r"\W", "_", name), scene.title, parts, connections)
    except CompositionError as error:
        raise SceneError(str(error), file=scene.file, key="units") from error
