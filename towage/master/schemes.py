"""The coupling schemes: values that say what a scheme needs and does, and take one communication step.

| scheme | what it does | step calls | order |
|---|---|---|---|
| ``hermite`` | predictor as in ``extrapolate``, then one corrector on cubic Hermite signals, with rollback | 2 | 4 |
| ``extrapolate`` | quadratic from value, rate and previous value; what has been stepped is interpolated | 1 | 3 |
| ``implicit`` | corrector repeated to a tolerance, accelerated by a quasi-Newton (IQN-ILS) update | 3 and more | 4 |
| ``jacobi`` | every unit sees its inputs held at the communication point (as libcosim's fixed step) | 1 | 1 |
| ``gauss-seidel`` | units in order, inputs held at their newest value | 1 | 1 |

Orders are those of the global error for smooth signals with rates (measured: ``benchmarks/coupling.py``). A scheme
returns its error estimate for the step, relative to the largest value of each signal: predictor against corrector where
there is a corrector, else the interface residual |u(end used) - u(end found)| times 0.05, its effect on a motion of the
loop's frequency at some 20 steps a period. The schemes that hold their inputs have none.

The limits on H w, w the frequency of an interface loop (`towage.checks.step`), are those below which the energy of the
undamped loop grows by less than 1 % a radian at mass ratios from 0.06 to 100 (measured: ``benchmarks/coupling.py
stability``).

Nothing heavy is imported here, so that a scene can be checked against its scheme.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from towage.errors import RunError

if TYPE_CHECKING:
    from towage.master.signals import Signal
    from towage.master.system import System

FLOOR = 1e-3
"""Scale of a signal that was never larger."""
MAX_ITERATIONS = 50
ITERATION_TOLERANCE = 1e-11
ROUND_OFF = 1e-8
"""A residual below this that no longer falls is round-off: a reaction is the difference of two large tensions."""
HISTORY = 9
"""Iterations that the quasi-Newton update looks back on, those of earlier steps included."""
RESIDUAL_WEIGHT = 0.05


@dataclass(frozen=True)
class Scheme:
    """A way to take one communication step.

    ``step(system, time, step)`` takes the started system from ``time`` (s) over ``step`` (s), leaves the ends of all
    signals as found, and returns its estimate of the step's error, relative to the largest value of each signal. It may
    raise `StepRefused` of a unit, and `RunError`.
    """

    name: str
    description: str
    """What it does, in one sentence."""
    order: int
    """Order of the global error for smooth signals with rates."""
    calls: int
    """Steps that it asks of a unit in a loop for one communication step, at least."""
    step: Callable[[System, float, float], float]
    goes_back: bool = False
    """It needs units that save and restore their state."""
    solves_loops: bool = False
    """It repeats a step until both ends of every signal fit, which algebraic loops need."""
    holds: bool = False
    """Inputs are held over a step: rates and events are not read, and there is no error estimate."""
    limits: tuple[float, float] | None = None
    """Largest H w of an interface loop with one mass, and with more than one; None: nothing is known to limit it."""

    def limit(self, masses: int) -> float:
        """Largest H w of an interface loop with so many masses; infinite if nothing limits it."""
        return self.limits[masses > 1] if self.limits else math.inf


def jacobi(system: System, time: float, step: float) -> float:
    """Zero-order hold, all units side by side. Creates energy: for comparison with other tools only."""
    for s in system.signals:
        system.hold(s)
    for i in system.order:
        system.advance(i, time, step)
    return 0.0


def gauss_seidel(system: System, time: float, step: float) -> float:
    """Zero-order hold of the newest values, one unit after the other. For comparison only."""
    for s in system.signals:
        system.hold(s)
    done: set[int] = set()
    for i in system.order:
        for s in system.into[i]:
            if s.source in done:
                s.polynomial = (s.end_value, 0.0, 0.0, 0.0)
        system.advance(i, time, step)
        done.add(i)
    return 0.0


def extrapolate(system: System, time: float, step: float) -> float:
    """Explicit, order 3. The first step after a start or an event has no history to extrapolate from: it gets a
    corrector where the units can go back."""
    estimate = _predict(system, time, step)
    if not system.old_step and system.saved_at == time:
        _correct(system, time, step)
    return estimate


def hermite(system: System, time: float, step: float) -> float:
    """Predictor and exactly one corrector, order 4."""
    _predict(system, time, step)
    predicted = _sent(system)
    _correct(system, time, step)
    return _change(predicted)


def implicit(system: System, time: float, step: float) -> float:
    """Corrector to convergence: unknown are the end values and rates of the signals that run backward.

    What earlier iterations told of the loop's Jacobian starts the next step too, as long as its length is the same and
    nothing changed branch: two corrections are then the rule."""
    _predict(system, time, step)
    if not system.looped:
        return 0.0
    import numpy as np  # not needed to check a scene, which asks what a scheme is

    predicted = _sent(system)
    weights = np.array([w / max(s.scale, FLOOR) for s in system.backward for w in ((1.0, step) if s.rated else (1.0,))])
    learned = system.learned(step)
    used = np.array(_ends(system))
    before: tuple[Any, Any] | None = None
    best, stalled, fresh = math.inf, 0, 0
    for _ in range(MAX_ITERATIONS):
        _set_ends(system, used)
        _correct(system, time, step)
        ends = np.array(_ends(system))
        residual = ends - used
        size = float(np.max(np.abs(residual * weights)))
        if not size < math.inf:
            break
        stalled = stalled + 1 if size > 0.5 * best else 0
        best = min(best, size)
        if size < ITERATION_TOLERANCE or (size < max(ROUND_OFF, system.floor) and stalled):
            return _change(predicted)
        if before:
            learned.append((residual - before[0], ends - before[1]))
            fresh += 1
        before = residual, ends
        kept = min(fresh, HISTORY) if stalled else HISTORY  # what an earlier step taught goes where it does not help
        del learned[: max(0, len(learned) - kept)]
        used = ends
        if learned:
            changes = weights[:, None] * np.array([r for r, _ in learned]).T
            norms = np.linalg.norm(changes, axis=0) + 1e-300
            mixture = np.linalg.lstsq(changes / norms, -residual * weights, rcond=1e-10)[0]
            used = ends + np.array([f for _, f in learned]).T @ (mixture / norms)
    raise RunError(
        f"the coupling did not converge in {MAX_ITERATIONS} iterations at a step of {step:g} s: try a smaller step, or "
        "join the tightly coupled units (cradle_on_line for a cradle on a stiff line)",
        time=time,
    )


def _sent(system: System) -> list[tuple[Signal, float]]:
    """What the looped units send at the end of the step."""
    return [(s, s.end_value) for i in system.looped for s in system.out[i]]


def _change(before: list[tuple[Signal, float]]) -> float:
    """Largest relative change since then; 0 if no unit is looped."""
    return max((abs(s.end_value - value) / max(s.scale, FLOOR) for s, value in before), default=0.0)


def _ends(system: System) -> list[float]:
    """Values and rates at the end of the step of the signals that run backward."""
    return [x for s in system.backward for x in ((s.end_value, s.end_rate) if s.rated else (s.end_value,))]


def _set_ends(system: System, values: Any) -> None:
    k = 0
    for s in system.backward:
        s.end_value = float(values[k])
        k += 1
        if s.rated:
            s.end_rate = float(values[k])
            k += 1


def _correct(system: System, time: float, step: float) -> None:
    """Step the looped units that go back again, with both ends of every input known."""
    if system.repeated:
        system.restore(system.repeated)
    for i in system.repeated:
        for s in system.into[i]:
            system.interpolate(s, step)
        system.advance(i, time, step)


def _predict(system: System, time: float, step: float) -> float:
    """All units in order: signals that run backward extrapolated, the others interpolated, their ends being known."""
    for s in system.backward:
        system.extrapolate(s)
    for i in system.order:
        for s in system.into[i]:
            if not s.backward:
                system.interpolate(s, step)
        system.advance(i, time, step)
    return RESIDUAL_WEIGHT * _residual(system.backward, step)


def _residual(signals: list[Signal], step: float) -> float:
    """Largest difference between the end of a signal as used and as found, relative to its scale."""
    worst = 0.0
    for s in signals:
        a0, a1, a2, a3 = s.polynomial
        if s.discrete:
            continue
        gap = abs(a0 + step * (a1 + step * (a2 + step * a3)) - s.end_value) / max(s.scale, FLOOR)
        worst = gap if gap > worst else worst
    return worst


HERMITE = Scheme(
    "hermite",
    "Predictor, then one corrector on cubic Hermite signals",
    order=4,
    calls=2,
    step=hermite,
    goes_back=True,
    limits=(2.4, 1.2),
)
EXTRAPOLATE = Scheme(
    "extrapolate",
    "Signals that run backward are extrapolated by a quadratic, the others interpolated",
    order=3,
    calls=1,
    step=extrapolate,
    limits=(1.2, 1.2),
)
IMPLICIT = Scheme(
    "implicit",
    "Corrector repeated until the ends of all signals fit, accelerated by a quasi-Newton update",
    order=4,
    calls=3,
    step=implicit,
    goes_back=True,
    solves_loops=True,
    limits=(3.1, 1.9),
)
JACOBI = Scheme(
    "jacobi",
    "Inputs held at the communication point, all units side by side",
    order=1,
    calls=1,
    step=jacobi,
    holds=True,
)
GAUSS_SEIDEL = Scheme(
    "gauss-seidel",
    "Inputs held at their newest value, one unit after the other",
    order=1,
    calls=1,
    step=gauss_seidel,
    holds=True,
)
