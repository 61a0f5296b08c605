"""A ship that answers by a table of responses, in a scene: coupled, composed, in an ensemble, natively."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from towage.ensemble.ensemble import Ensemble
from towage.errors import SceneError
from towage.master.master import Master
from towage.scene.flavour import resolve
from towage.scene.resolve import described
from towage.scene.scene import Scene
from towage.units.store import locator

SHIP = {
    "components": 24, "ramp_time": 5.0, "mass": 8e6, "stiffness": 1.2e7, "damping": 2e6, "point_x": -30.0, "point_y": 6.0,
    "update_interval": 1e4, "seed": 3.0,
}  # fmt: skip
LINE = {"stiffness": 1e5, "static_tension": 2e5, "length": 30.0, "wave_speed": 900.0}
CRADLE = {
    "mass": 3e4, "added_mass": 1.5e4, "weight_in_water": 2e5, "drag_area": 40.0, "drag_coefficient": 1.0, "drag_length": 4.0,
}  # fmt: skip


def scene(folder: Path, **coupling: Any) -> Scene:
    """A cage under the quarter of a ship."""
    rows = [
        "period [s], direction [deg], heave_amplitude [m/m], heave_phase [deg], roll_amplitude [deg/m], roll_phase [deg]"
    ]
    for period in (4, 6, 8, 10, 13, 18, 25):
        for direction in range(0, 181, 30):
            across = math.sin(math.radians(direction))
            rows.append(
                f"{period},{direction},{1.0 / (1.0 + (6.0 / period) ** 4)},{-period},{2.0 * across},{90 + period}"
            )
    (folder / "vessel.csv").write_text("\n".join(rows))
    return Scene.from_dict({
        "title": "cage", "stop_time": 20.0,
        "units": {
            "ship": {
                "fmu": "ship_in_sea", "parameters": SHIP,
                "inputs": {"wave_height": 2.5, "wave_period": 9.0, "wave_direction": 2.3, "speed": 0.0},
                "files": {"responses": {"file": "vessel.csv", "phase": "lead", "direction": "to"}},
            },
            "line": {"fmu": "spring_line", "parameters": LINE}, "cradle": {"fmu": "cradle", "parameters": CRADLE},
        },
        "connections": [
            "ship.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension",
            "line.reaction -> ship.reaction",
        ],
        "coupling": {"step": 0.1, "error_estimate": False, **coupling}, "record": {"interval": 0.5},
    }, folder / "cage.toml")  # fmt: skip


def test_members_of_many_seeds_are_the_coupled_scene(tmp_path: Path) -> None:
    """The ensemble checks two of its members against the FMU path itself; the coupled run of a seed has the ship's own motions
    to rounding, and the tension to the error of the coupling."""
    made = scene(tmp_path)
    ensemble = Ensemble(made, {"ship.seed": np.array([3.0, 4.0, 5.0, 3.0])})
    members = ensemble.run(series=["ship.roll", "line.tension"], samples=2, accuracy=1e-9, threads=1)
    assert members.done.all() and len(members.samples) == 2
    roll, tension = members.series["ship.roll"], members.series["line.tension"]
    assert (roll[0] == roll[3]).all() and np.abs(roll[0] - roll[1]).max() > 1e-3
    result = Master(made, flavour="python").run()
    assert any("mirror image" in text for text in described(made, locator()).warnings)
    assert roll[0] == pytest.approx(result.columns["ship.roll"], abs=1e-13)
    assert np.abs(tension[0] - result.columns["line.tension"]).max() < 1e-3 * np.ptp(tension[0])


def test_what_the_tables_are_made_from_is_not_varied(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="ship.components is fixed in a composed scene"):
        Ensemble(scene(tmp_path), {"ship.components": np.array([10.0, 20.0])})


@pytest.mark.slow
def test_the_native_flavour_carries_the_file(tmp_path: Path) -> None:
    resolved = resolve(scene(tmp_path), flavour="native")
    assert resolved.units["ship"].flavour == "native" and "given-" in str(resolved.units["ship"].path)
    one, two = (Master(scene(tmp_path), flavour=f).run() for f in ("native", "python"))  # type: ignore[arg-type]
    for name in ("ship.roll", "ship.heave", "line.tension"):
        assert one.columns[name] == pytest.approx(two.columns[name], rel=1e-9, abs=1e-9)
