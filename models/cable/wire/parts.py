"""What a wire is made of: sections from the lower end to the top, what is fixed to it, the water, and what makes no sense.

Names: a section is "section 1" (the lowest), and so on; SI.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...numeric.arrays import Array
from ...numeric.ops import Value
from ..case import CableError
from ..loading import Loading
from .point import Fixture, Material, drag_terms

PLANE, SPACE = 2, 3


@dataclass(frozen=True)
class Section:
    """A stretch of wire: ``length``, m; per unstretched length ``mass``, kg/m, and ``weight`` in water, N/m; ``diameter``,
    m; ``axial_stiffness`` EA, N; drag coefficient and ``loading``; ``damping`` B, N s, acts in tension; ``momentum_form`` of
    the added mass, else Morison's."""

    length: float
    mass: float
    weight: float
    diameter: float
    axial_stiffness: float
    drag_coefficient: float
    loading: Loading
    added_mass_coefficient: float = 1.0
    damping: float = 0.0
    breaking_load: float = math.inf
    momentum_form: bool | Value = False

    def material(self, density: float) -> Material:
        """Its points in water of ``density``, kg/m3."""
        added = self.added_mass_coefficient * density * math.pi * self.diameter**2 / 4.0
        return Material(
            self.axial_stiffness, self.damping, self.mass, added, self.momentum_form * added, self.weight,
            *drag_terms(self.loading, 0.5 * density * self.diameter * self.drag_coefficient),
        )  # fmt: skip


def cross_flow_terms(normal_drag: Value, tangential_drag: Value) -> Loading:
    """Loading of the independence principle with MoorDyn's Cdn and Cdt, for a drag coefficient of 1."""
    across, along = 0.5 * normal_drag, 0.5 * math.pi * tangential_drag
    return Loading((across, 0.0, -across, 0.0, 0.0), (along, 0.0, along, 0.0, 0.0))


def cross_flow_section(normal_drag: float, tangential_drag: float) -> tuple[float, Loading]:
    """(C_D, loading) of the same."""
    return 1.0, cross_flow_terms(normal_drag, tangential_drag)


@dataclass(frozen=True)
class Mass:
    """A body, clump or buoy: ``mass`` and ``added_mass`` (isotropic, or one a component), kg; ``weight`` in water, N,
    positive down; ``drag_area`` C_D A, m2; ``aft``: a constant force aft, N."""

    mass: float
    added_mass: float | tuple[float, ...]
    weight: float
    drag_area: float
    aft: float = 0.0

    def fixture(self, density: float, dimensions: int) -> Fixture:
        """What it is to the node that it is fixed to."""
        added = np.broadcast_to(np.asarray(self.added_mass, float), dimensions)
        return Fixture(tuple(float(self.mass + m) for m in added), self.weight, 0.5 * density * self.drag_area, self.aft)


@dataclass(frozen=True)
class Flow:
    """Velocity of the water over height: ``z``, m, ascending, shape (k,); ``velocity``, m/s, (k, d). Linear between, constant
    beyond."""

    z: Array
    velocity: Array

    def at(self, z: Array) -> tuple[Array, Array]:
        """(velocity (n, d); its slope over z, 1/s, (n, d)) at heights (n,)."""
        if len(self.z) == 1:
            return np.broadcast_to(self.velocity[0], (len(z), self.velocity.shape[1])), np.zeros(self.velocity.shape[1])
        k = np.clip(np.searchsorted(self.z, z, side="right") - 1, 0, len(self.z) - 2)
        slope = (self.velocity[k + 1] - self.velocity[k]) / (self.z[k + 1] - self.z[k])[:, None]
        inside = np.clip(z, self.z[0], self.z[-1])
        outside = (z < self.z[0]) | (z > self.z[-1])
        values = self.velocity[k] + slope * (inside - self.z[k])[:, None]
        return values, np.where(outside[:, None], 0.0, slope)


def uniform_flow(velocity: Array) -> Flow:
    """The same at every height."""
    return Flow(np.zeros(1), np.atleast_2d(np.asarray(velocity, float)))


@dataclass(frozen=True)
class Wire:
    """Sections from the lower end up; ``body`` at the lower end, or None: held there (``lower`` of a `Drive`); ``clumps``:
    (s, what) at joints of sections. Raises `CableError`."""

    sections: tuple[Section, ...]
    body: Mass | None
    density: float
    clumps: tuple[tuple[float, Mass], ...] = ()

    def __post_init__(self) -> None:
        reason = refusal(self)
        if reason:
            raise CableError(reason)

    @property
    def length(self) -> float:
        """Unstretched, m."""
        return sum(part.length for part in self.sections)

    @property
    def joints(self) -> Array:
        """s of the upper ends of the sections, m."""
        return np.cumsum([part.length for part in self.sections])


def refusal(wire: Wire) -> str:
    """What makes no sense, or an empty text."""
    if not wire.sections:
        return "a wire needs at least one section"
    for number, part in enumerate(wire.sections, 1):
        for name, value in (
            ("length", part.length), ("mass", part.mass), ("axial_stiffness", part.axial_stiffness),
        ):  # fmt: skip
            if not (0.0 < value < math.inf):
                return f"section {number}: {name}: expected a positive number, not {value:g}"
        for name, value in (
            ("diameter", part.diameter), ("drag_coefficient", part.drag_coefficient), ("damping", part.damping),
            ("added_mass_coefficient", part.added_mass_coefficient),
        ):  # fmt: skip
            if not (0.0 <= value < math.inf):
                return f"section {number}: {name}: expected a number >= 0, not {value:g}"
        if not math.isfinite(part.weight):
            return f"section {number}: weight: expected a number, not {part.weight:g}"
    # a clump stands at a node, which only the end of a section is sure to be
    for s, _ in wire.clumps:
        if np.abs(wire.joints[:-1] - s).min(initial=math.inf) > 1e-9 * wire.length:
            joints = ", ".join(f"{joint:g}" for joint in wire.joints[:-1]) or "none"
            return f"a clump at s = {s:g} m: expected a joint of two sections ({joints}); divide the section there"
    return ""
