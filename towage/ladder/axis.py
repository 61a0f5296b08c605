"""What a ladder is made of: axes, each with levels from the simplest model to the fullest.

    LINEAR = Level("linear drag", "how drag grows with the square of the speed", linear_drag)
    DRAG = Axis("drag", "How does the water resist?", needed, (LINEAR, Level("quadratic drag")))

A rung takes one level of every axis that a scene has. `towage.registry.AXES` finds axes by name; another package brings its
own by entry points of the group ``towage.axes``.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from towage.checks.track import Track
from towage.scene.parts import UnitEntry
from towage.scene.resolve import ResolvedScene, ResolvedUnit, described
from towage.scene.scene import Scene
from towage.units.description import Value
from towage.units.store import Locate

Array = NDArray[np.float64]
NOTHING: Mapping[str, float] = MappingProxyType({})


class Unfit(Exception):
    """A model cannot be made of a scene; the message says why, in one line."""


class Seen(NamedTuple):
    """The run of the scene as it is given, from which stand-ins take their constants: ``track``, all outputs at the
    communication points; they count from ``settle``, s, on."""

    track: Track
    settle: float

    def settled(self, name: str) -> Array:
        """The output "unit.variable" from ``settle`` on, at equal intervals of time, SI."""
        time = self.track.time
        count = int((time >= self.settle).sum())
        return self.track.at(name, np.linspace(self.settle, time[-1], max(count, 2)))

    def spread(self, name: str) -> tuple[float, float]:
        """(standard deviation of the output, of its rate a second), from which a mean frequency follows."""
        values = self.settled(name)
        rate = np.gradient(values, (float(self.track.time[-1]) - self.settle) / (len(values) - 1))
        return float(values.std()), float(rate.std())


@dataclass(frozen=True)
class Trial:
    """A scene on its way up the ladder, without cases. ``names``: what a compared output of the given scene is called in
    this one, as "unit.variable"; ``more``: a constant, SI, that is added to this one's before it is compared."""

    scene: Scene
    names: Mapping[str, str]
    seen: Seen
    locate: Locate
    more: Mapping[str, float] = field(default_factory=dict)

    def showing(self, margins: tuple[str, ...]) -> Trial:
        """With margins, "unit.margin_...", that are shown and do not decide."""
        checks = self.scene.checks
        shown = tuple(dict.fromkeys((*checks.report_only, *margins)))
        return replace(self, scene=structs.replace(self.scene, checks=structs.replace(checks, report_only=shown)))

    @cached_property
    def resolved(self) -> ResolvedScene:
        """The scene against its units. Raises `SceneError`."""
        return described(self.scene, self.locate)

    @property
    def wiring(self) -> list[tuple[str, str, str]]:
        """(as written, source, target) of every connection, both ends as "unit.variable"."""
        found = zip(self.scene.connections, self.resolved.connections, strict=True)
        return [(text, f"{c.source_unit}.{c.source}", f"{c.target_unit}.{c.target}") for text, c in found]

    def source(self, target: str) -> str:
        """The output that feeds an input. Raises `Unfit`."""
        for _, source, fed in self.wiring:
            if fed == target:
                return source
        raise Unfit(f"nothing is connected to {target}")

    def units(self, *models: str) -> list[ResolvedUnit]:
        """Its units of these models."""
        return [unit for unit in self.resolved.units.values() if unit.description.model_name in models]

    def value(self, unit: str, name: str) -> float:
        """A parameter or a constant input of a unit, SI. Raises `Unfit` for a unit without it."""
        found = self.resolved.units[unit]
        if not (variable := found.description.by_name().get(name)):
            raise Unfit(f"{unit} has no {name}: its FMU is of another version")
        return float(found.parameters.get(name, variable.start or 0.0))

    def is_input(self, unit: str, name: str) -> bool:
        """Whether a variable of a unit is an input."""
        return self.resolved.units[unit].description.by_name()[name].causality == "input"

    def setting(self, values: Mapping[str, float]) -> Trial:
        """With other values, "unit.variable" to SI; itself where it has them already."""
        new = {key: value for key, value in values.items() if self.value(*key.split(".", 1)) != value}
        return replace(self, scene=self.scene.setting(new, "ladder")) if new else self

    def rebuilt(
        self, units: Mapping[str, UnitEntry], connections: list[str], names: Mapping[str, str],
        more: Mapping[str, float] = NOTHING,
    ) -> Trial:  # fmt: skip
        """Of other units: ``names`` and ``more`` by what this trial calls an output, for those that are called otherwise or
        lack a constant now. Tables of checks and of the record, and margins of units that changed, are left out, and
        references between units become numbers."""
        scene = self.scene.without_comparisons()
        numbers = {name: self._numbers(name, unit) for name, unit in units.items()}
        old = self.scene.units
        kept = {name for name, unit in units.items() if name in old and old[name].fmu == unit.fmu}
        shown = tuple(name for name in scene.checks.report_only if name.partition(".")[0] in kept)
        checks, record = structs.replace(scene.checks, report_only=shown), structs.replace(scene.record, variables=None)
        scene = structs.replace(scene, units=numbers, connections=tuple(connections), checks=checks, record=record)
        added = {given: self.more.get(given, 0.0) + more.get(here, 0.0) for given, here in self.names.items()}
        called = {given: names.get(here, here) for given, here in self.names.items()}
        return replace(self, scene=scene, names=called, more=added)

    def _numbers(self, name: str, unit: UnitEntry) -> UnitEntry:
        """A unit whose values refer to no other unit."""

        def number(key: str, value: Value) -> Value:
            """The value, SI where it was a reference."""
            return self.value(name, key) if isinstance(value, str) and value.startswith("=") else value

        parameters = {key: number(key, value) for key, value in unit.parameters.items()}
        return structs.replace(unit, parameters=parameters, inputs={k: number(k, v) for k, v in unit.inputs.items()})


def _same(trial: Trial) -> Trial:
    return trial


def _always(trial: Trial) -> bool:
    return True


@dataclass(frozen=True)
class Level:
    """One way to model something. ``make`` changes a trial into one that does, or raises `Unfit`; ``leaves_out``: what it
    does not know, empty for the fullest; ``asked(trial)``: whether a scene has this level at all."""

    name: str
    leaves_out: str = ""
    make: Callable[[Trial], Trial] = _same
    asked: Callable[[Trial], bool] = _always


@dataclass(frozen=True)
class Axis:
    """A question with its answers, ``levels``, from the simplest model to the fullest. ``lacks(trial)``: why the question
    is none for a scene, empty if it is one."""

    name: str
    description: str
    lacks: Callable[[Trial], str]
    levels: tuple[Level, ...]


def entry(fmu: str, parameters: Mapping[str, Any], inputs: Mapping[str, Any] | None = None) -> UnitEntry:
    """A unit of a scene file."""
    return UnitEntry(fmu, dict(parameters), dict(inputs or {}))


def moved(scene: Scene, folder: os.PathLike[str]) -> Scene:
    """The scene for a file in ``folder``: paths of FMUs and of files that units carry are relative to it."""
    base = scene.file.parent if scene.file else ""

    def there(path: str) -> str:
        return os.path.relpath(os.path.join(base, path), folder)

    units = {
        name: structs.replace(
            unit, fmu=there(unit.fmu) if unit.fmu.endswith(".fmu") else unit.fmu,
            files={
                kind: {**given, "file": there(given["file"])} if isinstance(given, dict) else there(given)
                for kind, given in unit.files.items()
            },
        )
        for name, unit in scene.units.items()
    }  # fmt: skip
    return structs.replace(scene, units=units)
