"""One instance of a unit: values, state, stepping and the rules of the FMI call order, without any FMI.

Both flavours of FMU show this behaviour; the Python FMU is a thin shell around this class, so that "the FMU equals the
model" can be tested to the last bit.

Inputs are cubics over a communication step, u(t + s) = u + d1 s + d2 s^2/2 + d3 s^3/6. After a step, outputs are limits
from the left; once an input is set again they are limits from the right (branches change, a docking happens).
"""

from __future__ import annotations

import math
from typing import Any

from ..models.integrate import integrate
from ..models.ops import FLOATS, NEVER
from .unit import Unit

INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED = range(5)
PHASES = ("instantiated", "initializing", "stepping", "terminated", "failed")
TIME_TOLERANCE = 1e-9


class CallError(Exception):
    """The host broke a rule: call order, value, time. The message says which and what was expected."""


class StepError(Exception):
    """A step could not be computed; the instance is as it was before the step."""


class Instance:
    """A unit at work. Value references are positions in ``unit.variables``."""

    def __init__(self, unit: Unit) -> None:
        self.unit = unit
        model = unit.model
        self._outputs = model.outputs
        self._transition = getattr(model, "transition", None)
        self._next_event = getattr(model, "next_event_time", None)
        self._names = [v.name for v in unit.variables]
        causality = [v.causality for v in unit.variables]
        self._first_input = causality.index("input")
        n = len(unit.inputs)
        self._first_derivative = self._first_input + n
        self._first_output = len(unit.variables) - len(unit.observed)
        self._first_calculated = len(unit.variables) - len(unit.observed) - 4 * n - len(unit.calculated)
        settable = [
            c == "input" or (c == "parameter" and (v.variability == "tunable"))
            for c, v in zip(causality, unit.variables)
        ]
        early = [c in ("input", "parameter") for c in causality]
        self._settable = [early, early, settable, [False] * len(early), [False] * len(early)]
        self._nominal = tuple(1.0 for _ in getattr(model, "State", ()) and model.State._fields)
        self.reset()

    def reset(self) -> None:
        """Back to the instantiated phase, all values at their start."""
        self.phase = INSTANTIATED
        self.values: list[float] = [0.0 if v.start is None else v.start for v in self.unit.variables]
        self.time = 0.0
        self.stop_time = NEVER
        self._offset = 0.0
        self._touched = True
        self._fresh = False
        self._first_step = 0.0
        self._x: tuple[float, ...] = ()
        self._m: tuple[float, ...] = ()
        self._p: Any = None

    # ---- call order -------------------------------------------------------------------------------------------------

    def set_up(self, start_time: float, stop_time: float | None) -> None:
        """Times of the experiment, s. Raises `CallError` if they are not finite and in order."""
        if self.phase != INSTANTIATED:
            raise CallError(f"set up of the experiment in phase {PHASES[self.phase]}, expected right after instantiation")
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
        self._initialize()
        self.phase = STEPPING
        self._observe()

    def terminate(self) -> None:
        """No step after this."""
        self._expect(STEPPING, "terminate")
        self.phase = TERMINATED

    def _expect(self, phase: int, what: str) -> None:
        if self.phase != phase:
            raise CallError(f"{what} in phase {PHASES[self.phase]}, expected phase {PHASES[phase]}")

    # ---- values -----------------------------------------------------------------------------------------------------

    def set_values(self, references: list[int], values: list[float]) -> None:
        """Set parameters and inputs. Raises `CallError` for anything that may not be set now, or is not finite."""
        own, settable = self.values, self._settable[self.phase]
        try:
            for r, value in zip(references, values):
                if not settable[r] or value - value != 0.0:
                    self._refuse_set(r, value)
                own[r] = value
        except IndexError:
            raise CallError(f"no variable has value reference {max(references)}") from None
        self._touched = True
        self._fresh = False

    def _refuse_set(self, r: int, value: float) -> None:
        v = self.unit.variables[r]
        if not self._settable[self.phase][r]:
            raise CallError(
                f"{v.name} may not be set in phase {PHASES[self.phase]}: it is a {v.variability} {v.causality}"
            )
        raise CallError(f"{v.name} = {value}: expected a finite number")

    def get_values(self, references: list[int]) -> list[float]:
        """Current values; outputs are computed when first asked for."""
        if not self._fresh:
            if self.phase == INITIALIZING:
                self._initialize()
                self._observe()
            elif self.phase == STEPPING:
                self._observe()
        values = self.values
        try:
            return [values[r] for r in references]
        except IndexError:
            raise CallError(f"no variable has value reference {max(references)}") from None

    def _initialize(self) -> None:
        unit, model, values = self.unit, self.unit.model, self.values
        for v, value in zip(unit.variables[: self._first_calculated], values):
            if (v.min is not None and value < v.min) or (v.max is not None and value > v.max):
                raise CallError(f"{v.name} = {value:g} {v.unit}: expected {_range(v.min, v.max)}")
        self._p = model.Parameters(**{v.name: values[i] for i, v in enumerate(unit.parameters)})
        problem = model.problem(self._p) if hasattr(model, "problem") else None
        if problem:
            raise CallError(problem)
        if unit.calculated:
            values[self._first_calculated : self._first_input] = map(float, model.calculated(self._p, FLOATS))
        x, m = model.initial(self._p, FLOATS)
        self._x, self._m = tuple(x), tuple(m)
        self._offset, self._touched, self._fresh, self._first_step = 0.0, True, False, 0.0
        self._frozen = getattr(self._p, "freeze_branches", 0.0) > 0.5
        if unit.stepped:
            tolerance = values[unit.index["integration_tolerance"]]
            self._rtol, self._atol = tolerance, tuple(tolerance * n for n in self._nominal)

    # ---- inputs as polynomials --------------------------------------------------------------------------------------

    def _coefficients(self) -> list[tuple[float, float, float, float]]:
        """(u, d1, d2/2, d3/6) of every input."""
        v, i, d = self.values, self._first_input, self._first_derivative
        return [
            (v[i + j], v[d + 3 * j], 0.5 * v[d + 3 * j + 1], v[d + 3 * j + 2] / 6.0) for j in range(d - i)
        ]

    def _inputs(self, s: float) -> tuple[list[float], list[float]]:
        """Inputs and their rates ``s`` seconds after they were set."""
        c = self._coefficients()
        if s == 0.0:
            return [a[0] for a in c], [a[1] for a in c]
        return (
            [a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in c],
            [a1 + s * (2.0 * a2 + s * 3.0 * a3) for _, a1, a2, a3 in c],
        )

    def _observe(self) -> None:
        """Bring outputs up to date; a communication point that was touched changes branches first."""
        if self._touched:
            self._offset = 0.0
            self._touched = False
            u, du = self._inputs(0.0)
            if self._transition:
                self._x, self._m = self._transition(self.time, self._x, self._m, u, self._p, FLOATS)
        else:
            u, du = self._inputs(self._offset)
        self.values[self._first_output :] = self._outputs(self.time, self._x, self._m, u, du, self._p, FLOATS)
        self._fresh = True

    # ---- stepping ---------------------------------------------------------------------------------------------------

    def do_step(self, time: float, step: float) -> None:
        """Advance from ``time`` by ``step``, s. Raises `CallError` (nothing happened) or `StepError` (nothing
        happened, the numbers went bad)."""
        if self.phase != STEPPING:
            raise CallError(f"step in phase {PHASES[self.phase]}, expected phase {PHASES[STEPPING]}")
        end = time + step
        slack = TIME_TOLERANCE * (1.0 + abs(time))
        if not 0.0 < step < NEVER:
            raise CallError(f"step size {step}: expected a positive, finite number of seconds")
        if not abs(time - self.time) <= slack:
            raise CallError(f"step from t = {time}: expected t = {self.time}, where the last step ended")
        if end > self.stop_time + slack:
            raise CallError(f"step to t = {end}: expected at most the stop time {self.stop_time}")
        before = self._x, self._m, self._first_step
        try:
            self._advance(time, step)
            self.time, self._offset, self._touched = end, step, False
            self._observe()
        except (ArithmeticError, ValueError) as error:
            self._undo(time, before)
            raise StepError(f"step from t = {time} to {end}: {error}") from error
        observed = self.values[self._first_output :]
        if not abs(sum(observed)) < math.inf:
            self._undo(time, before)
            bad = next(i for i, value in enumerate(observed) if not abs(value) < math.inf)
            name = self._names[self._first_output + bad]
            raise StepError(f"step from t = {time} to {end}: {name} became {observed[bad]}")

    def _undo(self, time: float, before: tuple[Any, Any, float]) -> None:
        self._x, self._m, self._first_step = before
        self.time, self._offset, self._touched, self._fresh = time, 0.0, True, False

    def _advance(self, time: float, step: float) -> None:
        """Continuous state to the end of the step, transitions that fall inside included."""
        if self._transition:
            u, _ = self._inputs(0.0)
            self._x, self._m = self._transition(time, self._x, self._m, u, self._p, FLOATS)
        if not self._x:
            return
        if not self.unit.stepped:
            self._x = self.unit.model.advance(time, step, self._x, self._m, self._coefficients(), self._p, FLOATS)
            return
        done = 0.0
        while self._next_event:
            due = self._next_event(time + done, self._m, self._p, FLOATS) - time
            if not done < due < step * (1.0 - 1e-12):
                break
            self._integrate(time, done, due)
            done = due
            u, _ = self._inputs(done)
            self._x, self._m = self._transition(time + due, self._x, self._m, u, self._p, FLOATS)  # type: ignore[misc]
        self._integrate(time, done, step)

    def _integrate(self, time: float, start: float, end: float) -> None:
        model, p = self.unit.model, self._p
        derivatives, indicators, transition = model.derivatives, model.indicators, self._transition
        c = self._coefficients()
        if any(a1 or a2 or a3 for _, a1, a2, a3 in c):

            def inputs(s: float) -> list[float]:
                return [a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in c]
        else:
            held = [a[0] for a in c]

            def inputs(s: float) -> list[float]:
                return held

        m = self._m

        def rates(s: float, x: tuple[float, ...]) -> Any:
            return derivatives(time + s, x, m, inputs(s), p, FLOATS)

        def crossings(s: float, x: tuple[float, ...]) -> Any:
            return indicators(time + s, x, m, inputs(s), p, FLOATS)

        def change(s: float, x: tuple[float, ...]) -> tuple[float, ...]:
            nonlocal m
            if self._frozen:
                return x
            x, m = transition(time + s, x, m, inputs(s), p, FLOATS)
            return tuple(x)

        self._x, self._first_step = integrate(
            rates, start, self._x, end, rtol=self._rtol, atol=self._atol, indicators=crossings, on_event=change,
            first_step=self._first_step,
        )  # fmt: skip
        self._m = m

    # ---- full state -------------------------------------------------------------------------------------------------

    def state(self) -> tuple[Any, ...]:
        """Everything, immutable: restoring it makes the instance bit-equal to what it was."""
        return (
            self.phase, self.time, self.stop_time, self._offset, self._touched, self._fresh, self._first_step,
            tuple(self._x), tuple(self._m), tuple(self.values),
        )  # fmt: skip

    def restore(self, state: tuple[Any, ...]) -> None:
        """Set the state of this or another instance of the same unit."""
        if len(state) != 10 or len(state[9]) != len(self.values):
            raise CallError(f"this is not a state of {self.unit.name}")
        old = self.values[: self._first_calculated]
        (
            self.phase, self.time, self.stop_time, self._offset, self._touched, self._fresh, self._first_step,
            x, m, values,
        ) = state  # fmt: skip
        self.values[:] = values
        if self.phase >= STEPPING and (self._p is None or old != self.values[: self._first_calculated]):
            flags = self._offset, self._touched, self._fresh, self._first_step
            self._initialize()
            self._offset, self._touched, self._fresh, self._first_step = flags
        self._x, self._m = tuple(x), tuple(m)


def _range(low: float | None, high: float | None) -> str:
    if low is None:
        return f"at most {high:g}"
    return f"at least {low:g}" if high is None else f"{low:g} to {high:g}"
