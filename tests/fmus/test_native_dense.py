"""Dense matrix functions of the native runtime against numpy and scipy."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, matrix_balance, solve_continuous_lyapunov

from .native_instance import compile_library, doubles

RANDOM = np.random.default_rng(1)


@pytest.fixture(scope="module")
def dense(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    library = compile_library(["dense.c", "eigen.c"], tmp_path_factory.mktemp("dense") / "dense.so")
    for function in (library.exponential, library.eigenvalues, library.schur, library.lu_factor):
        function.restype = ctypes.c_bool
    return library


def column_major(a: Any) -> Any:
    return doubles(np.asarray(a).ravel(order="F").tolist())


def square(values: Any, n: int, columns: int | None = None) -> Any:
    return np.array(values).reshape(n, columns or n, order="F")


def companion(n: int) -> Any:
    """Of (s + 1)^n: one eigenvalue, one vector."""
    a = np.diag(np.ones(n - 1), 1)
    a[-1] = -np.poly1d([-1.0] * n, True).coeffs[:0:-1]
    return a


def chain(n: int) -> Any:
    """Masses on stiff springs, little damped, with displacements in micrometres: a norm far above the eigenvalues."""
    half = n // 2
    stiffness = 1e4 * (2.0 * np.eye(half) - np.eye(half, k=1) - np.eye(half, k=-1))
    a = np.block([[np.zeros((half, half)), np.eye(half)], [-stiffness, -0.01 * np.eye(half)]])
    scale = np.r_[np.full(half, 1e6), np.ones(half)]
    return a * scale[:, None] / scale


MATRICES: dict[str, Callable[[], Any]] = {
    "one": lambda: np.array([[-3.0]]),
    "zero": lambda: np.zeros((5, 5)),
    "random": lambda: RANDOM.normal(size=(30, 30)),
    "random160": lambda: RANDOM.normal(size=(160, 160)) / 8.0,
    "defective": lambda: companion(5),
    "nilpotent": lambda: np.diag(np.full(9, 100.0), 1),
    "triangular": lambda: np.triu(RANDOM.normal(size=(20, 20))) * 3.0,
    "stiff": lambda: np.diag([-1e5, -1.0, -1e-5]) + np.diag([1e3, 1.0], 1),
    "unscaled": lambda: chain(80),
}


@pytest.mark.parametrize("name", MATRICES)
def test_exponential(name: str, dense: ctypes.CDLL) -> None:
    a, _ = matrix_balance(MATRICES[name](), permute=False)
    n = len(a)
    found = column_major(a)
    assert dense.exponential(n, found, doubles(6 * n * n), (ctypes.c_int * n)())
    exact = expm(a)
    # both lose digits with every squaring of a matrix that is not normal: 1e-16 times the norm, 3e4 for the chain
    assert np.abs(square(found, n) - exact).max() <= 1e-15 * max(10.0, np.abs(a).sum(axis=0).max()) * np.abs(exact).max()


def test_exponential_refuses_what_is_not_finite(dense: ctypes.CDLL) -> None:
    for a in (np.array([[math.nan, 0.0], [0.0, 1.0]]), np.array([[1e4]])):
        n = len(a)
        assert not dense.exponential(n, column_major(a), doubles(6 * n * n), (ctypes.c_int * n)())


def eigenvalues(dense: ctypes.CDLL, a: Any) -> Any:
    n = len(a)
    values = doubles(2 * n)
    assert dense.eigenvalues(n, column_major(a), values, doubles(2 * n * n), doubles(2 * n))
    return np.array(values)[::2] + 1j * np.array(values)[1::2]


@pytest.mark.parametrize("name", MATRICES)
def test_eigenvalues(name: str, dense: ctypes.CDLL) -> None:
    a = MATRICES[name]()
    left = list(np.linalg.eigvals(a))
    # of a five-fold eigenvalue rounding leaves eps^(1/5) = 7e-4, of the ten-fold zero exactly nothing
    near = {"defective": 3e-3}.get(name, 1e-11 * np.abs(left).max())
    for value in eigenvalues(dense, a):
        place = int(np.argmin(np.abs(np.array(left) - value)))
        assert abs(left.pop(place) - value) <= near


def test_lyapunov_and_vectors(dense: ctypes.CDLL) -> None:
    """In the coordinates of a Schur form; both equations have the solutions that scipy finds."""
    n = 24
    a = RANDOM.normal(size=(n, n)) - 8.0 * np.eye(n)
    h, q = column_major(a), doubles(n * n)
    dense.hessenberg(n, h, q, doubles(n))
    real, turn = square(h, n), square(q, n)
    # products of orthogonal matrices: n eps of the norm
    assert np.abs(turn @ real @ turn.T - a).max() < 1e-13 * n
    assert np.abs(np.tril(real, -2)).max() == 0.0
    t, u = (doubles(np.c_[m.ravel(order="F"), np.zeros(n * n)].ravel().tolist()) for m in (real, turn))
    assert dense.schur(n, t, u)

    def complex_square(values: Any, columns: int = n) -> Any:
        return (np.array(values)[::2] + 1j * np.array(values)[1::2]).reshape(n, columns, order="F")

    triangle, unitary = complex_square(t), complex_square(u)
    assert np.abs(unitary @ triangle @ unitary.conj().T - a).max() < 1e-13 * n
    b = RANDOM.normal(size=(n, 3))
    for adjoint in (False, True):
        f = unitary.conj().T @ b @ b.T @ unitary
        given = doubles(np.c_[f.ravel(order="F").real, f.ravel(order="F").imag].ravel().tolist())
        dense.lyapunov(n, t, adjoint, given)
        found = (unitary @ complex_square(given) @ unitary.conj().T).real
        exact = solve_continuous_lyapunov(a.T if adjoint else a, -b @ b.T)
        # the distance of the spectrum from the axis is of order 1: only rounding
        assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()
    for j in (0, n // 2, n - 1):
        right, left = doubles(2 * n), doubles(2 * n)
        dense.right_vector(n, t, j, right)
        dense.left_vector(n, t, j, left)
        x, y = complex_square(right, 1)[:, 0], complex_square(left, 1)[:, 0]
        # vectors grow where eigenvalues are close: 1e-3 here
        assert np.abs(triangle @ x - triangle[j, j] * x).max() < 1e-11 * np.abs(x).max()
        assert np.abs(y.conj() @ triangle - triangle[j, j] * y.conj()).max() < 1e-11 * np.abs(y).max()


def test_factors(dense: ctypes.CDLL) -> None:
    """Singular values, and the factor of a matrix of low rank with a wide range of scales."""
    a = RANDOM.normal(size=(12, 9)) * 10.0 ** -np.arange(9)
    u, v, s = column_major(a), doubles(81), doubles(9)
    dense.singular_values(12, 9, u, v, s)
    exact = np.linalg.svd(a, compute_uv=False)
    # one-sided rotations are accurate relative to each singular value of scaled columns, LAPACK to the largest: 1e-16
    assert np.abs(np.array(s) - exact).max() < 1e-14 * exact[0]
    assert np.abs(square(u, 12, 9) @ square(v, 9).T - a).max() < 1e-14 * exact[0]
    b = RANDOM.normal(size=(10, 4)) * 10.0 ** np.linspace(-6.0, 6.0, 10)[:, None]
    p, root = column_major(b @ b.T), doubles(100)
    rank = dense.root_factor(10, p, root, doubles(10))
    assert 4 <= rank <= 6  # one or two columns at the level of rounding
    found, size = square(root, 10)[:, :rank], np.abs(b).max(axis=1)
    assert np.abs((found @ found.T - b @ b.T) / np.outer(size, size)).max() < 1e-13


def test_solve(dense: ctypes.CDLL) -> None:
    a, b = RANDOM.normal(size=(40, 40)), RANDOM.normal(size=(40, 3))
    lu, x, pivot = column_major(a), column_major(b), (ctypes.c_int * 40)()
    assert dense.lu_factor(40, lu, pivot)
    dense.lu_solve(40, 3, lu, pivot, x)
    exact = np.linalg.solve(a, b)
    assert np.abs(square(x, 40, 3) - exact).max() < 1e-15 * np.linalg.cond(a) * np.abs(exact).max()
    assert not dense.lu_factor(2, doubles(4), pivot)
