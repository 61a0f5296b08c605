"""The solution without coupling error of a scene made of a ship, a line and a cradle: the same model functions, joined
into one system of equations (`models/heave/system.py`) and integrated to 1e-12. It is what coupled runs are measured against.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from towage.models.heave.system import Simulation
from towage.scene.monolithic import monolithic
from towage.scene.resolve import ResolvedScene
from towage.scene.scene import Scene

Array = NDArray[np.float64]


def solve(resolved: ResolvedScene, time: Array) -> tuple[Array, Array]:
    """Heave of the cradle, m, and tension, N, at ``time``, each of shape (n,); the state just after an event."""
    system = monolithic(resolved)
    run = Simulation(system)
    heave, tension = np.empty(len(time)), np.empty(len(time))
    for k, t in enumerate(time):
        x = run.advance(float(t))
        heave[k] = x[-2]
        pull = system.stiffness * run.stretch(float(t), x)[0]
        tension[k] = pull if system.never_slack else max(0.0, pull)
    return heave, tension


def dimensionless_scene(
    drag: float,
    ratio: float,
    weight: float,
    *,
    start: tuple[float, float] = (0.0, 0.0),
    periods: float = 8.0,
    steps: int = 32,
    coupling: dict[str, Any] | None = None,
    ship: dict[str, float] | None = None,
    cradle: dict[str, float] | None = None,
) -> Scene:
    """The thesis's dimensionless problem as a scene: K = M = X0 = 1, b = ``drag``, omega = ``ratio``, W = ``weight``,
    from ``start`` = (heave, velocity), with ``steps`` communication steps a period. With ``ship`` (mass, damping,
    stiffness) the line's reaction goes back to the ship."""
    period = 2.0 * math.pi / ratio
    connections = [
        "ship.heave -> line.heave_top",
        "cradle.heave -> line.heave_bottom",
        "line.tension -> cradle.line_tension",
    ] + (["line.reaction -> ship.reaction"] if ship else [])
    body = {
        "mass": 1.0, "weight_in_water": weight, "water_density": 2.0 * drag, "drag_area": 1.0, "heave_start": start[0],
        "velocity_start": start[1], "integration_tolerance": 1e-12, **(cradle or {}),
    }  # fmt: skip
    return Scene.from_dict(
        {
            "title": f"B = {drag:g}, r = {ratio:g}, w = {weight:g}",
            "stop_time": periods * period,
            "connections": connections,
            "units": {
                "ship": {"fmu": "ship", "parameters": {"heave_amplitude": 1.0, "heave_period": period, **(ship or {})}},
                "line": {"fmu": "spring_line", "parameters": {"stiffness": 1.0, "static_tension": weight}},
                "cradle": {"fmu": "cradle", "parameters": body},
            },
            "coupling": {"step": period / steps, "error_estimate": False, **(coupling or {})},
        }
    )
