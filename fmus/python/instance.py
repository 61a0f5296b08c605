"""One instance of a unit: values, state, stepping and the rules of the FMI call order, without any FMI.

Both flavours of FMU show this behaviour; the Python FMU is a thin shell around this class, so that "the FMU equals the
model" can be tested to the last bit. Values and their rules are in ``values.py``, steps in ``stepping.py``; here are the
phases of a run and the full state.
"""

from __future__ import annotations

from typing import Any

from ...models.numeric.ops import NEVER
from .stepping import Stepping
from .values import FAILED, INITIALIZING, INSTANTIATED, PHASES, STEPPING, TERMINATED, CallError


class Instance(Stepping):
    """A unit at work. Value references are positions in ``unit.variables``."""

    def set_up(self, start_time: float, stop_time: float | None) -> None:
        """Times of the experiment, s. Raises `CallError` if they are not finite and in order."""
        if self.phase != INSTANTIATED:
            raise CallError(f"set up of the experiment in phase {PHASES[self.phase]}, expected after instantiation")
        if not abs(start_time) < NEVER or (stop_time is not None and not stop_time > start_time):
            raise CallError(f"start time {start_time} and stop time {stop_time} are not finite and in order")
        self.time = start_time
        self.stop_time = NEVER if stop_time is None else stop_time

    def enter_initialization(self) -> None:
        """Parameters and start values may still be set."""
        self._expect(INSTANTIATED, "enter initialization")
        self.phase = INITIALIZING

    def exit_initialization(self) -> None:
        """Fix the parameters and compute the initial state. Raises `CallError` if a parameter makes no sense."""
        self._expect(INITIALIZING, "exit initialization")
        self._first_outputs()
        self.phase = STEPPING

    def fail(self) -> None:
        """No call has an answer from here on."""
        self.phase = FAILED
        self._fresh = False

    def terminate(self) -> None:
        """No step after this."""
        self._expect(STEPPING, "terminate")
        self.phase = TERMINATED

    def _expect(self, phase: int, what: str) -> None:
        if self.phase != phase:
            raise CallError(f"{what} in phase {PHASES[self.phase]}, expected phase {PHASES[phase]}")

    def state(self) -> tuple[Any, ...]:
        """Everything, immutable: restoring it makes the instance bit-equal to what it was."""
        if self.phase == FAILED:
            raise CallError("the state of an instance that failed is of no use: reset it, or free it")
        if self._stale:
            self._retune()
        first = self._layout.calculated.start
        # parameters seldom change once there are results: one tuple serves all states of a run
        fixed = self._fixed if self.phase >= STEPPING else tuple(self.values[:first])
        return (
            self.phase, self.time, self.stop_time, self._offset, self._touched, self._fresh, self._first_step,
            self._x, self._m, fixed, tuple(self.values[first:]),
        )  # fmt: skip

    def restore(self, state: tuple[Any, ...]) -> None:
        """Set the state of this or another instance of the same unit."""
        first = self._layout.calculated.start
        if len(state) != 11 or len(state[9]) != first or len(state[9]) + len(state[10]) != len(self.values):
            raise CallError(f"this is not a state of {self.unit.name}")
        phase, time, stop_time, offset, touched, fresh, first_step, x, m, fixed, values = state
        if fixed is not self._fixed or self.phase < STEPPING or self._stale:
            self._stale = False
            self.values[:first] = fixed
            if phase >= STEPPING:
                self._initialize()
                self._fixed = fixed
        self.values[first:] = values
        self._cubics = None
        self.phase, self.time, self.stop_time = phase, time, stop_time
        self._offset, self._touched, self._fresh, self._first_step = offset, touched, fresh, first_step
        self._x, self._m = x, m
