"""One spelling of matrices for numpy and CasADi, as `ops` is for scalars.

`@`, `+`, `*`, `.T` and slices mean the same for both; what does not is a function here. Matrices are two-dimensional
throughout: a column has shape (n, 1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from .ops import FLOATS, Ops, arrays, symbols

Matrix = Any
"""A two-dimensional numpy array or a CasADi matrix."""
Step = Callable[[tuple[Any, ...], tuple[Any, ...], Ops], Sequence[Any]]
"""(state, constants, ops) -> state."""


@dataclass(frozen=True)
class MatrixOps:
    """``matrix(rows)`` builds a matrix from scalars row by row; ``solve(a, b)`` is a^-1 b; ``scalars`` and ``vectors``
    spell what is done with single elements and, element by element, with vectors: one-dimensional arrays, or columns.
    ``column`` makes a column of a vector, ``diagonal`` a diagonal matrix, ``elements`` a tuple of scalars; ``constant``
    takes an array of numbers.

    ``march(step, start, constants, varying)`` applies ``step(state, values, ops) -> state`` on tuples of scalars, once for each
    element of the vectors ``varying``, which are the first of the values, before the constants; it returns every component's
    values as a vector. A trace holds the text of ``step`` once."""

    zeros: Callable[[int, int], Matrix]
    eye: Callable[[int], Matrix]
    matrix: Callable[[Sequence[Sequence[Any]]], Matrix]
    vstack: Callable[[Sequence[Matrix]], Matrix]
    hstack: Callable[[Sequence[Matrix]], Matrix]
    solve: Callable[[Matrix, Matrix], Matrix]
    constant: Callable[[Any], Matrix]
    column: Callable[[Any], Matrix]
    diagonal: Callable[[Any], Matrix]
    elements: Callable[[Any], tuple[Any, ...]]
    march: Callable[[Step, Sequence[Any], Sequence[Any], Sequence[Any]], list[Any]]
    scalars: Ops
    vectors: Ops


@cache
def numbers() -> MatrixOps:
    """On numpy arrays."""
    import numpy as np

    def matrix(rows: Sequence[Sequence[Any]]) -> Matrix:
        return np.array(rows, dtype=float)

    def march(step: Step, start: Sequence[Any], constants: Sequence[Any], varying: Sequence[Any]) -> list[Any]:
        states, fixed = [tuple(map(float, start))], tuple(map(float, constants))
        for each in zip(*(column.tolist() for column in varying)):
            states.append(tuple(step(states[-1], (*each, *fixed), FLOATS)))
        return [np.array(values) for values in zip(*states[1:])]

    return MatrixOps(
        zeros=lambda n, m: np.zeros((n, m)), eye=np.eye, matrix=matrix, vstack=np.vstack, hstack=np.hstack,
        solve=np.linalg.solve, constant=np.asarray, column=lambda v: v[:, None], diagonal=np.diag, elements=tuple, march=march,
        scalars=FLOATS, vectors=arrays(),
    )  # fmt: skip


@cache
def traces() -> MatrixOps:
    """On CasADi MX matrices."""
    import casadi as ca

    def matrix(rows: Sequence[Sequence[Any]]) -> Matrix:
        return ca.vertcat(*(ca.horzcat(*row) for row in rows))

    def march(step: Step, start: Sequence[Any], constants: Sequence[Any], varying: Sequence[Any]) -> list[Any]:
        count, rows = varying[0].numel(), len(varying) + len(constants)
        state, fixed = ca.SX.sym("state", len(start)), ca.SX.sym("constants", rows)
        after = ca.vertcat(*step(tuple(ca.vertsplit(state)), tuple(ca.vertsplit(fixed)), symbols()))
        once = ca.Function(step.__name__, [state, fixed], [ca.densify(after)])
        all_of = ca.vertcat(*(column.T for column in varying), ca.repmat(ca.vertcat(*constants), 1, count))
        columns = once.mapaccum(count)(ca.vertcat(*start), all_of)
        return [columns[i, :].T for i in range(len(start))]

    # dense throughout: patterns of zeros would cost more text than they save time
    return MatrixOps(
        zeros=lambda n, m: ca.MX(ca.DM.zeros(n, m)), eye=lambda n: ca.MX(ca.DM.eye(n).full()), matrix=matrix,
        vstack=lambda parts: ca.vertcat(*parts), hstack=lambda parts: ca.horzcat(*parts),
        solve=lambda a, b: ca.solve(a, b, "qr"), constant=lambda values: ca.MX(ca.DM(values)), column=lambda v: v,
        diagonal=lambda v: ca.densify(ca.diag(v)),
        elements=lambda v: tuple(v[i] for i in range(v.numel())), march=march, scalars=symbols(), vectors=symbols(),
    )  # fmt: skip
