"""The coupling example against the same three models joined into one system."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from towage.models.heave import cradle, ship, spring_line
from towage.models.heave.system import Simulation, System

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "couple_with_fmpy.py"


def monolithic(times: np.ndarray) -> np.ndarray:
    """Heave of the cradle, m, with the parameters of the example."""
    system = System(
        ship=ship.Parameters(0.6, 8.0, 0.0, 16.0, 9.1e5, 1.5e5, 2.3e6, 0.05),
        line=spring_line.Parameters(
            stiffness=3.3e4, axial_stiffness=0.0, length=0.0, breaking_load=0.0, mass_per_length=0.0,
            weight_per_length=0.0, wave_speed=0.0, wire_damping=0.0, never_slack=0.0, freeze_branches=0.0,
            static_tension=8e4,
        ),
        cradle=cradle.Parameters(
            mass=3.6e4, added_mass=1.7e4, weight_in_water=8e4, drag_area=51.0, drag_coefficient=1.0,
            water_density=1025.0, drag_length=1.0, kinematic_viscosity=1.19e-6, critical_reynolds=1e5,
            docking_time=60.0, submersible_mass=2.6e4, submersible_weight_in_water=0.0, docked_drag_area=0.0,
            soft_docking=0.0, heave_start=0.0, velocity_start=0.0, linear_damping=0.0,
        ),
        two_way=True,
    )  # fmt: skip
    run = Simulation(system)
    return np.array([run.advance(float(t))[-2] for t in times])


def test_example_agrees_with_the_monolithic_solution(fmus: Path, tmp_path: Path) -> None:
    """Without the work tree, with steps of a quarter of a second and their half: order 4."""
    script = (
        f"import json, pathlib, runpy\nfor step in (0.25, 0.125):\n    names = runpy.run_path({str(EXAMPLE)!r})\n"
        f"    names['main'].__globals__['STEP'] = step\n    print(json.dumps(names['main'](pathlib.Path({str(fmus)!r}))))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=120,
        env={"TMPDIR": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("cradle: largest heave") and "towage" not in EXAMPLE.read_text()
    errors = []
    for step, line in zip((0.25, 0.125), lines[1::2], strict=True):
        heaves = np.array(json.loads(line))
        reference = monolithic(step * np.arange(1, len(heaves) + 1))
        errors.append(float(np.max(np.abs(heaves - reference))))
    assert np.max(np.abs(reference)) > 0.5
    # the loop turns at sqrt(K/M) = 0.79 rad/s, 0.1 rad per step: (0.1)^4 of a motion of 1 m, over a hundred steps of memory
    # and divided by 4! 4! of the cubic: some 2e-6
    assert errors[1] < 5e-6
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.5)
