"""Events of the units: zeros of their indicators (``event_*``) within a step, found and written down.

A branch of a unit (taut or slack) is frozen over a step, so that an indicator is smooth there. Its sign at the end of
the step, or the interpolant of one that only dips through zero, tells of a change; the step is then repeated with other
lengths until it ends just beyond the first zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from towage.master.system import System
from towage.models.numeric.root import Bracket
from towage.result.result import Event

LANDING = 1e-10
"""An event is located to this share of the step: 1e-10 of a step costs no accuracy and stays clear of rounding."""
MAX_TRIES = 60
Indication = tuple[float, float]
"""Value and rate of an event indicator; the rate is 0 where it is not known."""
Again = Callable[[float], float]
"""Repeats the step from its start with another length, s; returns the length that was done."""


def indications(system: System) -> list[Indication]:
    """Of every event indicator, at the end of the last step."""
    return [
        (values[slot], values[rate] if rate >= 0 else 0.0)
        for values, slot, rate in ((system.units[i].values, slot, rate) for i, slot, rate, _ in system.indicators)
    ]


def crossing(before: list[Indication], after: list[Indication], step: float) -> float:
    """0 if no indicator changes sign in the step; else a length at or before which one has changed: the step, or the
    extremum of the cubic Hermite interpolant of an indicator that only dips through zero and comes back."""
    for (g0, r0), (g1, r1) in zip(before, after):
        if (g0 > 0.0) != (g1 > 0.0):
            return step
        if g0 * r0 < 0.0 < g0 * r1:
            slope = (g1 - g0) / step
            a2, a3 = (3.0 * slope - 2.0 * r0 - r1) / step, (r0 + r1 - 2.0 * slope) / (step * step)
            root = math.sqrt(max(0.0, a2 * a2 - 3.0 * a3 * r0))
            s = -r0 / (a2 + math.copysign(root, a2)) if a2 else math.sqrt(max(0.0, -r0 / (3.0 * a3))) if a3 else 0.0
            if 0.0 < s < step and (g0 + s * (r0 + s * (a2 + s * a3)) > 0.0) != (g0 > 0.0):
                return s
    return 0.0


def locate(system: System, before: list[Indication], time: float, tried: float, high: float, again: Again) -> float:
    """End the step that began at ``time`` just beyond the first zero of an indicator; returns its length.

    ``tried`` is the length that was done last, ``high`` one by which an indicator has changed, and ``before`` what was
    indicated at ``time``.
    """
    done = tried if high == tried else again(high)
    which = _first_change(before, indications(system))
    if which < 0:  # the interpolant dipped through zero, the indicator itself does not
        return again(tried) if high != tried else tried
    width = max(LANDING * tried, 8e-16 * abs(time))
    bracket = Bracket(0.0, before[which][0], high, indications(system)[which][0], width)
    for _ in range(MAX_TRIES):
        if bracket.size <= width:
            break
        place = bracket.middle() if bracket.flat else bracket.secant()
        done = again(place)
        after = indications(system)
        changed = _first_change(before, after)
        if changed < 0:
            bracket.raise_low(place, after[which][0])
        elif changed != which:  # another indicator changes before this one
            which = changed
            bracket.restart(0.0, before[which][0], place, after[which][0])
        else:
            bracket.lower_high(place, after[which][0])
    return done if done == bracket.high else again(bracket.high)


def _first_change(before: list[Indication], after: list[Indication]) -> int:
    """The indicator that changes sign first, by the secant; -1 if none changes."""
    shares = {
        k: abs(a) / (abs(a) + abs(b) + 1e-300)
        for k, ((a, _), (b, _)) in enumerate(zip(before, after)) if (a > 0.0) != (b > 0.0)
    }  # fmt: skip
    return min(shares, key=shares.__getitem__) if shares else -1


def happened(system: System, time: float, before: list[Indication], announced: float | None) -> list[Event]:
    """The events at ``time``, the end of the last step: indicators that changed sign since ``before``, and the units that
    ``announced`` this time, s, if one did."""
    events = [
        Event(time, system.units[i].name, name, 1 if g1 > 0.0 else -1)
        for (g0, _), (g1, _), (i, _, _, name) in zip(before, indications(system), system.indicators)
        if (g0 > 0.0) != (g1 > 0.0)
    ]
    if announced is not None:
        events += [
            Event(time, system.units[i].name, "time event", 0)
            for i, slot in system.clocks if abs(system.units[i].values[slot] - announced) <= 1e-9 * (1.0 + announced)
        ]  # fmt: skip
    return events
