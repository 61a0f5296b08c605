"""Smaller linear models of a tow cable, each with its measured error.

Two methods, one for each kind of model:

* `balanced`: balanced realisation of the cable that keeps its length, the weak states replaced by their static response
  (singular perturbation): exact at rest and, as a rule, stable. The apparent mass
  m_app stays as it is.
* `modal`: elastic cables. The modes that matter in the band are kept, the others replaced by their response to a
  constant and a linearly growing input (static and acceleration correction: D and E). Balanced truncation fails here:
  lightly damped axial modes far above the band dominate the Hankel singular values.

The error is the largest over the band, frequency by frequency, of |y_reduced - y|/|y| with the largest component of the
towpoint's force and of the second pair of outputs (velocity of the body, or force on it), each for every input that counts alone.
A candidate that is not stable is never returned.

Not to be confused with proper orthogonal decomposition over a band, which gave unstable models here.

Source: singular perturbation of balanced systems, Liu and Anderson, Int. J. Control 50 (1989); modal acceleration,
Craig, Structural Dynamics (1981), chapter 15.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...numeric.arrays import Array, ComplexArray
from ..case import CableError
from .linear import BODY_VELOCITY, FORCE, StateSpace

FREQUENCIES = 40
"""Number of frequencies at which an error is measured, evenly spaced in their logarithm."""
BAND_START, BAND_SHARE = 0.02, 0.1
"""Low end of the band, rad/s, a period of five minutes; of a narrow band, its share of the high end."""
COUNTED = slice(FORCE.start, BODY_VELOCITY.stop)
"""Rows of y by which an error is measured."""
ALL = slice(None)
NEGLIGIBLE = 1e-12
"""Hankel singular values below this share of the largest are rounding."""


@dataclass(frozen=True)
class Reduced:
    """``error``: relative, as the module's text says, up to ``band``, rad/s."""

    model: StateSpace
    error: float
    band: float


def band_frequencies(band: float, count: int = FREQUENCIES) -> Array:
    """Angular frequencies, rad/s, up to ``band``."""
    return np.geomspace(min(BAND_START, BAND_SHARE * band), band, count)


class Modes(NamedTuple):
    """Eigenvalues of A, 1/s, (n,); inputs to modes, (n, m); modes to outputs, (r, n)."""

    values: ComplexArray
    left: ComplexArray
    right: ComplexArray


def modes(model: StateSpace) -> Modes:
    """The modes of a model."""
    values, vectors = np.linalg.eig(model.a)
    return Modes(values, np.linalg.solve(vectors, model.b), model.c @ vectors)


def transfer(model: StateSpace, frequencies: Array, known: Modes | None = None, rows: slice = ALL) -> ComplexArray:
    """Gains of outputs (``rows``) by every input, shape (frequencies, r, m), for exp(-i omega t); ``known``: its modes."""
    values, left, right = known or modes(model)
    s = -1j * frequencies[:, None]
    gains: ComplexArray = (right[rows] / (s - values)[:, None, :]) @ left + model.d[rows] + s[..., None] * model.e[rows]
    return gains


def relative_error(gains: ComplexArray, exact: ComplexArray, inputs: int = 4) -> float:
    """The measure of the module's text, for the first ``inputs`` of the inputs."""
    worst = 0.0
    for rows in (FORCE, BODY_VELOCITY):
        size = np.abs(exact[:, rows, :inputs]).max(axis=1)
        difference = np.abs(gains[:, rows, :inputs] - exact[:, rows, :inputs]).max(axis=1)
        keep = size > 0.0
        worst = max(worst, float((difference[keep] / size[keep]).max(initial=0.0)))
    return worst


def stable(model: StateSpace) -> bool:
    """Whether every mode decays."""
    return bool(np.linalg.eigvals(model.a).real.max(initial=-1.0) < 0.0)


def reduce(model: StateSpace, tolerance: float, band: float, extensible: bool, inputs: int = 4) -> Reduced:
    """The smallest model of the method for its kind whose error up to ``band``, rad/s, is at most ``tolerance``; the
    full model, error 0, where none is. Raises `CableError` for a tolerance or band that is not positive."""
    if not (tolerance > 0.0 and band > 0.0):
        raise CableError(f"tolerance {tolerance:g}, band {band:g} rad/s: expected positive numbers")
    frequencies, known = band_frequencies(band), modes(model)
    exact = transfer(model, frequencies, known, COUNTED)
    build = _modal(model, known, exact, frequencies, inputs) if extensible else _balanced(model, exact, inputs)
    for states in range(1, len(model.a)):
        # the profile along the cable is hundreds of outputs, and no error counts there
        candidate = build(states, COUNTED)
        if candidate is None or not stable(candidate):
            continue
        error = relative_error(transfer(candidate, frequencies), exact, inputs)
        if error <= tolerance:
            whole = build(states, ALL)
            assert whole is not None
            return Reduced(whole, error, band)
    return Reduced(model, 0.0, band)


Build = Callable[[int, slice], StateSpace | None]
"""Of the number of states and the outputs that are wanted."""


def _balanced(model: StateSpace, exact: ComplexArray, inputs: int) -> Build:
    """The reduced model of a number of states, or None."""
    from scipy.linalg import matrix_balance, solve_continuous_lyapunov  # loads slowly, see `exact_step`

    rows = COUNTED
    # outputs and inputs measured by what passes between them in the band
    out = 1.0 / np.abs(exact[:, rows, :2]).max(axis=(0, 2))
    scale = np.ones(inputs)
    scale[2:] = 1.0 / max(float(np.abs(exact[:, FORCE, 2:4]).max()), 1e-300) / out[0]
    # momenta beside angles cost the gramians three digits of the error, coordinates of like size none
    a, (size, _) = matrix_balance(model.a, permute=False, separate=True)
    all_b, all_c = model.b / size[:, None], model.c * size
    b, c = all_b[:, :inputs] * scale, all_c[rows] * out[:, None]
    controllability = _root(solve_continuous_lyapunov(a, -b @ b.T))
    observability = _root(solve_continuous_lyapunov(a.T, -c.T @ c))
    u, s, vt = np.linalg.svd(observability.T @ controllability)
    count = int((s > NEGLIGIBLE * s[0]).sum())
    root = 1.0 / np.sqrt(s[:count])
    right = controllability @ vt[:count].T * root
    left = observability @ u[:, :count] * root
    a, b, c = left.T @ a @ right, left.T @ all_b, all_c @ right

    def build(states: int, rows: slice) -> StateSpace | None:
        if states >= count:
            return None
        k = states
        slow, fast = slice(0, k), slice(k, count)
        x, u_fast = (np.linalg.solve(a[fast, fast], m) for m in (a[fast, slow], b[fast]))
        return replace(
            model, a=a[slow, slow] - a[slow, fast] @ x, b=b[slow] - a[slow, fast] @ u_fast,
            c=c[rows, slow] - c[rows, fast] @ x, d=model.d[rows] - c[rows, fast] @ u_fast, e=model.e[rows],
        )  # fmt: skip

    return build


def _root(gramian: Array) -> Array:
    """A factor R with R R' = the gramian."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    root: Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _modal(model: StateSpace, known: Modes, exact: ComplexArray, frequencies: Array, inputs: int) -> Build:
    """The reduced model of a number of states, or None where it would split a pair."""
    upper = np.flatnonzero(known.values.imag >= 0.0)
    values, left, right = known.values[upper], known.left[upper], known.right[:, upper]
    width, rows = np.where(values.imag > 0.0, 2, 1), COUNTED
    s = -1j * frequencies[:, None]
    # what a mode leaves behind when static and acceleration correction stand for it: (s/value)^2/(s - value)
    rest = np.abs((s / values) ** 2 / (s - values))
    size = np.maximum(np.abs(exact[:, rows, :inputs]).max(axis=1), 1e-300)
    strength = np.abs(left[:, None, :inputs]) * np.abs(right[rows].T[:, :, None])
    importance = np.array([
        (rest[:, i, None] * strength[i].max(axis=0) / size).max() * width[i] for i in range(len(values))
    ])  # fmt: skip
    order = np.argsort(-importance)
    sizes = np.cumsum(width[order])

    def build(states: int, rows: slice) -> StateSpace | None:
        whole = np.flatnonzero(sizes == states)
        if not len(whole):
            return None
        kept, dropped = order[: whole[0] + 1], order[whole[0] + 1 :]
        a, b, c = [], [], []
        for i in kept:
            re, im = values[i].real, values[i].imag
            if width[i] == 1:
                a.append(np.array([[re]]))
                b.append(left[i].real[None])
                c.append(right[rows, i].real[:, None])
            else:
                a.append(np.array([[re, im], [-im, re]]))
                b.append(np.stack([left[i].real, -left[i].imag]) * 2.0)
                c.append(np.stack([right[rows, i].real, right[rows, i].imag], axis=1))
        # conjugates double the real part of a pair
        out = right[rows][:, dropped]
        static = -((out * (width[dropped] / values[dropped])) @ left[dropped]).real
        acceleration = -((out * (width[dropped] / values[dropped] ** 2)) @ left[dropped]).real
        block = np.zeros((states, states))
        row = 0
        for part in a:
            block[row : row + len(part), row : row + len(part)] = part
            row += len(part)
        d, e = model.d[rows] + static, model.e[rows] + acceleration
        return replace(model, a=block, b=np.vstack(b), c=np.hstack(c), d=d, e=e)

    return build
