"""What a unit is: a model and what FMI adds to it.

From a `Unit` come the Python FMU, the native FMU, their ``modelDescription.xml``, the documentation page and the unit's table
in ``docs/``. Every variable stands once, with the model (``models/protocol/variables.py``). A value reference is a position in
`Unit.variables`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from ...models.protocol.model import AnyModel
from ...models.protocol.variables import Quantity, parameter, per_second, quantities


class BuildError(Exception):
    """An FMU cannot be built here, or not at all; the message says why and what to do."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Variable(Quantity):
    """A scalar of a unit's interface: a quantity with its name."""

    name: str


def named(name: str, quantity: Quantity) -> Variable:
    """The variable ``name``."""
    return Variable(name=name, **{f.name: getattr(quantity, f.name) for f in fields(Quantity)})


class Layout(NamedTuple):
    """Value references by kind. ``parameters`` include the integrator's; what only the native flavour shows, the last
    three, is empty otherwise."""

    parameters: range
    calculated: range
    inputs: range
    input_derivatives: range
    observed: range
    states: range
    state_derivatives: range
    extras: range


def layout_of(*counts: int) -> Layout:
    """The layout of so many variables of each kind, one kind after the other."""
    return Layout(*(range(a, b) for a, b in pairwise(accumulate(counts, initial=0))))


INPUT_ORDERS = (1, 2, 3)
"""Orders of the input derivatives that a unit takes: enough for a cubic over the communication step."""
INTEGRATION_TOLERANCE = named(
    "integration_tolerance",
    parameter("1", 1e-8, "Relative error per internal step of the integrator", min=1e-13, max=1e-2),
)


@dataclass(frozen=True, repr=False, eq=False)
class Unit:
    """A unit's declaration.

    ``observed`` are outputs, locals and their rates in the order of the model's ``Outputs``; ``states`` the continuous states
    that none of them shows. ``start`` and ``reference_inputs`` (amplitude and angular frequency of a sine) are a short run
    from which the packaged reference result is made. ``depends``: the inputs that act on each output without delay, None: as
    `dependencies` finds them. ``terminals``: the places where the unit is joined to another; the variables of each by what
    they are there (`force`, `displacement`, `velocity_surge`), which has one name on both sides.
    ``files``: kinds of file that a scene may give to the unit, with what they hold; ``given`` makes the unit that carries what
    was read from some of them, by kind; ``needs_files``: it means nothing without.
    """

    name: str
    description: str
    model: AnyModel
    parameters: tuple[Variable, ...]
    calculated: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    observed: tuple[Variable, ...]
    states: tuple[Variable, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    reference_inputs: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    depends: Mapping[str, tuple[str, ...]] | None = None
    terminals: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    given: Callable[[Mapping[str, Any]], Unit] | None = None
    needs_files: bool = False

    @classmethod
    def of(
        cls, model: AnyModel, *,
        start: Mapping[str, float] | None = None, inputs: Mapping[str, tuple[float, float]] | None = None,
        terminals: Mapping[str, Mapping[str, str]] | None = None,
        files: Mapping[str, str] | None = None, given: Callable[[Mapping[str, Any]], Unit] | None = None,
    ) -> Unit:  # fmt: skip
        """The unit of ``model`` with its reference run. Raises ``TypeError`` for a variable without a record."""
        states = tuple(kind for kind in (model.State, model.linear and model.linear.Own) if kind)
        return cls(
            model.name, model.description, model, _all(model.Parameters), _all(model.Calculated), _all(model.Inputs),
            _all(model.Outputs), tuple(named(n, q) for kind in states for n, q in quantities(kind).items()),
            start or {}, inputs or {}, terminals=terminals or {}, files=files or {}, given=given,
        )  # fmt: skip

    @property
    def not_native(self) -> str:
        """Why the unit has no native flavour, empty if it has."""
        return "" if self.model.numbers else self.model.floats_only

    @cached_property
    def input_derivatives(self) -> tuple[Variable, ...]:
        """Those of every input, three each."""
        return tuple(
            Variable(
                name=f"{v.name}_d{k}", unit=per_second(v.unit, k), start=0.0, causality="parameter", variability="tunable",
                description=f"Derivative of order {k} of {v.name} at the communication point",
            )
            for v in self.inputs for k in INPUT_ORDERS
        )  # fmt: skip

    @cached_property
    def _kinds(self) -> tuple[tuple[Variable, ...], ...]:
        """The variables by kind, in the order of `Layout`."""
        own = (INTEGRATION_TOLERANCE,) if self.model.integrated else ()
        return self.parameters + own, self.calculated, self.inputs, self.input_derivatives, self.observed

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """All variables; the position is the value reference."""
        return sum(self._kinds, ())

    @cached_property
    def layout(self) -> Layout:
        """Value references by kind."""
        return layout_of(*map(len, self._kinds), 0, 0, 0)

    @cached_property
    def index(self) -> dict[str, int]:
        """Value reference by name."""
        return {v.name: i for i, v in enumerate(self.variables)}


def _all(kind: Any) -> tuple[Variable, ...]:
    """The variables of ``kind``, each field of which must have a record."""
    if kind is None:
        return ()
    records = quantities(kind)
    names = kind._fields if hasattr(kind, "_fields") else [f.name for f in fields(kind)]
    bare = [name for name in names if name not in records]
    if bare:
        raise TypeError(f"{kind.__module__}.{kind.__qualname__}: {', '.join(bare)} has no record of unit and meaning")
    return tuple(named(name, quantity) for name, quantity in records.items())


def load(name: str) -> Unit:
    """The unit called ``name``. Raises ``ModuleNotFoundError`` if there is none."""
    unit: Unit = importlib.import_module(f"..{name}", __package__).UNIT
    return unit
