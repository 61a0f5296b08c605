"""The snap load of a wire against another solution: Godunov's scheme for the bar that cannot push, at Courant number 1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from towage.verify.wire_path import smooth
from towage.verify.wire_shock import snap

CASE: dict[str, Any] = {
    "water_density": 1025.0,
    "sections": [{
        "length": 3000.0, "mass": 45.0, "weight": 374.478695, "diameter": 0.092, "axial_stiffness": 5e8,
        "added_mass_coefficient": 1.0, "loading": "cross_flow", "normal_drag": 1.2, "tangential_drag": 0.01,
    }],
    "body": {"mass": 150e3, "added_mass": 100e3, "weight": 300e3, "drag_area": 80.0},
    "top": {
        "position": [0.0, 0.0, 0.0], "speed": 0.0, "omega": 0.739198271433, "amplitude": [0.0, 0.0, 2.5], "ramp_time": 17.0,
    },
    "snap": {"until": 19.0},
}  # fmt: skip
"""The case deep_lift_snap_8s of reference/wire.json, to the end of the first catch."""
CAUGHT = 15.895


def godunov_peak(cells: int) -> float:
    """Largest tension at the top, N, within 3 s of `CAUGHT`: m u' = n' - w - drag, e' = u', n = EA max(0, e) in cells, with the
    solution of the linear Riemann problem between them (upwind where the wire is taut, exact there)."""
    part, body, top = CASE["sections"][0], CASE["body"], CASE["top"]
    length, m, w, ea = (part[key] for key in ("length", "mass", "weight", "axial_stiffness"))
    c, inertia = math.sqrt(ea / m), body["mass"] + body["added_mass"]
    z, ds = m * c, length / cells
    dt = ds / c
    along = 0.5 * CASE["water_density"] * part["diameter"] * math.pi * part["tangential_drag"]
    bluff = 0.5 * CASE["water_density"] * body["drag_area"]
    u, e = np.zeros(cells), (body["weight"] + w * ds * (np.arange(cells) + 0.5)) / ea
    speed, t, peak = 0.0, 0.0, 0.0
    us, n = np.zeros(cells + 1), np.zeros(cells + 1)
    while t < CAUGHT + 3.0:
        s, rate, _ = smooth((t + 0.5 * dt) / top["ramp_time"])
        phase = top["omega"] * (t + 0.5 * dt)
        driven = top["amplitude"][2] * (rate / top["ramp_time"] * math.sin(phase) + s * top["omega"] * math.cos(phase))
        tension = ea * np.maximum(e, 0.0)
        n[1:-1] = 0.5 * (tension[:-1] + tension[1:] + z * (u[1:] - u[:-1]))
        us[1:-1] = 0.5 * (u[:-1] + u[1:] + (tension[1:] - tension[:-1]) / z)
        us[-1], n[-1] = driven, tension[-1] + z * (driven - u[-1])
        us[0] = speed
        for _ in range(3):
            n[0] = tension[0] + z * (u[0] - us[0])
            after = speed + dt * (n[0] - body["weight"] - bluff * abs(us[0]) * us[0]) / inertia
            us[0] = 0.5 * (speed + after)
        speed = after
        e += dt / ds * (us[1:] - us[:-1])
        u += dt / m * ((n[1:] - n[:-1]) / ds - w - along * np.abs(u) * u)
        t += dt
        if t > CAUGHT:
            peak = max(peak, float(n[-1]))
    return peak


@pytest.mark.slow
def test_the_peak_of_a_snap_is_that_of_a_front_scheme() -> None:
    found = snap(CASE)
    assert found["end_of_first_slack"] == pytest.approx(CAUGHT, rel=2e-3)
    # 1000 cells give 3.01 MN, 16 000 give 3.14 MN: a front keeps growing with its sharpness; 60 elements spread it more
    assert found["peak_tension_top_first_snap"] == pytest.approx(godunov_peak(1000), rel=0.04)
