"""Bonds: which connections carry a power together, and the energy that the coupling makes there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from towage.fmus.declare.quantities import dimension
from towage.master.bonds import BondEnergy, bonds
from towage.master.master import Master
from towage.scene.resolve import ResolvedConnection
from towage.scene.scene import Scene


def system(units: dict[str, str], *connections: str) -> Any:
    """A resolved scene as far as bonds ask: ``units`` gives the unit of measurement of each source."""
    parts: dict[str, Any] = {}
    for end, unit in units.items():
        name, _, variable = end.partition(".")
        part = parts.setdefault(name, SimpleNamespace(description=SimpleNamespace(units={}, variables={})))
        part.description.units[unit] = SimpleNamespace(exponents=dimension(unit))
        part.description.variables[variable] = SimpleNamespace(unit=unit)
        part.description.by_name = lambda part=part: part.description.variables
    ends = [[end.strip().partition(".") for end in text.split("->")] for text in connections]
    made = [ResolvedConnection(a[0], a[2], b[0], b[2], 1.0) for a, b in ends]
    return SimpleNamespace(units=parts, connections=tuple(made))


@pytest.mark.parametrize(
    ("effort", "motion", "velocity", "turns"),
    [("N", "m", False, False), ("kN", "ft/s", True, False), ("N.m", "rad", False, True), ("N.m", "rpm", True, True)],
)
def test_efforts_and_their_motions_are_bonds(effort: str, motion: str, velocity: bool, turns: bool) -> None:
    scene = system({"a.pull": effort, "b.move": motion}, "a.pull -> b.pull", "b.move -> a.move")
    (bond,) = bonds(scene)
    assert bond == (*scene.connections, velocity, turns)


@pytest.mark.parametrize(("effort", "motion"), [("N", "rad"), ("N.m", "m"), ("N", "m/s2"), ("W", "m"), ("m", "m/s")])
def test_what_carries_no_power_is_no_bond(effort: str, motion: str) -> None:
    assert not bonds(system({"a.pull": effort, "b.move": motion}, "a.pull -> b.pull", "b.move -> a.move"))


def test_a_motion_must_come_back_from_where_the_effort_goes() -> None:
    given = {"a.pull": "N", "b.move": "m", "c.move": "m"}
    assert not bonds(system(given, "a.pull -> b.pull", "b.move -> c.move"))
    assert not bonds(system(given, "a.pull -> b.pull", "c.move -> a.move"))
    assert not bonds(system({"a.pull": "N", "a.move": "m"}, "a.pull -> a.force", "a.move -> a.motion"))


def test_names_decide_where_an_effort_may_go_with_several_motions() -> None:
    given = {"a.force_x": "N", "a.force_z": "N", "b.velocity_x": "m/s", "b.velocity_z": "m/s"}
    back = ("b.velocity_x -> a.velocity_x", "b.velocity_z -> a.velocity_z")
    scene = system(given, "a.force_x -> b.force_x", "a.force_z -> b.force_z", *back)
    assert [(bond.effort.source, bond.motion.source) for bond in bonds(scene)] == [
        ("force_x", "velocity_x"), ("force_z", "velocity_z"),
    ]  # fmt: skip
    given = {"a.pull": "N", "b.one": "m", "b.other": "m"}
    assert not bonds(system(given, "a.pull -> b.pull", "b.one -> a.one", "b.other -> a.other"))


@pytest.mark.parametrize("velocity", [True, False])
def test_the_energy_is_half_the_gap_of_the_effort_times_the_way(velocity: bool) -> None:
    """Used is 3 + 2 s, found at the end of 0.5 s is 5: a gap of 1 N on a way of 0.5 s at 4 m/s."""
    effort: Any = SimpleNamespace(polynomial=(3.0, 2.0, 0.0, 0.0), end_value=5.0)
    motion: Any = SimpleNamespace(end_value=-4.0, end_rate=7.0) if velocity else SimpleNamespace(end_value=9.0, end_rate=-4.0)
    account = BondEnergy("a - b", effort, motion, velocity)
    account.add(0.5)
    account.add(0.5)
    assert account.residual == pytest.approx(2.0 * 0.5 * 1.0 * 2.0)
    assert account.throughput == pytest.approx(2.0 * 5.0 * 2.0)


def test_tows_have_a_power_residual() -> None:
    """Their units send velocities; a body is held by two bonds, told apart by their forces."""
    tow = Master(Scene.load("tow_600ft"), "half a foot of heave", flavour="python").run()
    assert list(tow.power_residual) == ["tow - ship"]
    assert 0.0 < tow.power_residual["tow - ship"] < 1e-6  # order 4 at some 30 steps a period
    two = Master(Scene.load("tow_two_units"), flavour="python").run()
    assert set(two.power_residual) == {
        "cable - body (body_force_heave)", "cable - body (body_force_surge)", "cable - ship", "cable - surge",
    }  # fmt: skip
    assert 0.0 < max(two.power_residual.values()) < 1e-5
