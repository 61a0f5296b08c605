"""A scene as one unit: the declaration that goes with `models.composed`.

Variables keep their names behind that of their part, ``<part>.<variable>``, with their units, bounds and descriptions;
start values are those of the scene. Inputs that are connected inside are gone, one ``integration_tolerance`` serves all,
and the branches are the composition's own business, so that there is no ``freeze_branches``. Parameters of linear units
are fixed: their matrices are made when the scene is composed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import ModuleType
from typing import NamedTuple

from ...models.compose.linear import LinearPart, is_linear
from ...models.compose.model import compose
from ...models.compose.plan import HELD, CompositionError, Connection
from .unit import Unit, Variable, local, next_event_time


class Part(NamedTuple):
    """A unit of the scene, and the values that the scene gives to its parameters and inputs, in SI."""

    name: str
    unit: Unit
    values: dict[str, float]

    @property
    def model(self) -> ModuleType:
        """The model that is composed."""
        model = self.unit.model
        if not is_linear(model):
            return model
        p = model.Parameters(**{v.name: self.values.get(v.name, v.start) for v in self.unit.parameters})
        try:
            return LinearPart(model, p)
        except CompositionError as error:
            raise CompositionError(f"{self.name}: {error}") from None


def scene_unit(name: str, description: str, parts: Sequence[Part], connections: Sequence[Connection]) -> Unit:
    """The unit called ``name``. Raises `CompositionError` for what cannot be composed."""
    model = compose({part.name: part.model for part in parts}, connections, name)
    inner = {c.target: c.source for c in connections}
    feeds = {(part.name, v.name): v.depends for part in parts for v in part.unit.outputs}

    def depends(part: str, output: str, seen: frozenset[tuple[str, str]] = frozenset()) -> set[str]:
        """The inputs of the scene that act on an output without delay."""
        found: set[str] = set()
        for entry in feeds.get((part, output), ()):
            if (part, entry) not in inner:
                found.add(f"{part}.{entry}")
            elif (part, entry) not in seen:
                found |= depends(*inner[part, entry], seen | {(part, entry)})
        return found

    def named(part: Part, v: Variable) -> Variable:
        start = part.values.get(v.name, v.start)
        fixed = v.causality == "parameter" and is_linear(part.unit.model)
        return replace(
            v, name=f"{part.name}.{v.name}", start=start, depends=tuple(sorted(depends(part.name, v.name))),
            min=start if fixed else v.min, max=start if fixed else v.max,
        )  # fmt: skip

    return Unit(
        name=name,
        description=description,
        model=model,
        parameters=tuple(named(part, v) for part in parts for v in part.unit.parameters if v.name != HELD),
        calculated=tuple(named(part, v) for part in parts for v in part.unit.calculated),
        inputs=tuple(named(part, v) for part in parts for v in part.unit.inputs if (part.name, v.name) not in inner),
        outputs=(
            *(named(part, v) for part in parts for v in part.unit.outputs),
            *((next_event_time(),) if model.clocks else ()),
        ),
        states=tuple(named(part, v) for part in parts for v in _states(part, model.parts[part.name])),
    )


def _states(part: Part, model: ModuleType) -> tuple[Variable, ...]:
    """The states that no output shows. Those of reduced matrices have no unit, and none is claimed for them."""
    shown = {v.name for v in part.unit.observed + part.unit.states}
    fields: tuple[str, ...] = model.State._fields
    return part.unit.states + tuple(
        local(name, "1", f"State of the linear unit {part.unit.name}") for name in fields if name not in shown
    )
