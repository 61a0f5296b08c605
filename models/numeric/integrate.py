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
from dataclasses import dataclass
from functools import cache
from typing import Any

Vector = tuple[float, ...]
Rates = Callable[[float, Vector], Sequence[float]]
Indicators = Callable[[float, Vector], Sequence[float]]


SMALLEST = 2.2250738585072014e-308
"""The smallest normal number: an error of that size is rounding whatever the tolerance, which may have underflowed."""

NEAR = 0.1
"""Share of its values at both ends of a step below which the vertex of an indicator's parabola is looked at."""

ROUNDING = 1e-9
"""Share of its value beyond the next zero below which an indicator is zero but for rounding."""

BLIND = 1e-6
"""Share of a step, begun on a zero, in which the sign is not trusted; four times as much, up to a tenth, with every event
that cuts a step to less than `SHORT` of itself: where an indicator is zero but for rounding, time goes on."""

SHORT = 1e-3


class IntegrationError(ArithmeticError):
    """No acceptable step: the message gives time, step and the state."""


@dataclass(frozen=True)
class Tableau:
    """Butcher coefficients. ``error`` holds one or two weight vectors; with two (E5, E3) the estimate is
    |E5|^2/sqrt(|E5|^2 + 0.01 |E3|^2) as in DOP853. ``order`` is that of the estimate plus one."""

    name: str
    c: Vector
    a: tuple[Vector, ...]
    b: Vector
    error: tuple[Vector, ...]
    order: int


DORMAND_PRINCE_5 = Tableau(
    # J. R. Dormand, P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980) 19-26.
    name="Dormand-Prince 5(4)",
    c=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0),
    a=(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    b=(35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    error=((71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),),
    order=5,
)


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


def integrate(
    rates: Rates,
    t: float,
    x: Vector,
    t_end: float,
    *,
    rtol: float,
    atol: Vector,
    indicators: Indicators | None = None,
    on_event: Callable[[float, Vector], Vector] | None = None,
    first_step: float = 0.0,
    method: Tableau = DORMAND_PRINCE_5,
    max_steps: int = 100_000,
    on_step: Callable[[float, Vector, Sequence[float], float, Vector, Sequence[float]], None] | None = None,
) -> tuple[Vector, float]:
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
        if h > 0.999999 * left:
            trial, landing = left, t_end
        else:
            trial, landing = h, t + h
        y, f_new, errors = step(rates, t, x, f, trial)
        ratio = _ratio(errors, x, y, rtol, atol)
        if not ratio <= 1.0:
            h = trial * (max(0.2, 0.9 * ratio**exponent) if ratio < 1e300 else 0.1)
            if not t + h > t:
                raise IntegrationError(f"no step is small enough at t = {t}, x = {x}: the rates are {tuple(f)}")
            continue
        grown = trial * min(5.0, 0.9 * ratio**exponent) if ratio > 1e-9 else 5.0 * trial
        event = False
        if indicators:
            g_new = indicators(landing, y)
            whole = trial
            if g_new != g:
                high = trial if _differ(g, g_new) else _inside(g, g_new, indicators, t, x, f, trial, y, f_new)
                while high > 0.0:
                    found = _locate(step, rates, indicators, t, x, f, g, high, trial, blind)
                    if not found:  # only the interpolant changes its sign
                        break
                    trial, y, f_new, g_new = found
                    landing, event = t + trial, True
                    high = _inside(g, g_new, indicators, t, x, f, trial, y, f_new)
            blind = min(4.0 * blind, 0.1) if event and trial < SHORT * whole else BLIND
            g = g_new
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
    g: Sequence[float],
    g_new: Sequence[float],
    indicators: Indicators,
    t: float,
    x: Vector,
    f: Sequence[float],
    h: float,
    y: Vector,
    f_new: Sequence[float],
) -> float:
    """A place within the step where an indicator that has one sign at both ends has the other, 0 if none is found:
    looked for on the cubic Hermite interpolant at mid-step, and where the parabola of an indicator through begin,
    middle and end of the step has its vertex near zero or beyond."""
    w = 0.125 * h
    middle = tuple([0.5 * (p + q) + w * (r - v) for p, q, r, v in zip(x, y, f, f_new)])
    g_middle = indicators(t + 0.5 * h, middle)
    if _hidden(g, g_middle, g_new):
        return 0.5 * h
    for a, m, b in zip(g, g_middle, g_new):
        slope = 4.0 * m - 3.0 * a - b
        bend = 2.0 * (a + b) - 4.0 * m
        if not slope * a < 0.0 < bend * a or (a > 0.0) != (b > 0.0):
            continue
        s = -0.5 * slope / bend
        bottom = a + 0.5 * s * slope
        near = bottom * a <= 0.0 or abs(bottom) < NEAR * max(abs(a), abs(b))
        if s < 1.0 and near and _hidden(g, indicators(t + s * h, interpolate(s, h, x, f, y, f_new)), g_new):
            return s * h
    return 0.0


def _hidden(g: Sequence[float], g_middle: Sequence[float], g_new: Sequence[float]) -> bool:
    """Whether some indicator has one sign at both ends and the other between them."""
    return any((a > 0.0) == (b > 0.0) != (m > 0.0) for a, m, b in zip(g, g_middle, g_new))


def _locate(
    step: Step,
    rates: Rates,
    indicators: Indicators,
    t: float,
    x: Vector,
    f: Sequence[float],
    g: Sequence[float],
    high: float,
    h: float,
    blind: float,
) -> tuple[float, Vector, Sequence[float], Sequence[float]] | None:
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
        best = min(changed, key=lambda i: abs(g[i]) / (abs(g[i]) + abs(g_new[i]) + 1e-300), default=-1)
        return y, f_new, g_new, best

    y, f_new, g_new, which = ahead(high)
    if which < 0:
        return None
    width = max(1e-12 * h, 1e-15 * abs(t))
    start, g_start = 0.0, g
    if 0.0 < abs(g[which]) < ROUNDING * abs(g_new[which]):
        s = min(blind * h, 0.1 * high)
        _, _, g_s, changed = ahead(s)
        if changed < 0:
            start, g_start = s, g_s
    if blind > 100.0 * BLIND:  # nothing but rounding changes the sign that often: go on
        width = max(width, blind * h)
    low, g_low, g_high, last = start, g_start[which], g_new[which], 0
    slow = 0
    for _ in range(200):
        size = high - low
        if size <= width:
            break
        if slow < 2 and g_high != g_low:  # halved values may underflow, both to zero
            s = high - g_high * size / (g_high - g_low) + 0.3 * width
        else:  # the rule stalls where the indicator touches zero, as e ~ s^2 at a start at rest on the limit of slack
            s, slow = low + 0.5 * size, 0
        s = s if s > low + 0.5 * width else low + 0.5 * width  # also where s is no number
        s = min(s, high - 0.5 * width)
        y_s, f_s, g_s, changed = ahead(s)
        if changed < 0:
            low, g_low = s, g_s[which]
            g_high *= 0.5 if last < 0 else 1.0
            last = -1
        elif changed != which:  # another indicator changes before this one
            high, y, f_new, g_new, which = s, y_s, f_s, g_s, changed
            low, g_low, g_high, last = start, g_start[which], g_s[which], 0
            size = 2.0 * high
        else:
            high, y, f_new, g_new, g_high = s, y_s, f_s, g_s, g_s[which]
            g_low *= 0.5 if last > 0 else 1.0
            last = 1
        slow = slow + 1 if high - low > 0.5 * size else 0
    return high, y, f_new, g_new
