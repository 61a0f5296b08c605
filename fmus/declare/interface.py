"""What an FMU shows: the variables that both flavours share and, for the native one, its continuous states, their
derivatives and the extras of a linear unit, in the order of ``native/runtime/unit.h``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from ...models.protocol.variables import local, per_second
from .dependencies import dependencies
from .unit import Layout, Unit, Variable, layout_of, named

Positions = tuple[tuple[int, ...], ...]
"""For each of several things, the positions of others on which it depends."""


@dataclass(frozen=True)
class Interface:
    """A unit's variables; value references are positions in `variables`. Only the native flavour has anything but the
    unit.

    ``states`` are the continuous states, named as in the model, ``reinit`` whether an event may change them;
    ``derivative_inputs`` and ``derivative_states`` tell on which inputs and states each derivative depends and
    ``observed_states`` on which states each observed variable does; ``structure`` holds the values of the structural
    parameters, which the build fixed; ``exchange``: whether it is for model exchange too.
    """

    unit: Unit
    states: tuple[Variable, ...] = ()
    extras: tuple[Variable, ...] = ()
    indicators: int = 0
    reinit: tuple[bool, ...] = ()
    derivative_inputs: Positions = ()
    derivative_states: Positions = ()
    observed_states: Positions = ()
    structure: Mapping[str, float] = field(default_factory=dict)
    exchange: bool = True

    @cached_property
    def shared(self) -> tuple[Variable, ...]:
        """The unit's own variables; a structural parameter has the value of the build and no other."""
        return tuple(
            replace(v, start=self.structure[v.name], min=self.structure[v.name], max=self.structure[v.name])
            if v.name in self.structure else v
            for v in self.unit.variables
        )  # fmt: skip

    @property
    def has_events(self) -> bool:
        """Whether there are discrete changes that the unit can locate: FMI 3 then offers event mode in co-simulation."""
        model = self.unit.model
        return model.transition is not None and (self.indicators > 0 or model.next_event_time is not None)

    @cached_property
    def as_built(self) -> Unit:
        """The unit with a reference run that this build can do: structural parameters have the values that it fixed."""
        return replace(self.unit, start={**self.unit.start, **self.structure})

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """All of them: shared, states, derivatives of the states, extras."""
        states = tuple(
            replace(named(f"state.{v.name}", local(v.unit, v.description, display=v.display)), nominal=v.nominal)
            for v in self.states
        )
        rates = tuple(
            named(f"der({v.name})", local(per_second(v.unit), f"Time derivative of {v.name}")) for v in states
        )
        return self.shared + states + rates + self.extras

    @cached_property
    def layout(self) -> Layout:
        """Value references by kind."""
        own = self.unit.layout[:5]
        return layout_of(*map(len, own), len(self.states), len(self.states), len(self.extras))

    def depends(self, reference: int) -> list[int]:
        """Value references of the inputs and states that act without delay on an observed variable or a derivative.
        Those of observed variables are the unit's, as an event may act through a mode."""
        unit, layout = self.unit, self.layout
        if reference in layout.observed:
            inputs = [unit.index[name] for name in dependencies(unit)[unit.variables[reference].name]]
            position = layout.observed.index(reference)
            states = self.observed_states[position] if self.observed_states else ()
        else:
            position = layout.state_derivatives.index(reference)
            inputs = [layout.inputs[k] for k in self.derivative_inputs[position]]
            states = self.derivative_states[position]
        return inputs + [layout.states[k] for k in states]


def declared_states(unit: Unit) -> tuple[Variable, ...]:
    """The states of the model in its own order, each from ``unit.states`` or the output of its name."""
    known = {v.name: v for v in unit.observed + unit.states}
    return tuple(known[name] for name in unit.model.State._fields)
