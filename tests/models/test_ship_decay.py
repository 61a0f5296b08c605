"""Free decay of `ship` from a start displacement, against the closed form."""

from __future__ import annotations

import math

import pytest

from towage.fmus.declare.unit import load
from towage.fmus.python.instance import Instance


def test_a_displaced_ship_decays_as_a_damped_oscillator_does() -> None:
    """z = exp(-d t) (z0 cos w t + (v0 + d z0)/w sin w t), d = c/2m, w^2 = k/m - d^2."""
    unit, mass, damping, stiffness, z0, v0 = load("ship"), 2e6, 4e5, 1.5e6, 1.2, -0.3
    instance = Instance(unit)
    values = {
        "mass": mass, "damping": damping, "stiffness": stiffness, "start_displacement": z0, "start_velocity": v0,
        "heave_amplitude": 0.0,
    }  # fmt: skip
    instance.set_values([unit.index[n] for n in values], list(values.values()))
    instance.set_up(0.0, None)
    instance.enter_initialization()
    instance.exit_initialization()
    decay = 0.5 * damping / mass
    omega = math.sqrt(stiffness / mass - decay * decay)
    for k in range(60):
        t = 0.5 * k
        wanted = math.exp(-decay * t) * (z0 * math.cos(omega * t) + (v0 + decay * z0) / omega * math.sin(omega * t))
        heave, velocity, margin = instance.get_values([unit.index[n] for n in ("heave", "velocity", "margin_sdof")])
        assert heave == pytest.approx(wanted, abs=1e-13) and margin == 1.0
        assert velocity == pytest.approx(v0, abs=1e-15) if k == 0 else True
        instance.do_step(t, 0.5)
