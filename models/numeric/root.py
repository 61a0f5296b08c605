"""A zero of a function between two places, by the rule of Illinois.

    s = b - g(b) (b - a) / (g(b) - g(a)),    a = low, b = high, g(a) and g(b) of different sign

The secant through both ends of a bracket gives the next place, which replaces the end of its sign. Where the same end
would be replaced twice running, the value at the other end is halved, so that both ends move; the order is 1.44.
Source: M. Dowell, P. Jarratt, "A modified regula falsi method", BIT 11 (1971) 168-174.

What is looked for here is the end of a step just beyond a zero: the secant is moved on by `BEYOND` of the width at which the
search ends, so that the last place tried tends to lie beyond, and kept half a width off both ends.
"""

from __future__ import annotations

BEYOND = 0.3
"""Share of the width at which the search ends by which the secant is moved on."""


class Bracket:
    """Where the zero is: between ``low``, where the function has the value ``g_low``, and ``high`` with ``g_high`` of the
    other sign, until they are ``width`` apart."""

    __slots__ = ("_g_high", "_g_low", "_last", "high", "low", "width")

    def __init__(self, low: float, g_low: float, high: float, g_high: float, width: float) -> None:
        self.width = width
        self.restart(low, g_low, high, g_high)

    def restart(self, low: float, g_low: float, high: float, g_high: float) -> None:
        """Begin anew, for another function perhaps."""
        self.low, self.high, self._last = low, high, 0
        self._g_low, self._g_high = g_low, g_high

    @property
    def size(self) -> float:
        """The distance of both ends."""
        return self.high - self.low

    @property
    def flat(self) -> bool:
        """Whether the rule has no next place: values that are halved may both underflow to zero."""
        return self._g_high == self._g_low

    def secant(self) -> float:
        """The place that the rule tries next."""
        high, size = self.high, self.high - self.low
        return self._inside(high - self._g_high * size / (self._g_high - self._g_low) + BEYOND * self.width)

    def middle(self) -> float:
        """The middle, where the rule is slow."""
        return self._inside(self.low + 0.5 * (self.high - self.low))

    def _inside(self, place: float) -> float:
        """``place``, at least half a width off both ends, also where it is no number."""
        first = self.low + 0.5 * self.width
        return min(place if place > first else first, self.high - 0.5 * self.width)

    def raise_low(self, place: float, value: float) -> None:
        """The function has not changed sign at ``place``."""
        self.low, self._g_low = place, value
        self._g_high *= 0.5 if self._last < 0 else 1.0
        self._last = -1

    def lower_high(self, place: float, value: float) -> None:
        """The function has changed sign at ``place``."""
        self.high, self._g_high = place, value
        self._g_low *= 0.5 if self._last > 0 else 1.0
        self._last = 1
