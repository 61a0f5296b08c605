"""Steps of an instance: continuous states to the end of the step, transitions that fall inside included.

A model that has a step of its own makes it; any other is integrated, with restarts at the zeros of its indicators and at
its next event.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...models.numeric.integrate import MAX_STEPS, IntegrationError, integrate
from ...models.numeric.ops import FLOATS, NEVER
from .values import EVENT_TOLERANCE, PHASES, STEPPING, CallError, StepError, Values

TIME_TOLERANCE = 1e-9
"""How far the time of a step may be from where the last one ended, relative to 1 s + |t|."""


def shifted(cubic: Sequence[float], s: float) -> tuple[float, float, float, float]:
    """Coefficients of the same cubic counted from ``s``."""
    a0, a1, a2, a3 = cubic
    return a0 + s * (a1 + s * (a2 + s * a3)), a1 + s * (2.0 * a2 + s * 3.0 * a3), a2 + 3.0 * a3 * s, a3


class Stepping(Values):
    """Values that move on."""

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
            self._change(time, self.values[self._inputs])
        if not self._x:
            return
        move, done, events = self._exactly if self._advances else self._integrate, 0.0, 0
        while self._next_event:
            event = self._next_event(time + done, self._m, self._p, FLOATS)
            due = event - time
            if not done < due < step * (1.0 - EVENT_TOLERANCE):
                break
            if events == MAX_STEPS:
                raise IntegrationError(f"more than {MAX_STEPS} events until t = {event}: take shorter steps")
            move(time, done, due)
            done, events = due, events + 1
            u = [a0 + due * (a1 + due * (a2 + due * a3)) for a0, a1, a2, a3 in self._polynomials()]
            # not time + due, which may round to just before the event
            self._x, self._m = self._transition(event, self._x, self._m, u, self._p, FLOATS)  # type: ignore[misc]
        move(time, done, step)

    def _exactly(self, time: float, start: float, end: float) -> None:
        """As `_integrate`, of a model that has a step of its own."""
        cubics = [shifted(c, start) for c in self._polynomials()] if start else self._polynomials()
        assert self._advances
        self._x = self._advances(time + start, end - start, self._x, self._m, cubics, self._p, FLOATS)

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
            assert indicators is not None
            return indicators(time + s, x, m, inputs(s), p, FLOATS)

        def change(s: float, x: tuple[float, ...]) -> tuple[float, ...]:
            nonlocal m
            if self._frozen:
                return x
            x, m = transition(time + s, x, m, inputs(s), p, FLOATS)  # type: ignore[misc]
            return x

        try:
            self._x, self._first_step = integrate(
                rates, start, self._x, end, rtol=self._rtol, atol=self._atol,
                indicators=crossings if indicators else None, on_event=change if transition else None,
                first_step=self._first_step,
            )  # fmt: skip
        except IntegrationError as error:
            names = ", ".join(self.unit.model.State._fields)
            raise IntegrationError(f"{error}; t counts from {time}, x is ({names})") from None
        self._m = m
