"""Initial values along the connections.

A unit of another make may compute its initial state from its inputs. So while the units are in initialisation mode, values
travel along the connections, pass by pass in the order of evaluation, until they stand still; a loop is solved for the
signals that run backward in that order. Then the units leave the mode one after the other, each with the newest values of
those before it, because some compute their outputs only then. Units of towage start from their parameters alone: where nothing
is connected to another unit, there is nothing to do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from towage.errors import RunError

if TYPE_CHECKING:
    from towage.master.signals import Signal
    from towage.master.system import System

PASSES = 100
STILL = 1e-12
"""Change of a signal in a pass, relative to its value, below which it stands still."""
SOLVED = 1e-9
"""The same where a loop is solved: what units iterate themselves is no better."""


def initialise(system: System, time: float) -> None:
    """Take all units, which are in initialisation mode, through it. Raises `RunError`."""
    travels = any(system.into[i] or any(t.target == i for t in system.texts) for i in system.foreign)
    if travels:
        _iterate(system, time)
    for i in system.order:
        if travels:
            _pass_on(system, i, time)
        system.units[i].begin(time)
        system.read(i)


def _iterate(system: System, time: float) -> None:
    """Until no signal changes."""
    for i in system.order:
        system.units[i].get(time)
        system.read(i)
    for _ in range(PASSES):
        if _pass(system, time) <= STILL:
            return
    _solve(system, time)


def _pass(system: System, time: float) -> float:
    """Every unit gets its inputs and is read; returns the largest relative change of what is sent."""
    before = [s.end_value for s in system.signals]
    for i in system.order:
        _pass_on(system, i, time)
        system.units[i].get(time)
        system.read(i)
    return max((_change(s, value) for s, value in zip(system.signals, before)), default=0.0)


def _change(s: Signal, before: float) -> float:
    return abs(s.end_value - before) / max(abs(s.end_value), abs(before), 1e-300)


def _pass_on(system: System, i: int, time: float) -> None:
    """Set the inputs of a unit to what their sources send now."""
    unit = system.units[i]
    system.pass_texts()
    if system.into[i]:
        for s in system.into[i]:
            unit.input_buffer[s.input.slot] = s.end_value
        unit.set(time)


def _solve(system: System, time: float) -> None:
    """The loops as equations for the signals that run backward. Raises `RunError` where they have no solution near."""
    from scipy.optimize import root

    loop = [s for s in system.backward if not s.discrete]

    def residual(values: list[float]) -> list[float]:
        """What a pass makes of these values, less the values."""
        for s, value in zip(loop, values):
            s.end_value = float(value)
        _pass(system, time)
        return [s.end_value - value for s, value in zip(loop, values)]

    found = root(residual, [s.end_value for s in loop], tol=STILL) if loop else None
    if found is not None:
        residual(list(found.x))
        if _pass(system, time) <= SOLVED:
            return
    names = ", ".join(str(s.connection) for s in system.backward)
    raise RunError(
        f"the initial values along the loop of {names} do not stand still after {PASSES} passes, and the equations of the loop "
        "could not be solved: give one of its units another start value, or break the loop",
        time=time,
    )
