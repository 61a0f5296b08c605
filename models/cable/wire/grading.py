"""Elements where the steady shape needs them: short in the layer behind a body, long where the wire is straight.

    error of an element = (l/2) max |g - I g| + BEND l (l/L)^p,   g = dr/ds of the steady shape, I its interpolation

The second term stands for the bends of a motion, which come where the steady shape is straight too: without it a straight
array is one element, and whips as one.
The element with the largest error is halved until there are as many as were asked for, or until the errors together are below
the tolerance. What remains is the error in position, over the length of the wire, that the mesh makes at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array
from .elements import lagrange, rule
from .mesh import Mesh
from .parts import Wire
from .rest import NO_TENSION, Shape

MOST_ELEMENTS = 400
BEND = 1e-2
"""Of the second term."""
SAMPLES = 9
"""Places in an element at which the interpolation is judged."""
INSIDE = 1e-9
"""Share of an element's length by which its ends are judged inside it: the pull jumps at a clump."""
EQUAL = 1e-6
"""Errors that differ by less than this share of them are equal."""


@dataclass(frozen=True)
class Graded:
    """A mesh and the ``error`` of the steady shape on it, relative to the length of the wire."""

    mesh: Mesh
    error: float


def inner_places() -> Array:
    """Where in [-1, 1] the interpolation is judged."""
    return np.linspace(-1.0, 1.0, SAMPLES + 2)[1:-1]


def graded_mesh(wire: Wire, shape: Shape, degree: int, elements: int = 0, tolerance: float = 0.0) -> Graded:
    """``elements`` (one a section at least), or 0: as many as ``tolerance`` needs, `MOST_ELEMENTS` at most."""
    stiffness = np.array([part.axial_stiffness for part in wire.sections])
    inner = inner_places()
    table, points = lagrange(degree, inner), rule(degree).points

    def error(low: float, length: float, section: int) -> float:
        def slope(x: Array) -> Array:
            s = np.clip(low + 0.5 * length * (x + 1.0), low + INSIDE * length, low + length * (1.0 - INSIDE))
            n = shape.pull(s)
            size = np.linalg.norm(n, axis=1, keepdims=True) + NO_TENSION
            g: Array = n / size + n / stiffness[section]
            return g

        still = 0.5 * length * float(np.abs(slope(inner) - table @ slope(points)).max())
        return still + BEND * length * (length / wire.length) ** degree

    found: list[tuple[float, float, float, int]] = []
    low = 0.0
    for section, part in enumerate(wire.sections):
        found.append((error(low, part.length, section), low, part.length, section))
        low += part.length
    most = elements or MOST_ELEMENTS
    while len(found) < most and (elements or sum(item[0] for item in found) > tolerance * wire.length):
        # of equals but for rounding the lowest, so that every machine and flavour divides alike
        worst = max(item[0] for item in found) * (1.0 - EQUAL)
        at = next(k for k, item in enumerate(found) if item[0] >= worst)
        _, low, length, section = found[at]
        half = 0.5 * length
        found[at : at + 1] = [(error(s, half, section), s, half, section) for s in (low, low + half)]
    return Graded(
        Mesh(np.array([item[2] for item in found]), np.array([item[3] for item in found]), degree),
        sum(item[0] for item in found) / wire.length,
    )
