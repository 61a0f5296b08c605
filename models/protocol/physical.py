"""What no body and no water can be, as requirements that models share: numbers in SI, true for any model of such a thing.

They catch what is written in the wrong unit or in the wrong place; a run of such a scene would be faultless and mean nothing.
Weights are compared with m g in water alone: a problem without dimensions (M = K = 1) has no g, and a medium that is no water.
"""

from __future__ import annotations

import math

from ..numeric.ops import Ops, Value
from .model import Requirement

GRAVITY = 9.80665
"""Standard gravity, m/s2."""
LIGHTEST_WATER, DENSEST_WATER = 900.0, 1500.0
"""kg/m3; hot fresh water has 958, the Dead Sea 1240."""
DENSEST_LIQUID = 13600.0
"""kg/m3, mercury."""
DENSEST_SOLID = 22600.0
"""kg/m3; osmium has 22 590."""
ROUNDING = 1e-6
"""Relative; a body as heavy in water as in air, with m g written to seven digits, is taken."""


def holds(condition: Value, ops: Ops) -> Value:
    """1 where the condition holds, else 0: a `Requirement`'s value."""
    return ops.where(condition, 1.0, 0.0)


def weight_below_gravity(
    weight: Value, mass: Value, density: Value, weight_name: str, mass_name: str, ops: Ops
) -> Requirement:
    """A weight in water, N, of at most m g (per length alike), where ``density``, kg/m3, is that of water: buoyancy cannot
    pull down."""
    text = (
        f"{weight_name} is above {mass_name} * g, the weight in air: in water a body weighs less by its buoyancy; "
        f"raise {mass_name} or lower {weight_name} (units of measure?)"
    )
    possible = holds(weight <= mass * GRAVITY * (1.0 + ROUNDING), ops)
    return ops.where(density >= LIGHTEST_WATER, ops.where(density <= DENSEST_WATER, possible, 1.0), 1.0), text


def liquid(density: Value, ops: Ops) -> Requirement:
    """A density, kg/m3, that a liquid can have; 0 leaves its drag out."""
    text = f"water_density is above {DENSEST_LIQUID:g} kg/m3, denser than mercury: sea water has 1025 kg/m3"
    return holds(density <= DENSEST_LIQUID, ops), text


def solid_cylinder(mass: Value, diameter: Value, mass_name: str, diameter_name: str, ops: Ops) -> Requirement:
    """A mass per length, kg/m, that a round cross-section of this diameter, m, can hold."""
    text = (
        f"{mass_name} is more than osmium, {DENSEST_SOLID:g} kg/m3, of this {diameter_name} would have: "
        f"lower {mass_name} or raise {diameter_name}"
    )
    return holds(mass <= DENSEST_SOLID * 0.25 * math.pi * diameter * diameter, ops), text
