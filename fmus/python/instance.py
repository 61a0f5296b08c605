"""One instance of a unit: values, state, stepping and the rules of the FMI call order, without any FMI.

Both flavours of FMU show this behaviour; the Python FMU is a thin shell around this class, so that "the FMU equals the
model" can be tested to the last bit.

Inputs are cubics over a communication step, u(t + s) = u + d1 s + d2 s^2/2 + d3 s^3/6, and start anew at each: what is
not set again begins the next step with the same u, d1, d2 and d3. After a step, outputs are limits from the left; once
anything is set they are limits from the right (branches change, a docking happens).

A tunable parameter set between steps is in force from the next call that needs it on; continuous states and branches
stay. If it makes no sense that call is refused, and the values that were in force before stay so. Where states belong to
their parameters (the model's ``untunable``), setting one is refused at once.
"""

from __future__ import annotations

from typing import Any

from ...models.numeric.integrate import IntegrationError, integrate
from ...models.numeric.ops import FLOATS, NEVER
from ..declare.unit import Unit
from .inline import floats

INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED = range(5)
PHASES = ("instantiated", "initializing", "stepping", "terminated", "failed")
TIME_TOLERANCE = 1e-9
"""How far the time of a step may be from where the last one ended, relative to 1 s + |t|."""
EVENT_TOLERANCE = 1e-12
"""An event this close to a communication point, relative to 1 s + |t|, happens there: k*h is not exactly the time."""

Polynomials = list[tuple[float, float, float, float]]
"""(u, d1, d2/2, d3/6) of every input."""


class CallError(Exception):
    """The host broke a rule: call order, value, time. The message says which and what was expected."""


class StepError(Exception):
    """A step could not be computed; the instance is as it was before the step."""


class Instance:
    """A unit at work. Value references are positions in ``unit.variables``."""

    def __init__(self, unit: Unit) -> None:
        self.unit = unit
        self._model = model = floats(unit.model)
        self._outputs = model.outputs
        self._transition = getattr(model, "transition", None)
        self._next_event = getattr(model, "next_event_time", None)
        n = len(unit.inputs)
        self._first_output = len(unit.variables) - len(unit.observed)
        self._first_derivative = self._first_output - 3 * n
        self._first_input = self._first_derivative - n
        self._first_calculated = self._first_input - len(unit.calculated)
        causes = {"input", "parameter"}
        early = frozenset(i for i, v in enumerate(unit.variables) if v.causality in causes)
        later = frozenset(i for i in early if unit.variables[i].variability != "fixed")
        self._tunable = frozenset(i for i in later if i < self._first_calculated)
        # parameters that are tuned take the long way, so that inputs take the short one
        self._settable = (early, early, later - self._tunable, frozenset[int](), frozenset[int]())
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
        self._stale = False
        self._first_step = 0.0
        self._x: tuple[float, ...] = ()
        self._m: tuple[float, ...] = ()
        self._p: Any = None
        self._fixed: tuple[float, ...] = ()
        self._cubics: Polynomials | None = None

    # ---- call order -------------------------------------------------------------------------------------------------

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

    def _first_outputs(self) -> None:
        try:
            self._initialize()
            self._observe()
        except (ArithmeticError, ValueError) as error:
            raise CallError(f"initial values at t = {self.time}: {error}") from error

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

    # ---- values -----------------------------------------------------------------------------------------------------

    def set_values(self, references: list[int], values: list[float]) -> None:
        """Set parameters and inputs. Raises `CallError` for anything that may not be set now, or is not finite."""
        own, settable = self.values, self._settable[self.phase]
        for r, value in zip(references, values):
            if r not in settable or value - value != 0.0:
                self._tune(r, value)
            own[r] = value
        self._touched = True
        self._fresh = False
        self._cubics = None

    def _tune(self, r: int, value: float) -> None:
        """A tunable parameter between steps; anything else that comes here is refused."""
        tunable = self.phase == STEPPING and r in self._tunable
        tied = self._model.untunable(self._p) if tunable and hasattr(self._model, "untunable") else ""
        if tunable and not tied and value - value == 0.0:
            self._stale = True
            return
        self._check_references([r])
        v = self.unit.variables[r]
        if tied:
            raise CallError(f"{v.name} may not be set: {tied}")
        if not tunable and r not in self._settable[self.phase]:
            raise CallError(
                f"{v.name} may not be set in phase {PHASES[self.phase]}: it is a {v.variability} {v.causality}"
            )
        raise CallError(f"{v.name} = {value}: expected a finite number")

    def get_values(self, references: list[int]) -> list[float]:
        """Current values; outputs are computed when first asked for. Raises `CallError` if they are not finite."""
        if not self._fresh:
            self._refresh(references)
        values = self.values
        try:
            found = [values[r] for r in references]
        except IndexError:
            self._check_references(references)
            raise
        if found and min(references) < 0:
            self._check_references(references)
        return found

    def _check_references(self, references: list[int]) -> None:
        for r in references:
            if not 0 <= r < len(self.values):
                # the bridge reads the unsigned value references of FMI as signed
                raise CallError(f"no variable has value reference {r % 2**32}, they are 0 to {len(self.values) - 1}")

    def _refresh(self, references: list[int]) -> None:
        if self.phase == STEPPING:
            try:
                self._observe()
            except (ArithmeticError, ValueError) as error:
                raise CallError(f"outputs at t = {self.time}: {error}") from error
        elif self.phase == INITIALIZING:
            # parameters can be read while they do not fit together yet
            if any(r >= self._first_output or self._first_calculated <= r < self._first_input for r in references):
                self._first_outputs()
        elif self.phase == FAILED:
            raise CallError("the instance failed before: reset it, or free it")

    def _take_parameters(self) -> None:
        """Check the parameters and compute what follows from them alone. Raises `CallError`; nothing happened then."""
        unit, model, values = self.unit, self._model, self.values
        for v, value in zip(unit.variables[: self._first_calculated], values):
            if (v.min is not None and value < v.min) or (v.max is not None and value > v.max):
                raise CallError(f"{v.name} = {value:g} {v.unit}: expected {_range(v.min, v.max)}")
        p = model.Parameters(**{v.name: values[i] for i, v in enumerate(unit.parameters)})
        for number, text in model.requirements(p, FLOATS) if hasattr(model, "requirements") else ():
            if not number > 0.0:
                raise CallError(text)
        problem = model.problem(p) if hasattr(model, "problem") else None
        if problem:
            raise CallError(problem)
        if unit.calculated:
            values[self._first_calculated : self._first_input] = map(float, model.calculated(p, FLOATS))
        self._fixed, self._p = tuple(values[: self._first_calculated]), p
        self._stale = False

    def _retune(self) -> None:
        """Put tuned parameters in force. Raises `CallError`; the previous ones are then in force."""
        try:
            self._take_parameters()
        except (ArithmeticError, ValueError) as error:
            raise CallError(f"parameters set at t = {self.time}: {error}") from error
        finally:
            if self._stale:
                self.values[: self._first_calculated] = self._fixed
                self._stale = False

    def _initialize(self) -> None:
        unit, model, values = self.unit, self._model, self.values
        self._take_parameters()
        x, m = model.initial(self._p, FLOATS)
        self._x, self._m = tuple(x), tuple(m)
        self._offset, self._touched, self._fresh, self._first_step = 0.0, True, False, 0.0
        self._frozen = getattr(self._p, "freeze_branches", 0.0) > 0.5
        self._stepped = unit.stepped
        if self._stepped:
            self._rtol = values[unit.index["integration_tolerance"]]
            self._atol = (self._rtol,) * len(x)

    # ---- inputs and outputs ----------------------------------------------------------------------------------------

    def _polynomials(self) -> Polynomials:
        c = self._cubics
        if c is None:
            v, d = self.values, self._first_derivative
            inputs = v[self._first_input : d]
            c = [(u, v[k], 0.5 * v[k + 1], v[k + 2] / 6.0) for k, u in zip(range(d, self._first_output, 3), inputs)]
            self._cubics = c
        return c

    def _observe(self) -> None:
        """Bring outputs up to date; a communication point that was touched changes branches first."""
        if self._touched:
            if self._stale:
                self._retune()
            self._offset = 0.0
            self._touched = False
            v, d = self.values, self._first_derivative
            u, du = v[self._first_input : d], v[d : self._first_output : 3]
            if self._transition:
                self._change(self.time, u)
        else:
            s, c = self._offset, self._polynomials()
            u = [a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in c]
            du = [a1 + s * (2.0 * a2 + s * 3.0 * a3) for _, a1, a2, a3 in c]
        observed = self._outputs(self.time, self._x, self._m, u, du, self._p, FLOATS)
        total = sum(observed)
        if total - total != 0.0:
            for variable, value in zip(self.unit.observed, observed):
                if value - value != 0.0:
                    raise ArithmeticError(f"{variable.name} became {value}")
        self.values[self._first_output :] = observed
        self._fresh = True

    def _change(self, time: float, u: list[float]) -> None:
        """The discrete change at a communication point."""
        if self._next_event:
            due = self._next_event(time, self._m, self._p, FLOATS)
            if 0.0 < due - time <= EVENT_TOLERANCE * (1.0 + abs(time)):
                time = due
        self._x, self._m = self._transition(time, self._x, self._m, u, self._p, FLOATS)  # type: ignore[misc]

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
        if not abs(time - self.time) <= slack < NEVER:
            raise CallError(f"step from t = {time}: expected t = {self.time}, where the last step ended")
        if end > self.stop_time + slack:
            raise CallError(f"step to t = {end}: expected at most the stop time {self.stop_time}")
        if self._stale:
            self._retune()
        before = self._x, self._m, self._first_step, self.time, self._offset, self._touched
        try:
            self._advance(time, step)
            self.time, self._offset, self._touched = end, step, False
            self._observe()
        except (ArithmeticError, ValueError) as error:
            self._x, self._m, self._first_step, self.time, self._offset, self._touched = before
            self._fresh = False
            raise StepError(f"step from t = {time} to {end}: {error}") from error

    def _advance(self, time: float, step: float) -> None:
        """Continuous state to the end of the step, transitions that fall inside included."""
        if self._transition:
            self._change(time, self.values[self._first_input : self._first_derivative])
        if not self._x:
            return
        if not self._stepped:
            self._x = self._model.advance(time, step, self._x, self._m, self._polynomials(), self._p, FLOATS)
            return
        done = 0.0
        while self._next_event:
            event = self._next_event(time + done, self._m, self._p, FLOATS)
            due = event - time
            if not done < due < step * (1.0 - EVENT_TOLERANCE):
                break
            self._integrate(time, done, due)
            done = due
            u = [a0 + due * (a1 + due * (a2 + due * a3)) for a0, a1, a2, a3 in self._polynomials()]
            # not time + due, which may round to just before the event
            self._x, self._m = self._transition(event, self._x, self._m, u, self._p, FLOATS)  # type: ignore[misc]
        self._integrate(time, done, step)

    def _integrate(self, time: float, start: float, end: float) -> None:
        """Continuous state from ``time + start`` to ``time + end``."""
        derivatives, indicators, transition = self._model.derivatives, self._model.indicators, self._transition
        m, p, c = self._m, self._p, self._polynomials()
        moving = [k for k, (_, a1, a2, a3) in enumerate(c) if a1 or a2 or a3]
        u = [a[0] for a in c]
        if len(moving) == 1:  # by far the most frequent case
            ((a0, a1, a2, a3),) = (c[k] for k in moving)
            before, after = u[: moving[0]], u[moving[0] + 1 :]

            def inputs(s: float) -> list[float]:
                return [*before, a0 + s * (a1 + s * (a2 + s * a3)), *after]
        elif moving:

            def inputs(s: float) -> list[float]:
                return [a0 + s * (a1 + s * (a2 + s * a3)) for a0, a1, a2, a3 in c]
        else:

            def inputs(s: float) -> list[float]:
                return u

        def rates(s: float, x: tuple[float, ...]) -> Any:
            return derivatives(time + s, x, m, inputs(s), p, FLOATS)

        def crossings(s: float, x: tuple[float, ...]) -> Any:
            return indicators(time + s, x, m, inputs(s), p, FLOATS)

        def change(s: float, x: tuple[float, ...]) -> tuple[float, ...]:
            nonlocal m
            if self._frozen:
                return x
            x, m = transition(time + s, x, m, inputs(s), p, FLOATS)  # type: ignore[misc]
            return x

        try:
            self._x, self._first_step = integrate(
                rates, start, self._x, end, rtol=self._rtol, atol=self._atol, indicators=crossings, on_event=change,
                first_step=self._first_step,
            )  # fmt: skip
        except IntegrationError as error:
            names = ", ".join(self.unit.model.State._fields)
            raise IntegrationError(f"{error}; t counts from {time}, x is ({names})") from None
        self._m = m

    # ---- full state -------------------------------------------------------------------------------------------------

    def state(self) -> tuple[Any, ...]:
        """Everything, immutable: restoring it makes the instance bit-equal to what it was."""
        if self.phase == FAILED:
            raise CallError("the state of an instance that failed is of no use: reset it, or free it")
        if self._stale:
            self._retune()
        first = self._first_calculated
        # parameters seldom change once there are results: one tuple serves all states of a run
        fixed = self._fixed if self.phase >= STEPPING else tuple(self.values[:first])
        return (
            self.phase, self.time, self.stop_time, self._offset, self._touched, self._fresh, self._first_step,
            self._x, self._m, fixed, tuple(self.values[first:]),
        )  # fmt: skip

    def restore(self, state: tuple[Any, ...]) -> None:
        """Set the state of this or another instance of the same unit."""
        first = self._first_calculated
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


def _range(low: float | None, high: float | None) -> str:
    if low is None:
        return f"at most {high:g}"
    return f"at least {low:g}" if high is None else f"{low:g} to {high:g}"
