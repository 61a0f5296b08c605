"""Elements where the steady shape needs them: short in the layer behind a body, long where the wire is straight.

    error of an element = (l/2) max |g - I g| + BEND l (l/L)^p,   g = dr/ds of the steady shape, I its interpolation

The second term stands for the bends of a motion, which come where the steady shape is straight too: without it a straight
array is one element, and whips as one.
The element with the largest error is halved until there are as many as were asked for, or until the errors together are below
the tolerance. What remains is the error in position, over the length of the wire, that the mesh makes at rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heapreplace

import numpy as np

from ...numeric.arrays import Array
from .elements import lagrange, rule
from .mesh import Mesh
from .parts import Wire
from .rest import Shape

MOST_ELEMENTS = 400
BEND = 1e-2
"""Of the second term."""
SAMPLES = 9
"""Places in an element at which the interpolation is judged."""


@dataclass(frozen=True)
class Graded:
    """A mesh and the ``error`` of the steady shape on it, relative to the length of the wire."""

    mesh: Mesh
    error: float


def graded_mesh(wire: Wire, shape: Shape, degree: int, elements: int = 0, tolerance: float = 0.0) -> Graded:
    """``elements`` (one a section at least), or 0: as many as ``tolerance`` needs, `MOST_ELEMENTS` at most."""
    stiffness = np.array([part.axial_stiffness for part in wire.sections])
    inner = np.linspace(-1.0, 1.0, SAMPLES + 2)[1:-1]
    table, points = lagrange(degree, inner), rule(degree).points

    def error(low: float, length: float, section: int) -> float:
        def slope(x: Array) -> Array:
            s = np.clip(low + 0.5 * length * (x + 1.0), low + 1e-9 * length, low + length * (1.0 - 1e-9))
            n = shape.pull(s)
            size = np.linalg.norm(n, axis=1, keepdims=True) + 1e-30
            g: Array = n / size + n / stiffness[section]
            return g

        still = 0.5 * length * float(np.abs(slope(inner) - table @ slope(points)).max())
        return still + BEND * length * (length / wire.length) ** degree

    heap: list[tuple[float, float, float, int]] = []
    low = 0.0
    for section, part in enumerate(wire.sections):
        heap.append((-error(low, part.length, section), low, part.length, section))
        low += part.length
    heapify(heap)
    most = elements or MOST_ELEMENTS
    while len(heap) < most and (elements or -sum(item[0] for item in heap) > tolerance * wire.length):
        _, low, length, section = heap[0]
        half = 0.5 * length
        heapreplace(heap, (-error(low, half, section), low, half, section))
        right = (-error(low + half, half, section), low + half, half, section)
        heap.append(right)
        heapify(heap)
    ordered = sorted(heap, key=lambda item: item[1])
    return Graded(
        Mesh(np.array([item[2] for item in ordered]), np.array([item[3] for item in ordered]), degree),
        -sum(item[0] for item in heap) / wire.length,
    )
