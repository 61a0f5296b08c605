"""Whether a unit of another make can do what its description says.

A unit whose state is not all that it keeps, as any PythonFMU unit with an attribute that is no registered variable, goes back
in part only: every scheme that repeats steps would silently give wrong physics. So its steps are repeated now and then
just to see, at steps 0, 1, 2, 4, 8, ... of a run: at rest even a forgetful unit repeats itself. What this cannot
see: a unit that answers OK without stepping, or that ignores what it is given, does so repeatably.
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
