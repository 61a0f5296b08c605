"""Parameters of the unit ``wire``, and what they describe in the terms of ``cable/wire``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from ...numeric.ops import FLOATS, Ops, Value
from ...protocol.model import Requirement
from ...protocol.physical import liquid, weight_below_gravity
from ...protocol.variables import parameter
from ..loading import Loading, eames
from ..wire.parts import Flow, Mass, Section, Wire, cross_flow_terms


@dataclass(frozen=True)
class Parameters:
    """The wire from the towpoint down, a tail behind it (an array, a drogue line), a clump at their joint, the body at the
    end, the water; and how the wire is divided in space and time. SI."""

    tow_speed: Annotated[Value, parameter("m/s", 3.0, "Speed of the towing frame; 0: hanging", display="kn", min=0.0)]
    water_density: Annotated[Value, parameter("kg/m3", 1025.0, "Density of the water", min=0.0)]
    in_space: Annotated[Value, parameter("1", 0.0, "1: in space; 0: in the vertical plane of towing", min=0.0, max=1.0)]
    loading_form: Annotated[Value, parameter("1", 1.0, "0: Eames (friction); 1: cross-flow", min=0.0, max=1.0)]
    wire_length: Annotated[Value, parameter("m", 150.0, "Unstretched length at the start", display="ft", min=1e-3)]
    wire_mass: Annotated[Value, parameter("kg/m", 0.6, "Mass per length", min=1e-9)]
    wire_weight: Annotated[Value, parameter("N/m", 4.75, "Weight in water per length")]
    wire_diameter: Annotated[Value, parameter("m", 0.012, "Diameter", display="mm", min=0.0)]
    wire_axial_stiffness: Annotated[Value, parameter("N", 8e6, "Axial stiffness EA", min=1e-9)]
    wire_normal_drag: Annotated[Value, parameter("1", 1.5, "Drag coefficient across the wire", min=0.0)]
    wire_tangential_drag: Annotated[
        Value, parameter("1", 0.01, "Cdt of the cross-flow form (times pi d), or Eames' friction f", min=0.0)
    ]
    wire_damping: Annotated[Value, parameter("N.s", 0.0, "Internal damping, acts in tension", min=0.0)]
    wire_bending_stiffness: Annotated[
        Value,
        parameter("N.m2", 0.0, "Bending stiffness EI, for margin_bending alone (EA d^2/16 at most); 0: not known", min=0.0),
    ]
    breaking_load: Annotated[Value, parameter("N", 0.0, "Breaking load of the wire; 0: not known", min=0.0)]
    added_mass_coefficient: Annotated[Value, parameter("1", 1.0, "Added mass over displaced mass, wire and tail", min=0.0)]
    momentum_added_mass: Annotated[
        Value, parameter("1", 0.0, "1: momentum form of the added mass of wire and tail; 0: Morison's", min=0.0, max=1.0)
    ]
    tail_length: Annotated[Value, parameter("m", 0.0, "Length of the tail below the wire; 0: none", min=0.0)]
    tail_mass: Annotated[Value, parameter("kg/m", 1.29, "Mass per length of the tail", min=1e-9)]
    tail_weight: Annotated[Value, parameter("N/m", 0.0, "Weight in water per length of the tail")]
    tail_diameter: Annotated[Value, parameter("m", 0.04, "Diameter of the tail", display="mm", min=0.0)]
    tail_axial_stiffness: Annotated[Value, parameter("N", 2e6, "Axial stiffness EA of the tail", min=1e-9)]
    tail_normal_drag: Annotated[Value, parameter("1", 1.2, "Drag coefficient across the tail", min=0.0)]
    tail_tangential_drag: Annotated[Value, parameter("1", 0.0035, "As of the wire", min=0.0)]
    tail_bending_stiffness: Annotated[Value, parameter("N.m2", 0.0, "As of the wire", min=0.0)]
    clump_mass: Annotated[Value, parameter("kg", 0.0, "Mass at the joint of wire and tail", min=0.0)]
    clump_added_mass: Annotated[Value, parameter("kg", 0.0, "Its added mass", min=0.0)]
    clump_weight: Annotated[Value, parameter("N", 0.0, "Its weight in water; a buoy: negative")]
    clump_drag_area: Annotated[Value, parameter("m2", 0.0, "Its drag area", min=0.0)]
    body_mass: Annotated[Value, parameter("kg", 800.0, "Mass of the body", min=0.0)]
    body_added_mass: Annotated[Value, parameter("kg", 300.0, "Its added mass", min=0.0)]
    body_added_mass_heave: Annotated[Value, parameter("kg", 0.0, "Its added mass in heave; 0: body_added_mass", min=0.0)]
    body_weight: Annotated[Value, parameter("N", 5000.0, "Its weight in water")]
    body_lift: Annotated[Value, parameter("N", 0.0, "Constant lift on it; a depressor: negative")]
    body_drag_area: Annotated[Value, parameter("m2", 0.3, "Its drag area", min=0.0)]
    body_drag: Annotated[Value, parameter("N", 0.0, "Constant force on it aft, beside that of its drag area", min=0.0)]
    body_port: Annotated[
        Value,
        parameter(
            "1", 0.0, "1: the body is a unit of its own at the wire's lower end, whose velocity comes in; body_mass to "
            "body_drag give the steady tow alone", min=0.0, max=1.0,
        ),
    ]  # fmt: skip
    surface_height: Annotated[
        Value, parameter("m", 0.0, "Height of the water's surface above the mean towpoint; for margin_surface alone")
    ]
    current_surge: Annotated[Value, parameter("m/s", 0.0, "Current at the towpoint, along the towing direction")]
    current_sway: Annotated[Value, parameter("m/s", 0.0, "Current at the towpoint, to port; needs in_space")]
    current_depth: Annotated[
        Value, parameter("m", 0.0, "Depth below the towpoint at which the current has ended, falling linearly; 0: never", min=0.0)
    ]
    elements: Annotated[Value, parameter("1", 0.0, "Number of elements; 0: as many as tolerance needs", min=0.0, max=400.0)]
    degree: Annotated[Value, parameter("1", 4.0, "Degree of the elements; 1: lumped masses", min=1.0, max=6.0)]
    tolerance: Annotated[
        Value, parameter("1", 1e-4, "Error of the shape by the elements over the length", min=1e-10, max=0.1)
    ]
    velocity_tolerance: Annotated[
        Value, parameter("m/s", 1e-3, "Error of the velocities in an internal step", min=1e-9, max=1.0)
    ]
    largest_step: Annotated[Value, parameter("s", 2.0, "Largest internal step", min=1e-6)]


def requirements(p: Parameters, ops: Ops) -> list[Requirement]:
    """What the parameters must fulfil: weights below those in air, a known loading."""
    # a body without mass is not weighed: the report's printed sample is one, whose mass is in its added masses
    possible, why = weight_below_gravity(p.body_weight, p.body_mass, p.water_density, "body_weight", "body_mass", ops)
    form, port = (ops.where(v * (v - 1.0) == 0.0, 1.0, 0.0) for v in (p.loading_form, p.body_port))
    found = [
        weight_below_gravity(p.wire_weight, p.wire_mass, p.water_density, "wire_weight", "wire_mass", ops),
        weight_below_gravity(p.tail_weight, p.tail_mass, p.water_density, "tail_weight", "tail_mass", ops),
        (ops.where(p.body_mass == 0.0, 1.0, possible), why),
        weight_below_gravity(p.clump_weight, p.clump_mass, p.water_density, "clump_weight", "clump_mass", ops),
        liquid(p.water_density, ops),
    ]
    return [
        (form, "loading_form: expected 0 (Eames) or 1 (cross-flow)"),
        (port, "body_port: expected 0 (the body on board) or 1 (a unit of its own)"),
        (
            ops.where(p.in_space > 0.5, 1.0, ops.where(p.current_sway == 0.0, 1.0, 0.0)),
            "current_sway pushes the wire out of the vertical plane: set in_space = 1",
        ),
        *found,
    ]  # fmt: skip


def _sections(p: Parameters, ops: Ops) -> tuple[Section, Section]:
    """(Tail, wire), the tail of whatever length."""

    def section(length: Value, mass: Value, weight: Value, diameter: Value, stiffness: Value, normal: Value,
                along: Value) -> Section:
        friction, across = eames(along), cross_flow_terms(normal, along)
        of_eames = tuple(tuple(normal * c for c in row) for row in (friction.normal, friction.tangential))
        terms = (
            tuple(ops.where(p.loading_form < 0.5, e, c) for e, c in zip(one, other))
            for one, other in zip(of_eames, (across.normal, across.tangential))
        )
        return Section(
            length, mass, weight, diameter, stiffness, 1.0, Loading(*terms), p.added_mass_coefficient, p.wire_damping,
            momentum_form=p.momentum_added_mass,
        )  # fmt: skip

    return (
        section(p.tail_length, p.tail_mass, p.tail_weight, p.tail_diameter, p.tail_axial_stiffness, p.tail_normal_drag,
                p.tail_tangential_drag),
        section(p.wire_length, p.wire_mass, p.wire_weight, p.wire_diameter, p.wire_axial_stiffness, p.wire_normal_drag,
                p.wire_tangential_drag),
    )  # fmt: skip


def _masses(p: Parameters, ops: Ops) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """(Body, clump), as `Mass` takes them, of three components."""
    heave = ops.where(p.body_added_mass_heave == 0.0, p.body_added_mass, p.body_added_mass_heave)
    return (
        (p.body_mass, (p.body_added_mass, p.body_added_mass, heave), p.body_weight - p.body_lift, p.body_drag_area, p.body_drag),
        (p.clump_mass, (p.clump_added_mass,) * 3, p.clump_weight, p.clump_drag_area, 0.0),
    )


def _kept(p: Parameters) -> list[int]:
    """Which of three components a vector has: forward and up in the plane."""
    return [0, 1, 2] if p.in_space > 0.5 else [0, 2]


def wire_of(p: Parameters) -> Wire:
    """The wire that the parameters describe. Raises `CableError`."""
    kept = _kept(p)
    (tail, wire), (body, clump) = _sections(p, FLOATS), (
        Mass(mass, tuple(added[k] for k in kept), *others) for mass, added, *others in _masses(p, FLOATS)
    )
    if p.tail_length > 0.0:
        return Wire((tail, wire), body, p.water_density, ((p.tail_length, clump),))
    return Wire((wire,), body, p.water_density)


def _flow(p: Parameters, ops: Ops) -> tuple[Value, tuple[Value, ...], tuple[Value, ...]]:
    """(1 where the current changes with depth, else 0; velocity of the water in the towing frame at the lower level and above
    the upper one, of three components)."""
    current = (p.current_surge, p.current_sway, 0.0)
    changes = ops.where(p.current_depth * (ops.abs(p.current_surge) + ops.abs(p.current_sway)) > 0.0, 1.0, 0.0)
    above = (current[0] - p.tow_speed, current[1], 0.0)
    below = (above[0] - changes * current[0], above[1] - changes * current[1], 0.0)
    return changes, below, above


def flow_of(p: Parameters) -> Flow:
    """Current in the towing frame."""
    changes, *velocities = _flow(p, FLOATS)
    table = np.array(velocities, float)[:, _kept(p)]
    return Flow(np.array([-p.current_depth, 0.0]), table) if changes else Flow(np.zeros(1), table[1:])


class Numbers(NamedTuple):
    """What the steps in C take (``fmus/native/runtime/chain/wire.h``): ``levels`` of the flow at the heights ``level``, its
    velocities one after the other; ``bending``: EI, N m2; masses of three components, weight, drag, force aft of
    `point.Fixture`."""

    dimensions: Value
    elements: Value
    degree: Value
    tolerance: Value
    velocity_tolerance: Value
    largest_step: Value
    breaking_load: Value
    tail_length: Value
    wire_length: Value
    body_port: Value
    surface_height: Value
    tail_bending: Value
    wire_bending: Value
    tail_diameter: Value
    wire_diameter: Value
    levels: Value
    tail: tuple[Value, ...]
    wire: tuple[Value, ...]
    body: tuple[Value, ...]
    clump: tuple[Value, ...]
    level: tuple[Value, ...]
    flow: tuple[Value, ...]


def numbers(p: Parameters, ops: Ops) -> Numbers:
    """Of the wire that the parameters describe."""
    (tail, wire), masses = _sections(p, ops), _masses(p, ops)
    changes, below, above = _flow(p, ops)
    body, clump = (
        (*(mass + each for each in added), weight, 0.5 * p.water_density * area, aft) for mass, added, weight, area, aft in masses
    )
    return Numbers(
        ops.where(p.in_space > 0.5, 3.0, 2.0), p.elements, p.degree, p.tolerance, p.velocity_tolerance, p.largest_step,
        p.breaking_load, p.tail_length, p.wire_length, p.body_port, p.surface_height, p.tail_bending_stiffness,
        p.wire_bending_stiffness, p.tail_diameter, p.wire_diameter, 1.0 + changes, tail.material(p.water_density),
        wire.material(p.water_density), body, clump, (-p.current_depth, 0.0),
        (*(ops.where(changes > 0.5, b, a) for b, a in zip(below, above)), *above),
    )  # fmt: skip
