"""Whether a unit of another make restores its state, as its description says that it can.

A unit may save less than its state, as a PythonFMU unit does that has an attribute which is no registered variable. Every
scheme that repeats steps would then give wrong physics without a word. So steps 0, 1, 2, 4, 8, ... of a run are
repeated: not the first alone, because a unit at rest repeats itself in any case. Two faults are not seen, because they
repeat themselves too: a unit that answers OK without stepping, and one that ignores its inputs.
"""

from __future__ import annotations

from towage.errors import RunError
from towage.master.system import System
from towage.units.fmu import StepRefused

REPEATED = 1e-9
"""Relative difference between a step and its repetition that passes: sums may be formed in another order."""
REMEDY = "Take scheme 'extrapolate' with events = false, which never goes back"


def repeat(system: System, time: float, step: float) -> None:
    """Step every foreign unit again, from its saved state at ``time`` with the same inputs. Raises `RunError` if it ends
    elsewhere."""
    for i in system.foreign:
        unit = system.units[i]
        first = unit.values
        unit.restore(time)
        try:
            unit.advance(time, step)
        except StepRefused as refusal:
            raise RunError(
                f"refuses a step that it did before its state was restored ({refusal}). {REMEDY}",
                unit=unit.name, time=time,
            ) from None  # fmt: skip
        for name, a, b in zip(unit.outputs, first, unit.values):
            if abs(a - b) > REPEATED * max(abs(a), abs(b)):
                raise RunError(
                    f"does not restore its state, though its description says that it can: {name} is {a!r} after a step "
                    f"of {step:g} s and {b!r} after the same step repeated. {REMEDY}",
                    unit=unit.name, variable=name, time=time,
                )  # fmt: skip
