"""Runs of any unit, from its declaration: start values, and for every input a centre and a size. A unit that is new in the
registry is tested without an entry here; what stands in the two tables is what physics demands.

Inputs are random cubics of ``centre + size U`` with derivatives ``size U`` of the orders 1 to 3, U from -1 to 1: over a step
of 0.5 s they leave that range by at most 0.65 sizes.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

from towage.fmus import UNITS
from towage.fmus.declare.unit import Unit, Variable, load

NATIVE = tuple(name for name in UNITS if not load(name).not_native)
STARTS: dict[str, dict[str, float]] = {
    "ship": {"heave_phase": 0.3},
    # both sides of a docking, and everything that a line can have
    "cradle_on_line": {
        "docking_time": 3.0, "submersible_mass": 8e3, "docked_drag_area": 15.0, "length": 30.0, "wave_speed": 900.0,
    },
    "wire": {"degree": 2.0},  # half the nodes of its reference run, a fifth of the time
}  # fmt: skip
INPUTS: dict[str, dict[str, tuple[float, float]]] = {
    # large enough to make the line slack at times
    "spring_line": {"heave_top": (0.0, 4.0), "heave_bottom": (0.0, 4.0)},
    "cradle": {"line_tension": (0.0, 3e4)},
    "cradle_on_line": {"heave_top": (0.0, 4.0)},
    # a sea that the hull answers to
    "ship_in_sea": {"wave_height": (4.0, 1.0), "wave_period": (9.0, 1.0), "speed": (6.0, 0.5)},
}
"""Centre and size of inputs that the declaration does not bound as physics does."""
SIZES = {"m": 0.5, "m/s": 0.2, "N": 500.0, "rad": 0.1}
"""Sizes of inputs by unit, where the reference run has none."""
LEAVES = 2.0
"""A declared bound is so many sizes away from the centre: more than a cubic leaves it."""


@dataclass(frozen=True)
class Case:
    """Start values and, by input, (centre, size)."""

    start: dict[str, float]
    inputs: dict[str, tuple[float, float]]

    def cubics(self, chance: random.Random, held: bool = False) -> dict[str, float]:
        """A random cubic for every input, or a random value."""
        return {
            f"{name}{suffix}": (0.0 if suffix else centre) + (0.0 if held and suffix else size * chance.uniform(-1.0, 1.0))
            for name, (centre, size) in self.inputs.items()
            for suffix in ("", "_d1", "_d2", "_d3")
        }


def case(name: str) -> Case:
    """The runs of a unit."""
    unit = load(name)
    start = {**unit.start, **STARTS.get(name, {})}
    if not start.keys() & {v.name for v in unit.parameters}:
        first = unit.parameters[0]
        start[first.name] = 1.1 * (first.start or 1.0)  # a value that is not the default
    return Case(start, {v.name: INPUTS.get(name, {}).get(v.name) or _range(unit, v) for v in unit.inputs})


def _range(unit: Unit, v: Variable) -> tuple[float, float]:
    """(centre, size) of an input within its declared bounds."""
    size, _ = unit.reference_inputs.get(v.name, (SIZES.get(v.unit, 1.0), 0.0))
    centre = unit.start.get(v.name, v.start or 0.0)
    if v.min is not None:
        centre = max(centre, v.min + LEAVES * size)
    if v.max is not None:
        centre = min(centre, v.max - LEAVES * size)
    return centre, size


CASES = {name: case(name) for name in UNITS}
