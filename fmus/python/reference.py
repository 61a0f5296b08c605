"""The reference run that an FMU carries: a short run of the unit, as the unit itself computes it."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..declare.unit import INPUT_ORDERS, Unit
from ..describe.documentation import REFERENCE_STEP
from ..describe.members import Reference
from .instance import Instance

REFERENCE_STEPS = 100


def reference_run(unit: Unit) -> Reference:
    """Inputs are sines, set with their three derivatives before each step."""
    instance = Instance(unit)
    instance.set_values([unit.index[k] for k in unit.start], list(unit.start.values()))
    instance.set_up(0.0, None)
    instance.enter_initialization()
    instance.exit_initialization()
    references, signals = [], []
    for name, (amplitude, omega) in unit.reference_inputs.items():
        references += [unit.index[name]] + [unit.index[f"{name}_d{k}"] for k in INPUT_ORDERS]
        signals.append((amplitude, omega))
    outputs = [i for i, v in enumerate(unit.variables) if v.causality == "output"]
    given, found = ([",".join(["time", *(unit.variables[i].name for i in part)])] for part in (references, outputs))
    for k in range(REFERENCE_STEPS + 1):
        t = k * REFERENCE_STEP
        values = [value for a, w in signals for value in _sine(a, w, t)]
        instance.set_values(references, values)
        given.append(_row(t, values))
        found.append(_row(t, instance.get_values(outputs)))
        instance.do_step(t, REFERENCE_STEP)
    return Reference("\n".join(given) + "\n", "\n".join(found) + "\n", REFERENCE_STEP, REFERENCE_STEPS)


def _row(t: float, values: Iterable[float]) -> str:
    return ",".join(f"{value!r}" for value in (t, *values))


def _sine(amplitude: float, omega: float, t: float) -> list[float]:
    """a sin(omega t) and its first three derivatives."""
    s, c = amplitude * math.sin(omega * t), amplitude * math.cos(omega * t)
    return [s, omega * c, -omega * omega * s, -omega * omega * omega * c]
