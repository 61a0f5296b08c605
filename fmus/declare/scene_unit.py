"""A scene as one unit: the declaration that goes with ``models/compose``.

Variables keep their names behind that of their part, ``<part>.<variable>``, with their units, bounds and descriptions;
start values are those of the scene. Inputs that are connected inside are no inputs of the unit. One
``integration_tolerance`` serves all, and there is no ``freeze_branches``: the composition locates its branches itself.
Parameters of linear units, and those that decide tables of others, are fixed: matrices and tables are made when the scene is
composed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ...models.compose.linear import can_be_part, linear_part
from ...models.compose.model import compose
from ...models.compose.plan import HELD, CompositionError, Connection
from ...models.protocol.model import AnyModel
from ...models.protocol.variables import NEXT_EVENT, local, rate_of
from .dependencies import dependencies
from .unit import Unit, Variable, named


class Part(NamedTuple):
    """A unit of the scene, and the values that the scene gives to its parameters and inputs, in SI."""

    name: str
    unit: Unit
    values: dict[str, float]

    @property
    def model(self) -> AnyModel:
        """The model that is composed."""
        model = self.unit.model
        if not self._matrices:
            return model.fixed({v.name: self.values.get(v.name, v.start or 0.0) for v in self._fixed})
        p = model.Parameters(**{v.name: self.values.get(v.name, v.start) for v in self.unit.parameters})
        try:
            return linear_part(model, p) if model.linear else _part(model, p)
        except CompositionError as error:
            raise CompositionError(f"{self.name}: {error}") from None

    @property
    def _matrices(self) -> bool:
        """Whether all parameters are fixed, as matrices or elements are made of them."""
        return can_be_part(self.unit.model) or self.unit.model.part is not None

    @property
    def _fixed(self) -> tuple[Variable, ...]:
        """Parameters from which matrices or tables are made when the scene is composed."""
        return tuple(v for v in self.unit.parameters if self._matrices or v.name in self.unit.model.structure)

    def full_name(self, variable: str) -> str:
        """The name of a variable in the scene."""
        return f"{self.name}.{variable}"

    def variable(self, v: Variable) -> Variable:
        """A parameter, input or output in the scene, whose values have been given."""
        start = self.values.get(v.name, v.start)
        fixed = v in self._fixed
        v = replace(v, needed=v.needed and v.causality == "input")
        if fixed:
            return replace(v, name=self.full_name(v.name), start=start, min=start, max=start)
        return replace(v, name=self.full_name(v.name), start=start)

    def observed(self) -> tuple[Variable, ...]:
        """Outputs and locals in the scene; texts of rates name them in full."""
        rates = {
            f"{v.name}_rate": named(f"{self.full_name(v.name)}_rate", rate_of(self.full_name(v.name), v.unit))
            for v in self.unit.observed if v.causality == "output"
        }  # fmt: skip
        return tuple(rates.get(v.name) or self.variable(v) for v in self.unit.observed)

    def states(self, model: AnyModel) -> tuple[Variable, ...]:
        """The states of ``model`` that no output shows. Those of reduced matrices have no unit, and none is claimed for
        them."""
        shown = {v.name for v in self.unit.observed + self.unit.states}
        other = tuple(
            named(name, local("1", f"State of the linear unit {self.unit.name}"))
            for name in model.State._fields if name not in shown
        )  # fmt: skip
        return tuple(self.variable(v) for v in self.unit.states + other)


def scene_unit(name: str, description: str, parts: Sequence[Part], connections: Sequence[Connection]) -> Unit:
    """The unit called ``name``. Raises `CompositionError` for what cannot be composed."""
    models = {part.name: part.model for part in parts}
    for c in connections:
        if c.target[1] in models[c.target[0]].held:
            raise CompositionError(f"{c}: {c.target[0]} takes it as constant in a composition: set it as an input instead")
    model = compose(models, connections, name)
    connected = {c.target for c in connections}
    clock = (named("next_event_time", NEXT_EVENT),) if model.next_event_time else ()
    return Unit(
        name=name,
        description=description,
        model=model,
        parameters=tuple(part.variable(v) for part in parts for v in part.unit.parameters if v.name != HELD),
        calculated=tuple(part.variable(v) for part in parts for v in part.unit.calculated),
        inputs=tuple(
            part.variable(v) for part in parts for v in part.unit.inputs if (part.name, v.name) not in connected
        ),
        observed=(*(v for part in parts for v in part.observed()), *clock),
        states=tuple(v for part in parts for v in part.states(models[part.name])),
        depends=_dependencies(parts, connections),
        terminals={
            f"{part.name}.{terminal}": {member: part.full_name(variable) for member, variable in members.items()}
            for part in parts for terminal, members in part.unit.terminals.items()
            if not any((part.name, variable) in connected for variable in members.values())
        },
    )  # fmt: skip


def _part(model: AnyModel, p: Any) -> AnyModel:
    """What stands for a model that steps by itself."""
    assert model.part is not None
    if refusal := model.refused(p):
        raise CompositionError(refusal)
    return model.part(p)


def _dependencies(parts: Sequence[Part], connections: Sequence[Connection]) -> dict[str, tuple[str, ...]]:
    """The open inputs of the scene that act on each output without delay: those of its unit, through connections."""
    inner = {c.target: c.source for c in connections}
    direct = {(part.name, name): inputs for part in parts for name, inputs in dependencies(part.unit).items()}

    def reached(part: str, output: str, seen: frozenset[tuple[str, str]] = frozenset()) -> set[str]:
        names: set[str] = set()
        for source in direct.get((part, output), ()):
            if (part, source) not in inner:
                names.add(f"{part}.{source}")
            elif (part, source) not in seen:
                names |= reached(*inner[part, source], seen | {(part, source)})
        return names

    outputs = {f"{part}.{name}": tuple(sorted(reached(part, name))) for part, name in direct}
    return outputs | {"next_event_time": ()}
