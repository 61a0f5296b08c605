"""Frequency response of a tow cable by piecewise collocation: the default solver.

    y' = A(s) y,   two rows at the body, two at the towpoint        (``perturbation.py``)

On every element of a graded mesh y is a polynomial of degree p that satisfies the equations at the p Gauss points;
neighbours share their end node. The two-point problem is solved as such, by one sparse elimination with scaled columns
and one refinement, so a solution that grows by e^280 from end to end (5 km at 2 Hz) costs nothing: shooting
(``shooting.py``) cannot represent it.

The elements follow the steps of the steady integration (short where the tension is slight), subdivided until |kappa| h
is at most 2, kappa the spatial wave numbers of the equations (eigenvalues of A). Velocities are scaled by omega, so
that the limit of low frequencies is exact.

Not to be confused with a finite-difference scheme with frozen coefficients, the source's: that one is of first order.

Source of the method: collocation at Gauss points as in de Boor and Swartz, SIAM J. Numer. Anal. 10 (1973).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...numeric.arrays import Array, ComplexArray
from ..case import CableError, Tow
from .perturbation import Excitation, Response, body_rows, coefficients, towpoint_values
from .steady import Steady, basis, graded_edges, steady

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

PHASE_PER_ELEMENT = 5.0
"""Largest |kappa| h; degree 16 then interpolates exp(kappa s) to 2.5^17/(2^16 17!) = 3e-13."""
MAX_ELEMENTS = 5000


def wave_numbers(tow: Tow, omega: float, state: Steady) -> Array:
    """Largest |kappa|, 1/m, in every element of the steady state, shape (K,)."""
    matrices = coefficients(tow, omega, state.angle, state.log_tension)
    # a similarity that evens the magnitudes out: eigenvalues of badly scaled matrices lose digits
    scale = np.array(
        [1.0, tow.end_tension, max(omega, 1e-300) * tow.cable.length, max(omega, 1e-300) * tow.cable.length]
    )
    largest: Array = np.abs(np.linalg.eigvals(matrices * scale / scale[:, None])).max(axis=(1, 2))
    return largest


def mesh(tow: Tow, omega: float) -> Steady:
    """Steady state on a mesh that resolves the frequency ``omega``, rad/s. Raises `CableError` where it would need
    more than `MAX_ELEMENTS` elements."""
    edges = graded_edges(tow)
    coarse = steady(tow, edges)
    parts = np.maximum(1, np.ceil(wave_numbers(tow, omega, coarse) * np.diff(edges) / PHASE_PER_ELEMENT)).astype(int)
    if parts.sum() > MAX_ELEMENTS:
        raise CableError(
            f"the response at {omega / (2.0 * math.pi):.4g} Hz needs {parts.sum()} elements, at most {MAX_ELEMENTS} "
            "are solved: expected a lower frequency or a shorter cable"
        )
    if not np.any(parts > 1):
        return coarse
    fine = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges[:-1], edges[1:], parts)]
    return steady(tow, np.concatenate([*fine, edges[-1:]]))


def respond(
    tow: Tow,
    omega: float,
    excitation: Excitation,
    state: Steady | None = None,
) -> Response:
    """Response at ``omega``, rad/s, > 0, on the mesh of ``state`` (default: one that resolves omega). Raises
    `CableError` for a frequency that is not positive and finite, or equations without a unique solution."""
    return responses(tow, omega, [excitation], state)[0]


def responses(tow: Tow, omega: float, excitations: list[Excitation], state: Steady | None = None) -> list[Response]:
    """`respond` for several excitations at the cost of about one."""
    from scipy.sparse import csc_matrix  # takes long to load, and a unit may never ask

    check_frequency(omega)
    state = state or mesh(tow, omega)
    nodes, values, derivative = basis()
    p, count = len(nodes) - 1, len(state.edges) - 1
    half = 0.5 * np.diff(state.edges)
    velocity = omega * tow.cable.length
    scale = np.array([1.0, tow.end_tension, velocity, velocity])
    gauss = coefficients(tow, omega, state.angle @ values.T, state.log_tension @ values.T) * scale / scale[:, None]
    # blocks[k, i, a, j, b]: equation a at Gauss point i of element k, unknown b at node j
    blocks = np.einsum("ij,ab->iajb", derivative, np.eye(4))[None] - np.einsum("k,kiab,ij->kiajb", half, gauss, values)
    unknowns = 4 * (count * p + 1)
    first = 4 * p * np.arange(count)[:, None, None]
    shape = (count, 4 * p, 4 * (p + 1))
    rows = np.broadcast_to(2 + first + np.arange(4 * p)[None, :, None], shape)
    columns = np.broadcast_to(first + np.arange(4 * (p + 1))[None, None, :], shape)
    last = [unknowns - 2, unknowns - 1]
    side = np.zeros((unknowns, len(excitations)), dtype=complex)
    for i, excitation in enumerate(excitations):
        lower, lower_side = body_rows(tow, omega, excitation)
        side[:2, i] = lower_side / tow.end_tension
        side[-2:, i] = towpoint_values(omega, float(state.angle[-1, -1]), excitation) / velocity
    matrix = csc_matrix(
        (
            np.concatenate([blocks.ravel(), (lower * scale / tow.end_tension).ravel(), [1.0, 1.0]]),
            (
                np.concatenate([rows.ravel(), [0] * 4, [1] * 4, last]),
                np.concatenate([columns.ravel(), np.tile(np.arange(4), 2), last]),
            ),
        ),
        shape=(unknowns, unknowns),
    )
    index = p * np.arange(count)[:, None] + np.arange(p + 1)
    solution = _solve(matrix, side)
    answers = []
    for i in range(len(excitations)):
        fields = (solution[:, i].reshape(-1, 4) * scale)[index]
        answers.append(Response(state, omega, fields[..., 0], fields[..., 1], fields[..., 2], fields[..., 3]))
    return answers


def _solve(matrix: csc_matrix, side: ComplexArray) -> ComplexArray:
    """Sparse elimination with rows scaled to one, and one refinement."""
    from scipy.sparse.linalg import splu

    size = np.asarray(abs(matrix).max(axis=1).todense()).ravel()
    scaled = matrix.multiply(1.0 / size[:, None]).tocsc()
    b = side / size[:, None]
    try:
        factors = splu(scaled)
    except RuntimeError as error:
        raise CableError(f"the response is not determined (singular equations): {error}") from error
    x = factors.solve(b)
    x = x + factors.solve(b - scaled @ x)
    if not np.all(np.isfinite(x)):
        raise CableError("the response is not determined: the solution is not finite")
    solution: ComplexArray = x
    return solution


def check_frequency(omega: float) -> None:
    """Raises `CableError` unless ``omega`` is a positive finite number."""
    if not (math.isfinite(omega) and omega > 0.0):
        raise CableError(f"the angular frequency is {omega}: expected a positive finite number")
