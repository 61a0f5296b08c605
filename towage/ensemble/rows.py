"""What the members of an ensemble are: parameters and inputs of a unit, one row a member, and which rows make no sense."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from towage.errors import SceneError, suggest
from towage.fmus.declare.unit import Unit
from towage.scene.compose import unit_of
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator

if TYPE_CHECKING:
    from towage.fmus.native.traced import Traced

Array = NDArray[np.float64]


def composed(scene: Scene) -> Unit:
    """The scene, which has no cases, as one unit. Raises `SceneError` where it cannot be composed."""
    return unit_of(described(scene, locator()), scene.file.stem if scene.file else "scene")


def equally_many(varied: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """The values of what is varied, by name, shape (members,). Raises `SceneError` where they are not equally many."""
    arrays = {name: np.atleast_1d(np.asarray(values, np.float64)) for name, values in varied.items()}
    sizes = {name: len(values) for name, values in arrays.items()}
    if len(set(sizes.values())) != 1 or 0 in sizes.values():
        raise SceneError(f"every varied parameter needs one value a member, the same number for all: got {sizes}")
    return arrays


def rows(scene: Scene | None, unit: Unit, varied: Mapping[str, Array]) -> Array:
    """Parameters, then inputs of ``unit``, SI, shape (members, parameters and inputs). Raises `SceneError` for names and
    values that do not fit."""
    variables = {v.name: v for v in unit.parameters + unit.inputs}
    places = {name: k for k, name in enumerate(variables)}
    table = np.tile([v.start or 0.0 for v in variables.values()], (len(next(iter(varied.values()))), 1))
    for name, values in varied.items():
        if name not in variables:
            raise SceneError(f"{name!r} is no parameter of {unit.name}{suggest(name, variables)}")
        v = variables[name]
        if v.causality == "parameter" and v.min is not None and v.min == v.max:
            raise SceneError(
                f"{name} is fixed in a composed scene, as matrices follow from it: vary it by towage sweep --engine runs"
            )
        table[:, places[name]] = values
        for other, factor in (_followers(scene, name, values) if scene else {}).items():
            if other not in varied:
                table[:, places[other]] = factor * values
    return table


def refusals(unit: Unit, traced: Traced, table: Array) -> dict[int, str]:
    """Rows of ``table`` that the unit would refuse, and why."""
    reasons: dict[int, str] = {}
    for v, values in zip(unit.parameters + unit.inputs, table.T):
        low, high = (-np.inf if v.min is None else v.min), (np.inf if v.max is None else v.max)
        fits = np.isfinite(values)
        if v.causality == "parameter":  # bounds of inputs are not checked by a unit either
            fits &= (values >= low) & (values <= high)
        for k in np.flatnonzero(~fits):
            reasons.setdefault(int(k), f"{v.name} = {values[k]:g} {v.unit}: expected {low:g} to {high:g}")
    if required := traced.functions.get("required"):
        numbers = np.array(required(table.T[: len(unit.parameters)], np.empty((0, len(table)))))
        for text, values in zip(traced.requirements, numbers):
            for k in np.flatnonzero(~(values > 0.0)):
                reasons.setdefault(int(k), text)
    return reasons


def _followers(scene: Scene, name: str, values: Array) -> dict[str, float]:
    """Parameters that the scene makes a multiple of ``name`` ("= unit.parameter"), with the factor: those that change with
    it. Tried with a value that the scene takes; raises its `SceneError` if it takes none."""
    error = SceneError(f"no value of {name} is finite")
    by_size = values[np.argsort(-np.abs(values))]
    for value in (float(by_size[k]) for k in (0, len(values) // 2, -1)):
        try:
            there, near = (
                _parameters(scene, name, v) for v in (value, value * (1.0 - 2.0**-10) if value else 2.0**-10)
            )
        except SceneError as refused:
            error = refused
            continue
        changed = {other: x for other, x in there.items() if other != name and near[other] != x}
        return {other: x / value if value else 0.0 for other, x in changed.items()}
    raise error


def _parameters(scene: Scene, name: str, value: float) -> dict[str, float]:
    """What the scene gives to its units when it sets ``name``."""
    units = described(scene.setting({name: value}, "ensemble"), locator()).units
    given = {f"{unit}.{parameter}": x for unit, entry in units.items() for parameter, x in entry.parameters.items()}
    return {parameter: x for parameter, x in given.items() if isinstance(x, float)}
