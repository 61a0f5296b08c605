"""What tracing gives: a unit's functions as CasADi expressions, and the sizes and places that the C text needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from ...models.numeric.kernel import Kernel
from ...models.numeric.ops import symbols
from ...models.protocol.state_space import Study
from ..declare.interface import Interface
from ..declare.unit import BuildError

OPS = symbols()


class NotNative(BuildError):
    """The unit has no native flavour; the message says why."""


@dataclass(frozen=True)
class TracedLinear:
    """The matrices of a linear unit, by the fields of ``Linear`` in ``unit.h``.

    ``layouts`` tells for every set-up, by the name of its function, how large its matrices are and where they stand in c;
    ``own`` is the number of own states, ``degree`` that of the polynomials of the core inputs, ``rate_rows`` the number
    of the first rows of y whose rates are used; ``places`` holds the position in c of each component of the constants.
    """

    study: Study
    layouts: Mapping[str, Mapping[str, int]]
    own: int
    degree: int
    rate_rows: int
    places: Any


@dataclass(frozen=True)
class Traced:
    """A unit as traced. ``functions`` by the name of their field in ``Unit`` of ``unit.h``, those of ``Linear`` with
    ``linear_`` before it; ``requirements`` are the messages, one for each result of ``required``; ``constants`` is the
    length of c; ``linear`` describes the matrices of a linear unit; ``kernels`` are those that the functions call;
    ``headers`` are those that the chain of a wire needs, by name, empty for other units."""

    interface: Interface
    functions: dict[str, ca.Function]
    modes: int
    requirements: tuple[str, ...] = ()
    constants: int = 0
    linear: TracedLinear | None = None
    kernels: tuple[Kernel, ...] = ()
    headers: Mapping[str, str] = field(default_factory=dict)


def column(name: str, size: int) -> Any:
    """A dense column of symbols."""
    return ca.SX.sym(name, size)


def parts(vector: Any) -> tuple[Any, ...]:
    """The components of a column."""
    return tuple(vector[i] for i in range(vector.numel()))


def dense(values: Iterable[Any]) -> Any:
    """A dense column of ``values``."""
    return ca.densify(ca.vertcat(*map(ca.SX, values)))


def forward(function: ca.Function, with_now: bool = False) -> ca.Function:
    """Directional derivatives: (arguments, results, one seed an argument) -> one derivative a result, all dense. ``with_now``:
    the last argument stands for the first, the time, in calls of kernels, and is no argument of what is returned."""
    sizes = [function.size1_in(i) for i in range(function.n_in() - with_now)]
    arguments, seeds = [column("a", n) for n in sizes], [column("s", n) for n in sizes]
    unused = [column("r", function.size1_out(i)) for i in range(function.n_out())]
    now = [column("now", 1)] if with_now else []
    results = function.call([*arguments, *now], True, False)
    sensed = [ca.jtimes(r, ca.vertcat(*arguments), ca.vertcat(*seeds)) for r in results]
    if with_now:
        whole = ca.Function("sensed", [*arguments, *now, *seeds], sensed)
        sensed = whole.call([*arguments, arguments[0], *seeds], True, False)
    return ca.Function(f"{function.name()}_forward", [*arguments, *unused, *seeds], [dense([d]) for d in sensed])
