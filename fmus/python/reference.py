"""The reference result that an FMU carries: a short run of the unit, as the unit itself computes it."""

from __future__ import annotations

import math

from ..declare.unit import Unit
from ..describe.documentation import REFERENCE_STEP
from .instance import Instance

REFERENCE_STEPS = 100


def reference_result(unit: Unit) -> str:
    """CSV of the reference run, as the unit itself computes it."""
    instance = Instance(unit)
    instance.set_values([unit.index[k] for k in unit.start], list(unit.start.values()))
    instance.set_up(0.0, None)
    instance.enter_initialization()
    instance.exit_initialization()
    references, signals = [], []
    for name, (amplitude, omega) in unit.reference_inputs.items():
        references += [unit.index[name]] + [unit.index[f"{name}_d{k}"] for k in (1, 2, 3)]
        signals.append((amplitude, omega))
    inputs = references[::4]
    outputs = [i for i, v in enumerate(unit.variables) if v.causality == "output"]
    lines = ["time," + ",".join(unit.variables[i].name for i in inputs + outputs)]
    for k in range(REFERENCE_STEPS + 1):
        t = k * REFERENCE_STEP
        instance.set_values(references, [value for a, w in signals for value in _sine(a, w, t)])
        lines.append(",".join(f"{value!r}" for value in [t, *instance.get_values(inputs + outputs)]))
        instance.do_step(t, REFERENCE_STEP)
    return "\n".join(lines) + "\n"


def _sine(amplitude: float, omega: float, t: float) -> list[float]:
    """a sin(omega t) and its first three derivatives."""
    s, c = amplitude * math.sin(omega * t), amplitude * math.cos(omega * t)
    return [s, omega * c, -omega * omega * s, -omega * omega * omega * c]
