"""What a unit is: a model and the one declaration of its variables.

From a `Unit` come the Python FMU, its ``modelDescription.xml``, its documentation page and its table in ``docs/``;
nothing is typed twice. Value references are positions in `Unit.variables`.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType

from ...models.numeric.ops import NEVER


class BuildError(Exception):
    """An FMU cannot be built here, or not at all; the message says why and what to do."""


@dataclass(frozen=True)
class Variable:
    """A scalar of a unit's interface.

    ``unit`` is SI (``fmus/declare/quantities.py``); ``display`` the unit in which a person may want to read it. ``depends``
    names the inputs that act on an output without delay. ``rate`` declares the local ``<name>_rate`` with it.
    """

    name: str
    unit: str
    description: str
    start: float | None = None
    causality: str = "parameter"
    variability: str = "fixed"
    display: str | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    depends: tuple[str, ...] = ()
    rate: bool = False


def parameter(name: str, unit: str, start: float, description: str, **options: object) -> Variable:
    """A parameter that is fixed once a run has begun."""
    return Variable(name, unit, description, start, "parameter", "fixed", **options)  # type: ignore[arg-type]


def tunable(name: str, unit: str, start: float, description: str, **options: object) -> Variable:
    """A parameter that may change between steps."""
    return Variable(name, unit, description, start, "parameter", "tunable", **options)  # type: ignore[arg-type]


def calculated(name: str, unit: str, description: str, variability: str = "fixed", **options: object) -> Variable:
    """A calculated parameter; "tunable" where it follows from a tunable one."""
    return Variable(name, unit, description, None, "calculatedParameter", variability, **options)  # type: ignore[arg-type]


def entry(name: str, unit: str, start: float, description: str, **options: object) -> Variable:
    """A continuous input."""
    return Variable(name, unit, description, start, "input", "continuous", **options)  # type: ignore[arg-type]


def output(name: str, unit: str, description: str, **options: object) -> Variable:
    """A continuous output."""
    return Variable(name, unit, description, None, "output", "continuous", **options)  # type: ignore[arg-type]


def local(name: str, unit: str, description: str, variability: str = "continuous", **options: object) -> Variable:
    """A local variable."""
    return Variable(name, unit, description, None, "local", variability, **options)  # type: ignore[arg-type]


def per_second(unit: str, order: int = 1) -> str:
    """The unit of a time derivative: m -> m/s -> m/s2."""
    base, _, power = unit.partition("/s")
    order += int(power or 1) if "/s" in unit else 0
    return f"{base}/s" + (str(order) if order > 1 else "")


INPUT_ORDERS = (1, 2, 3)
"""Orders of the input derivatives that a unit takes: enough for a cubic over the communication step."""

INTEGRATION_TOLERANCE = parameter(
    "integration_tolerance", "1", 1e-8, "Relative error per internal step of the integrator", min=1e-13, max=1e-2
)
FREEZE_BRANCHES = parameter(
    "freeze_branches", "1", 0.0,
    "1: a branch (taut or slack) holds over a communication step, and the master puts communication points on the "
    "zeros of event_*; 0: the unit looks after its branches itself", min=0.0, max=1.0,
)  # fmt: skip


@dataclass(frozen=True)
class Unit:
    """A unit's declaration. ``outputs`` lists outputs and locals in any order; rates of outputs with ``rate=True`` and
    derivatives of inputs are added. ``reference`` is a short run from which the packaged reference result is made:
    start values, and inputs as amplitude and angular frequency of a sine. ``states`` describes the continuous states that
    no output of the same name shows, for model exchange; ``not_native`` says why a unit has no native flavour."""

    name: str
    description: str
    model: ModuleType
    parameters: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    calculated: tuple[Variable, ...] = ()
    start: dict[str, float] = field(default_factory=dict)
    reference_inputs: dict[str, tuple[float, float]] = field(default_factory=dict)
    states: tuple[Variable, ...] = ()
    not_native: str = ""

    @cached_property
    def stepped(self) -> bool:
        """Whether the integrator steps this unit (it has rates but no exact step)."""
        return hasattr(self.model, "derivatives") and not any(hasattr(self.model, f) for f in ("advance", "setup"))

    @cached_property
    def input_derivatives(self) -> tuple[Variable, ...]:
        """Those of every input, three each."""
        return tuple(
            Variable(
                f"{v.name}_d{k}", per_second(v.unit, k),
                f"Derivative of order {k} of {v.name} at the communication point", 0.0, "parameter", "tunable",
            )
            for v in self.inputs for k in INPUT_ORDERS
        )  # fmt: skip

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """All variables; the position is the value reference."""
        own = (INTEGRATION_TOLERANCE,) if self.stepped else ()
        return self.parameters + own + self.calculated + self.inputs + self.input_derivatives + self.observed

    @cached_property
    def observed(self) -> tuple[Variable, ...]:
        """Outputs, locals and rates, in the order of the model's ``Outputs``."""
        rates = tuple(
            local(f"{v.name}_rate", per_second(v.unit), f"Time derivative of {v.name}") for v in self.outputs if v.rate
        )
        named = {v.name: v for v in self.outputs + rates}
        fields: tuple[str, ...] = self.model.Outputs._fields
        if set(named) != set(fields):
            raise TypeError(f"unit {self.name}: declared {sorted(set(named) ^ set(fields))} on one side only")
        return tuple(named[f] for f in fields)

    @cached_property
    def index(self) -> dict[str, int]:
        """Value reference by name."""
        return {v.name: i for i, v in enumerate(self.variables)}


def load(name: str) -> Unit:
    """The unit called ``name``. Raises ``ModuleNotFoundError`` if there is none."""
    unit: Unit = importlib.import_module(f"..{name}", __package__).UNIT
    return unit


def margin(name: str, formula: str, depends: tuple[str, ...] = ()) -> Variable:
    """A margin output: 1 at rest, 0 at the limit of validity, negative beyond."""
    return output(f"margin_{name}", "1", f"1 at rest, 0 at the limit, negative beyond: {formula}", depends=depends)


def next_event_time() -> Variable:
    """The local that asks for a communication point."""
    return local(
        "next_event_time", "s", f"Next time at which a communication point is wanted, {NEVER:g} if none", "discrete"
    )
