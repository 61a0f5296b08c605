"""One spelling of matrices for numpy and CasADi, as `ops` is for scalars.

`@`, `+`, `*`, `.T` and slices mean the same for both; what does not is a function here. Matrices are two-dimensional
throughout: a column has shape (n, 1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .ops import FLOATS, Ops, symbols

Matrix = Any
"""A two-dimensional numpy array or a CasADi matrix."""


@dataclass(frozen=True)
class MatrixOps:
    """``matrix(rows)`` builds a matrix from scalars row by row; ``solve(a, b)`` is a^-1 b; ``scalars`` spells what is done
    with single elements."""

    zeros: Callable[[int, int], Matrix]
    eye: Callable[[int], Matrix]
    matrix: Callable[[Sequence[Sequence[Any]]], Matrix]
    vstack: Callable[[Sequence[Matrix]], Matrix]
    hstack: Callable[[Sequence[Matrix]], Matrix]
    solve: Callable[[Matrix, Matrix], Matrix]
    scalars: Ops


def numbers() -> MatrixOps:
    """On numpy arrays."""
    import numpy as np

    def matrix(rows: Sequence[Sequence[Any]]) -> Matrix:
        return np.array(rows, dtype=float)

    return MatrixOps(
        zeros=lambda n, m: np.zeros((n, m)), eye=np.eye, matrix=matrix, vstack=np.vstack, hstack=np.hstack,
        solve=np.linalg.solve, scalars=FLOATS,
    )  # fmt: skip


def traces() -> MatrixOps:
    """On CasADi MX matrices."""
    import casadi as ca

    def matrix(rows: Sequence[Sequence[Any]]) -> Matrix:
        return ca.vertcat(*(ca.horzcat(*row) for row in rows))

    return MatrixOps(
        zeros=ca.MX.zeros, eye=ca.MX.eye, matrix=matrix, vstack=lambda parts: ca.vertcat(*parts),
        hstack=lambda parts: ca.horzcat(*parts), solve=lambda a, b: ca.solve(a, b, "qr"), scalars=symbols(),
    )  # fmt: skip
