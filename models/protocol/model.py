"""A model is a value: its named variables and its pure functions of them, in one record.

| name | meaning |
|---|---|
| t, h | time and length of a step, s |
| x, m | continuous states and modes (discrete states, 0.0 or 1.0), ``State`` and ``Modes`` |
| u, du | inputs and their first time derivatives, ``Inputs`` |
| p | parameters, ``Parameters``, a frozen dataclass |
| ops | the spelling of sin, where, ... for the kind of value in use (``numeric/ops.py``) |

The functions read nothing but their arguments, so that one text serves floats, arrays, symbols and traces. Names stand for
components everywhere (``x.velocity``); the Python FMU turns them into positions when it loads a model.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from ..numeric.ops import FLOATS, Ops, Value

if TYPE_CHECKING:
    from .linear_model import LinearModel

P = TypeVar("P")
X = TypeVar("X")
M = TypeVar("M")
U = TypeVar("U")
Y = TypeVar("Y")
Requirement = tuple[Value, str]
"""A value that must be positive, and what to say where it is not."""


def refusal_of(requirements: Sequence[Requirement]) -> str:
    """The message of the first requirement, of numbers, that is not met (nan meets none); empty if all are."""
    return next((text for value, text in requirements if not value > 0.0), "")


Cubics = Sequence[Sequence[Value]]
"""Of every input the coefficients of 1, s, s^2, s^3 over a step."""


class Record:
    """Base of records of functions: a name that is not one of the record's fields is refused with the closest that is, and
    so is a function of that name which the module defines and the record does not hold."""

    def __new__(cls, *values: Any, **named: Any) -> Any:
        """Refuses names that are not fields."""
        known = [f.name for f in fields(cls)]  # type: ignore[arg-type]
        for name in named:
            if name not in known:
                import difflib  # for a fault alone

                close = difflib.get_close_matches(name, known, 1)
                hint = f"did you mean {close[0]}?" if close else f"expected one of {', '.join(known)}"
                raise TypeError(f"{cls.__name__} has no function {name}: {hint}")
        return super().__new__(cls)

    def check_against(self, module: str) -> None:
        """Raises ``TypeError`` for a function that ``module`` defines under the name of a field that is empty."""
        for field in fields(self):  # type: ignore[arg-type]
            defined = getattr(sys.modules.get(module), field.name, None)
            if getattr(self, field.name) is None and callable(defined) and defined.__module__ == module:
                raise TypeError(f"{module} defines {field.name}, but its {type(self).__name__} does not name it")


@dataclass(frozen=True, eq=False, repr=False)
class Model(Record, Generic[P, X, M, U, Y]):
    """The functions by which a unit, a composition and a trace know a model. What is None the model does not have.

    * ``initial(p, ops) -> (x, m)``: start of a run.
    * ``outputs(t, x, m, u, du, p, ops) -> Outputs``: all that can be observed, rates and margins included.
    * ``derivatives(t, x, m, u, p, ops) -> x'``: smooth between events.
    * ``advance(t, h, x, m, cubics, p, ops) -> x``: the step, where the model makes it itself.
    * ``indicators(t, x, m, u, p, ops)``: zero-crossing functions; an integrator restarts at their zeros.
    * ``transition(t, x, m, u, p, ops) -> (x, m)``: the discrete change at a communication point or event.
    * ``next_event_time(t, m, p, ops)``: when a transition is due, s, `NEVER` if none.
    * ``calculated(p, ops) -> Calculated``: what follows from the parameters alone.
    * ``requirements(p, ops)``: what the parameters must fulfil.
    * ``refusal(p)``: why these parameters make no model, where that takes more than `requirements`; empty if they do.
    * ``tuning_refusal(p)``: why tunable parameters may not change while the model runs with p; empty if they may.

    * ``numbers(p, ops)``: what the steps of a wire in C take, where ``floats_only`` functions have a native flavour all the same.
    * ``part(p)``: the model with these parameters, numbers, whose states have rates, which stands for it in a composition.

    ``floats_only`` says why the functions cannot be traced, empty where they can. ``structure`` names parameters that decide
    sizes and tables, which a trace and a composition fix (`fixed`). ``takes_second``: ``outputs`` takes the
    second derivatives of the inputs after the first (parts of a composition alone). ``by_position``: components are read by
    position, so that plain tuples do for named ones. ``linear`` holds the matrices of a linear model; ``over(spelling)`` gives
    a model that is made of others with these spelled anew. ``held`` names inputs whose rates x' would need, so that nothing in
    a composition may feed them.
    """

    name: str
    description: str
    Parameters: Callable[..., P]
    State: Any
    Modes: Any
    Inputs: Any
    Outputs: Any
    Calculated: Any = None
    _: KW_ONLY
    initial: Callable[[P, Ops], tuple[X, M]]
    outputs: Callable[..., Y]
    derivatives: Callable[[Value, X, M, U, P, Ops], X] | None = None
    advance: Callable[[Value, Value, X, M, U, P, Ops], X] | None = None
    indicators: Callable[[Value, X, M, U, P, Ops], tuple[Value, ...]] | None = None
    transition: Callable[[Value, X, M, U, P, Ops], tuple[X, M]] | None = None
    next_event_time: Callable[[Value, M, P, Ops], Value] | None = None
    calculated: Callable[[P, Ops], Sequence[Value]] | None = None
    requirements: Callable[[P, Ops], Sequence[Requirement]] | None = None
    refusal: Callable[[P], str] | None = None
    tuning_refusal: Callable[[P], str] | None = None
    numbers: Callable[[P, Ops], Sequence[Any]] | None = None
    part: Callable[[P], AnyModel] | None = None
    floats_only: str = ""
    structure: tuple[str, ...] = ()
    takes_second: bool = False
    by_position: bool = False
    linear: LinearModel | None = None
    over: Callable[[Spelling], AnyModel] | None = None
    held: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.linear is None and self.over is None:
            self.check_against(self.outputs.__module__)

    def fixed(self, values: Mapping[str, float]) -> Model[P, X, M, U, Y]:
        """The model whose parameters of ``values`` are these numbers, whatever it is given."""
        if not values:
            return self

        def hold(p: Any) -> None:
            for name, value in values.items():
                object.__setattr__(p, name, value)

        kind = type("Fixed", (self.Parameters,), {"__post_init__": hold, "__annotations__": {}})  # type: ignore[arg-type]
        return replace(self, Parameters=dataclass(frozen=True)(kind))

    @property
    def documentation(self) -> str:
        """The docstring of the module that holds the functions: equation, symbols, assumptions, source."""
        home = self.linear.observe if self.linear else self.outputs
        return (sys.modules[home.__module__].__doc__ or "").strip()

    @property
    def integrated(self) -> bool:
        """Whether an integrator steps this model: it has rates but no step of its own."""
        return self.derivatives is not None and self.advance is None

    def refused(self, p: P) -> str:
        """Why the model does not take these parameters, numbers; empty if it does."""
        unmet = refusal_of(self.requirements(p, FLOATS)) if self.requirements else ""
        return unmet or (self.refusal(p) if self.refusal else "")


AnyModel = Model[Any, Any, Any, Any, Any]
Spelling = Callable[[AnyModel], AnyModel]
"""Gives a model whose functions are written another way, with the same values."""


def remembered(make: Callable[[P], Y]) -> Callable[[P], Y]:
    """``make(parameters)``, computed once for equal parameters and kept on the object itself, which is found at once:
    hashing dozens of fields would cost more than a step."""
    known = lru_cache(maxsize=16)(make)
    key = f"_made_by_{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def remember(parameters: P) -> Y:
        kept: dict[str, Y] = parameters.__dict__
        try:
            return kept[key]
        except KeyError:
            kept[key] = known(parameters)
            return kept[key]

    return remember
