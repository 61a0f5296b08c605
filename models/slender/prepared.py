"""Towed slender body, prepared to run with numpy: what is computed once for a set of parameters.

Symbols and units: `setup`.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..numeric.arrays import Array
from ..numeric.matrix_ops import numbers
from .galerkin import Matrices
from .modes import roots, spectrum
from .setup import Constants, Parameters, assemble, body, resolution, size_of, system_of


class Prepared:
    """Matrices and scales; ``points``: rows of tip and tail, m, and yaw, rad. Raises ``ValueError`` where there is no
    body."""

    def __init__(self, p: Parameters) -> None:
        self.body = body(p)
        self.system: Matrices = system_of(p, size_of(p), numbers())
        self.n = self.system.n
        made = assemble(p, self.system, numbers())
        self.setup, self.constants = made, Constants(*map(float, made.constants))
        self.tau: float = self.constants.time_scale
        self.speed: float = self.constants.speed_scale
        self.pull: float = self.constants.pull
        self.rope = p.rope_length
        self.points: Array = self.setup.c[:3, : self.n]


@lru_cache(maxsize=16)
def prepare(p: Parameters) -> Prepared:
    """What follows from a set of parameters, remembered. Raises ``ValueError`` where there is no body."""
    return Prepared(p)


@lru_cache(maxsize=16)
def resolved_constants(p: Parameters) -> Constants:
    """The constants, with the speed up to which the modes are resolved, as `setup.resolution` defines it."""
    made, asked = prepare(p), resolution(size_of(p))
    reference = system_of(p, asked.size, numbers())
    below = made.constants.flexure * made.tau if asked.below else np.inf
    k = 0
    while (k + 1) * asked.grid <= asked.end:
        u = (k + 1) * asked.grid
        wanted = spectrum(reference, u, asked.modes)
        modes = roots(made.system, u)
        if any(np.min(np.abs(modes - s)) > asked.error * abs(s) for s in wanted[np.abs(wanted) < below]):
            break
        k += 1
    return made.constants._replace(resolved=max(k, 0.5) * asked.grid)
