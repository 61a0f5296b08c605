"""Values of an instance, by value reference: what may be set when, what follows from it.

Inputs are cubics over a communication step, u(t + s) = u + d1 s + d2 s^2/2 + d3 s^3/6, and start anew at each: what is
not set again begins the next step with the same u, d1, d2 and d3. After a step, outputs are limits from the left; once
anything is set they are limits from the right (branches change, a docking happens).

A tunable parameter set between steps is in force from the next call that needs it on; continuous states and branches
stay. If it makes no sense that call is refused, and the values that were in force before stay so. Where states belong to
their parameters (the model's ``tuning_refusal``), setting one is refused at once.
"""

from __future__ import annotations

from typing import Any

from ...models.numeric.ops import FLOATS, NEVER
from ..declare.unit import Unit
from .inline import floats

INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED = range(5)
PHASES = ("instantiated", "initializing", "stepping", "terminated", "failed")
EVENT_TOLERANCE = 1e-12
"""An event this close to a communication point, relative to 1 s + |t|, happens there: k*h is not exactly the time."""

Polynomials = list[tuple[float, float, float, float]]
"""(u, d1, d2/2, d3/6) of every input."""


class CallError(Exception):
    """The host broke a rule: call order, value, time. The message says which and what was expected."""


class StepError(Exception):
    """A step could not be computed; the instance is as it was before the step."""


class Values:
    """The values of a unit at work, with what makes them: parameters, states, modes, inputs, outputs."""

    def __init__(self, unit: Unit) -> None:
        self.unit = unit
        self._layout = layout = unit.layout
        self._model: Any = floats(unit.model)
        self._outputs, self._advances = self._model.outputs, self._model.advance
        self._transition, self._next_event = self._model.transition, self._model.next_event_time
        self._parameters, self._calculated, self._inputs, derivatives, self._observed = (
            slice(part.start, part.stop) for part in layout[:5]
        )
        self._rates, self._cubic_places = slice(derivatives.start, derivatives.stop, 3), layout.input_derivatives[::3]
        early = frozenset((*layout.parameters, *layout.inputs, *layout.input_derivatives))
        later = frozenset(i for i in early if unit.variables[i].variability != "fixed")
        self._tunable = later & frozenset(layout.parameters)
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
        refuses = self._model.tuning_refusal
        tied = refuses(self._p) if tunable and refuses else ""
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
            wanted = [values[r] for r in references]
        except IndexError:
            self._check_references(references)
            raise
        if wanted and min(references) < 0:
            self._check_references(references)
        return wanted

    def _first_outputs(self) -> None:
        try:
            self._initialize()
            self._observe()
        except (ArithmeticError, ValueError) as error:
            raise CallError(f"initial values at t = {self.time}: {error}") from error

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
            if any(r in self._layout.observed or r in self._layout.calculated for r in references):
                self._first_outputs()
        elif self.phase == FAILED:
            raise CallError("the instance failed before: reset it, or free it")

    def _take_parameters(self) -> None:
        """Check the parameters and compute what follows from them alone. Raises `CallError`; nothing happened then."""
        unit, model, values = self.unit, self._model, self.values
        for v, value in zip(unit.variables[self._parameters], values):
            if (v.min is not None and value < v.min) or (v.max is not None and value > v.max):
                raise CallError(f"{v.name} = {value:g} {v.unit}: expected {_range(v.min, v.max)}")
        p = model.Parameters(**{v.name: values[i] for i, v in enumerate(unit.parameters)})
        if refusal := model.refused(p):
            raise CallError(refusal)
        if unit.calculated:
            values[self._calculated] = map(float, model.calculated(p, FLOATS))
        self._fixed, self._p = tuple(values[self._parameters]), p
        self._stale = False

    def _retune(self) -> None:
        """Put tuned parameters in force. Raises `CallError`; the previous ones are then in force."""
        try:
            self._take_parameters()
        except (ArithmeticError, ValueError) as error:
            raise CallError(f"parameters set at t = {self.time}: {error}") from error
        finally:
            if self._stale:
                self.values[self._parameters] = self._fixed
                self._stale = False

    def _initialize(self) -> None:
        unit, model, values = self.unit, self._model, self.values
        self._take_parameters()
        x, m = model.initial(self._p, FLOATS)
        self._x, self._m = tuple(x), tuple(m)
        self._offset, self._touched, self._fresh, self._first_step = 0.0, True, False, 0.0
        frozen = unit.index.get("freeze_branches")
        self._frozen = frozen is not None and values[frozen] > 0.5
        if model.integrated:
            self._rtol = values[unit.index["integration_tolerance"]]
            self._atol = (self._rtol,) * len(x)

    def _polynomials(self) -> Polynomials:
        c = self._cubics
        if c is None:
            v = self.values
            c = [(u, v[k], 0.5 * v[k + 1], v[k + 2] / 6.0) for k, u in zip(self._cubic_places, v[self._inputs])]
            self._cubics = c
        return c

    def _observe(self) -> None:
        """Bring outputs up to date; a communication point that was touched changes branches first."""
        if self._touched:
            if self._stale:
                self._retune()
            self._offset = 0.0
            self._touched = False
            v = self.values
            u, du = v[self._inputs], v[self._rates]
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
        self.values[self._observed] = observed
        self._fresh = True

    def _change(self, time: float, u: list[float]) -> None:
        """The discrete change at a communication point."""
        if self._next_event:
            due = self._next_event(time, self._m, self._p, FLOATS)
            if 0.0 < due - time <= EVENT_TOLERANCE * (1.0 + abs(time)):
                time = due
        self._x, self._m = self._transition(time, self._x, self._m, u, self._p, FLOATS)  # type: ignore[misc]


def _range(low: float | None, high: float | None) -> str:
    if low is None:
        return f"at most {high:g}"
    return f"at least {low:g}" if high is None else f"{low:g} to {high:g}"
