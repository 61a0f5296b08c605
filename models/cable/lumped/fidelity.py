"""A linear model of a tow as small as its error allows: number of nodes and of states chosen, error stated.

The error of the discretisation is measured, not estimated: gains of the lumped model against the frequency response
(``cable/steady/response.py``) at three frequencies of the band, in the measure of ``reduction.py``. As it falls with the
square of the number of nodes, a few trials find that number. Where a light body bends the cable near itself, segments that
are shorter there do with fewer: of a few `GRADINGS` the one with the least error is taken. The error of the reduction is added
to it. In Quadrant I the velocity of the towpoint counts, in II forces on the body too: they are what drives the two problems.

A cable alone is reduced for its ends moving together and for their offset (`ends_together`): a velocity of one end
without its offset meets the last half segment's drag alone, which says nothing about the model.

The inextensibility error is the largest difference over the band between the frequency responses with and without EA.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...numeric.arrays import ComplexArray
from ...numeric.matrix_ops import MatrixOps, numbers
from ..case import CableError, Tow
from ..steady.perturbation import Excitation, Response
from ..steady.response import mesh, responses
from .linear import StateSpace, cable_elastic, tow_elastic, tow_rigid
from .lumped import MOST, hanging
from .reduction import COUNTED, reduce, relative_error

GRADINGS = (1.0, 3.0, 10.0)
"""The last segment over the first. Larger ones err more (`tests/models/test_cable_linear.py`): waves at the top need short
segments too."""
TRIED = 60
"""Most segments with which they are compared."""
LEAST_SHARE = 0.25
"""Share of the tolerance that is left to the reduction, whatever the segments took."""
UNIT_EXCITATIONS = [Excitation(surge=1.0), Excitation(heave=1.0), Excitation(drag=-1.0), Excitation(lift=1.0)]


@dataclass(frozen=True)
class Chosen:
    """``full``: the model before reduction; ``nodes``: segments, ``grading``: the last over the first; ``error``: of
    discretisation and reduction together, relative, over the band; ``inextensible_error``: of leaving EA out (0 for an elastic
    model or an unknown EA)."""

    model: StateSpace
    full: StateSpace
    nodes: int
    error: float
    inextensible_error: float
    grading: float = 1.0


def exact_gains(tow: Tow, frequencies: list[float]) -> ComplexArray:
    """Gains (frequencies, 4, 4) of force on the towpoint and velocity of the body, by velocity of the towpoint and
    force on the body, from the frequency response."""
    state = mesh(tow, max(frequencies))
    gains = np.empty((len(frequencies), 4, 4), dtype=complex)
    for k, omega in enumerate(frequencies):
        for j, r in enumerate(responses(tow, omega, UNIT_EXCITATIONS, state)):
            amplitude = -1j * omega if j < 2 else 1.0
            gains[k, :, j] = np.array(_observed(r)) / amplitude
    return gains


def _observed(r: Response) -> tuple[complex, ...]:
    fx, fy = r.towpoint_force
    x, y = r.displacement
    return -fx, -fy, complex(-1j * r.omega * x[0, 0]), complex(-1j * r.omega * y[0, 0])


def choose(
    tow: Tow,
    extensible: bool,
    band: float,
    tolerance: float,
    nodes: int = 0,
    reduced: bool = True,
    with_body: bool = True,
    grading: float = 0.0,
) -> Chosen:
    """The model for a band, rad/s, and a relative tolerance; ``nodes`` > 0 fixes the number of segments, equal ones unless
    ``grading`` > 0 says another ratio of the last to the first. Without body
    the cable is elastic, its inputs are those of `ends_together`, and its discretisation error is that of the same cable
    with the body. Raises `CableError`."""
    if not (0.0 < tolerance < 1.0 and 0.0 < band < math.inf):
        raise CableError(f"tolerance {tolerance:g}, band {band:g} rad/s: expected 0 < tolerance < 1, band > 0")
    extensible = extensible or not with_body
    rigid = replace(tow, cable=replace(tow.cable, axial_stiffness=math.inf))
    tow_used = tow if extensible else rigid
    build = tow_elastic if extensible else tow_rigid
    frequencies = [band, band / 3.0, band / 10.0]
    exact = exact_gains(tow_used, frequencies)
    counted = 2 if with_body and tow.quadrant == 1 else 4
    target = tolerance if not reduced else 0.6 * tolerance

    def tried(count: int, grading: float) -> _Trial:
        model = build(tow_used, count, grading)
        gains = np.array([_gains(model, omega) for omega in frequencies])
        return _Trial(relative_error(gains, exact, counted), model, count, grading)

    best = tried(nodes or hanging(tow_used).count, grading or 1.0)
    if not (nodes or grading or best.error <= target):
        count = min(TRIED, _wanted(best, target))
        best = min((found for g in GRADINGS if (found := _or_none(tried, count, g))), default=best)
    for _ in range(5):
        if nodes or best.error <= target or best.segments >= MOST:
            break
        # a light body may hang with some numbers of segments alone; the error says what is left
        if not (found := _or_none(tried, _wanted(best, target), best.grading)):
            break
        best = found
    error, model, count, grading = best
    full = model if with_body else ends_together(cable_elastic(tow_used, max(count, 2), grading), numbers())
    final = full
    if reduced:
        smaller = reduce(full, max(LEAST_SHARE * tolerance, tolerance - error), band, extensible, counted)
        final, error = smaller.model, error + smaller.error
    lost = 0.0
    if not extensible and math.isfinite(tow.cable.axial_stiffness):
        lost = relative_error(exact, exact_gains(tow, frequencies), counted)
    return Chosen(final, full, count, error, lost, grading)


class _Trial(NamedTuple):
    """A model of so many ``segments``, and its error."""

    error: float
    model: StateSpace
    segments: int
    grading: float


def _wanted(trial: _Trial, target: float) -> int:
    """Segments that reach ``target``, of an error of second order."""
    return min(MOST, max(trial.segments + 2, math.ceil(1.03 * trial.segments * math.sqrt(trial.error / target))))


def _or_none(tried: Callable[[int, float], _Trial], count: int, grading: float) -> _Trial | None:
    """The trial, if the cable hangs so."""
    try:
        return tried(count, grading)
    except CableError:
        return None


def ends_together(model: StateSpace, ops: MatrixOps) -> StateSpace:
    """`cable_elastic` with the inputs (velocity of both ends together, m/s, offset of the body, m, its rate, m/s), of which
    the first four count."""
    one, none = np.eye(2), np.zeros((2, 2))
    turn = ops.constant(np.block([[one, none, none], [one, none, one], [none, one, none]]))
    return replace(model, b=model.b @ turn, d=model.d @ turn, e=model.e @ turn)


def _gains(model: StateSpace, omega: float) -> ComplexArray:
    return model.response(omega, np.eye(4, dtype=complex), COUNTED)
