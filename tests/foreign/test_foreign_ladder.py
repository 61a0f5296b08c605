"""The ladder of a scene with a unit of another make: what the units say of their inputs is all that is known."""

from __future__ import annotations

from pathlib import Path

from towage.ladder.simplest import simplest
from towage.scene.scene import Scene


def test_rungs_of_the_coupling_alone(hidden_mass: dict[bool, Path]) -> None:
    """One way and two ways, as the ship's input says what it means to leave it open."""
    scene = {
        "title": "Another's mass pushed by a ship", "stop_time": 4.0, "coupling": {"step": 0.1, "scheme": "extrapolate"},
        "units": {
            "ship": {"fmu": "ship", "parameters": {"mass": 4.0, "stiffness": 9.0, "heave_period": 2.0}},
            "mass": {"fmu": str(hidden_mass[True])},
        },
        "connections": ["ship.heave -> mass.force", "mass.position -> ship.reaction"],
    }  # fmt: skip
    named = {"driver": "ship.heave", "motion": "mass.position", "tension": "mass.position"}
    cut = ["mass.position -> ship.reaction"]
    ladder = simplest(Scene.from_dict(scene | {"checks": {"sdof": {"cut": cut} | named}}))
    assert [rung.name for rung in ladder.rungs] == ["one way", "two ways"]
    assert ladder.fullest.name == "two ways" and ladder.rungs[1].given
    assert len(ladder.absent) == 5
