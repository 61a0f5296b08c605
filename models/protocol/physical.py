"""What no body and no water can be, as requirements that models share: numbers in SI, true for any model of such a thing.

They catch what is written in the wrong unit or in the wrong place; a run of such a scene would be faultless and mean nothing.
"""

from __future__ import annotations

import math

from ..numeric.ops import Ops, Value
from .model import Requirement

GRAVITY = 9.80665
"""Standard gravity, m/s2."""
DENSEST_WATER = 1500.0
"""kg/m3; the Dead Sea has 1240."""
DENSEST_SOLID = 22600.0
"""kg/m3; osmium has 22 590."""
ROUNDING = 1e-6
"""Relative; a body as heavy in water as in air, with m g written to seven digits, is taken."""


def holds(condition: Value, ops: Ops) -> Value:
    """1 where the condition holds, else 0: a `Requirement`'s value."""
    return ops.where(condition, 1.0, 0.0)


def weight_below_gravity(weight: Value, mass: Value, weight_name: str, mass_name: str, ops: Ops) -> Requirement:
    """A weight in water, N, of at most m g (per length alike): buoyancy cannot pull down."""
    text = (
        f"{weight_name} is above {mass_name} * g, the weight in air: in water a body weighs less by its buoyancy; "
        f"raise {mass_name} or lower {weight_name} (units of measure?)"
    )
    return holds(weight <= mass * GRAVITY * (1.0 + ROUNDING), ops), text


def water(density: Value, ops: Ops) -> Requirement:
    """A density of water, kg/m3, that there is; 0 leaves its drag out."""
    text = f"water_density is above {DENSEST_WATER:g} kg/m3, denser than any natural water: sea water has 1025 kg/m3"
    return holds(density <= DENSEST_WATER, ops), text


def solid_cylinder(mass: Value, diameter: Value, mass_name: str, diameter_name: str, ops: Ops) -> Requirement:
    """A mass per length, kg/m, that a round cross-section of this diameter, m, can hold."""
    text = (
        f"{mass_name} is more than osmium, {DENSEST_SOLID:g} kg/m3, of this {diameter_name} would have: "
        f"lower {mass_name} or raise {diameter_name}"
    )
    return holds(mass <= DENSEST_SOLID * 0.25 * math.pi * diameter * diameter, ops), text
