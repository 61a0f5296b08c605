"""A smooth change: from 0 to a height over a given time, twice continuously differentiable.

    r = a s^3 (10 - 15 s + 6 s^2),   s = t/duration within [0, 1]
"""

from __future__ import annotations

from .ops import NEGLIGIBLE, Ops, Value


def ramp(t: Value, duration: Value, ops: Ops, height: Value = 1.0) -> tuple[Value, Value, Value]:
    """r and its first two time derivatives, per s and per s2, at ``t``, s; a ``duration`` of 0 s: r is the height a."""
    scale = ops.where(duration > NEGLIGIBLE, 1.0 / ops.where(duration > NEGLIGIBLE, duration, 1.0), 0.0)
    s = ops.where(duration > NEGLIGIBLE, ops.minimum(1.0, ops.maximum(0.0, t * scale)), 1.0)
    r = height * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    rest = 1.0 - s
    r1 = height * 30.0 * s * s * rest * rest * scale
    r2 = height * 60.0 * s * rest * (1.0 - 2.0 * s) * scale * scale
    return r, r1, r2


def ramp_integral(t: Value, duration: Value, ops: Ops) -> Value:
    """Integral of r, of height 1, from 0 to ``t``, s, within 0 to ``duration`` > 0, s."""
    s = ops.minimum(1.0, ops.maximum(0.0, t / duration))
    return duration * s * s * s * s * (2.5 - 3.0 * s + s * s)
