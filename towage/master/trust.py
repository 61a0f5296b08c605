"""Whether a unit of another make restores its state, as its description says that it can, and how well.

A unit may save less than its state, as a PythonFMU unit does that has an attribute which is no registered variable: every
scheme that repeats steps would then give wrong physics without a word. Or it has a solver with variable steps inside, which
starts anew: a repeated step then differs by the solver's own tolerance. So steps 0, 1, 2, 4, 8, ... of a run are repeated: not
the first alone, because a unit at rest repeats itself in any case. The difference is the unit's noise. It may be a tenth of the
error control's tolerance, `FIXED` where the step is fixed; both are errors of one step. Where it is more, ``auto`` begins again
with a scheme that never goes back, and a scheme that was named is refused. Two faults are not seen, because they repeat
themselves too: a unit that answers OK without stepping, and one that ignores its inputs.
"""

from __future__ import annotations

from towage.master.system import System
from towage.units.description import Variable
from towage.units.doubt import Doubt
from towage.units.fmu import StepRefused, Unit

REPEATED = 1e-9
"""Relative difference between a step and its repetition that is rounding: sums may be formed in another order."""
FIXED = 1e-6
"""The noise that a run with a fixed step bears: a thousand steps of it, all to one side, are 0.1 %."""
SHARE = 0.1
"""Of the error control's tolerance: the noise must not be what the control sees."""
REMEDY = "Take scheme 'extrapolate' with events = false, which never goes back"


def allowed(tolerance: float | None) -> float:
    """The noise that a run bears, relative; ``tolerance`` is that of the error control, None for a fixed step."""
    return FIXED if tolerance is None else SHARE * tolerance


def repeat(system: System, time: float, step: float, limit: float) -> None:
    """Step every foreign unit that goes back again, from its saved state at ``time`` with the same inputs, and note its noise.
    Raises `Doubt` if it ends elsewhere by more than ``limit``, relative to the largest value of an output, or if it does not
    heed the derivatives of its inputs."""
    for i in system.foreign:
        unit = system.units[i]
        if not unit.can_roll_back:
            continue
        first = unit.values
        _again(unit, time, step)
        scales = system.scales.setdefault(i, [_nominal(unit.variables, name) for name in unit.outputs])
        for k, (name, a, b) in enumerate(zip(unit.outputs, first, unit.values)):
            scales[k] = max(scales[k], abs(a), abs(b))
            noise = abs(a - b) / scales[k] if a != b else 0.0
            if noise > REPEATED:
                system.noise[unit.name] = max(noise, system.noise.get(unit.name, 0.0))
            if noise > limit:
                raise Doubt(
                    f"does not restore its state, though its description says that it can: {name} is {a!r} after a step "
                    f"of {step:g} s and {b!r} after the same step repeated, more than the {limit:g} of its size that this run "
                    f"bears. {REMEDY}", "state",
                    f"does not restore its state well enough ({name} differs by {noise:.2g} of its size after a step repeated "
                    f"at t = {time:g} s, this run bears {limit:g})",
                    unit.name, name, time,
                )  # fmt: skip
        if first == unit.values:
            _slopes(unit, time, step)


def _again(unit: Unit, time: float, step: float) -> None:
    """Repeat a step. Raises `Doubt` where it is refused now."""
    unit.restore(time)
    try:
        unit.advance(time, step)
    except StepRefused as refusal:
        why = f"refuses a step that it did before its state was restored ({refusal})"
        raise Doubt(f"{why}. {REMEDY}", "state", why, unit.name, "", time) from None


def _slopes(unit: Unit, time: float, step: float) -> None:
    """Repeat a step with inputs that are held, and then as it was. Raises `Doubt` for a unit that is said to take derivatives of
    its inputs and gives the same bits without those it had, while its inputs matter to it."""
    told, first = unit.wiring.slopes, unit.values
    buffer = unit.input_buffer
    kept = buffer[:]
    if told.start == told.stop or not any(buffer[told]):
        return
    outcomes = []
    for share in (0.0, 1.0):  # held at the beginning, and at the end: what differs shows that they matter
        for place in unit.inputs.values():
            if told.start <= place.derivatives < told.stop:
                buffer[place.slot] = kept[place.slot] + share * step * kept[place.derivatives]
        for k in range(told.start, told.stop):
            buffer[k] = 0.0
        _again(unit, time, step)
        outcomes.append(unit.values)
    for k, value in enumerate(kept):
        buffer[k] = value
    _again(unit, time, step)
    if outcomes[0] == first != outcomes[1]:
        raise Doubt(
            "takes derivatives of its inputs, as its description says that it can, and does nothing with them: its inputs are "
            "those of the beginning of a step all through it. Take scheme 'auto', which holds them at their mean", "slopes",
            "does nothing with the derivatives of its inputs", unit.name, "", time,
        )  # fmt: skip


def _nominal(variables: dict[str, Variable], name: str) -> float:
    """The size of a variable that its description tells; 0 if it does not."""
    variable = variables.get(name)
    return abs(variable.nominal or 0.0) if variable else 0.0
