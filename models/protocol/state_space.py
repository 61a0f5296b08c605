"""What a linear model tells about itself, for numpy and CasADi alike: matrices, and how far they are to be trusted.

    z' = A(s) z + B(s) v,   y = C z + D v + E v',   A(s) = A0 + s A1 + s^2 A2, likewise B

`docs/native.md` lists the functions of a linear model; these are the types that they return. Names refer to components
of the model's `constants`, values of which the runtime fills in or reads.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..numeric.matrix_ops import Matrix
from ..numeric.ops import Ops, Value


class Setup(NamedTuple):
    """``a`` and ``b``: one matrix a power of the schedule, shapes (n, n) and (n, k); ``c``, ``d``, ``e`` of shapes (r, n),
    (r, k), (r, k); ``constants``: a named tuple of scalars and of tuples of scalars."""

    a: tuple[Matrix, ...]
    b: tuple[Matrix, ...]
    c: Matrix
    d: Matrix
    e: Matrix
    constants: Any


@dataclass(frozen=True)
class Reduction:
    """How the states are reduced where the parameter ``reduced`` is 1, by the parameters ``tolerance`` and ``band``.

    ``modal``: keep modes, else balance. Errors are those of `lumped.reduction`: rows 0, 1 and rows 2, 3 of y, for the
    first ``measured`` of v. ``states`` and ``error``: where their number and the error (added to what `Comparison` found)
    go. ``direct``: constants (xx, xy, yx, yy) that hold the block of D at a row and column, which the reduction changes. z
    starts at zero, which is the only state that all coordinates share.
    """

    modal: bool
    measured: str
    states: str
    error: str
    direct: tuple[str, int, int] | None = None


@dataclass(frozen=True)
class Comparison:
    """An error by comparison with the set-up for another ``size``, of at least as many inputs and four rows of y.

    ``weight`` times the largest relative difference of the gains up to ``band`` is added to the constant ``target``.
    ``weight`` 1/3 with half the segments is Richardson's estimate for an error of second order. Relative to the gains of
    this model, or to those of the other if that is the truer one. ``when(p, ops)`` > 0: whether it is made at all.
    ``stand_in``: the set-up of another model and its size, which stands for this one on both sides.
    """

    size: Any
    weight: float
    target: str
    truer: bool = False
    when: Callable[[Any, Ops], Value] | None = None
    stand_in: tuple[Callable[[Any, Any, Any], Setup], Any] | None = None


@dataclass(frozen=True)
class Resolution:
    """How far the schedule goes with resolved modes: the largest multiple k ``grid`` <= ``end`` of it up to which all of
    the first ``modes`` (Im >= 0, by magnitude) of the set-up for ``size`` are met to the relative ``error`` by modes of
    this one, at least grid/2. ``below`` names the constant above whose value, 1/s, modes do not count (None: all do);
    ``target`` the constant that becomes the result."""

    size: Any
    modes: int
    error: float
    grid: float
    end: float
    target: str
    below: str | None = None


@dataclass(frozen=True)
class Study:
    """All that is to be found out about a linear model at the start. ``growth_below`` names the constant, 1/s, that modes
    must not exceed in magnitude to count in ``growth``, the largest real part (None: growth is not wanted, 0)."""

    reduction: Reduction | None = None
    comparisons: tuple[Comparison, ...] = ()
    resolution: Resolution | None = None
    growth_below: str | None = None
