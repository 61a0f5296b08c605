"""Explicit embedded Runge-Kutta steps with error control and event location.

    x_{n+1} = x_n + h sum_i b_i k_i,    k_i = f(t_n + c_i h, x_n + h sum_{j<i} a_ij k_j)

One driver, `integrate`, serves every nonlinear model; a method is a tableau (data). It lands on the zeros of the
model's indicators, so that every accepted step sees a smooth right-hand side: without this the kink of |v| v costs the
fifth-order method two orders. For speed the stages of a tableau are unrolled once per dimension into one Python
function; a two-component step then costs about as much as its right-hand sides.

Not to be confused with the exact steps of the linear models, which have an ``advance`` of their own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from .root import Bracket
from .tableaus import DORMAND_PRINCE_5, Tableau

Vector = tuple[float, ...]
Rates = Callable[[float, Vector], Sequence[float]]
Indicators = Callable[[float, Vector], Sequence[float]]

SAFETY, LEAST_GROWTH, MOST_GROWTH = 0.9, 0.2, 5.0
"""Factor on the step that the error asks for; the least and the most by which a step changes."""
RESCUE, NO_NUMBER = 0.1, 1e300
"""Factor on a step whose error is no number, or this much over its tolerance."""
LANDING = 0.999999
"""A step longer than this share of what is left goes to the end."""
MAX_STEPS, MAX_TRIALS = 100_000, 200
"""Steps in one call; trials to locate an event."""
EVENT_WIDTH, TIME_WIDTH = 1e-12, 1e-15
"""Width of the bracket of an event, relative to the step and to the time (4 units in the last place)."""
TINY = 1e-300
"""Keeps a share of zero by zero a number."""

SMALLEST = 2.2250738585072014e-308
"""The smallest normal number: an error of that size is rounding whatever the tolerance, which may have underflowed."""

NEAR = 0.1
"""Share of its values at both ends of a step below which the vertex of an indicator's parabola is looked at."""

FAR = 0.35
"""Share of its value at either end above which an indicator at mid-step rules out such a vertex: a parabola whose vertex is
below 0.1 of the larger end is at mid-step below 0.1 + 0.9/4 of it. For speed alone."""

ROUNDING = 1e-9
"""Share of its value beyond the next zero below which an indicator is zero but for rounding."""

BLIND = 1e-6
"""Share of a step, begun on a zero, in which the sign is not trusted; four times as much, up to a tenth, with every event
that cuts a step to less than `SHORT` of itself, until a step is not cut: where an indicator is zero but for rounding, time
goes on."""
MOST_BLIND, SHORT = 0.1, 1e-3


class IntegrationError(ArithmeticError):
    """No acceptable step: the message gives time, step and the state."""


Step = Callable[[Rates, float, Vector, Sequence[float], float], tuple[Vector, Sequence[float], tuple[Vector, ...]]]


@cache
def unrolled(method: Tableau, n: int) -> Step:
    """The step of ``method`` for ``n`` components: (f, t, x, f(t, x), h) -> (x(t + h), f there, error vectors)."""

    def combination(weights: Vector, i: int) -> str:
        return " + ".join(f"{w!r}*k{j}_{i}" for j, w in enumerate(weights) if w != 0.0)

    def names(prefix: str) -> str:
        return ", ".join(f"{prefix}{i}" for i in range(n)) + ("," if n == 1 else "")

    lines = ["def step(f, t, x, k, h):", f"    {names('x')} = x", f"    {names('k0_')} = k"]
    for s in range(1, len(method.c)):
        point = ", ".join(f"x{i} + h*({combination(method.a[s], i)})" for i in range(n))
        lines.append(f"    {names(f'k{s}_')} = f(t + {method.c[s]!r}*h, ({point},))")
    last = len(method.c)
    lines.append("    y = (" + ", ".join(f"x{i} + h*({combination(method.b, i)})" for i in range(n)) + ",)")
    lines.append("    new = f(t + h, y)")
    lines.append(f"    {names(f'k{last}_')} = new")
    errors = ["(" + ", ".join(f"h*({combination(e, i)})" for i in range(n)) + ",)" for e in method.error]
    lines.append(f"    return y, new, ({', '.join(errors)},)")
    scope: dict[str, Any] = {}
    exec("\n".join(lines), scope)
    return scope["step"]  # type: ignore[no-any-return]


def _until_event(
    step: Step, rates: Rates, indicators: Indicators, t: float, x: Vector, f: Sequence[float], g: Sequence[float],
    trial: float, landing: float, y: Vector, f_new: Sequence[float], g_new: Sequence[float], high: float, blind: float,
) -> tuple[float, float, Vector, Sequence[float], Sequence[float], bool, float]:  # fmt: skip
    """The step of size ``trial`` from (t, x) to (landing, y), where an indicator has another sign at ``high`` or seems to,
    cut just beyond its first event: (size, landing, y, rates and indicators there, whether there is an event, the next
    ``blind``)."""
    event, whole = False, trial
    while high > 0.0:
        located = _locate(step, rates, indicators, t, x, f, g, high, trial, blind)
        if not located:  # only the interpolant changes its sign
            break
        trial, y, f_new, g_new = located
        landing, event = t + trial, True
        high = _inside(g, g_new, indicators, t, x, f, trial, y, f_new)
    if not event:
        blind = BLIND
    elif trial < SHORT * whole:
        blind = min(4.0 * blind, MOST_BLIND)
    return trial, landing, y, f_new, g_new, event, blind


def _ratio(errors: tuple[Vector, ...], x: Vector, y: Vector, rtol: float, atol: Vector) -> float:
    """Largest error over its tolerance."""
    worst = [0.0, 0.0]
    for which, error in enumerate(errors):
        largest = 0.0
        for e, a, b, tiny in zip(error, x, y, atol):
            a, b = abs(a), abs(b)
            r = abs(e) / (tiny + rtol * (a if a > b else b) + SMALLEST)
            if not r <= largest:
                largest = r
        worst[which] = largest
    first, second = worst
    if len(errors) == 1 or first == 0.0:
        return first
    return first * (first / math.hypot(first, 0.1 * second))


def _shorter(trial: float, ratio: float, exponent: float, t: float, x: Vector, f: Sequence[float]) -> float:
    """The step to try after one of size ``trial`` whose error was ``ratio`` times its tolerance, or no number. Raises
    `IntegrationError` where it would not move the time ``t``."""
    h = trial * (max(LEAST_GROWTH, SAFETY * ratio**exponent) if ratio < NO_NUMBER else RESCUE)
    if not t + h > t:
        raise IntegrationError(f"no step is small enough at t = {t}, x = {x}: the rates are {tuple(f)}")
    return h


def integrate(
    rates: Rates, t: float, x: Vector, t_end: float, *, rtol: float, atol: Vector, indicators: Indicators | None = None,
    on_event: Callable[[float, Vector], Vector] | None = None, first_step: float = 0.0, method: Tableau = DORMAND_PRINCE_5,
    max_steps: int = MAX_STEPS,
    on_step: Callable[[float, Vector, Sequence[float], float, Vector, Sequence[float]], None] | None = None,
) -> tuple[Vector, float]:  # fmt: skip
    """Integrate x' = rates(t, x) from ``t`` to ``t_end``; returns (x(t_end), a step to begin the next call with).

    At each zero of an indicator the step ends just beyond it and ``on_event(t, x) -> x`` is called, which may change x
    and the branch that ``rates`` uses. ``on_step(t0, x0, f0, t1, x1, f1)`` sees every accepted step. ``rtol`` is
    relative to each component, ``atol`` absolute per component. Raises `IntegrationError` when no step is small enough
    or ``max_steps`` are not enough.
    """
    step = unrolled(method, len(x))
    exponent = -1.0 / method.order
    f = rates(t, x)
    g = indicators(t, x) if indicators else ()
    h = first_step if first_step > 0.0 else t_end - t
    steps, blind = 0, BLIND
    while True:
        left = t_end - t
        if left <= 0.0:
            return x, h
        steps += 1
        if steps > max_steps:
            raise IntegrationError(f"{max_steps} steps were not enough to reach t = {t_end} (now t = {t}, x = {x})")
        trial, landing = (left, t_end) if h > LANDING * left else (h, t + h)
        y, f_new, errors = step(rates, t, x, f, trial)
        ratio = _ratio(errors, x, y, rtol, atol)
        if not ratio <= 1.0:
            h = _shorter(trial, ratio, exponent, t, x, f)
            continue
        grown = trial * min(MOST_GROWTH, SAFETY * ratio**exponent) if ratio > 1e-9 else MOST_GROWTH * trial
        event = False
        if indicators:
            g_new = indicators(landing, y)
            high = trial if _differ(g, g_new) else _inside(g, g_new, indicators, t, x, f, trial, y, f_new)
            if high > 0.0:
                trial, landing, y, f_new, g, event, blind = _until_event(
                    step, rates, indicators, t, x, f, g, trial, landing, y, f_new, g_new, high, blind
                )
            else:
                g, blind = g_new, BLIND
        if on_step:
            on_step(t, x, f, landing, y, f_new)
        # a step cut short by t_end or an event says nothing against the longer step that was tried before
        h = max(h, grown) if trial < h else grown
        t, x, f = landing, y, f_new
        if event and on_event:
            x = on_event(t, x)
            f = rates(t, x)
            g = indicators(t, x) if indicators else ()


def interpolate(s: float, h: float, x: Vector, f: Sequence[float], y: Vector, f_new: Sequence[float]) -> Vector:
    """Cubic Hermite interpolant of a step of length ``h`` at ``s`` in [0, 1], O(h^4)."""
    a, b = 1.0 - s, s
    wx, wy = a * a * (1.0 + 2.0 * b), b * b * (1.0 + 2.0 * a)
    wf, wg = h * a * a * b, -h * b * b * a
    return tuple(wx * p + wy * q + wf * r + wg * v for p, q, r, v in zip(x, y, f, f_new))


def _differ(g: Sequence[float], g_new: Sequence[float]) -> bool:
    """Whether some indicator has another sign."""
    return [a > 0.0 for a in g] != [a > 0.0 for a in g_new]


def _inside(
    g: Sequence[float], g_new: Sequence[float], indicators: Indicators, t: float, x: Vector, f: Sequence[float], h: float,
    y: Vector, f_new: Sequence[float],
) -> float:  # fmt: skip
    """A place within the step where an indicator that has one sign at both ends has the other, 0 if none is found:
    looked for on the cubic Hermite interpolant at mid-step, and where the parabola of an indicator through begin,
    middle and end of the step has its vertex near zero or beyond."""
    w = 0.125 * h
    middle = tuple([0.5 * (p + q) + w * (r - v) for p, q, r, v in zip(x, y, f, f_new)])
    for a, m, b in zip(g, indicators(t + 0.5 * h, middle), g_new):
        if (a > 0.0) != (b > 0.0):
            continue
        if (a > 0.0) != (m > 0.0):
            return 0.5 * h
        if (m > FAR * a and m > FAR * b) if a > 0.0 else (m < FAR * a and m < FAR * b):
            continue
        slope = 4.0 * m - 3.0 * a - b
        bend = 2.0 * (a + b) - 4.0 * m
        if not slope * a < 0.0 < bend * a:
            continue
        s = -0.5 * slope / bend
        bottom = a + 0.5 * s * slope
        if s < 1.0 and (bottom * a <= 0.0 or abs(bottom) < NEAR * max(abs(a), abs(b))):
            there = indicators(t + s * h, interpolate(s, h, x, f, y, f_new))
            if any((a > 0.0) == (b > 0.0) != (v > 0.0) for a, v, b in zip(g, there, g_new)):
                return s * h
    return 0.0


def _locate(
    step: Step, rates: Rates, indicators: Indicators, t: float, x: Vector, f: Sequence[float], g: Sequence[float],
    high: float, h: float, blind: float,
) -> tuple[float, Vector, Sequence[float], Sequence[float]] | None:  # fmt: skip
    """The step that ends just beyond the first zero before ``high`` in a step of ``h``: (length, state, rates,
    indicators) there; None where no sign has changed at ``high``.

    Bracketing by true steps with the Illinois rule on the indicator that changes first, and bisection where that rule
    does not halve the bracket in two steps, until it is shorter than 1e-12 of the step or 4 units in the last place of
    the time. A step often begins on a zero, just located, where the sign is that of rounding for a while: the next zero
    is sought from ``blind`` of the step on, if no sign has changed there.
    """

    def ahead(s: float) -> tuple[Vector, Sequence[float], Sequence[float], int]:
        y, f_new, _ = step(rates, t, x, f, s)
        g_new = indicators(t + s, y)
        changed = [i for i, (a, b) in enumerate(zip(g, g_new)) if (a > 0.0) != (b > 0.0)]
        best = min(changed, key=lambda i: abs(g[i]) / (abs(g[i]) + abs(g_new[i]) + TINY), default=-1)
        return y, f_new, g_new, best

    y, f_new, g_new, which = ahead(high)
    if which < 0:
        return None
    width = max(EVENT_WIDTH * h, TIME_WIDTH * abs(t))
    start, g_start = 0.0, g
    if 0.0 < abs(g[which]) < ROUNDING * abs(g_new[which]):
        s = min(blind * h, MOST_BLIND * high)
        _, _, g_s, changed = ahead(s)
        if changed < 0:
            start, g_start = s, g_s
    if blind > 100.0 * BLIND:  # nothing but rounding changes the sign that often: go on
        width = max(width, blind * h)
    bracket = Bracket(start, g_start[which], high, g_new[which], width)
    slow = 0
    for _ in range(MAX_TRIALS):
        size = bracket.size
        if size <= width:
            break
        if slow < 2 and not bracket.flat:
            s = bracket.secant()
        else:  # the rule stalls where the indicator touches zero, as e ~ s^2 at a start at rest on the limit of slack
            s, slow = bracket.middle(), 0
        y_s, f_s, g_s, changed = ahead(s)
        if changed < 0:
            bracket.raise_low(s, g_s[which])
        else:
            y, f_new, g_new = y_s, f_s, g_s
            if changed == which:
                bracket.lower_high(s, g_s[which])
            else:  # another indicator changes before this one
                which = changed
                bracket.restart(start, g_start[which], s, g_s[which])
                size = 2.0 * s
        slow = slow + 1 if bracket.size > 0.5 * size else 0
    return bracket.high, y, f_new, g_new
