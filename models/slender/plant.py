"""Towed slender body, made ready to run with numpy: what is computed once for a set of parameters.

Symbols and units: `setup`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..numeric.matrix_ops import numbers
from ..protocol.linear_model import LinearUnit
from .damping import propagator
from .galerkin import Array, Matrices
from .modes import roots, spectrum
from .setup import Constants, Parameters, assemble, body, problem, resolution, size_of, system_of

__all__ = ["Parameters", "Plant", "SlenderUnit", "body", "constants", "plant", "problem"]


class Plant:
    """Matrices and scales; ``points``: rows of tip and tail, m, and yaw, rad."""

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
def plant(p: Parameters) -> Plant:
    """The plant of a set of parameters, remembered. Raises ``ValueError`` where there is none."""
    return Plant(p)


@lru_cache(maxsize=16)
def constants(p: Parameters) -> Constants:
    """The constants, with the speed up to which the modes are resolved, as `setup.resolution` defines it."""
    made, asked = plant(p), resolution(size_of(p))
    reference = system_of(p, asked.size, numbers())
    below = getattr(made.constants, asked.below) * made.tau if asked.below else np.inf
    k = 0
    while (k + 1) * asked.grid <= asked.end:
        u = (k + 1) * asked.grid
        wanted = spectrum(reference, u, asked.modes)
        found = roots(made.system, u)
        if any(np.min(np.abs(found - s)) > asked.error * abs(s) for s in wanted[np.abs(wanted) < below]):
            break
        k += 1
    return made.constants._replace(resolved=max(k, 0.5) * asked.grid)


@dataclass(eq=False)
class SlenderUnit(LinearUnit):
    """The unit of the Python flavour, with an exponential that is fast for a speed that changes at every step."""

    def _operator(self, h: float, s: float) -> Array:
        return propagator(*self.matrices(s), h)
