"""How a wire is divided: elements from the lower end to the top, none across a joint of sections."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import AnyArray, Array
from .elements import rule
from .parts import Wire


@dataclass(frozen=True)
class Mesh:
    """``lengths`` of the elements, m, from the lower end, their ``degree``, and the ``section`` that each is of."""

    lengths: Array
    section: AnyArray
    degree: int

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.lengths) * self.degree + 1

    @property
    def places(self) -> Array:
        """s of the nodes, m, (n,)."""
        ends = np.concatenate([[0.0], np.cumsum(self.lengths)])
        inner = 0.5 * (rule(self.degree).points[:-1] + 1.0)
        return np.append((ends[:-1, None] + self.lengths[:, None] * inner).ravel(), ends[-1])


def uniform_mesh(wire: Wire, elements: int, degree: int) -> Mesh:
    """``elements`` shared among the sections by length, at least one each."""
    lengths = np.array([part.length for part in wire.sections])
    counts = np.maximum(1, np.round(elements * lengths / lengths.sum())).astype(int)
    return Mesh(np.repeat(lengths / counts, counts), np.repeat(np.arange(len(counts)), counts), degree)
