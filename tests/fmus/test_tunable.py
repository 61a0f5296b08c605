"""Parameters that change between steps: in force from the next call on, refused as a whole, part of the state."""

from __future__ import annotations

import random

import pytest

from towage.fmus.declare.unit import Unit, load
from towage.fmus.python.instance import Instance
from towage.fmus.python.values import CallError
from towage.models.numeric.ops import FLOATS

from .test_instance import Player

TUNABLE = {
    "ship": {"mass", "damping", "stiffness"},
    "ship_in_sea": {"mass", "damping", "stiffness"},
    "spring_line": {"stiffness", "axial_stiffness", "static_tension"},
    "cradle": {"added_mass", "weight_in_water", "drag_area", "drag_coefficient", "linear_damping"},
    "cradle_on_line": {
        "added_mass", "weight_in_water", "drag_area", "drag_coefficient", "linear_damping", "stiffness", "axial_stiffness",
    },
    "towed_body": {"added_mass_surge", "added_mass_heave", "drag"},
}  # fmt: skip


def tunable(unit: Unit) -> set[str]:
    return {v.name for v in unit.parameters if v.variability == "tunable"}


@pytest.mark.parametrize("name", TUNABLE)
def test_what_is_tunable(name: str) -> None:
    assert tunable(load(name)) == TUNABLE[name]


@pytest.mark.parametrize("name", TUNABLE)
def test_what_follows_from_a_tunable_parameter_is_declared_so(name: str) -> None:
    """Found by changing each: at the start values of the reference run, where nothing hides behind another."""
    unit, chance, moved = load(name), random.Random(1), set()
    start = {v.name: unit.start.get(v.name, v.start or 0.0) for v in unit.parameters}
    for _ in range(20):
        base = {**start, "stiffness": chance.choice((0.0, 1e4))} if "axial_stiffness" in start else start
        before = unit.model.calculated(unit.model.Parameters(**base), FLOATS)
        for parameter in tunable(unit):
            changed = base | {parameter: base[parameter] * chance.uniform(0.5, 2.0) + 1.0}
            after = unit.model.calculated(unit.model.Parameters(**changed), FLOATS)
            moved |= {v.name for v, a, b in zip(unit.calculated, before, after) if a != b}
    assert moved == {v.name for v in unit.calculated if v.variability == "tunable"}


def test_a_change_at_rest_moves_to_the_new_equilibrium() -> None:
    """Ship under a constant pull R: z goes to -R/K1, with the stiffness that is in force."""
    ship = Player("ship", heave_amplitude=0.0, mass=1e3, damping=2e3, stiffness=1e3).run(40.0, 40, reaction=(500.0, 0, 0, 0))
    assert ship["heave"] == pytest.approx(-0.5, rel=1e-9)  # exp(-40 s * 1/s) of the start is left
    ship.set({"stiffness": 2e3})
    assert ship["heave"] == pytest.approx(-0.5, rel=1e-9), "the state stays"
    assert ship.get("natural_frequency") == [2.0**0.5]
    for k in range(40):
        ship.it.do_step(40.0 + k, 1.0)
    assert ship["heave"] == pytest.approx(-0.25, rel=1e-9)


@pytest.mark.parametrize("read", [True, False])
def test_a_change_equals_a_new_run_from_the_same_state(read: bool) -> None:
    """To the last bit: with and without a read between the change and the step."""
    start = {"mass": 5e3, "added_mass": 1e3, "drag_area": 10.0, "weight_in_water": 2e4}
    old = Player("cradle", **start).run(1.0, 10, line_tension=(2.5e4, 300.0, 0.0, 0.0))
    heave, velocity = old.get("heave", "velocity")
    new = Player("cradle", 1.0, **(start | {"added_mass": 3e3, "heave_start": heave, "velocity_start": velocity}))
    old.set({"added_mass": 3e3})
    if read:
        assert old["port_mass"] == 8e3
    for each in (old, new):
        each.it._first_step = 0.0  # the integrator's memory of its last step is no part of a new run
        each.set_cubics(1.0, {"line_tension": (2.5e4, 300.0, 0.0, 0.0)})
        each.it.do_step(1.0, 0.5)
    names = ("heave", "velocity", "acceleration", "margin_drag_reynolds", "port_mass")
    assert old.get(*names) == new.get(*names)
    assert old["port_mass"] == 8e3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stiffness": -1.0}, "stiffness = -1 N/m: expected at least 0"),
        ({"stiffness": 0.0, "axial_stiffness": 0.0}, "stiffness is 0 and so is axial_stiffness / length"),
    ],
)
@pytest.mark.parametrize("call", ["get", "step", "state"])
def test_what_makes_no_sense_is_refused_and_changes_nothing(change: dict[str, float], message: str, call: str) -> None:
    line = Player("spring_line", stiffness=1e4, static_tension=2e4).run(1.0, 1, heave_top=(0.5, 0.0, 0.0, 0.0))
    names = ("tension", "stiffness", "axial_stiffness", "port_stiffness", "unstretched_length")
    before = line.get(*names)
    line.set({"static_tension": 3e4} | change)
    with pytest.raises(CallError, match=message):
        {"get": lambda: line["tension"], "step": lambda: line.it.do_step(1.0, 0.5), "state": line.it.state}[call]()
    assert line.get(*names) == before
    line.it.do_step(1.0, 0.5)
    assert line.get(*names) == before


def test_what_is_not_tunable_is_still_refused() -> None:
    ship = Player("ship")
    for name, value, message in (
        ("heave_period", 3.0, "heave_period may not be set in phase stepping: it is a fixed parameter"),
        ("port_mass", 3.0, "port_mass may not be set in phase stepping: it is a tunable calculatedParameter"),
        ("mass", float("nan"), "mass = nan: expected a finite number"),
    ):
        with pytest.raises(CallError, match=message):
            ship.set({name: value})
    ship.it.terminate()
    with pytest.raises(CallError, match="mass may not be set in phase terminated"):
        ship.set({"mass": 2e6})


@pytest.mark.parametrize("pending", [False, True])
def test_state_holds_tuned_parameters(pending: bool) -> None:
    """Into the same instance, tuned again since, and into another."""
    player = Player("cradle", added_mass=1e3, drag_area=5.0).run(1.0, 4, line_tension=(1e3, 0.0, 0.0, 0.0))
    player.set({"added_mass": 4e3, "drag_area": 7.0})
    if not pending:
        player.it.do_step(1.0, 0.25)
    saved = player.it.state()

    def future(it: Instance) -> list[float]:
        it.restore(saved)
        it.do_step(it.time, 0.5)
        return it.get_values(list(range(len(it.unit.variables))))

    expected = future(player.it)
    assert expected[player.unit.index["port_mass"]] == 5e3
    player.set({"added_mass": 9e3})
    assert future(player.it) == expected, "a pending change is gone"
    player.set({"added_mass": 9e3})
    player.it.do_step(player.it.time, 0.5)
    assert future(player.it) == expected, "so is one in force"
    assert future(Instance(player.unit)) == expected
    assert future(Player("cradle").it) == expected
