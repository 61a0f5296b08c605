"""What the exports to other co-simulation hosts share: a resolved scene as FMU files coupled at a fixed step.

Such a host passes values on at communication points and holds them over the step, as our scheme ``jacobi`` does (order 1),
whatever scheme the scene asks for. What needs a master of ours stays behind: rates and input derivatives on the
connections, located events, error control, checks and verdict.
"""

from __future__ import annotations

from typing import NamedTuple

from towage.fmus.describe.fmi2 import number
from towage.scene.resolve import ResolvedScene
from towage.units.description import Value, Variable

TICKS = 1_000_000_000
"""Ticks of libcosim's clock a second: it keeps time in whole nanoseconds."""


class Export(NamedTuple):
    """A scene ready to be written: ``step`` in s, ``files`` the file name of each unit's FMU. Units of one FMU share it."""

    resolved: ResolvedScene
    step: float
    files: dict[str, str]

    def variable(self, unit: str, name: str) -> Variable:
        """A variable of a unit of the scene."""
        return self.resolved.units[unit].description.by_name()[name]

    def fmus(self) -> dict[str, bytes]:
        """The FMUs under their file names."""
        return {self.files[name]: unit.path.read_bytes() for name, unit in self.resolved.units.items()}


def prepare(resolved: ResolvedScene) -> Export:
    """Raises `SceneError` for a scene that a fixed-step host cannot run."""
    scene = resolved.scene
    if scene.coupling.step is None:
        raise scene.error(
            "leaves the step to the error control, but hosts of OSP and SSP need a fixed one: "
            "give it with --set coupling.step='0.05 s'",
            "coupling.tolerance",
        )
    for name, unit in resolved.units.items():
        variables = unit.description.by_name()
        for parameter in unit.parameters:
            if variables[parameter].type == "Enumeration":
                raise scene.error(
                    "is an enumeration, whose value neither format can carry by number: leave it at its start value",
                    f"units.{name}.parameters.{parameter}",
                )
    return Export(resolved, host_step(scene.coupling.step), _files(resolved))


def host_step(step: float) -> float:
    """The step, s, to whole nanoseconds; libcosim cuts off what is beyond them, so it must not come out just below."""
    ticks = max(1, round(step * TICKS))
    seconds = ticks / TICKS
    return seconds if int(seconds * TICKS) == ticks else (ticks + 0.5) / TICKS


def text(value: Value) -> str:
    """A value as XML Schema spells it; numbers read back to the same double."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return number(value) if isinstance(value, float) else str(value)


def _files(resolved: ResolvedScene) -> dict[str, str]:
    """File names that differ where the FMUs do, also where case is ignored."""
    taken: dict[str, object] = {}
    files = {}
    for name, unit in resolved.units.items():
        count, file = 1, unit.path.name
        while taken.setdefault(file.casefold(), unit.path) != unit.path:
            count += 1
            file = f"{unit.path.stem}_{count}.fmu"
        files[name] = file
    return files
